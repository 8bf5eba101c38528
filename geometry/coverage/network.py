"""The ways to go through each stroke, as flat arrays a compiled search can walk, and the distance between them."""

import math
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from geometry.arrays import Indices, Points
from geometry.compiled import compiled, quick

Whole: TypeAlias = Any  # an integer in compiled code, where numpy's types do not distinguish numbers and arrays

MICRONS_PER_MM = 1000.0
ROUNDING = 0.4567
"""Where a distance tips over to the next micron: away from the halves and tenths on which drawn boards put their
distances, so that turning the board does not flip one."""
NEIGHBOURS = 16
TABLE_LIMIT = 1500
"""Up to so many ways all distances are kept in a table; above it they are computed when needed."""


class Network(NamedTuple):
    """Ways (a stroke gone through from one entry to one exit), numbered stroke after stroke.

    The start is stroke n and the end stroke n + 1, with one way each.
    """

    entry: Points
    """(w, 3) mm"""
    exit: Points
    """(w, 3) mm"""
    stroke: Indices
    """(w,) the stroke each way goes through"""
    first: Indices
    """(n + 3,) first way of each stroke, and the total"""
    mirror: Indices
    """(w,) the same stroke from the exit to the entry; the way itself where that does not exist. Its own inverse."""
    after: Indices
    """(w, k) for each way one way of each of the nearest strokes that may follow, nearest first"""
    before: Indices
    """(w, k) the same for what may come before"""
    table: NDArray[np.int64]
    """(w, w) micrometres from exit to entry, or (0, 0)"""
    open_end: int
    """The end's way where the route may stop anywhere, else -1"""
    skewed: bool
    """Whether a sequence can have another length when it is done the other way round"""


@quick
def leg(network: Network, a: Whole, b: Whole) -> Whole:
    """Micrometres from the exit of way ``a`` to the entry of way ``b``."""
    if network.table.shape[0] > 0:
        return network.table[a, b]
    if b == network.open_end:
        return 0
    return distance_um(network.exit[a], network.entry[b])


@quick
def distance_um(a: Points, b: Points) -> Whole:
    """Distance of two points as an integer, so that equal lengths are equal however the board lies."""
    x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    return math.floor(math.sqrt(x * x + y * y + z * z) * MICRONS_PER_MM + ROUNDING)


def build_network(entries: tuple[Points, ...], exits: tuple[Points, ...], start: Points, end: Points | None) -> Network:
    """Number the ways and find the neighbours of each.

    Args:
        entries: (m, 3) per stroke, mm.
        exits: (m, 3) per stroke, mm.
        start: (3,) mm.
        end: (3,) mm, or ``None`` where the route may stop anywhere.
    """
    last = start if end is None else end
    entry = np.vstack((*entries, start[None], last[None]))
    leave = np.vstack((*exits, start[None], last[None]))
    counts = np.array([*(len(points) for points in entries), 1, 1])
    first = np.concatenate(([0], np.cumsum(counts)))
    stroke = np.repeat(np.arange(len(counts)), counts)
    mirror = _pair_mirrors(entry, leave, first)
    table = np.zeros((0, 0), dtype=np.int64)
    if len(entry) <= TABLE_LIMIT:
        table = _tabulate(entry, leave)
        if end is None:
            table[:, -1] = 0
    return Network(
        entry=entry,
        exit=leave,
        stroke=stroke,
        first=first,
        mirror=mirror,
        after=_nearest(leave, entry, stroke),
        before=_nearest(entry, leave, stroke),
        table=table,
        open_end=len(entry) - 1 if end is None else -1,
        skewed=bool(np.any((entry != leave[mirror]) | (leave != entry[mirror]))),
    )


@compiled
def _tabulate(entry: Points, leave: Points) -> NDArray[np.int64]:
    table = np.empty((len(entry), len(entry)), dtype=np.int64)
    for a in range(len(entry)):
        for b in range(len(entry)):
            table[a, b] = distance_um(leave[a], entry[b])
    return table


@compiled
def _pair_mirrors(entry: Points, leave: Points, first: Indices) -> Indices:
    mirror = np.full(len(entry), -1, dtype=np.int64)
    for s in range(len(first) - 1):
        for a in range(first[s], first[s + 1]):
            for b in range(a, first[s + 1]):
                if mirror[a] < 0 and mirror[b] < 0 and np.all(entry[a] == leave[b]) and np.all(leave[a] == entry[b]):
                    mirror[a] = b
                    mirror[b] = a
            if mirror[a] < 0:
                mirror[a] = a
    return mirror


def _nearest(from_points: Points, to_points: Points, stroke: Indices) -> Indices:
    """The nearest way of each of the nearest other strokes; equally near ones in the order of their numbers.

    The tree is queried for more until its last neighbour is farther than the last that is needed: which of several
    equally far points it returns depends on the last bits of the coordinates.

    Returns:
        (w, k), padded with -1.
    """
    to_points = to_points[:-2]
    near = np.full((len(from_points), min(NEIGHBOURS, stroke[-1] - 1)), -1, dtype=np.int64)
    pending = np.arange(len(from_points))
    tree = KDTree(to_points)
    count = NEIGHBOURS * max(1, round(len(to_points) / max(1, stroke[-1] - 1))) + 4
    while near.shape[1] and len(pending):
        count = min(count, len(to_points))
        found = np.reshape(tree.query(from_points[pending], k=count)[1], (len(pending), count))
        done = _keep_nearest(from_points, to_points, stroke, (pending, np.sort(found, axis=1), near))
        pending = pending[~done]
        count *= 2
    return near


@compiled
def _keep_nearest(
    from_points: Points, to_points: Points, stroke: Indices, queried: tuple[Indices, Indices, Indices]
) -> NDArray[np.bool_]:
    pending, found, near = queried
    done = np.zeros(len(pending), dtype=np.bool_)
    for row in range(len(pending)):
        way = pending[row]
        lengths = np.array([distance_um(from_points[way], to_points[b]) for b in found[row]])
        ranked = np.argsort(lengths, kind="mergesort")
        count = 0
        needed = 0
        for rank in ranked:
            b = found[row, rank]
            fresh = stroke[b] != stroke[way]
            for known in near[way, :count]:
                fresh = fresh and stroke[known] != stroke[b]
            if fresh:
                near[way, count] = b
                count += 1
                needed = lengths[rank]
            if count == near.shape[1]:
                break
        full = count == near.shape[1] and needed < lengths[ranked[-1]] - 1
        done[row] = full or len(found[row]) == len(to_points)
        if not done[row]:
            near[way, :] = -1
    return done
