"""What tuning finds from a poor recipe, against a seeded random search over the same variables, board after board.

Run: ``OMP_NUM_THREADS=1 python benchmarks/tuning.py [--analyses 40] [--random 60] [--seed 1] [--jobs 2] [BOARD ...]``

The poor recipe only rushes across the board, on one side. The random search has all the paths that tuning adds by
itself, on each side that has components, and draws what tuning may change: their speeds, heights, tilts, passes,
pauses and repeats, and which of them there are. Its ranges are narrower than those of tuning, around what was good
before, so that it is a strong reference. Both are judged by the same fast analyses and by the objective of tuning:
first the shortfall of what a recipe can meet, then the seconds of the program. The ratio is the time of the tuned
recipe over that of the fastest recipe of the random search that is as clean; above 1.05, or where one is cleaner, the
run fails.
"""

import argparse
import math
import random
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path

from boards.load import load_board
from cleaning.parameters.load import load_parameters
from cleaning.prepared_board import PreparedBoard, prepare
from recipes.load import recipe_library
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.request import AllowedChanges, ProgramLimits, TuningRequest
from rulesengine.tuning.trial.requirements import total_shortfall
from rulesengine.tuning.trial.trial_runner import TrialRunner
from rulesengine.tuning.tune import tune
from rulesengine.tuning.variables import CHANGE_KINDS
from specs.progress import no_progress

FILE = recipe_library()["smt-aqueous"].with_name("poor.yaml")
BOARDS = ("tiny", "two-sided", "sensor-hub", "radio-stick")
POOR = """recipe: poor
extends: smt-aqueous
templates:
  sweep: {speed_mm_s: 120}
sequence:
  - {function: clean, nozzle: ring60, paths: [sweep]}
  - {function: rinse, nozzle: ring60, paths: [sweep]}
"""
ALLOWED = AllowedChanges(frozenset(CHANGE_KINDS) - {"pressure", "temperature"})
MOST_RATIO = 1.05
SPEEDS_MM_S, RINSE_SPEEDS_MM_S = (6.0, 80.0), (15.0, 140.0)
HEIGHTS_MM = (20.0, 60.0)
PRESENT = 0.6
"""Chance of each path but the first of a step."""


@dataclass(frozen=True, slots=True)
class Row:
    """What one board showed."""

    board: str
    components: int
    tuned: str
    used: int
    random: str
    ratio: float
    """Infinite where the random search found a cleaner recipe, 0 where none of it is as clean."""
    seconds: tuple[float, float]
    """By the clock: tuning, random search."""


def random_text(draw: random.Random, sides: list[str]) -> str:
    """One recipe of the random search."""

    def between(low: float, high: float) -> float:
        return round(math.exp(draw.uniform(math.log(low), math.log(high))), 1)

    templates: list[str] = []
    steps: list[str] = []
    for function, speeds, most in (("clean", SPEEDS_MM_S, 8), ("rinse", RINSE_SPEEDS_MM_S, 4)):
        paths: list[str] = []
        for word, spec in (
            ("sweep", "path: raster, direction_deg: longest_edge, overlap: 0.3, margin_mm: 3"),
            ("rim", "path: board_perimeter, offset_mm: 5, tilt_deg: 20"),
            ("across", f"path: raster, direction_deg: across_longest_edge, tilt_deg: {draw.randint(0, 30)}"),
            ("parts", "path: component_perimeter, tilt_deg: "
             f"{draw.randint(31, 45)}, passes: {draw.randint(1, 4)}, edge_delay_s: {round(draw.uniform(0, 1), 1)}"),
        ):  # fmt: skip
            if not paths or draw.random() < PRESENT:
                paths.append(f"{word}_{function}")
                numbers = f"height_mm: {between(*HEIGHTS_MM)}, speed_mm_s: {between(*speeds)}"
                templates.append(f"  {paths[-1]}: {{{spec}, {numbers}}}")
        repeat = draw.randint(1, most)
        steps += [
            f"  - {{function: {function}, nozzle: ring60, side: {side}, paths: [{', '.join(paths)}], repeat: {repeat}}}"
            for side in sides
        ]
    steps.sort(key=lambda step: "side: bottom" in step)  # the board turns once
    return "\n".join(["recipe: poor", "extends: smt-aqueous", "templates:", *templates, "sequence:", *steps, ""])


