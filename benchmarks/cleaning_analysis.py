"""What a program cleans, from the loaded board to the verdicts: stages, total, growth with the board, and how exact.

Run: ``OMP_NUM_THREADS=1 python benchmarks/cleaning_analysis.py [--recipe RECIPE] [--most 16] [BOARD]``

Three parts. Stages: one analysis of the board's program, which should take ten seconds. Exactness: what the rays of
that analysis say of the mean volume on some components, beside the exact integral. Growth: panels of 1, 4 and 16 copies
of the board (up to ``--most``), each planned and analysed anew. Times are processor seconds of all threads unless it
says clock.
"""

import argparse
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from plan import panel

from boards.board import Board
from boards.load import load_board
from boards.understand import understand
from cleaning.analyse import analyse_on
from cleaning.parameters.load import load_parameters
from cleaning.prepared_board import PreparedBoard, prepare
from cleaning.verdicts.results import CleaningReport
from cleaning.verify import verify
from recipes.load import load_recipe
from recipes.recipe import Recipe
from rulesengine.planning.pipeline import run

GOAL_S = 10.0
VERIFIED = 12
"""Components that are worked out exactly."""
ROUNDS = 3
PHASES = {
    "flushing under parts": "exposure",
    "judging": "gaps",
    "done": "verdicts",
}
"""What has been done when the analysis tells this for the first time."""


@dataclass(frozen=True)
class Analysed:
    """One analysis and what it took."""

    prepared: PreparedBoard
    report: CleaningReport
    seconds: dict[str, float]
    """By phase, in order."""
    clock_s: float

    @property
    def total_s(self) -> float:
        """All phases together."""
        return sum(self.seconds.values())


def analysed(board: Board, recipe: Recipe) -> Analysed:
    """Analyse a board's program at the effort that is used where none is named."""
    program, parameters = run(recipe, board).program, load_parameters()
    clock, begin = time.perf_counter(), time.process_time()
    prepared = prepare(board, parameters, lambda *_: None)
    marks = {"prepare": time.process_time()}

    def note(what: str, _done: float) -> None:
        if what in PHASES:
            marks.setdefault(PHASES[what], time.process_time())

    report = analyse_on(prepared, program, recipe, progress=note)
    clock = time.perf_counter() - clock
    took = np.diff([begin, *marks.values()])
    return Analysed(prepared, report, dict(zip(marks, took.tolist(), strict=True)), clock)


def tell_stages(board: Board, recipe: Recipe) -> Analysed:
    rounds = [analysed(board, recipe) for _ in range(ROUNDS)]
    best = min(rounds, key=lambda each: each.total_s)
    report = best.report
    samples, rays = sum(len(each.samples.times) for each in report.stages), sum(each.rays for each in report.exposures)
    triangles = sum(len(body.patches) for body in board.bodies)
    print(
        f"{board.name}: {triangles:,} triangles, {len(report.parts)} components, {len(best.prepared.undersides)} gaps"
    )
    print(f"  program of {report.duration_s:.0f} s: {samples:,} samples, {rays:,} rays")
    print("  " + ", ".join(f"{name} {seconds:.2f} s" for name, seconds in best.seconds.items()))
    clocks = " ".join(f"{each.clock_s:.1f}" for each in rounds)
    print(
        f"  in all {best.total_s:.2f} s, {best.total_s / GOAL_S:.2f} of {GOAL_S:g} s; by the clock {clocks} s; "
        f"1 / {report.duration_s / best.total_s:.0f} of the program's own time"
    )
    return best


def tell_exactness(done: Analysed) -> None:
    names = [part.component for part in done.report.parts]
    begin = time.process_time()
    found = verify(done.report, done.prepared, names[:: max(1, len(names) // VERIFIED)][:VERIFIED])
    took = time.process_time() - begin
    print(f"exact integral on {len({each.component for each in found})} components: {took:.2f} s")
    for function in dict.fromkeys(each.function for each in found):
        pairs = np.array([(each.rays_mm, each.exact_mm) for each in found if each.function == function])
        pairs = pairs[pairs[:, 1] > 0]
        error = pairs[:, 0] / pairs[:, 1] - 1
        print(f"  {function}: mean volume {error.mean():+.1%}, rms {error.std():.1%}, worst {np.abs(error).max():.1%}")


def tell_growth(board: Board, recipe: Recipe, most: int) -> None:
    base: float | None = None
    for across, up in ((1, 1), (2, 2), (4, 4)):
        if across * up > most:
            break
        done = analysed(understand(panel(board.bodies, across, up), "panel"), recipe)
        base = base or done.total_s
        phases = ", ".join(f"{name} {seconds:.2f} s" for name, seconds in done.seconds.items())
        times = done.total_s / (base * across * up)
        print(
            f"panel of {across * up}: {phases}; in all {done.total_s:.1f} s, {times:.2f} times as much for each board"
        )


def main(words: list[str]) -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("board", nargs="?", type=Path, default=Path("smt-demo"))
    parser.add_argument("--recipe", default="smt-aqueous")
    parser.add_argument("--most", type=int, default=16, help="copies of the board in the largest panel")
    arguments = parser.parse_args(words)
    board, recipe = load_board(arguments.board), load_recipe(arguments.recipe)
    done = tell_stages(board, recipe)
    print()
    tell_exactness(done)
    print()
    tell_growth(board, recipe, arguments.most)


if __name__ == "__main__":
    main(sys.argv[1:])
