"""What levelling saves on a board at equal deposit: seconds, litres, and verdicts that differ.

    OMP_NUM_THREADS=1 python benchmarks/level_board.py [BOARD] [RECIPE]

Rasters and flushes get the speeds of least time at which each component, and the bare board, keeps what nine tenths of
its cells have. Ends with 1 if the timed program lays less, takes longer, or fewer components are clean.
"""

import sys
import time

from boards.load import board_library, load_board
from cleaning.analyse import analyse
from cleaning.parameters.load import load_parameters
from recipes.load import load_recipe
from rulesengine.levelling.level_plan import level_plan
from rulesengine.planning.pipeline import run
from rulesengine.timing.time_plan import time_plan

MOST_SHORT = 2e-3


def main(board_name: str = "smt-demo", recipe_name: str = "smt-aqueous") -> int:
    """Level one board and compare."""
    done = run(load_recipe(recipe_name), load_board(board_library()[board_name]))
    begin = time.process_time()
    plan, report = level_plan(done.plan, done.board, done.fitted, "least-time")
    took = time.process_time() - begin
    before, after = report.before, report.after
    print(f"{board_name} with {recipe_name}: {took:.0f} s of processor time")
    for step in report.steps:
        times = f"{step.spray_before_s:.1f} to {step.spray_after_s:.1f} s" if step.levelled else "keeps its speeds"
        short = [100 * each.deviation for each in (step.timed.planned, step.timed.finer)]
        print(
            f"  {step.function}: {times}, {step.surfaces} surfaces, short by {short[0]:.2f} % "
            f"({short[1]:.2f} % on finer cells)"
        )
    for name, unit, one, other in (
        ("time", "s", before.duration_s, after.duration_s),
        ("spraying", "s", before.spray_s, after.spray_s),
        ("liquid", "l", before.litres, after.litres),
    ):
        print(f"  {name:9} {one:8.3f} {unit} to {other:8.3f} {unit}, {100 * (other / one - 1):+.1f} %")
    clean: list[int] = []
    for program in (done.program, time_plan(plan, done.fitted.limits)):
        found = analyse(program, done.board, done.fitted, load_parameters("default"))
        clean.append(sum(part.verdict == "clean" for part in found.parts))
    print(f"  clean and dry underneath: {clean[0]} to {clean[1]} of {len(done.board.components)} components")
    short = max(step.timed.planned.deviation for step in report.steps)
    return int(short > MOST_SHORT or after.duration_s > before.duration_s or clean[1] < clean[0])


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
