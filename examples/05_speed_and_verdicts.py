"""The effect of one speed on the verdicts: plan and analyse a board at several speeds of one template.

python examples/05_speed_and_verdicts.py [BOARD] [TEMPLATE] [SPEED ...]
"""

import sys
from collections import Counter

import washboard as wb


def main(board: str = "tiny", template: str = "around", *speeds_mm_s: str) -> None:
    """Print time and verdicts for each speed of a template."""
    opened, recipe = wb.open_board(board), wb.open_recipe("smt-aqueous")
    plan, clean = None, None
    for speed_mm_s in map(float, speeds_mm_s or ("60", "30", "15")):
        # Strokes of templates that stay as they are, and the board made ready for the model, are taken from before.
        plan = wb.plan(opened, recipe.edit(f"templates.{template}.speed_mm_s", speed_mm_s), before=plan)
        clean = wb.analyse(plan, before=clean)
        counts = ", ".join(
            f"{count} {name}" for name, count in sorted(Counter(v.outcome for v in clean.verdicts).items())
        )
        print(f"{template} at {speed_mm_s:g} mm/s: {plan.duration_s:.0f} s, {counts}")


if __name__ == "__main__":
    main(*sys.argv[1:])
