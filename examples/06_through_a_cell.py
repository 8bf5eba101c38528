"""A board through a robot cell to a robot's program: plan, check, export.

python examples/06_through_a_cell.py [BOARD] [CELL] [DIALECT] [FOLDER]
"""

import sys

import washboard as wb


def main(board: str = "tiny", cell: str = "ur5e-bench", dialect: str = "ur", folder: str = "robot-program") -> None:
    """Plan a board, find the robot's joint motion for it, and write the program in the robot's language."""
    robot = wb.check(wb.plan(board, "rinse-only"), cell)
    print(f"{cell}: {'can' if robot.possible else 'cannot'} carry out the program, in {len(robot.joints)} moves")
    for finding in robot.findings:
        print(f"  {finding.severity} {finding.rule.id}: {finding.message}")
    if robot.possible:
        for file in robot.export(folder, dialect):
            print(f"written {file}")


if __name__ == "__main__":
    main(*sys.argv[1:])
