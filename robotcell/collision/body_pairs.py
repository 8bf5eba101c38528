"""Pairs of bodies that may meet while one tool is carried: bounds on their distance, and exact checks by coal.

In a pair the body that moves more (the later link) is the second; the first stands still or is an earlier link.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Points, Scalars
from robotcell.cell.cell import Cell
from robotcell.collision.box_gaps import gaps_of, mark_near, write_places
from robotcell.collision.coal_bodies import Part, Solid, coal
from robotcell.collision.segments import is_apart
from robotcell.robot.robot import Joints, Poses, Robot, link_poses

CONTACT = 1e-3
"""m: models, robots and boards are no more exact than this; what is nearer is in contact."""
RESOLUTION = 1e-3
"""m beyond its margin within which a pair may count as colliding between two rows of joints, though it does not."""


@dataclass(frozen=True, slots=True, eq=False)
class BodyPairs:
    """The bodies, and all pairs of them that can collide, while one tool is carried."""

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
    """Poses of all solids for n rows of joints. Cell frame."""

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
    """m"""

    def taken(self, which: NDArray[np.bool_] | Indices) -> "Items":
        """Give some of the items."""
        return Items(self.rows[which], self.pairs[which], self.margins[which])


def all_pairs(cell: Cell, solids: tuple[Solid, ...]) -> BodyPairs:
    """List all pairs that could ever meet: robot and tool with fixtures, with one another, with the board.

    In this order, because a box is quicker to check than a board. Left out is what cannot move against each other, and
    a link with its neighbour. A body of the tool is checked against all links but the last.
    """
    moving = [index for index, solid in enumerate(solids) if solid.link > 0]
    links = [index for index, solid in enumerate(solids) if solid.part == "robot"]
    pairs = [(index, other) for index in _of(solids, "fixture") for other in moving]
    pairs += [
        (index, other)
        for index in links
        for other in moving
        if solids[other].link - solids[index].link >= (1 if solids[other].part == "tool" else 2)
    ]
    pairs += [(index, other) for index in _of(solids, "board") for other in moving]
    array = np.array(pairs, np.int64).reshape(-1, 2)
    # The nozzle's distance from the board is set by the recipe, and the robot's own bodies are known exactly: only
    # contact is forbidden there.
    parts = ((solids[one].part, solids[other].part) for one, other in pairs)
    close = [one == "robot" or (one, other) == ("board", "tool") for one, other in parts]
    margins = np.where(close, min(cell.margin, CONTACT), cell.margin)
    return BodyPairs(cell.robot, cell.T_cell_base, solids, array[:, 0], array[:, 1], margins)


def place(bodies: BodyPairs, q: Joints) -> Places:
    """Give the poses of the solids at (n, dof) rows of joints."""
    links = bodies.T_cell_base @ link_poses(bodies.robot, q)
    turns = np.empty((len(q), len(bodies.solids), 3, 3))
    middles = np.empty((len(q), len(bodies.solids), 3))
    carriers = np.array([-1 if each.stands else each.link for each in bodies.solids], dtype=np.int64)
    mounted = np.array([each.T_link_solid for each in bodies.solids]).reshape(-1, 4, 4)
    write_places(links, carriers, mounted, turns, middles)
    return Places(turns, middles)


def near_items(bodies: BodyPairs, places: Places, margins: Scalars) -> Items:
    """Give the pairs whose bounding spheres and boxes come within the margin, row by row: the broad phase.

    Args:
        bodies: The pairs.
        places: Of n rows.
        margins: (pairs,) or (n, pairs) m; minus infinity for pairs to be left out.
    """
    wide = np.broadcast_to(margins, (len(places.turns), len(bodies.first)))
    near = np.empty(wide.shape, dtype=np.bool_)
    radii = np.array([solid.radius for solid in bodies.solids])
    mark_near((places.turns, places.middles), (bodies.first, bodies.second), (radii, _halves(bodies)), wide, near)
    rows, pairs = np.nonzero(near)
    return Items(rows, pairs, wide[rows, pairs])


def gaps(bodies: BodyPairs, places: Places, items: Items) -> Scalars:
    """Give (m,) lower bounds of the distances: between the bounding boxes, along the axes of each."""
    pairs, found = (bodies.first[items.pairs], bodies.second[items.pairs]), np.empty(len(items.rows))
    gaps_of((places.turns, places.middles), items.rows, pairs, _halves(bodies), found)
    return found


def _halves(bodies: BodyPairs) -> NDArray[np.float64]:
    """(solids, 3) half the edges of the boxes."""
    return np.array([solid.half for solid in bodies.solids]).reshape(-1, 3)


def _of(solids: Sequence[Solid], part: Part) -> list[int]:
    return [index for index, solid in enumerate(solids) if solid.part == part]


Probe: TypeAlias = Callable[..., Any]
"""(row, pair, margin, piece) -> a coal ``Contact`` nearer than the margin, or None.

