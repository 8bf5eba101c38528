"""A placement as a search finds it, without one: a board 30 mm nearer to the robot, and a map of a few nodes."""

from functools import cache
from types import SimpleNamespace

import numpy as np
from placed_parts import flat_top
from tiny_session import tiny_session

from robotcell.cell.load import hold_board, read_cell
from robotcell.placement.configurations import describe_placement
from robotcell.placement.evaluate import PlacementGoal
from robotcell.placement.optimise import judge_placement
from robotcell.placement.placement_map import PlacementMap
from robotcell.robot.robot import pose
from robotcell.search_placement import PlacementTrial, Relocation


@cache
def found_place() -> Relocation:
    """A place 30 mm nearer, as a search gives it, with a map of 4 x 3 nodes."""
    loaded, session = read_cell("ur5e-bench"), tiny_session()
    cell = hold_board(loaded, session.workpiece).cell
    moved = cell.with_held_at(pose((-0.03, 0, 0), (0, 0, 0)) @ cell.held_pose)
    targets, goal = flat_top(3, 2), PlacementGoal()
    trials = [
        PlacementTrial(judge_placement(each, targets, goal), each, SimpleNamespace(cell=each, findings=()))
        for each in (cell, moved)
    ]
    details = describe_placement(moved, targets, goal)
    values = np.linspace(-1.0, 0.1, 24).reshape(4, 3, 2)
    mapped = PlacementMap(
        np.linspace(-0.2, 0.4, 4), np.linspace(-0.3, 0.3, 3), np.array([0.0, np.pi]), values, (3, 2, 1),
        details.score, moved.T_cell_board,
    )  # fmt: skip
    return Relocation(trials[0], (trials[1],), 296, details, mapped, session.workpiece)
