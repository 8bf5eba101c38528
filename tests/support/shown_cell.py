"""A robot on a table with the smallest board before it, and a way for it to move: to look at, not to spray with."""

from functools import cache
from pathlib import Path

import numpy as np

import robotcell
from programs.program import MoveTo, TimedProgram
from robotcell.cell.cell import Cell, Tool
from robotcell.robot.robot import Body, Box, Capsule, pose
from robotcell.robot.urdf import read_urdf

ROBOTS = Path(robotcell.__file__).parent / "library" / "robots"


@cache
def shown_cell() -> Cell:
    robot = read_urdf(ROBOTS / "ur5e" / "ur5e.urdf")
    lance = Body("lance", Capsule(0.008, 0.16), pose((0, 0, 0.08), (0, 0, 0)))
    knife = Body("knife", Box((0.08, 0.02, 0.1)), pose((0, 0, 0.05), (0, 0, 0)))
    return Cell(
        name="bench",
        robot=robot,
        T_cell_base=np.eye(4),
        T_cell_board=pose((0.45, -0.05, 0.1), (0, 0, 0)),
        home=np.radians([180.0, -110.0, 110.0, -90.0, -90.0, 0.0]),
        tools=(
            Tool(1, "lance", pose((0, 0, 0.17), (0, 0, 0)), (lance,)),
            Tool(2, "knife", pose((0, 0, 0.1), (0, 0, 0)), (knife,)),
        ),
        fixtures=(Body("table", Box((1.4, 0.9, 0.02)), pose((0.4, 0, -0.012), (0, 0, 0))),),
        margin=0.005,
    )


def sway(cell: Cell, program: TimedProgram) -> np.ndarray:
    """(moves, dof) joints that swing about home as the TCP goes about."""
    places = np.array([item.position for item in program.instructions if isinstance(item, MoveTo)])
    return cell.home + 0.2 * np.sin(0.02 * places @ np.linspace(-1.0, 1.0, 3 * cell.robot.dof).reshape(3, -1))
