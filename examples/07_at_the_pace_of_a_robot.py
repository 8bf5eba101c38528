"""A program at the pace of a robot: what its limits cost in time.

python examples/07_at_the_pace_of_a_robot.py [BOARD] [CELL]
"""

import sys

import washboard as wb


def main(board: str = "tiny", cell: str = "ur5e-bench") -> None:
    """Plan twice: within the limits of the recipe, and within those of the robot too."""
    recipe = wb.open_recipe("rinse-only")
    free = wb.plan(board, recipe)
    paced = wb.plan(free.workpiece, recipe, cell=cell)
    print(f"{free.duration_s:.1f} s within the limits of the recipe, {paced.duration_s:.1f} s for {cell}")


if __name__ == "__main__":
    main(*sys.argv[1:])