def objective(outcome: Outcome) -> tuple[float, float]:
    """Shortfall of what a recipe can meet, then the time: less is better."""
    return total_shortfall(outcome.attainable), outcome.seconds


def search_randomly(prepared: PreparedBoard, tuned: Outcome, most: int, seed: int) -> tuple[Outcome, Outcome | None]:
    """The best recipe by the objective, and the fastest that is as clean as the tuned one."""
    draw = random.Random(seed)
    sides = sorted({component.side for component in prepared.board.components}, reverse=True)
    runner = TrialRunner(FILE, prepared, "clean", most + 1)
    runner.first(POOR)  # so that its warnings are no obstacle
    found: list[Outcome] = []
    while len(found) < most:
        outcome = runner.outcome(random_text(draw, sides))
        found += [] if outcome is None else [outcome]
        print(f"{prepared.board.name}: random {len(found)} of {most}", end="\r", file=sys.stderr, flush=True)
    clean = [each for each in found if objective(each)[0] <= objective(tuned)[0]]
    return min(found, key=objective), min(clean, key=lambda each: each.seconds, default=None)


def measure(board: str, analyses: int, most: int, seed: int) -> Row:
    """Tune one board, and search it randomly."""
    prepared = prepare(load_board(Path(board)), load_parameters(), no_progress)
    begin = time.perf_counter()
    request = TuningRequest("clean", ProgramLimits(), ALLOWED, analyses)
    tuned = tune(TrialRunner(FILE, prepared, "clean", analyses), POOR, request)
    middle = time.perf_counter()
    best, fastest = search_randomly(prepared, tuned.last, most, seed)
    end = time.perf_counter()
    if objective(best)[0] < objective(tuned.last)[0]:
        ratio = math.inf
    else:
        ratio = 0.0 if fastest is None else tuned.last.seconds / fastest.seconds
    return Row(
        board, tuned.last.total, _words(tuned.last), tuned.used, _words(best), ratio, (middle - begin, end - middle)
    )


def _words(outcome: Outcome) -> str:
    return f"{outcome.figures.clean_components} clean, {outcome.seconds:.0f} s, {outcome.litres:.1f} l"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("boards", nargs="*", default=BOARDS, metavar="BOARD")
    parser.add_argument("--analyses", type=int, default=40)
    parser.add_argument("--random", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1, help="boards at a time")
    options = parser.parse_args()
    print(f"{'board':12} {'parts':>5}  {'tuned':30} {'analyses':>8}  {'best of random':30} {'ratio':>12}   took")
    work = partial(measure, analyses=options.analyses, most=options.random, seed=options.seed)
    worst = 0.0
    with ProcessPoolExecutor(options.jobs, mp_context=get_context("spawn")) as pool:
        for row in pool.map(work, options.boards):
            ratio = "none as clean" if row.ratio == 0 else f"{row.ratio:.2f}"
            took = " + ".join(f"{each:.0f} s" for each in row.seconds)
            print(
                f"{row.board:12} {row.components:5}  {row.tuned:30} {row.used:8}  {row.random:30} {ratio:>12}   {took}",
                flush=True,
            )
            worst = max(worst, row.ratio)
    print(
        f"ratio: time of the tuned over the fastest of {options.random} random recipes, seed {options.seed}, as clean"
    )
    if worst > MOST_RATIO:
        print(f"tuning is worse than the random search by more than {MOST_RATIO:g}")
    return int(worst > MOST_RATIO)


if __name__ == "__main__":
    sys.exit(main())
