"""What tuning finds from a poor recipe, against a plain grid search over the same knobs.

Run: ``OMP_NUM_THREADS=1 python benchmarks/tuning.py [--analyses 40] [--grid 400] [BOARD]``

The poor recipe only rushes across the board. The grid has around it what tuning adds by itself: paths around the
components and the rim, a slanted one across; their speeds, and how often washing and rinsing are done. It is analysed
in the order of the time that the programs take, which planning alone tells, up to the first that is clean: no grid
search needs fewer analyses to find its fastest clean recipe. Both are judged by the same fast analyses.
"""

import argparse
import itertools
import sys
import time
from pathlib import Path

from boards.load import load_board
from cleaning.load import load_parameters
from cleaning.subject import Subject, prepare
from recipes.load import recipe_library
from rulesengine.tuning.asked import Asked, Limits
from rulesengine.tuning.bench import Bench
from rulesengine.tuning.knobs import KINDS
from rulesengine.tuning.moves import Allowed
from rulesengine.tuning.outcome import Outcome, seconds_of
from rulesengine.tuning.search import tune

FILE = recipe_library()["smt-aqueous"].with_name("poor.yaml")
POOR = """recipe: poor
extends: smt-aqueous
templates:
  sweep: {speed_mm_s: 120}
sequence:
  - {function: clean, nozzle: ring60, paths: [sweep]}
  - {function: rinse, nozzle: ring60, paths: [sweep]}
"""
GRID = """recipe: poor
extends: smt-aqueous
templates:
  sweep: {{speed_mm_s: 60}}
  rim: {{path: board_perimeter, height_mm: 40, speed_mm_s: {rim}, offset_mm: 5, tilt_deg: 20}}
  across: {{path: raster, height_mm: 40, speed_mm_s: 40, direction_deg: across_longest_edge, tilt_deg: 25}}
  parts: {{path: component_perimeter, height_mm: 40, speed_mm_s: {parts}, tilt_deg: 39, passes: {passes}}}
sequence:
  - {{function: clean, nozzle: ring60, paths: [{paths}], repeat: {wash}}}
  - {{function: rinse, nozzle: ring60, paths: [{paths}], repeat: {rinse}}}
"""
PATHS = ("rim, parts", "rim, across, parts")
KNOBS = {"rim": (20, 40, 80), "parts": (10, 20, 40), "passes": (1, 2), "wash": (2, 4, 8), "rinse": (1, 2, 4)}
ALLOWED = Allowed(frozenset(KINDS) - {"pressure", "temperature"})


def grid_texts() -> list[str]:
    named = [dict(zip(KNOBS, values, strict=True)) for values in itertools.product(*KNOBS.values())]
    return [GRID.format(**values, paths=paths) for values in named for paths in PATHS]


def search_grid(subject: Subject, most: int) -> tuple[Outcome | None, int, int]:
    """The fastest clean recipe of the grid, how many analyses it took, and how many recipes there are."""
    texts = grid_texts()
    bench = Bench(FILE, subject, "clean", most)
    bench.first(POOR)
    planned = [(text, bench.planned(text)) for text in texts]
    timed = sorted((seconds_of(run), text) for text, run in planned if run is not None)
    for _, text in timed:
        outcome = bench.outcome(text)
        if outcome is None or outcome.clean:
            return outcome, bench.used - 1, len(texts)
    return None, bench.used - 1, len(texts)


def main() -> None:
    reader = argparse.ArgumentParser()
    reader.add_argument("board", nargs="?", default="tiny")
    reader.add_argument("--analyses", type=int, default=40)
    reader.add_argument("--grid", type=int, default=400)
    asked = reader.parse_args()
    subject = prepare(load_board(Path(asked.board)), load_parameters(), lambda *_: None)
    begin = time.perf_counter()
    tuned = tune(Bench(FILE, subject, "clean", asked.analyses), POOR, Asked("clean", Limits(), ALLOWED, asked.analyses))
    middle = time.perf_counter()
    last = tuned.last
    print(f"{asked.board}: {last.total} components")
    state = "clean" if last.clean else f"{len(last.wants)} judgements wanting"
    print(f"tuned: {state}, {last.seconds:.0f} s, {last.litres:.2f} l, {tuned.used} analyses ({middle - begin:.0f} s)")
    sys.stdout.flush()
    best, used, size = search_grid(subject, asked.grid)
    end = time.perf_counter()
    found = "no clean one" if best is None else f"clean, {best.seconds:.0f} s, {best.litres:.2f} l"
    print(f"grid of {size}: {found}, {used} analyses ({end - middle:.0f} s)")
    if best is None:
        return
    print(f"tuned / grid: time {last.seconds / best.seconds:.2f}, analyses {tuned.used / used:.2f}")
    if not last.clean or last.seconds > best.seconds or tuned.used > used:
        sys.exit("tuning is no better than the grid")


if __name__ == "__main__":
    main()
