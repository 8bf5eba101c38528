"""Which bodies may meet while one tool is carried, where they are, how far apart they are at least. Metres, radians.

In a pair the body that moves more (the later link) is the second; the first stands still or is an earlier link.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from robotcell.cell.cell import Cell
from robotcell.collision.coal_bodies import Part, Solid
from robotcell.robot.robot import Joints, Poses, Robot, link_poses

CONTACT = 1e-3
"""m: models, robots and boards are no more exact than this; what is nearer touches."""
RESOLUTION = 1e-3
"""m beyond its margin that a pair may be said to meet on a way between two rows of joints, though it does not."""


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Everything that can meet while one tool is carried."""

    robot: Robot
    T_cell_base: Poses
    solids: tuple[Solid, ...]
    first: Indices
    """(pairs,) index of the solid that moves less."""
    second: Indices
    """(pairs,)"""
    margins: Scalars
    """(pairs,) m that each pair keeps apart."""

    @property
    def outside(self) -> NDArray[np.bool_]:
        """(pairs,) whether the pair is of the robot or its tool with board or fixture."""
        return np.array([solid.stands for solid in self.solids], np.bool_)[self.first]


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """Where every solid of a scene is, for n rows of joints. Cell frame."""

    turns: NDArray[np.float64]
    """(n, solids, 3, 3)"""
    middles: NDArray[np.float64]
    """(n, solids, 3)"""


@dataclass(frozen=True, slots=True, eq=False)
class Items:
    """Pairs to look at more closely: (m,) each."""

    rows: Indices
    """Rows of the places."""
    pairs: Indices
    margins: Scalars
    """How near counts."""

    def taken(self, which: NDArray[np.bool_] | Indices) -> "Items":
        """Give some of the items."""
        return Items(self.rows[which], self.pairs[which], self.margins[which])


def all_pairs(cell: Cell, solids: tuple[Solid, ...]) -> Scene:
    """List all pairs that could ever meet: robot and tool with fixtures, with one another, with the board.

    In this order, because a box is quicker to check than a board. Left out is what cannot move against each other, and
    a link with its neighbour. A body of the tool is checked against all links but the last.
    """
    moving = [index for index, solid in enumerate(solids) if solid.link > 0]
    links = [index for index, solid in enumerate(solids) if solid.part == "robot"]
    pairs = [(index, other) for index in _of(solids, "fixture") for other in moving]
    pairs += [(index, other) for index in links for other in moving if _apart(solids[index], solids[other])]
    pairs += [(index, other) for index in _of(solids, "board") for other in moving]
    array = np.array(pairs, np.int64).reshape(-1, 2)
    margins = np.array([_margin(cell, solids[one], solids[other]) for one, other in pairs])
    return Scene(cell.robot, cell.T_cell_base, solids, array[:, 0], array[:, 1], margins)


def without(scene: Scene, dropped: NDArray[np.bool_]) -> Scene:
    """Leave pairs out of a scene."""
    kept = ~dropped
    return replace(scene, first=scene.first[kept], second=scene.second[kept], margins=scene.margins[kept])


def place(scene: Scene, q: Joints) -> Places:
    """Say where the solids are at (n, dof) rows of joints."""
    links = scene.T_cell_base @ link_poses(scene.robot, q)
    turns = np.empty((len(q), len(scene.solids), 3, 3))
    middles = np.empty((len(q), len(scene.solids), 3))
    for index, solid in enumerate(scene.solids):
        pose = solid.T_link_solid if solid.stands else links[:, solid.link] @ solid.T_link_solid
        turns[:, index], middles[:, index] = pose[..., :3, :3], pose[..., :3, 3]
    return Places(turns, middles)


def near_items(scene: Scene, places: Places, margins: Scalars) -> Items:
    """Give the pairs that the balls and boxes about their bodies cannot tell apart, row by row.

    Args:
        scene: The pairs.
        places: Of n rows.
        margins: (pairs,) or (n, pairs): how near counts; minus infinity for what does not count.
    """
    wide = np.broadcast_to(margins, (len(places.turns), len(scene.first)))
    radii = np.array([solid.radius for solid in scene.solids])
    between = places.middles[:, scene.second] - places.middles[:, scene.first]
    far = radii[scene.first] + radii[scene.second] + wide
    rows, pairs = np.nonzero((far >= 0.0) & (np.einsum("npi,npi->np", between, between) <= far * far))
    items = Items(rows, pairs, wide[rows, pairs])
    return items.taken(gaps(scene, places, items) <= items.margins)


def gaps(scene: Scene, places: Places, items: Items) -> Scalars:
    """Give (m,) a distance that the bodies of each item are not nearer than: between their boxes, seen along each."""
    half = np.array([solid.half for solid in scene.solids]).reshape(-1, 3)
    first, second = scene.first[items.pairs], scene.second[items.pairs]
    turn_first, turn_second = places.turns[items.rows, first], places.turns[items.rows, second]
    between = places.middles[items.rows, second] - places.middles[items.rows, first]
    turned = np.abs(np.swapaxes(turn_first, 1, 2) @ turn_second)
    seen_first = np.abs(np.einsum("mji,mj->mi", turn_first, between)) - half[first]
    seen_first -= np.einsum("mij,mj->mi", turned, half[second])
    seen_second = np.abs(np.einsum("mji,mj->mi", turn_second, between)) - half[second]
    seen_second -= np.einsum("mji,mj->mi", turned, half[first])
    return np.maximum(_length(seen_first), _length(seen_second))


def _length(outside: NDArray[np.float64]) -> Scalars:
    return np.sqrt((np.maximum(outside, 0.0) ** 2).sum(axis=1))


def _of(solids: Sequence[Solid], part: Part) -> list[int]:
    return [index for index, solid in enumerate(solids) if solid.part == part]


def _apart(one: Solid, other: Solid) -> bool:
    """Whether a body of the robot and a later one can move against each other without being neighbours."""
    return other.link - one.link >= (1 if other.part == "tool" else 2)


def _margin(cell: Cell, one: Solid, other: Solid) -> float:
    """The cell's margin keeps the robot from everything, and the tool from fixtures.

    How near the nozzle goes to the board is the recipe's business, and its own bodies are known exactly to one another:
    there no more than contact is forbidden.
    """
    if one.part == "robot" or (one.part == "board" and other.part == "tool"):
        return min(cell.margin, CONTACT)
    return cell.margin