Of a piece of the pair's first solid; of the whole solid where it is -1, or left out."""
_SPARE = 1e-5
"""m beyond the margin within which nothing is proven: coal's own distances are exact to less."""


@dataclass(frozen=True, slots=True, eq=False)
class Touch:
    """Two bodies that are near each other. Cell frame, m."""

    body: str
    """What moves: of the robot or its tool."""
    other: str
    """A fixture, a body of the board, or another body of the robot."""
    distance: float
    """0 where they overlap."""
    points: Points
    """(2, 3) nearest point of the body, then of the other."""


def distances(bodies: BodyPairs, places: Places, items: Items, groups: Indices) -> Scalars:
    """Give (m,) a distance at which each pair was met, infinite where it is farther apart than its margin.

    Of a mesh it is the distance of some triangle within the margin, not always the nearest. Once a pair is nearer than
    it may ever be (its own margin), the rest of its group is passed over and given as far.

    Args:
        bodies: The pairs.
        places: Where the bodies are.
        items: (m,) the pairs to check, and their margins.
        groups: (m,) items of one group decide about the same row or motion.
    """
    probe, least = probe_of(bodies, places), bodies.margins.tolist()
    found = np.full(len(items.rows), np.inf)
    settled: set[int] = set()
    each = zip(items.rows.tolist(), items.pairs.tolist(), items.margins.tolist(), groups.tolist(), strict=True)
    for index, (row, pair, margin, group) in enumerate(each):
        if group in settled:
            continue
        contact = probe(row, pair, margin)
        if contact is not None:
            distance = max(contact.penetration_depth, 0.0)
            found[index] = distance
            if distance <= least[pair]:
                settled.add(group)
    return found


def touch_of(bodies: BodyPairs, pair: int, contact: Any, piece: int = -1) -> Touch:
    """Convert a coal contact between the two bodies of a pair, or with a piece of the first of them."""
    first, second = bodies.solids[bodies.first[pair]], bodies.solids[bodies.second[pair]]
    points = np.array([contact.getNearestPoint2(), contact.getNearestPoint1()]).reshape(2, 3)
    distance = max(float(contact.penetration_depth), 0.0)
    owner = piece if piece >= 0 else int(first.owners[contact.b1]) if len(first.owners) else 0
    return Touch(second.names[0], first.names[owner], distance, points)


def probe_of(bodies: BodyPairs, places: Places) -> Probe:
    """Prepare the check of pairs, and of pieces; poses in coal's own form are kept as long as the probe is."""
    engine, kept = coal(), dict[tuple[int, int], Any]()
    request, result = engine.CollisionRequest(), engine.CollisionResult()
    request.enable_contact, request.num_max_contacts = True, 1
    first, second = bodies.first.tolist(), bodies.second.tolist()
    still = {index for index, solid in enumerate(bodies.solids) if solid.stands}
    hulls = [solid.hull for solid in bodies.solids]
    boards = {index for index, solid in enumerate(bodies.solids) if solid.pieces.triangles}

    def pose(row: int, solid: int) -> Any:
        key = (0 if solid in still else row, solid)
        if key not in kept:
            kept[key] = engine.Transform3s(places.turns[row, solid], places.middles[row, solid])
        return kept[key]

    def is_proven_apart(row: int, one: int, other: int, margin: float) -> bool:
        """Whether a hull is far from a board: coal takes milliseconds where it comes near many triangles."""
        hull = hulls[other]
        if hull is None or one not in boards:
            return False
        across = places.turns[row, one].T
        turn, offset = (
            across @ places.turns[row, other],
            across @ (places.middles[row, other] - places.middles[row, one]),
        )
        return is_apart(bodies.solids[one].pieces.tree, hull, turn, offset, margin + _SPARE)

    def probe(row: int, pair: int, margin: float, piece: int = -1) -> Any:
        one, other = first[pair], second[pair]
        if piece < 0 and is_proven_apart(row, one, other, margin):
            return None
        request.security_margin = margin
        result.clear()
        solid = bodies.solids[one]
        geometry = solid.geometry if piece < 0 else solid.pieces.geometries[piece]
        met = engine.collide(geometry, pose(row, one), bodies.solids[other].geometry, pose(row, other), request, result)
        return result.getContact(0) if met else None

    return probe
