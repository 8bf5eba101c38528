"""What tuning finds from a poor recipe, against a plain grid search over the same design variables.

Run: ``OMP_NUM_THREADS=1 python benchmarks/tuning.py [--analyses 40] [--grid 432] [BOARD]``

The poor recipe only rushes across the board. The grid has what tuning adds by itself: paths around the components and
the rim, a slanted one across; their speeds, and how often washing and rinsing are done. It is analysed in the order of
the time of the programs, which planning alone gives, up to the first that is as clean as the tuned one: no grid
search needs fewer analyses to find its fastest recipe of that cleanliness. Both are judged by the same fast analyses.
"""

import argparse
import itertools
import sys
import time
from pathlib import Path

from boards.load import load_board
from cleaning.parameters.load import load_parameters
from cleaning.prepared_board import PreparedBoard, prepare
from recipes.load import recipe_library
from rulesengine.tuning.report import explain
from rulesengine.tuning.trial.outcome import Outcome, seconds_of
from rulesengine.tuning.trial.request import AllowedChanges, ProgramLimits, TuningRequest
from rulesengine.tuning.trial.trial_runner import TrialRunner
from rulesengine.tuning.tune import tune
from rulesengine.tuning.variables.design_variables import CHANGE_KINDS
from specs.progress import no_progress

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
  sweep: {{speed_mm_s: {sweep}}}
  rim: {{path: board_perimeter, height_mm: 40, speed_mm_s: 40, offset_mm: 5, tilt_deg: 20}}
  across: {{path: raster, height_mm: 40, speed_mm_s: {across}, direction_deg: across_longest_edge, tilt_deg: 25}}
  parts: {{path: component_perimeter, height_mm: 40, speed_mm_s: {parts}, tilt_deg: 39, passes: {passes}}}
sequence:
  - {{function: clean, nozzle: ring60, paths: [{paths}], repeat: {wash}}}
  - {{function: rinse, nozzle: ring60, paths: [{paths}], repeat: {rinse}}}
"""
GRID_VALUES = {
    "sweep": (40, 80),
    "across": (0, 10, 20, 40),
    "parts": (10, 20, 40),
    "passes": (1, 2),
    "wash": (2, 4, 8),
    "rinse": (1, 2, 4),
}
"""Speeds in mm/s; 0: there is no such path."""
ALLOWED = AllowedChanges(frozenset(CHANGE_KINDS) - {"pressure", "temperature"})


def grid_texts() -> list[str]:
    texts: list[str] = []
    for values in itertools.product(*GRID_VALUES.values()):
        named = dict(zip(GRID_VALUES, values, strict=True))
        paths = "rim, sweep, across, parts" if named["across"] else "rim, sweep, parts"
        texts.append(GRID.format(**named | {"across": named["across"] or 40}, paths=paths))
    return texts


def as_clean(outcome: Outcome, other: Outcome) -> bool:
    return len(outcome.unmet) <= len(other.unmet) and outcome.shortfall <= other.shortfall


def search_grid(prepared: PreparedBoard, tuned: Outcome, most: int) -> tuple[Outcome | None, int, int]:
    """The fastest recipe of the grid that is as clean, how many analyses it took, and how many recipes there are."""
    texts = grid_texts()
    runner = TrialRunner(FILE, prepared, "clean", most + 1)
    runner.first(POOR)
    timed = sorted((seconds_of(run), text) for text in texts if (run := runner.planned(text)) is not None)
    for seconds, text in timed:
        outcome = runner.outcome(text)
        if outcome is None or as_clean(outcome, tuned):
            return outcome, runner.used - 1, len(texts)
        state = f"{runner.used - 1} of {len(timed)}, {seconds:.0f} s: {len(outcome.unmet)} requirements open"
        print(state, end="\r", file=sys.stderr, flush=True)
    return None, runner.used - 1, len(texts)


def main() -> None:
    reader = argparse.ArgumentParser()
    reader.add_argument("board", nargs="?", default="tiny")
    reader.add_argument("--analyses", type=int, default=40)
    reader.add_argument("--grid", type=int, default=432)
    options = reader.parse_args()
    prepared = prepare(load_board(Path(options.board)), load_parameters(), no_progress)
    begin = time.perf_counter()
    tuned = tune(
        TrialRunner(FILE, prepared, "clean", options.analyses),
        POOR,
        TuningRequest("clean", ProgramLimits(), ALLOWED, options.analyses),
    )
    middle = time.perf_counter()
    last = tuned.last
    print(f"{options.board}: {last.total} components")
    state = (
        "clean" if last.clean else "not met: " + "; ".join(f"{each.component} {each.rule}" for each in explain(tuned))
    )
    print(f"tuned: {state}, {last.seconds:.0f} s, {last.litres:.2f} l, {tuned.used} analyses ({middle - begin:.0f} s)")
    sys.stdout.flush()
    best, used, size = search_grid(prepared, last, options.grid)
    end = time.perf_counter()
    found = "none as clean" if best is None else f"{best.seconds:.0f} s, {best.litres:.2f} l"
    print(f"grid of {size}: {found}, {used} analyses ({end - middle:.0f} s)")
    if best is None:
        return
    print(f"tuned / grid: time {last.seconds / best.seconds:.2f}, analyses {tuned.used / used:.2f}")
    if last.seconds > best.seconds or tuned.used > used:
        sys.exit("tuning is no better than the grid")


if __name__ == "__main__":
    main()
