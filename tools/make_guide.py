"""Draw the pictures of the page in ``docs/``: go the guide's way through the real page and take one at each step.

Run it with ``python tools/make_guide.py [FOLDER [LAST_STEP]]`` and look at the pictures in ``docs/images/guide-*.png``.
It needs chromium.
"""

import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "support"))

from driven_page import CHROMIUM, NO_CHROMIUM, DrivenPage, open_chromium  # noqa: E402
from webui.page.workpiece import plan_workpiece  # noqa: E402

from specs.progress import no_progress  # noqa: E402
from webui.page.project import open_project  # noqa: E402
from webui.server.server import open_session, serve  # noqa: E402

IMAGES = ROOT / "docs" / "images"
SETTLE_MS = 2500
WAIT_MS = 400_000
"""A check of the sample in its cell, on a machine that does other work too."""
TUNING_MS = 1_800_000
PORT = 8170
ALL = "Program, report, picture and recipe"


def open_page(tab: DrivenPage) -> None:
    """The page as it opens."""
    tab.wait_until_planned()


def look_at_board(tab: DrivenPage) -> None:
    """What was understood of the board, its parts coloured by class."""
    tab.tab("Board")
    tab.choose("Colour by", "Class")


def look_at_component(tab: DrivenPage) -> None:
    """One part and its card, and the buttons that mask it."""
    tab.tab("Components")
    tab.choose("Go to", "U1")
    tab.see("Mask U1")


def look_at_findings(tab: DrivenPage) -> None:
    """The worst finding, its place, and the template that caused it."""
    tab.page.locator("[data-status=findings]").click()
    tab.press("Next")
    tab.page.locator("[data-entry='templates.around']").wait_for()


def edit_recipe(tab: DrivenPage) -> None:
    """A slower path around the parts."""
    before = tab.time_text
    tab.press("Plan")
    tab.edit("around", "Speed (mm/s)", "30")
    tab.wait_for_another_time(before)


def choose_step(tab: DrivenPage) -> None:
    """A step of the job, its strokes highlighted."""
    tab.tab("Job")
    tab.page.get_by_role("button", name="rinse").first.click()


def look_at_paths(tab: DrivenPage) -> None:
    """The strokes, one of them selected."""
    tab.press("Iso")
    tab.tab("Paths")
    tab.press("Next")


def play(tab: DrivenPage) -> None:
    """The program in the middle of its way."""
    tab.press("None")
    tab.choose("Speed (x)", "20")
    tab.press("Play")
    tab.wait_for_input("Time (s)", "value => Number(value) > 150")
    tab.press("Pause")


def rewind(tab: DrivenPage) -> None:
    """Back to the beginning, where the nozzle is not in the way."""
    tab.page.locator(".mantine-Slider-thumb").first.press("Home")
    tab.wait_for_input("Time (s)", "value => Number(value) === 0")


def save(tab: DrivenPage) -> None:
    """The recipe's text under a name of its own."""
    rewind(tab)
    tab.press("Plan")
    tab.tab("YAML")
    tab.press("Save as…")
    tab.type("File", "my-board")
    tab.page.get_by_text("saved", exact=True).wait_for()
    tab.wait_until_planned()


def compare(tab: DrivenPage) -> None:
    """The recipe as it began beside the edited one."""
    tab.tab("Compare")
    tab.choose("With", "smt-aqueous")
    tab.see("Total time")


def check_robot(tab: DrivenPage) -> None:
    """The robot of a cell in the middle of the program, and what came of the check."""
    tab.choose("With", "nothing")
    tab.tab("Robot")
    tab.choose("Cell", "ur5e-bench")
    tab.press("Check")
    tab.see("The robot can do it")
    tab.press("Play")
    tab.wait_for_input("Time (s)", "value => Number(value) > 40")
    tab.press("Pause")
    tab.press("Whole cell")


def look_at_reach(tab: DrivenPage) -> None:
    """How well the robot reaches each part of the paths, and what its joints do."""
    tab.press("Workpiece")
    tab.choose("Metric", "Manipulability")
    tab.choose("Show", "Speed")
    tab.page.mouse.move(150, 600)
    tab.page.mouse.wheel(0, 5000)  # to the end of the tab


def write_robot_program(tab: DrivenPage) -> None:
    """The text of the robot's program at the stroke that is selected."""
    rewind(tab)
    tab.choose("Metric", "The recipe")
    tab.tab("Paths")
    tab.press("Next")
    tab.tab("Program")
    tab.press("Write")
    tab.see("Read back")


