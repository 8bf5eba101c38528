"""Placements as four numbers: which there are, their poses, and where there is room. Metres, radians."""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from robotcell.placement.evaluate import PlacementTask
from robotcell.placement.room import HasRoom
from robotcell.robot.poses import inverse, pose
from robotcell.robot.robot import Poses

Spot: TypeAlias = NDArray[np.float64]
"""(4,) distance from the base's axis, own yaw, height, direction about the base's axis."""
Spots: TypeAlias = NDArray[np.float64]
"""(n, 4)"""

_DIRECTIONS = np.radians(5.0)
_OTHER_DIRECTIONS = 3


class SearchSpace:
    """Placements as four numbers: where they are, and whether there is room."""

    def __init__(self, task: PlacementTask, has_room: HasRoom | None) -> None:
        cell, goal = task.cell, task.goal
        self.has_room: HasRoom = has_room or (lambda _: True)
        self.T_cell_base = cell.T_cell_base
        self._T_base_board = inverse(cell.T_cell_base) @ cell.T_cell_board
        self._centre = np.append(task.targets.T_board_tcp[:, :3, 3].mean(axis=0), 1.0)
        self._middle = (self._T_base_board @ self._centre)[:3]
        self.here: Spot = np.array([float(np.linalg.norm(self._middle[:2])), 0.0, 0.0, 0.0])
        spans = np.array([goal.distance, goal.yaw, goal.height])
        self.low, self.high = spans[:, 0], spans[:, 1]
        self.searched = np.flatnonzero(self.high > self.low)
        low, high = goal.direction
        count = int(np.floor((high - low) / _DIRECTIONS + 1e-9)) + 1
        around = np.append(low + _DIRECTIONS * np.arange(count), 0.0) if count > 1 else np.array([low])
        self.directions = np.unique(np.clip(around, low, high))
        self._around = np.stack([cell.T_cell_base @ pose((0, 0, 0), (0, 0, each)) for each in self.directions])

    def pose_at(self, spot: Spot) -> Poses:
        """(4, 4) T_cell_board with the middle of the targets at a distance from the base's axis, turned and lifted."""
        return self.T_cell_base @ pose((0, 0, 0), (0, 0, float(spot[3]))) @ self._ahead(spot)

    def _ahead(self, spot: Spot) -> Poses:
        """(4, 4) T_base_board of a spot, in the direction in which the board lies."""
        away = np.array([self._middle[0], self._middle[1], 0.0])
        length = float(np.linalg.norm(away))
        away = away / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
        target = away * spot[0] + np.array([0.0, 0.0, self._middle[2] + spot[2]])
        turned = self._T_base_board @ pose((0, 0, 0), (0, 0, float(spot[1])))
        turned[:3, 3] += target - (turned @ self._centre)[:3]
        return turned

    def kept(self, spot: Spot) -> Spot:
        """Bring a spot into the bounds; a whole turn of yaw has none."""
        inside = spot.copy()
        inside[:3] = np.clip(spot[:3], self.low, self.high)
        if self.high[1] - self.low[1] > 2.0 * np.pi - 1e-9:
            inside[1] = self.low[1] + np.mod(spot[1] - self.low[1], 2.0 * np.pi)
        return inside

    def roomy(self, spot: Spot) -> list[Spot]:
        """Give a spot in the directions in which there is room: the nearest to its own, then some far from that."""
        order = np.argsort(np.round(np.abs(self.directions - spot[3]), 9), kind="stable")
        poses = self._around[order] @ self._ahead(spot)
        roomy = order[[self.has_room(each) for each in poses]]
        found = [np.append(spot[:3], direction) for direction in self.directions[roomy].tolist()]
        if len(found) <= 1 + _OTHER_DIRECTIONS:
            return found
        others = np.linspace(0, len(found) - 1, 1 + _OTHER_DIRECTIONS).round().astype(int)[1:]
        return [found[0], *(found[each] for each in others.tolist())]
