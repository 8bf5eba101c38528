"""From an edit to the picture: on the server, and as seen in a browser, against planning everything anew.

Run: ``OMP_NUM_THREADS=1 python benchmarks/ui.py BOARD [RECIPE] [TEMPLATE]``

Edits the speed, the height and the tilt of one template, again and again, each time to a value that was not there
before. The server's side is all that happens between the value and the bytes that are sent: the text, the plan, the
lines of the scene. "Anew" is a plan without anything remembered. The browser's side begins with the Enter key and ends
when the new total stands on the page; the new lines come in the same message. Chromium draws without a graphics card
here, on the processor that plans: a desk's browser is quicker.
"""

import statistics
import sys
import tempfile
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "support"))

from driven_page import CHROMIUM, DrivenPage, open_chromium

from boards.load import load_board
from geometry.coverage.route import forget_routes
from rulesengine.pipeline import run
from webui.app import open_session, serve
from webui.layers.markers import find_markers, markers_glb
from webui.layers.ribbons import board_size_mm, line_width_mm
from webui.layers.strokes import stroke_lines, strokes_glb, tint_strokes, transfers_glb
from webui.project import open_project
from webui.session import Session

FIELDS = {"speed_mm_s": "Speed (mm/s)", "height_mm": "Height (mm)", "tilt_deg": "Tilt (\N{DEGREE SIGN})"}
REPEATS = 5
WATCH = """() => {
  window.begun = 0; window.taken = 0;
  const total = () => document.querySelector('[data-total]')?.textContent;
  document.addEventListener('keydown', event => {
    if (event.key !== 'Enter') return;
    window.begun = performance.now(); window.taken = 0;
    const before = total();
    const watcher = new MutationObserver(() => {
      if (total() !== before) { window.taken = performance.now() - window.begun; watcher.disconnect(); }
    });
    watcher.observe(document.body, {subtree: true, childList: true, characterData: true});
  }, true);
}"""


def layers_of(session: Session) -> int:
    """Make the bytes of all that an edit changes in the scene, and count them."""
    assert session.run is not None
    plan, size = session.run.plan, board_size_mm(session.board)
    lines = stroke_lines(plan)
    tints, _ = tint_strokes(lines, "function", [None] * len(lines))
    markers = markers_glb(find_markers(plan), size / 260)
    return len(strokes_glb(lines, tints, line_width_mm(size))) + len(transfers_glb(plan)) + len(markers)


def edited(session: Session, template: str, field: str, value: float) -> tuple[Session, list[float]]:
    """Edit a value and plan; seconds for the text, the plan, the layers."""
    times = [time.perf_counter()]
    session = session.set_value(("templates", template, field), value)
    times.append(time.perf_counter())
    session = replace(session, run=run(session.recipe, session.board))
    times.append(time.perf_counter())
    layers_of(session)
    times.append(time.perf_counter())
    return session, [after - before for before, after in pairwise(times)]


def on_the_server(session: Session, template: str) -> None:
    spec = session.recipe.templates[template].model_dump()
    for field in FIELDS:
        if not isinstance(spec.get(field), int | float):
            continue
        edits: list[list[float]] = []
        anew: list[float] = []
        for number in range(1, REPEATS + 1):
            session, parts = edited(session, template, field, spec[field] - number)
            edits.append(parts)
        for _ in range(2):
            board = load_board(Path(session.board_name))
            forget_routes()
            begun = time.perf_counter()
            run(session.recipe, board)
            anew.append(time.perf_counter() - begun)
        text, plan, layers = (1000 * statistics.median(column) for column in zip(*edits, strict=True))
        print(
            f"{template}.{field:11} server {text + plan + layers:5.0f} ms (text {text:.0f}, plan {plan:.0f}, lines "
            f"{layers:.0f}); planned anew {1000 * min(anew):.0f} ms"
        )


def in_the_browser(session: Session, template: str) -> None:
    spec = session.recipe.templates[template].model_dump()
    with tempfile.TemporaryDirectory() as folder, open_chromium() as browser:
        server = serve(session, open_project(Path(folder)), "127.0.0.1", 8160)
        tab = DrivenPage(browser, server.address)
        tab.dismiss_notice()
        tab.page.evaluate(WATCH)
        for field, label in FIELDS.items():
            if not isinstance(spec.get(field), int | float):
                continue
            taken: list[float] = []
            for number in range(1, REPEATS + 1):
                tab.edit(template, label, f"{spec[field] - number - 0.5:g}")
                tab.page.wait_for_function("window.taken > 0")
                taken.append(tab.page.evaluate("window.taken"))
                tab.page.wait_for_timeout(1500)
            print(
                f"{template}.{field:11} browser {statistics.median(taken):5.0f} ms "
                f"(from {min(taken):.0f} to {max(taken):.0f})"
            )
        server.stop()


def main() -> None:
    board, recipe, template = (*sys.argv[1:4], *("smt-demo", "smt-aqueous", "around")[len(sys.argv) - 1 :])
    session = open_session(board, recipe)
    session = replace(session, run=run(session.recipe, session.board))
    layers_of(session)
    on_the_server(session, template)
    if CHROMIUM is None:
        print("no chromium in /usr/bin: the browser's side is not measured")
    else:
        in_the_browser(session, template)


if __name__ == "__main__":
    main()
