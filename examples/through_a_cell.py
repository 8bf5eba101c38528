"""A board through a robot cell to a robot's program: plan, check, export.

python examples/through_a_cell.py [BOARD] [CELL] [DIALECT] [FOLDER]
"""

import sys
from pathlib import Path

from boards.load import load_board
from programs.export import find_dialect
from recipes.load import load_recipe
from reports.files.export_robot import export_in_cell
from reports.files.robot_files import write_program
from robotcell.cell.load import read_cell
from rulesengine.planning.pipeline import run


def main(board: str = "tiny", cell: str = "ur5e-bench", dialect: str = "ur", folder: str = "robot-program") -> None:
    """Plan a board, find the robot's joint motion for it, and write the program in the robot's language."""
    done = run(load_recipe("rinse-only"), load_board(Path(board)))
    result = export_in_cell(done.program, read_cell(cell), dialect, done.board)
    print(f"{cell}: {'can' if result.report.possible else 'cannot'} carry out the program")
    for finding in result.findings:
        print(f"  {finding.severity} {finding.rule.id}: {finding.message}")
    if result.report.possible:
        for file in write_program(Path(folder), result.exported.files, find_dialect(dialect)):
            print(f"written {file}")


if __name__ == "__main__":
    main(*sys.argv[1:])
