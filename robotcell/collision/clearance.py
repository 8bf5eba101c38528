"""How near robot and tool come to the board and to fixtures, exactly, and at which points. Metres.

The distance from a board to what is a capsule, as most of a tool is, is that of a segment to triangles. Anything else
is measured body by body: the boxes around the board's bodies bound the distance far better than the one around them
all, so that few bodies, each of few triangles, have to be looked at exactly.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geometry.arrays import Indices, Scalars
from robotcell.collision.body_pairs import (
    BodyPairs,
    Items,
    Places,
    Probe,
    Touch,
    gaps,
    near_items,
    probe_of,
    touch_of,
)
from robotcell.collision.box_gaps import box_gaps
from robotcell.collision.collision import Collider, in_chunks, pairs_with
from robotcell.collision.segments import nearest_triangles
from robotcell.robot.robot import Joints, row_pieces

FARTHEST = 0.02
"""m: what is farther away is of no interest. The work grows steeply with it: the more of a board is within reach."""
_EXACT = 5e-5
"""m: how exact a distance is."""
NEAREST_DIGITS = 6
"""Of metres by which rows are compared: what moves at one height has one distance but for rounding."""
_WIDER = 1.5
_AT_ONCE = 2048
"""Pairs with a board that are compared with its bodies together: bounds the memory."""


@dataclass(frozen=True, slots=True, eq=False)
class Clearance:
    """The nearest that robot or tool is to board or fixture, row by row. Not of bodies of the robot to one another."""

    distances: Scalars
    """(n,) m, exact to 0.05 mm; 0 where bodies overlap, ``farthest`` where nothing is nearer than that."""
    touches: tuple[Touch | None, ...]
    """(n,) which bodies, and their nearest points; None where nothing is nearer than ``farthest``. Of a program only
    the nearest has it: a large one has a million rows."""

    @property
    def nearest(self) -> int:
        """The first row that is nearest, to a micrometre."""
        return int(np.argmin(np.round(self.distances, NEAREST_DIGITS)))


def clearance(collider: Collider, q: Joints, tool: int, farthest: float = FARTHEST) -> Clearance:
    """Measure the clearance at (n, dof) rows of joints, as far as it is smaller than ``farthest``.

    A fixture that the base stands on is left out for the first link, as everywhere.

    Raises:
        CellError: The cell has no such tool.
    """
    bodies = pairs_with(collider, tool, q)
    boards, rods = np.array([(bool(each.pieces.triangles), each.rod is not None) for each in bodies.solids], np.bool_).T
    touches: list[Touch | None] = []
    for _, places in in_chunks(bodies, q):
        items = near_items(bodies, places, np.where(bodies.outside, farthest, -np.inf))
        rod = (boards[bodies.first] & rods[bodies.second])[items.pairs]
        known = _nearest_rods(bodies, places, items.taken(rod), farthest)
        rows, *found = _candidates(bodies, places, items.taken(~rod), farthest)
        ends, probe = np.searchsorted(rows, np.arange(len(places.turns) + 1)).tolist(), probe_of(bodies, places)
        each = list(zip(*(column.tolist() for column in found), strict=True))
        touches += [
            _nearest(bodies, probe, row, each[a:b], known.get(row), farthest)
            for row, (a, b) in enumerate(pairwise(ends))
        ]
    distances = np.array([farthest if touch is None else touch.distance for touch in touches])
    return Clearance(distances, tuple(touches))


def _nearest_rods(bodies: BodyPairs, places: Places, items: Items, farthest: float) -> dict[int, Touch]:
    """Give of each row the nearest of some pairs of a board and a capsule, where that is nearer than ``farthest``."""
    nearest: dict[int, Touch] = {}
    for pair in np.unique(items.pairs).tolist():
        first, second = bodies.solids[bodies.first[pair]], bodies.solids[bodies.second[pair]]
        rows = items.rows[items.pairs == pair]
        half, radius = (0.0, 0.0) if second.rod is None else second.rod
        turn, middle = places.turns[rows, bodies.first[pair]], places.middles[rows, bodies.first[pair]]
        seen = np.einsum("mji,mj->mi", turn, places.middles[rows, bodies.second[pair]] - middle)
        along = half * np.einsum("mji,mj->mi", turn, places.turns[rows, bodies.second[pair]][:, :, 2])
        found = nearest_triangles(first.pieces.tree, seen - along, seen + along, radius + farthest)
        met = np.flatnonzero(found.triangle >= 0)
        points = np.einsum("mij,mkj->mki", turn[met], found.points[met]) + middle[met, None]
        for at, row, ends in zip(met.tolist(), rows[met].tolist(), points, strict=True):
            apart = float(found.distances[at])
            distance = max(apart - radius, 0.0)
            if row not in nearest or distance < nearest[row].distance:
                surface = ends[0] + min(radius / max(apart, radius), 1.0) * (ends[1] - ends[0])
                name = first.names[first.owners[found.triangle[at]]]
                nearest[row] = Touch(second.names[0], name, distance, np.stack((surface, ends[1])))
    return nearest


def _candidates(
    bodies: BodyPairs, places: Places, items: Items, farthest: float
) -> tuple[Indices, Indices, Indices, Scalars]:
    """Give which of some pairs, and pieces of what consists of some, may be nearer than ``farthest``.

    Returns:
        (m,) each, by row, the lowest bound first: rows, pairs, pieces (-1 where the first solid of the pair is looked
        at as a whole), and m that they are apart at least.
    """
    least = gaps(bodies, places, items)
    counts = np.array([len(bodies.solids[index].pieces.triangles) for index in bodies.first.tolist()], dtype=np.int64)
    whole = counts[items.pairs] == 0
    parts = [(np.flatnonzero(whole), np.full(int(whole.sum()), -1), least[whole])]
    for first in np.unique(bodies.first[items.pairs[~whole]]).tolist():
        mine = np.flatnonzero(bodies.first[items.pairs] == first)
        parts += [_near_pieces(bodies, places, items, mine[some], farthest) for some in row_pieces(len(mine), _AT_ONCE)]
    at, pieces, bounds = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.lexsort((pieces, items.pairs[at], bounds, items.rows[at]))
    return items.rows[at[order]], items.pairs[at[order]], pieces[order], bounds[order]


def _near_pieces(
    bodies: BodyPairs, places: Places, items: Items, which: Indices, farthest: float
) -> tuple[Indices, Indices, Scalars]:
    """Compare items of one first solid with its pieces; give those nearer than ``farthest``: item, piece and bound."""
    from shapely import STRtree, box

    rows, pairs = items.rows[which], items.pairs[which]
    first, second = bodies.first[pairs], bodies.second[pairs]
    middle, half = np.moveaxis(bodies.solids[int(first[0])].pieces.boxes, 1, 0)
    size = np.array([bodies.solids[index].half for index in second.tolist()])
    turn = places.turns[rows, first]
    turned = np.swapaxes(turn, 1, 2) @ places.turns[rows, second]
    seen = np.einsum("mji,mj->mi", turn, places.middles[rows, second] - places.middles[rows, first])
    reach = np.einsum("mij,mj->mi", np.abs(turned), size) + farthest
    low, high = seen - reach, seen + reach
    tree = STRtree(box(*(middle - half)[:, :2].T, *(middle + half)[:, :2].T))
    item, piece = tree.query(box(*low[:, :2].T, *high[:, :2].T))
    beside = (low[item, 2] <= (middle + half)[piece, 2]) & (high[item, 2] >= (middle - half)[piece, 2])
    item, piece = item[beside], piece[beside]
    bounds = box_gaps(turned[item], seen[item] - middle[piece], half[piece], size[item])
    near = bounds <= farthest
    return which[item[near]], piece[near], bounds[near]


def _nearest(
    bodies: BodyPairs,
    probe: Probe,
    row: int,
    candidates: list[tuple[int, int, float]],
    known: Touch | None,
    farthest: float,
) -> Touch | None:
    """Narrow the margin until nothing is within it: what was met last is the nearest, within ``_EXACT``.

    A pair is first met by widening from what its boxes allow: a margin far beyond the distance makes coal try most
    triangles of a board. What is known to be near has to be undercut.
    """
    nearest, farthest = known, farthest if known is None else known.distance - _EXACT
    for pair, piece, bound in candidates:
        margin = min(max(_WIDER * bound, _EXACT), farthest)
        while margin >= 0.0 and bound <= farthest:
            contact = probe(row, pair, margin, piece)
            if contact is not None:
                nearest = touch_of(bodies, pair, contact, piece)
                margin = farthest = nearest.distance - _EXACT
            elif margin < farthest:
                margin = min(_WIDER * margin, farthest)
            else:
                break
    return nearest
