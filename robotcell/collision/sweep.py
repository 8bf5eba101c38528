"""Continuous collision checks between two rows of joints: nothing is jumped over, however thin. Metres, radians.

The motion is straight in the joints. Half way, every pair is checked with its margin widened by the farthest that its
bodies can move against each other on the way from there to either end (turn times lever, summed over the joints
between them). A pair that keeps the widened margin keeps its own on the whole way; else the way is halved. Where the
widening is below ``RESOLUTION`` and the widened margin is still not kept, the motion counts as a collision. So no
collision is missed, and none is reported of bodies that are farther apart than their margin and ``RESOLUTION``.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from robotcell.collision.body_pairs import (
    RESOLUTION,
    BodyPairs,
    Items,
    Touch,
    distances,
    gaps,
    near_items,
    place,
    probe_of,
    touch_of,
)
from robotcell.collision.collision import Collider, pairs_with
from robotcell.robot.robot import Joints, row_pieces

_COARSE = 1e-2
"""m of widening above which only boxes are compared: the exact check would be slow and seldom decides anything."""
_AT_ONCE = 512
"""Motions checked together: bounds the memory."""


@dataclass(frozen=True, slots=True, eq=False)
class _Pieces:
    """Pieces of motions, 2 to the power of ``level`` equal ones in each: (m,) those not yet proved free for a pair."""

    level: int
    motion: Indices
    number: Indices
    """Which piece of its motion."""
    pair: Indices

    @property
    def half(self) -> float:
        """Half a piece's length, as a fraction of the motion."""
        return 0.5 / (1 << self.level)

    @property
    def middle(self) -> Scalars:
        """(m,) as a fraction of the motion."""
        return (2 * self.number + 1).astype(np.float64) * self.half

    def halved(self, which: NDArray[np.bool_]) -> "_Pieces":
        """Give both halves of some of the pieces."""
        motion, number, pair = (np.repeat(each[which], 2) for each in (self.motion, self.number, self.pair))
        later = np.arange(len(number)) % 2
        return _Pieces(self.level + 1, motion, 2 * number + later, pair)


def collides_between(collider: Collider, start: Joints, end: Joints, tool: int) -> NDArray[np.bool_]:
    """Give (n,) whether anything collides on the way from (n, dof) to (n, dof) rows of joints, ends included.

    Raises:
        CellError: The cell has no such tool.
    """
    bodies = pairs_with(collider, tool, start, end)
    parts = (_sweep(bodies, start[rows], end[rows])[0] for rows in row_pieces(len(start), _AT_ONCE))
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
    pieces = _Pieces(0, items.rows, np.zeros(len(items.rows), np.int64), items.pairs)
    while len(pieces.motion):
        widening = travels[pieces.motion, pieces.pair] * pieces.half
        least = bodies.margins[pieces.pair]
        margins = least + widening
        keys = (pieces.motion << pieces.level) + pieces.number
        _, at, rows = np.unique(keys, return_index=True, return_inverse=True)
        begin, way = start[pieces.motion[at]], (end - start)[pieces.motion[at]]
        places, items = place(bodies, begin + pieces.middle[at][:, None] * way), Items(rows, pieces.pair, margins)
        near = np.where(gaps(bodies, places, items) <= margins, margins, np.inf)
        exact = np.flatnonzero(np.isfinite(near) & (widening <= _COARSE))
        near[exact] = distances(bodies, places, items.taken(exact), pieces.motion[exact])
        met = np.isfinite(near)
        decided = met & ((widening <= RESOLUTION) | (near <= least))
        collides[pieces.motion[decided]] = pieces.pair[decided]
        where[pieces.motion[decided]] = pieces.middle[decided]
        pieces = pieces.halved(met & (collides[pieces.motion] < 0))
    return collides, where


def _travels(bodies: BodyPairs, start: Joints, end: Joints) -> Scalars:
    """(n, pairs) the farthest that the bodies of a pair can move against each other on a motion, whatever the pose.

    A turn moves a point by no more than the angle times its distance from the axis; that distance is no more than the
    way along the chain: from joint to joint, by what the sliding joints between are out, to the body's farthest point.
    """
    joints, turns = bodies.robot.joints, np.abs(end - start)
    out = np.maximum(np.abs(start), np.abs(end)) * np.array([joint.kind == "prismatic" for joint in joints])
    steps = np.array([np.linalg.norm(joint.T_parent_joint[:3, 3]) for joint in joints]) + out
    travels = np.zeros((len(start), len(bodies.first)))
    for pair, (one, other) in enumerate(zip(bodies.first.tolist(), bodies.second.tolist(), strict=True)):
        first, second = bodies.solids[one], bodies.solids[other]
        lever = np.full(len(start), np.linalg.norm(second.T_link_solid[:3, 3]) + second.radius)
        for joint in range(second.link - 1, first.link - 1, -1):
            travels[:, pair] += turns[:, joint] * (1.0 if joints[joint].kind == "prismatic" else lever)
            lever = lever + steps[:, joint]
    return travels
