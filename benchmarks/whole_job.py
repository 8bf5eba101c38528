"""The whole job in the browser, without the command line: its clicks, its seconds, and what comes out.

Run: ``OMP_NUM_THREADS=1 python benchmarks/whole_job.py [BOARD]``

Goes from CAD to a robot's program on the real page: a sample board is imported as STEP (boxes of its components), a
recipe is chosen, planned, one part masked; the program is analysed, checked in a cell that holds the board out of
reach, the remedy applied, the robot's motion analysed, and everything downloaded as one zip, which is opened and read
back. A click is what the browser's pointer presses, lists and their options included; choosing the file in the window
of the operating system counts as one more. Ends with 1 if there are more than 25 clicks, or a file is missing.
Chromium draws without a graphics card here, on the processor that plans and analyses: a desk's browser is quicker.
"""

import io
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "support"))

from driven_page import CHROMIUM, NO_CHROMIUM, DrivenPage, open_chromium
from hostile_cells import hostile_text
from step_writer import Placed, StepWriter

from boards.board import Board
from boards.load import load_board
from programs.load import load_program
from webui.page.project import open_project
from webui.server.server import Server, open_session, serve

MOST_CLICKS = 25
RECIPE, CELL = "low-standoff", "far-away.yaml"
IN_THE_FILE_WINDOW = 1
WAIT_MS = 150_000
COUNT = """
addEventListener('pointerdown', event => {
  if (event.isTrusted) sessionStorage.setItem('clicks', 1 + Number(sessionStorage.getItem('clicks') ?? 0));
}, true);
"""
WANTED = (".wash", ".json", ".png", ".script", "-joints.png", ".yaml", "-cleaning.html", "-cleaning.json")


def step_text(board: Board) -> str:
    """A board as a CAD program would export it, each component the box around it."""
    x_min, y_min, x_max, y_max = board.outline.bounds
    low, top = board.bottom_z_mm, board.top_z_mm
    parts: list[Placed] = [
        (
            "board",
            f"{board.name} PCB",
            (x_max - x_min, y_max - y_min, top - low),
            ((x_min + x_max) / 2, (y_min + y_max) / 2, low),
        )
    ]
    for each in board.components:
        left, front, right, back = each.outline.bounds
        size = (round(right - left, 3), round(back - front, 3), max(each.height_mm, 0.1))
        foot = top if each.side == "top" else low - size[2]
        product = f"{each.package} {size[0]:g}x{size[1]:g}"
        parts.append((each.name, product, size, ((left + right) / 2, (front + back) / 2, foot)))
    return StepWriter().write(parts)


def part_to_mask(board: Board) -> tuple[str, tuple[float, float, float]]:
    """The tallest component and the middle of its top: nothing stands in front of it in the view from above."""
    tallest = max((each for each in board.components if each.side == "top"), key=lambda each: each.height_mm)
    middle = tallest.outline.centroid
    return tallest.name, (middle.x, middle.y, board.top_z_mm + tallest.height_mm)


