"""A search of your own: the fastest raster at which a board is still rinsed everywhere, by bisection.

python examples/13_your_own_loop.py [BOARD] [TEMPLATE]
"""

import sys

import washboard as wb


def main(board: str = "tiny", template: str = "sweep") -> None:
    """Halve the range of speeds until it is narrow; each plan takes what still holds from the one before."""
    opened, recipe = wb.open_board(board), wb.open_recipe("rinse-only")
    plan = wb.plan(opened, recipe)
    low, high = 20.0, 120.0
    while high - low > 10.0:
        middle = (low + high) / 2
        plan = wb.plan(opened, recipe.edit(f"templates.{template}.speed_mm_s", middle), before=plan)
        slow = [
            each for each in plan.findings if each.rule.id == "speed-below-programmed" and each.severity == "warning"
        ]
        low, high = (low, middle) if slow else (middle, high)
        print(f"{middle:.0f} mm/s: {plan.duration_s:.1f} s, {len(slow)} strokes slower than programmed")
    print(f"{template} keeps {low:.0f} mm/s")


if __name__ == "__main__":
    main(*sys.argv[1:])
