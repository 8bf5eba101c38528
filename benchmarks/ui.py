"""From an edit to the picture: on the server, and as seen in a browser, against planning everything anew.

Run: ``OMP_NUM_THREADS=1 python benchmarks/ui.py BOARD [RECIPE] [TEMPLATE]``

Edits the speed, the height and the tilt of one template, again and again, each time to a value that was not there
before. "Paths" is the time to the new paths: those of the sketch where the order has to be searched for, else those of
the run. "Run" is the time to the final program. The server's side is all that happens between the value and the bytes
that are sent: the text, the plan, the lines of the scene. "Anew" is a run on a board that was just loaded, without
anything remembered. The browser's side begins with the Enter key; the new lines come in the same message as the words
that are waited for. Chromium draws without a graphics card here, on the processor that plans: a desk's browser is
quicker.
"""

import statistics
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "support"))

from driven_page import CHROMIUM, DrivenPage, open_chromium

from boards.load import load_board
from geometry.coverage.route import forget_routes
from programs.plan import Plan
from rulesengine.planning.pipeline import run
from specs.progress import no_progress
from webui.glb.glb import line_width_mm, size_mm
from webui.layers.paths.nozzle import find_markers, markers_glb
from webui.layers.paths.strokes import stroke_lines, strokes_glb, tint_strokes, transfers_glb
from webui.page.page import freeze_gc
from webui.page.project import open_project
from webui.page.session import Session
from webui.server.server import open_session, serve

FIELDS = {"speed_mm_s": "Speed (mm/s)", "height_mm": "Height (mm)", "tilt_deg": "Tilt (\N{DEGREE SIGN})"}
REPEATS, ANEW_EVERY = 20, 5
STEP = 0.5
"""Between the values of two edits."""
BEGIN = 35.0
"""First value where the recipe states a word, such as a height that is worked out."""
QUIET_MS = 3000
"""Between two edits: until the playback has taken up the last one."""
WATCH = """() => {
  const said = selector => document.querySelector(selector)?.textContent ?? '';
  document.addEventListener('keydown', event => {
    if (event.key !== 'Enter') return;
    const begun = performance.now(), total = said('[data-total]');
    let waited = false;
    window.paths = window.whole = 0;
    const watcher = new MutationObserver(() => {
      const planned = said('[data-progress]').startsWith('Planned');
      waited ||= !planned;
      if (!window.paths && said('[data-sketch]')) window.paths = performance.now() - begun;
      if (!planned || !waited && said('[data-total]') === total) return;
      window.whole = performance.now() - begun;
      window.paths ||= window.whole;
      watcher.disconnect();
    });
    watcher.observe(document.body, {subtree: true, childList: true, characterData: true});
  }, true);
}"""


def layers_of(session: Session, plan: Plan) -> int:
    """Make the bytes of all that an edit changes in the scene, and count them."""
    size = size_mm(session.workpiece)
    lines = stroke_lines(plan)
    tints, _ = tint_strokes(lines, "function", [None] * len(lines))
    markers = markers_glb(find_markers(plan), size / 260)
    return len(strokes_glb(lines, tints, line_width_mm(size))) + len(transfers_glb(plan)) + len(markers)


def edited(session: Session, template: str, field: str, value: float) -> tuple[Session, list[float]]:
    """Edit a value and plan it as the page does; seconds of the text, to the paths, to the run."""
    begun = time.perf_counter()
    session = session.set_value(("templates", template, field), value)
    read = time.perf_counter()
    seen: list[float] = []

    def sketched(plan: Plan) -> None:
        layers_of(session, plan)
        seen.append(time.perf_counter())

    done = run(session.recipe, session.board, no_progress, sketched, session.run)
    layers_of(session, done.plan)
    seen.append(time.perf_counter())
    return replace(session, run=done), [read - begun, seen[0] - begun, seen[-1] - begun]


def first_value(spec: dict[str, object], field: str) -> float:
    """The value that the recipe states, or one to begin with."""
    stated = spec[field]
    return float(stated) if isinstance(stated, int | float) else BEGIN


def planned_anew(session: Session) -> float:
    """Seconds of a run without anything remembered."""
    board = load_board(Path(session.workpiece_name))
    forget_routes()
    begun = time.perf_counter()
    run(session.recipe, board)
    return time.perf_counter() - begun


def on_the_server(session: Session, template: str) -> None:
    spec = session.recipe.templates[template].model_dump()
    for field in FIELDS:
        if field not in spec:
            continue
        begin = first_value(spec, field)
        edits: list[list[float]] = []
        anew: list[float] = []
        for number in range(1, REPEATS + 1):
            session, parts = edited(session, template, field, begin - STEP * number)
            edits.append(parts)
            if number % ANEW_EVERY == 1:
                anew.append(planned_anew(session))
        text, paths, whole = (1000 * statistics.median(column) for column in zip(*edits, strict=True))
        full = 1000 * statistics.median(anew)
        print(
            f"{template}.{field:11} server: text {text:.0f} ms, paths {paths:.0f} ms, run {whole:.0f} ms; planned "
            f"anew {full:.0f} ms, {full / paths:.1f} times the paths and {full / whole:.1f} times the run",
            flush=True,
        )


def in_the_browser(session: Session, template: str) -> None:
    spec = session.recipe.templates[template].model_dump()
    run(session.recipe, session.board)  # what is remembered was forgotten to plan anew
    with tempfile.TemporaryDirectory() as folder, open_chromium() as browser:
        server = serve(session, open_project(Path(folder)), "127.0.0.1", 8160)
        tab = DrivenPage(browser, server.address, all_frames=True)
        tab.dismiss_notice()
        tab.page.evaluate(WATCH)
        for field, label in FIELDS.items():
            if field not in spec:
                continue
            begin = first_value(spec, field)
            taken: dict[str, list[float]] = {"paths": [], "whole": []}
            for number in range(1, REPEATS + 1):
                tab.page.wait_for_timeout(QUIET_MS)
                tab.edit(template, label, f"{begin - STEP * (number + 0.5):g}")
                tab.page.wait_for_function("window.whole > 0")
                for what, times in taken.items():
                    times.append(tab.page.evaluate(f"window.{what}"))
            told = ", ".join(
                f"{name} {statistics.median(times):.0f} ms (from {min(times):.0f} to {max(times):.0f})"
                for name, times in zip(("paths", "run"), taken.values(), strict=True)
            )
            print(f"{template}.{field:11} browser: {told}", flush=True)
        server.stop()


def main() -> None:
    board, recipe, template = (*sys.argv[1:4], *("smt-demo", "smt-aqueous", "around")[len(sys.argv) - 1 :])
    session = open_session(board, recipe)
    first = run(session.recipe, session.board)
    session = replace(session, run=first)
    layers_of(session, first.plan)
    freeze_gc()
    on_the_server(session, template)
    if CHROMIUM is None:
        print("no chromium in /usr/bin: the browser's side is not measured")
    else:
        in_the_browser(session, template)


if __name__ == "__main__":
    main()
