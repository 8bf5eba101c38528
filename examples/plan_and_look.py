"""Plan a board and look at it: load, plan, print what was found, draw the paths.

python examples/plan_and_look.py [BOARD] [RECIPE] [PICTURE.png]
"""

import sys
from pathlib import Path

from boards.load import load_board
from recipes.load import load_recipe
from reports.pictures.plan_picture import draw_plan
from rulesengine.planning.pipeline import run


def main(board: str = "tiny", recipe: str = "smt-aqueous", picture: str = "plan.png") -> None:
    """Plan a board with a recipe, and draw where the nozzle goes."""
    done = run(load_recipe(recipe), load_board(Path(board)))
    totals = done.program.totals
    print(f"{done.board.name} with {done.recipe.recipe}: {totals.duration_s:.1f} s, {totals.moves} moves")
    for finding in done.findings:
        print(f"  {finding.severity} {finding.rule.id} {finding.made_by}: {finding.message}")
    Path(picture).write_bytes(draw_plan(done.board, done.program, Path(picture).suffix))
    print(f"drawn in {picture}")


if __name__ == "__main__":
    main(*sys.argv[1:])