def download(tab: DrivenPage) -> None:
    """All files of the job in one."""
    tab.tab("Files")
    tab.page.wait_for_function(f"() => document.body.innerText.includes({ALL!r})")
    with tab.page.expect_download() as waiting:
        tab.press("Download")
    print(waiting.value.suggested_filename, waiting.value.path().stat().st_size, "bytes")


def look_at_cleaning(tab: DrivenPage) -> None:
    """What the program is predicted to clean: verdicts, and how much lands where."""
    tab.tab("Robot")
    tab.choose("Cell", "none")
    tab.tab("Paths")
    tab.press("None")
    rewind(tab)
    tab.tab("Cleaning")
    tab.press("Analyse")
    tab.see("no proof of cleanliness")
    tab.page.get_by_label("Paths too").first.click()
    tab.choose("Show", "Volume")
    tab.press("Iso")


def look_at_gap(tab: DrivenPage) -> None:
    """What flows under a part."""
    tab.choose("Show", "Shear under parts")
    tab.choose("Part", "U1")
    tab.choose("In the gap", "Wall shear")
    tab.page.mouse.move(60, 700)  # beside the list, which would scroll in place of the tab
    tab.page.mouse.wheel(0, 5000)


def tune(tab: DrivenPage) -> None:
    """What tuning proposes: the changes, each with its effect and cost, and the diff of the recipe."""
    tab.choose("Show", "Nothing")
    tab.press("Tune…")
    tab.type("Analyses at most", "8")
    tab.press("Start")
    tab.page.locator("[data-diff]").wait_for(timeout=TUNING_MS)


STEPS: dict[str, Callable[[DrivenPage], None]] = {
    "open": open_page,
    "board": look_at_board,
    "component": look_at_component,
    "findings": look_at_findings,
    "recipe": edit_recipe,
    "job": choose_step,
    "paths": look_at_paths,
    "playback": play,
    "save": save,
    "compare": compare,
    "robot": check_robot,
    "reach": look_at_reach,
    "program": write_robot_program,
    "files": download,
    "cleaning": look_at_cleaning,
    "gap": look_at_gap,
    "tuning": tune,
}


def judge_part(tab: DrivenPage) -> None:
    """Stripes on a part in their order, without repair, and what they clean."""
    before = tab.time_text
    tab.page.get_by_label("Repair", exact=True).uncheck()
    tab.press("Apply")
    tab.wait_for_another_time(before)
    tab.tab("Cleaning")
    tab.press("Analyse")
    tab.see("Held for less")
    tab.press("Iso")


TOURS = (("smt-demo", "smt-aqueous", STEPS), ("f-bracket", "part-degrease", {"part": judge_part}))
"""Workpiece, recipe and steps."""


def draw_guide(folder: Path, last: str = "") -> None:
    """Take a picture of each step, up to the last one of that name; without a name those of all tours.

    Raises:
        RuntimeError: the page complained about something on the way.
    """
    for workpiece, recipe, steps in TOURS:
        if not last or last in steps:
            _draw_tour(folder, last, (workpiece, recipe), steps)


def _draw_tour(
    folder: Path, last: str, opened: tuple[str, str], steps: dict[str, Callable[[DrivenPage], None]]
) -> None:
    with tempfile.TemporaryDirectory() as project, open_chromium() as browser:
        session = open_session(*opened)
        plan_workpiece(session.recipe, session.workpiece, no_progress)  # else pictures show how long compiling takes
        server = serve(session, open_project(Path(project)), "127.0.0.1", PORT)
        tab = DrivenPage(browser, server.address, sharpness=1.0, wait_ms=WAIT_MS)
        tab.dismiss_notice()
        for name, step in steps.items():
            step(tab)
            tab.page.mouse.move(700, 10)  # a hint fades slowly
            tab.page.wait_for_timeout(SETTLE_MS)
            tab.picture(folder / f"guide-{name}.png")
            if name == last:
                break
        server.stop()
    if tab.errors:
        raise RuntimeError("\n".join(tab.errors))


if __name__ == "__main__":
    if CHROMIUM is None:
        sys.exit(NO_CHROMIUM)
    draw_guide(Path(sys.argv[1]) if sys.argv[1:] else IMAGES, "".join(sys.argv[2:3]))
