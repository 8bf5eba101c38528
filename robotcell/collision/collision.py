"""Collisions of a robot in its cell with the board, fixtures or itself. Metres, radians.

What counts as a collision:

- a link nearer to the board or to a fixture than the cell's margin;
- a body of the tool nearer to a fixture than the margin, or to the board than ``CONTACT``: the nozzle's height above
  the board is set by the recipe (``robotcell.collision.clearance`` measures how near it comes);
- two bodies of robot and tool nearer to each other than ``CONTACT``.

What does not: a link with its neighbours; bodies of robot and tool that touch each other at home (they are made so);
the base, which stands still; the first link with a fixture that the base stands on.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from boards.board import Workpiece
from geometry.arrays import Indices, Scalars
from robotcell.cell.cell import Cell
from robotcell.collision.body_pairs import (
    CONTACT,
    RESOLUTION,
    BodyPairs,
    Items,
    Places,
    Touch,
    all_pairs,
    distances,
    gaps,
    near_items,
    place,
    probe_of,
    touch_of,
)
from robotcell.collision.box_gaps import write_travels
from robotcell.collision.coal_bodies import Part, board_solid, body_solid
from robotcell.errors import CellError
from robotcell.robot.robot import Joints, Poses, pose, row_pieces

_AT_ONCE = 100_000
"""Pairs checked in one array: bounds the memory."""


@dataclass(frozen=True, slots=True, eq=False)
class Collider:
    """A cell and a board, prepared for checks."""

    by_tool: Mapping[int, BodyPairs]
    """By the number of the tool that is carried."""
    T_cell_board: Poses


def build_collider(cell: Cell, board: Workpiece | None) -> Collider:
    """Prepare a cell for collision checks; without a board only the cell itself is checked.

    Raises:
        CellError: Coal is not installed.
    """
    own, robot = np.eye(4), cell.robot
    around = [body_solid(body, "fixture", 0, own) for body in cell.fixtures]
    around += [body_solid(body, "robot", link, own) for link, bodies in enumerate(robot.bodies) for body in bodies]
    above = () if board is None else (board_solid(board, cell.T_cell_board),)
    by_tool: dict[int, BodyPairs] = {}
    for tool in cell.tools:
        carried = (body_solid(body, "tool", robot.dof, robot.T_link_flange) for body in tool.bodies)
        every = all_pairs(cell, (*around, *carried, *above))
        at_home = place(every, cell.home[None])
        items = near_items(every, at_home, np.where(every.outside, -np.inf, CONTACT + RESOLUTION))
        touching = np.isfinite(distances(every, at_home, items, np.arange(len(items.rows))))
        # The first link is not checked with a fixture that the base touches.
        fixture, carried_base = _touching_base(every, CONTACT)
        carrying = set(fixture[carried_base].tolist())
        pairs = zip(every.first.tolist(), every.second.tolist(), strict=True)
        dropped = np.array([one in carrying and every.solids[other].link == 1 for one, other in pairs], np.bool_)
        dropped[items.pairs[touching]] = True  # made so; a swept check could mistake them for colliding
        first, second, margins = (each[~dropped] for each in (every.first, every.second, every.margins))
        by_tool[tool.number] = replace(every, first=first, second=second, margins=margins)
    return Collider(MappingProxyType(by_tool), cell.T_cell_board)


def with_board_at(collider: Collider, T_cell_board: Poses) -> Collider:
    """Move the board to another pose, without preparing anything anew."""
    moved = T_cell_board @ np.linalg.inv(collider.T_cell_board)
    return Collider(_each_moved(collider, moved, "board"), T_cell_board)


def with_fixture_moved(collider: Collider, name: str, offset: NDArray[np.float64]) -> Collider:
    """Move the fixtures of a name by (3,) m in the cell, without preparing anything anew."""
    return Collider(_each_moved(collider, pose(offset.tolist(), (0, 0, 0)), "fixture", name), collider.T_cell_board)


def _each_moved(collider: Collider, moved: Poses, part: Part, name: str | None = None) -> Mapping[int, BodyPairs]:
    by_tool = {number: _moved(bodies, moved, part, name) for number, bodies in collider.by_tool.items()}
    return MappingProxyType(by_tool)


def _moved(bodies: BodyPairs, moved: Poses, part: Part, name: str | None = None) -> BodyPairs:
    """Give the bodies with all of a part, or those of one name, moved (4, 4) in the cell."""
    solids = (
        replace(each, T_link_solid=moved @ each.T_link_solid)
        if each.part == part and name in (None, *each.names[:1])
        else each
        for each in bodies.solids
    )
    return replace(bodies, solids=tuple(solids))


def fixtures_through_base(collider: Collider, deep: float) -> tuple[str, ...]:
    """Name the fixtures that reach into the bodies of the robot's base, which no configuration can avoid.

    A fixture does if moving it by ``deep``, m, to none of the six sides frees it of the same body: the robot may stand
    on it or beside it, or as deep in a recess of it.
    """
    bodies = next(iter(collider.by_tool.values()))
    sides = np.vstack((np.zeros((1, 3)), deep * np.eye(3), -deep * np.eye(3))).tolist()
    found = [_touching_base(_moved(bodies, pose(side, (0, 0, 0)), "fixture"), 0.0) for side in sides]
    met = np.all([touching for _, touching in found], axis=0)
    return tuple(dict.fromkeys(bodies.solids[index].names[0] for index in found[0][0][met].tolist()))


def collides(collider: Collider, q: Joints, tool: int) -> NDArray[np.bool_]:
    """Give (n,) for each of (n, dof) rows of joints whether anything collides.

    Raises:
        CellError: The cell has no such tool.
    """
    bodies = pairs_with(collider, tool, q)
    hit = np.zeros(len(q), np.bool_)
    for start, places in in_chunks(bodies, q):
        items = near_items(bodies, places, bodies.margins)
        found = distances(bodies, places, items, items.rows)
        hit[start + items.rows[np.isfinite(found)]] = True
    return hit


def first_pairs(collider: Collider, q: Joints, tool: int) -> tuple[Touch | None, ...]:
    """Name for each of (n, dof) rows the first pair that collides: fixtures, then the robot itself, then the board.

    Raises:
        CellError: The cell has no such tool.
    """
    found = dict(_touches(collider, q, tool, first_only=True))
    return tuple(found.get(row) for row in range(len(q)))


def fewest_obstacles(collider: Collider, q: Joints, tool: int) -> tuple[Touch, ...]:
    """Give the pairs that collide at that of (n, dof) rows which the fewest other bodies keep from being clear.

    One pair for each of these bodies: fixtures, then the robot's own, then the board's; none where a row is clear.

    Raises:
        CellError: The cell has no such tool.
    """
    met = [dict[str, Touch]() for _ in q]
    for row, touch in _touches(collider, q, tool, first_only=False):
        met[row].setdefault(touch.other, touch)
    return tuple(min(met, key=len, default={}).values())


def _touches(collider: Collider, q: Joints, tool: int, *, first_only: bool) -> Iterator[tuple[int, Touch]]:
    """Give the pairs that collide at (n, dof) rows, each with its row: of a row the first, or all."""
    bodies, settled = pairs_with(collider, tool, q), set[int]()
    for start, places in in_chunks(bodies, q):
        items, probe = near_items(bodies, places, bodies.margins), probe_of(bodies, places)
        for row, pair in zip((start + items.rows).tolist(), items.pairs.tolist(), strict=True):
            contact = None if row in settled else probe(row - start, pair, float(bodies.margins[pair]))
            if contact is not None:
                settled.update([row] if first_only else [])
                yield row, touch_of(bodies, pair, contact)


def pairs_with(collider: Collider, tool: int, *joints: Joints) -> BodyPairs:
    """Give the bodies and pairs with a tool, to be looked at at some (n, dof) rows.

    Raises:
        CellError: The cell has no such tool.
        ValueError: The rows are not (n, dof) finite numbers.
    """
    if tool not in collider.by_tool:
        known = ", ".join(str(number) for number in collider.by_tool) or "none"
        raise CellError(
            f"the cell has no tool {tool} (it has {known}); add it to the cell, or correct the nozzle's tool"
        )
    bodies = collider.by_tool[tool]
    for q in joints:
        if q.shape != (len(joints[0]), bodies.robot.dof) or not np.isfinite(q).all():
            raise ValueError(f"joints must be finite and of shape (n, {bodies.robot.dof}), not {q.shape}")
    return bodies


def in_chunks(bodies: BodyPairs, q: Joints) -> Iterator[tuple[int, Places]]:
    """Place the bodies at (n, dof) rows, some rows at a time: the first row's index, and the places."""
    step = max(1, _AT_ONCE // max(1, len(bodies.first)))
    for start in range(0, len(q), step):
        yield start, place(bodies, q[start : start + step])


def _touching_base(bodies: BodyPairs, margin: float) -> tuple[Indices, NDArray[np.bool_]]:
    """Give (pairs,) the fixture of each pair with a body of the base, and whether they come within a margin."""
    fixtures = [index for index, solid in enumerate(bodies.solids) if solid.part == "fixture"]
    bases = [index for index, solid in enumerate(bodies.solids) if solid.part == "robot" and solid.link == 0]
    first, second = (grid.ravel().astype(np.int64) for grid in np.meshgrid(fixtures, bases, indexing="ij"))
    standing = replace(bodies, first=first, second=second, margins=np.full(len(first), margin))
    places = place(standing, np.zeros((1, bodies.robot.dof)))
    items = Items(np.zeros(len(first), np.int64), np.arange(len(first)), standing.margins)
    return first, np.isfinite(distances(standing, places, items, np.arange(len(first))))


_COARSE = 1e-2
"""m of widening above which only boxes are compared: the exact check would be slow and seldom decides anything."""
_MOTIONS_AT_ONCE = 512
"""Motions checked together: bounds the memory."""


def collides_between(collider: Collider, start: Joints, end: Joints, tool: int) -> NDArray[np.bool_]:
    """Give (n,) whether anything collides on the way from (n, dof) to (n, dof) rows of joints, ends included.

    Raises:
        CellError: The cell has no such tool.
    """
    bodies = pairs_with(collider, tool, start, end)
    parts = (_sweep(bodies, start[rows], end[rows])[0] for rows in row_pieces(len(start), _MOTIONS_AT_ONCE))
    return np.concatenate([np.zeros(0, np.int64), *parts]) >= 0


def touch_between(collider: Collider, start: Joints, end: Joints, tool: int) -> Touch | None:
    """Name a pair that collides on the way between two (dof,) rows of joints; ``None`` where none does.

    Raises:
        CellError: The cell has no such tool.
    """
    bodies = pairs_with(collider, tool, start[None], end[None])
    pairs, fractions = _sweep(bodies, start[None], end[None])
    if pairs[0] < 0:
        return None
    pair, row = int(pairs[0]), start + float(fractions[0]) * (end - start)
    contact = probe_of(bodies, place(bodies, row[None]))(0, pair, float(bodies.margins[pair]) + RESOLUTION)
    return touch_of(bodies, pair, contact)


def _sweep(bodies: BodyPairs, start: Joints, end: Joints) -> tuple[Indices, Scalars]:
    """Halve the motions until every pair keeps its margin or is too near.

    Returns:
        (n,) a pair that is too near, -1 where all keep their margins; and where, as a fraction of the motion.
    """
    collides, where = np.full(len(start), -1, np.int64), np.zeros(len(start))
    travels = _travels(bodies, start, end)
    items = near_items(bodies, place(bodies, (start + end) / 2), bodies.margins + travels / 2)
    # 2 to the power of ``level`` equal pieces of each motion: (m,) those not yet proved free for a pair
    level, motion, number, pair = 0, items.rows, np.zeros(len(items.rows), np.int64), items.pairs
    while len(motion):
        half = 0.5 / (1 << level)  # of a piece, as a fraction of the motion
        middle, widening = (2 * number + 1).astype(np.float64) * half, travels[motion, pair] * half
        least = bodies.margins[pair]
        margins = least + widening
        _, at, rows = np.unique((motion << level) + number, return_index=True, return_inverse=True)
        begin, way = start[motion[at]], (end - start)[motion[at]]
        places, items = place(bodies, begin + middle[at][:, None] * way), Items(rows, pair, margins)
        near = np.where(gaps(bodies, places, items) <= margins, margins, np.inf)
        exact = np.flatnonzero(np.isfinite(near) & (widening <= _COARSE))
        near[exact] = distances(bodies, places, items.taken(exact), motion[exact])
        met = np.isfinite(near)
        decided = met & ((widening <= RESOLUTION) | (near <= least))
        collides[motion[decided]], where[motion[decided]] = pair[decided], middle[decided]
        open_yet = met & (collides[motion] < 0)
        motion, number, pair = (np.repeat(each[open_yet], 2) for each in (motion, number, pair))
        level, number = level + 1, 2 * number + np.arange(len(number)) % 2
    return collides, where


def _travels(bodies: BodyPairs, start: Joints, end: Joints) -> Scalars:
    """(n, pairs) the farthest that the bodies of a pair can move against each other on a motion, whatever the pose.

    A turn moves a point by no more than the angle times its distance from the axis; that distance is no more than the
    way along the chain: from joint to joint, by what the sliding joints between are out, to the body's farthest point.
    """
    joints = bodies.robot.joints
    slides = np.array([joint.kind == "prismatic" for joint in joints])
    steps = np.array([float(np.linalg.norm(joint.T_parent_joint[:3, 3])) for joint in joints])
    links = np.array([solid.link for solid in bodies.solids])
    levers = np.array([float(np.linalg.norm(each.T_link_solid[:3, 3])) + each.radius for each in bodies.solids])
    pairs, travels = (links[bodies.first], links[bodies.second]), np.empty((len(start), len(bodies.first)))
    write_travels((start, end), (slides, steps), pairs, levers[bodies.second], travels)
    return travels
