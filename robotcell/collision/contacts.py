"""Exact checks of single pairs by coal: whether two bodies are nearer than a margin, how near, and where. Metres."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from geometry.arrays import Indices, Points, Scalars
from robotcell.collision.body_pairs import BodyPairs, Items, Places
from robotcell.collision.coal_bodies import coal
from robotcell.collision.hulls import is_apart

Probe: TypeAlias = Callable[[int, int, float], Any]
"""(row, pair, margin) -> a coal ``Contact`` nearer than the margin, or None."""
PieceProbe: TypeAlias = Callable[[int, int, int, float], Any]
"""(row, pair, piece, margin) -> the same of a piece of the pair's first solid; of the whole solid where it is -1."""
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
    """Prepare the check of pairs at given poses."""
    probe = piece_probe_of(bodies, places)
    return lambda row, pair, margin: probe(row, pair, -1, margin)


def piece_probe_of(bodies: BodyPairs, places: Places) -> PieceProbe:
    """Prepare the check of pairs, and of pieces; poses in coal's own form are kept as long as the probe is."""
    engine, kept = coal(), dict[tuple[int, int], Any]()
    request, result = engine.CollisionRequest(), engine.CollisionResult()
    request.enable_contact, request.num_max_contacts = True, 1
    geometries = [solid.geometry for solid in bodies.solids]
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

    def probe(row: int, pair: int, piece: int, margin: float) -> Any:
        one, other = first[pair], second[pair]
        if piece < 0 and is_proven_apart(row, one, other, margin):
            return None
        request.security_margin = margin
        result.clear()
        geometry = geometries[one] if piece < 0 else bodies.solids[one].pieces.geometries[piece]
        met = engine.collide(geometry, pose(row, one), geometries[other], pose(row, other), request, result)
        return result.getContact(0) if met else None

    return probe
