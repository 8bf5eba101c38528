"""Plan a board and look at it: open, plan, print what was found, draw the paths.

python examples/01_plan_and_look.py [WORKPIECE] [RECIPE] [PICTURE.png]
"""

import sys
from pathlib import Path

import washboard as wb


def main(workpiece: str = "tiny", recipe: str = "smt-aqueous", picture: str = "plan.png") -> None:
    """Plan a workpiece with a recipe, and draw where the nozzle goes."""
    plan = wb.plan(workpiece, recipe)
    print(
        f"{plan.workpiece.name} with {plan.recipe.recipe}: {plan.duration_s:.1f} s, {sum(plan.litres.values()):.2f} l"
    )
    for finding in plan.findings:
        print(f"  {finding.severity} {finding.rule.id} {finding.made_by}: {finding.message}")
    Path(picture).write_bytes(plan.picture(Path(picture).suffix))
    print(f"drawn in {picture}")


if __name__ == "__main__":
    main(*sys.argv[1:])
