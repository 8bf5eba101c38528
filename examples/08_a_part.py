"""A part of any shape: stripes over its faces, and the time that each is held in the cone.

python examples/08_a_part.py [PART] [RECIPE] [PICTURE.png]
"""

import sys
from pathlib import Path

import washboard as wb


def main(part: str = "f-bracket", recipe: str = "part-degrease", picture: str = "part.png") -> None:
    """Plan a part, judge its faces, and draw both."""
    opened = wb.open_recipe(recipe)
    plan = wb.plan(wb.open_workpiece(part, opened), opened)
    clean = wb.analyse(plan)
    print(f"{part}: {plan.duration_s:.0f} s over {len(plan.workpiece.faces)} faces, {clean.verdict}")
    for each in clean.verdicts:
        print(f"  {each.face}: {each.verdict}, {each.held_share:.1%} of what can be seen is held")
    Path(picture).write_bytes(plan.picture(Path(picture).suffix))


if __name__ == "__main__":
    main(*sys.argv[1:])