class WholeJob:
    """Goes the way and notes the clicks and seconds of each part of it."""

    def __init__(self, tab: DrivenPage, server: Server, step: Path) -> None:
        """Begin on the page as it opens."""
        self._tab, self._server, self._step = tab, server, step
        self.clicks = 0
        self.seconds = 0.0
        self.files: dict[str, bytes] = {}

    def go(self) -> None:
        """Go all of it."""
        parts: tuple[tuple[str, Callable[[], int]], ...] = (
            ("import STEP, plan", self._import),
            ("choose a recipe, plan", self._choose_recipe),
            ("mask a part", self._mask),
            ("analyse", self._analyse),
            ("check in a cell", self._check),
            ("apply the remedy", self._apply_remedy),
            ("analyse its motion", self._analyse),
            ("download all", self._download),
        )
        print(f"{'part':<24} {'clicks':>6} {'seconds':>8}")
        for name, part in parts:
            begun, before = time.perf_counter(), self._counted()
            more = part()
            clicks, seconds = self._counted() - before + more, time.perf_counter() - begun
            self.clicks, self.seconds = self.clicks + clicks, self.seconds + seconds
            print(f"{name:<24} {clicks:>6} {seconds:>8.1f}", flush=True)
        print(f"{'all of it':<24} {self.clicks:>6} {self.seconds:>8.1f}")

    def _counted(self) -> int:
        return int(self._tab.page.evaluate("Number(sessionStorage.getItem('clicks') ?? 0)"))

    def _import(self) -> int:
        before = self._tab.time_text
        self._tab.tab("Board")
        with self._tab.page.expect_file_chooser() as chooser:
            self._tab.press("Import CAD")
        chooser.value.set_files(self._step)
        self._tab.wait_for_input("Board", "(value, name) => value === name", self._step.name)
        self._tab.wait_for_another_time(before)
        self._tab.wait_until_planned()
        return IN_THE_FILE_WINDOW

    def _choose_recipe(self) -> int:
        before = self._tab.time_text
        self._tab.tab("YAML")
        self._tab.press("Open…")
        self._tab.choose("Recipe", RECIPE)
        self._tab.press("Open")
        self._tab.wait_for_another_time(before)
        self._tab.tab("Recipe")
        return 0

    def _mask(self) -> int:
        session = self._server.sessions.pages()[0].session
        name, place = part_to_mask(session.board)
        self._tab.click_scene(next(iter(self._server.viser.get_clients().values())).camera, place)
        self._tab.see(f"Mask {name}")
        self._tab.press("Avoid")
        self._tab.see("Do not avoid")
        self._tab.wait_until_planned()
        return 0

    def _analyse(self) -> int:
        self._tab.page.locator("#wb-bar [data-to='Clean']").click()
        self._tab.press("Analyse")
        self._tab.see("no proof of cleanliness")
        return 0

    def _check(self) -> int:
        self._tab.page.locator("#wb-bar [data-to='Robot']").click()
        self._tab.choose("Cell", CELL)
        self._tab.press("Check")
        self._tab.see("The robot cannot do it")
        return 0

    def _apply_remedy(self) -> int:
        self._tab.press("Apply the remedy")
        self._tab.see("The robot can do it")
        return 0

    def _download(self) -> int:
        self._tab.page.locator("#wb-bar [data-to='Export']").click()
        with self._tab.page.expect_download() as waiting:
            self._tab.press("Download")
        with zipfile.ZipFile(io.BytesIO(waiting.value.path().read_bytes())) as archive:
            self.files = {name: archive.read(name) for name in archive.namelist()}
        return 0


def main(board: str) -> int:
    """Go the way; 0 if it takes at most the clicks that are allowed and nothing is missing."""
    if CHROMIUM is None:
        print(NO_CHROMIUM)
        return 1
    with tempfile.TemporaryDirectory() as folder, open_chromium() as browser:
        project, cad = Path(folder) / "project", Path(folder) / f"{board}.step"
        project.mkdir()
        cad.write_text(step_text(load_board(Path(board))))
        (project / CELL).write_text(hostile_text("ur5e-bench", "far"))
        server = serve(open_session("smt-demo", "smt-aqueous"), open_project(project), "127.0.0.1", 0)
        context = browser.new_context(viewport={"width": 1440, "height": 900}, accept_downloads=True)
        context.add_init_script(COUNT)
        tab = DrivenPage(browser, server.address, context.new_page(), wait_ms=WAIT_MS)
        job = WholeJob(tab, server, cad)
        try:
            job.go()
        finally:
            server.stop()
        for name, content in sorted(job.files.items()):
            print(f"  {name:<40} {len(content):>9} bytes")
        missing = [end for end in WANTED if not any(name.endswith(end) for name in job.files)]
        program = project / "read.wash"
        program.write_bytes(next((job.files[name] for name in job.files if name.endswith(".wash")), b""))
        print(f"read back: {load_program(program).totals.duration_s:.1f} s; errors of the page: {tab.errors or 'none'}")
    if missing:
        print("missing:", ", ".join(missing))
    return int(bool(missing or tab.errors or job.clicks > MOST_CLICKS))


if __name__ == "__main__":
    sys.exit(main("".join(sys.argv[1:2]) or "sensor-hub"))
