"""Ways through strokes as flat arrays, and a route that changes in place, with an undo log."""

import math
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from geometry.arrays import Indices, Points
from geometry.compiled import compiled, inlined, inner, quick

Whole: TypeAlias = Any  # an integer in compiled code, where numpy's types do not distinguish numbers and arrays

MICRONS_PER_MM = 1000.0
ROUNDING = 0.4567
"""Where a distance tips over to the next micron: away from the halves and tenths on which drawn boards put their
distances, so that turning the board does not flip one."""
NEIGHBOURS = 16
TABLE_LIMIT = 1500
"""Up to so many ways all distances are kept in a table; above it they are computed when needed."""
ROOM = 4096
"""Changes that can be taken back"""


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


@inlined
def leg(network: Network, a: Whole, b: Whole) -> Whole:
    """Micrometres from the exit of way ``a`` to the entry of way ``b``."""
    if network.table.shape[0] > 0:
        return network.table[a, b]
    if b == network.open_end:
        return 0
    return distance_um(network.exit[a], network.entry[b])


@inner
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
        found = np.sort(found, axis=1)
        lengths = _lengths(from_points, to_points, pending, found)
        ranked = np.argsort(lengths, axis=1, kind="stable")
        done = _keep_nearest(stroke, pending, (found, lengths, ranked), near)
        done |= count == len(to_points)
        near[pending[~done]] = -1
        pending = pending[~done]
        count *= 2
    return near


@compiled
def _lengths(from_points: Points, to_points: Points, pending: Indices, found: Indices) -> Indices:
    lengths = np.empty(found.shape, dtype=np.int64)
    for row in range(len(pending)):
        for rank in range(found.shape[1]):
            lengths[row, rank] = distance_um(from_points[pending[row]], to_points[found[row, rank]])
    return lengths


@compiled
def _keep_nearest(
    stroke: Indices, pending: Indices, queried: tuple[Indices, Indices, Indices], near: Indices
) -> NDArray[np.bool_]:
    found, lengths, ranked = queried
    done = np.zeros(len(pending), dtype=np.bool_)
    for row in range(len(pending)):
        way = pending[row]
        count = 0
        needed = 0
        for rank in ranked[row]:
            b = found[row, rank]
            fresh = stroke[b] != stroke[way]
            for known in near[way, :count]:
                fresh = fresh and stroke[known] != stroke[b]
            if fresh:
                near[way, count] = b
                count += 1
                needed = lengths[row, rank]
            if count == near.shape[1]:
                break
        done[row] = count == near.shape[1] and needed < lengths[row, ranked[row, -1]] - 1
    return done


class Tour(NamedTuple):
    """An order of strokes with a way through each.

    Position 0 is the start and position n + 1 the end; position n + 2, which is also position -1, repeats the start so
    that every position has two neighbours.
    """

    order: Indices
    """(n + 3,) stroke at each position"""
    place: Indices
    """(n + 2,) position of each stroke"""
    way: Indices
    """(n + 2,) chosen way of each stroke"""
    skew: Indices
    """(n + 2,) what the legs up to each position would cost more in the opposite sense; all 0 unless skewed"""


def new_tour(network: Network, order: Indices, way: Indices) -> Tour:
    """A tour from the strokes by position and their ways by stroke."""
    tour = Tour(np.append(order, order[0]), np.argsort(order), way.copy(), np.zeros(len(order), dtype=np.int64))
    update_skew(network, tour, 1, len(order) - 1)
    return tour


@inlined
def at(tour: Tour, position: Whole) -> Whole:
    """The way at a position."""
    return tour.way[tour.order[position]]


@quick
def update_skew(network: Network, tour: Tour, low: Whole, high: Whole) -> None:
    """Bring the skew up to date after legs changed that end at positions ``low`` to ``high``."""
    if not network.skewed:
        return
    low, high = max(1, low), min(high, len(tour.skew) - 1)
    shift = -tour.skew[high]
    for position in range(low, high + 1):
        a, b = at(tour, position - 1), at(tour, position)
        back = leg(network, network.mirror[b], network.mirror[a])
        tour.skew[position] = tour.skew[position - 1] + back - leg(network, a, b)
    shift += tour.skew[high]
    for position in range(high + 1, len(tour.skew)):
        tour.skew[position] += shift


@quick
def turn_change(network: Network, tour: Tour, low: Whole, high: Whole) -> Whole:
    """What turning around positions ``low`` to ``high`` would add to the length."""
    before, after = at(tour, low - 1), at(tour, high + 1)
    first, last = at(tour, low), at(tour, high)
    change = leg(network, before, network.mirror[last]) + leg(network, network.mirror[first], after)
    return change - leg(network, before, first) - leg(network, last, after) + tour.skew[high] - tour.skew[low]


@quick
def turn(network: Network, tour: Tour, low: Whole, high: Whole) -> None:
    """Do positions ``low`` to ``high`` the other way round, each stroke mirrored. The skew is left behind."""
    while low <= high:
        a, b = tour.order[low], tour.order[high]
        way_a, way_b = network.mirror[tour.way[a]], network.mirror[tour.way[b]]
        tour.order[low], tour.order[high] = b, a
        tour.place[a], tour.place[b] = high, low
        tour.way[a] = way_a
        tour.way[b] = way_b
        low += 1
        high -= 1


@inner
def swap_change(network: Network, tour: Tour, low: Whole, middle: Whole, high: Whole) -> Whole:
    """What swapping positions ``low`` to ``middle`` with ``middle + 1`` to ``high`` would add to the length."""
    before, first, second = at(tour, low - 1), at(tour, low), at(tour, middle + 1)
    end_first, end_second, after = at(tour, middle), at(tour, high), at(tour, high + 1)
    change = leg(network, before, second) + leg(network, end_second, first) + leg(network, end_first, after)
    return change - leg(network, before, first) - leg(network, end_first, second) - leg(network, end_second, after)


class State(NamedTuple):
    """Of a descent: the queue of strokes whose neighbourhood is to be searched, and the undo log."""

    queue: Indices
    """(n + 2,) strokes in the order in which they are looked at, from ``mark[0]`` on, around the end"""
    waiting: Indices
    """(n + 2,) 1 for each stroke that is in the queue"""
    done: Indices
    """(room, 2) positions turned around, or -1 - stroke and its old way"""
    mark: Indices
    """Head of the queue, its length, the number of things done, lowest and highest position touched"""
    slack: int
    """A change that adds less than so many micrometres is tried: better ways around it may make it shorter"""
    cost: Indices
    """(2, most ways of a stroke) least lengths up to the ways of two strokes that follow each other"""


def new_state(network: Network, slack: int) -> State:
    """An empty state for a tour, and a slack."""
    count, most = len(network.first) - 1, int(np.max(np.diff(network.first)))
    return State(
        np.zeros(count, dtype=np.int64),
        np.zeros(count, dtype=np.int64),
        np.zeros((ROOM, 2), dtype=np.int64),
        np.array([0, 0, 0, count, 0]),
        slack,
        np.zeros((2, most), dtype=np.int64),
    )


@quick
def look_at(tour: Tour, state: State, position: Whole) -> None:
    """Queue the stroke at a position."""
    stroke = tour.order[position]
    if state.waiting[stroke]:
        return
    state.waiting[stroke] = 1
    state.queue[(state.mark[0] + state.mark[1]) % len(state.queue)] = stroke
    state.mark[1] += 1


@inner
def do_turn(network: Network, tour: Tour, state: State, low: Whole, high: Whole) -> None:
    """Turn positions around and log it. The skew is left behind."""
    turn(network, tour, low, high)
    state.done[state.mark[2], 0] = low
    state.done[state.mark[2], 1] = high
    state.mark[2] += 1


@inner
def do_way(network: Network, tour: Tour, state: State, way: Whole) -> None:
    """Go another way through a stroke and log it. The skew is left behind."""
    stroke = network.stroke[way]
    if tour.way[stroke] == way:
        return
    state.done[state.mark[2], 0] = -1 - stroke
    state.done[state.mark[2], 1] = tour.way[stroke]
    state.mark[2] += 1
    tour.way[stroke] = way


@quick
def touched(network: Network, tour: Tour, state: State, low: Whole, high: Whole) -> None:
    """The legs that end at positions ``low`` to ``high`` have changed: bring the skew up to date."""
    update_skew(network, tour, low, high)
    state.mark[3] = min(state.mark[3], low)
    state.mark[4] = max(state.mark[4], high)


@inner
def undo_to(network: Network, tour: Tour, state: State, begun: Whole, legs: tuple[Whole, Whole]) -> None:
    """Undo what was logged from number ``begun`` on; only legs that end between two positions had changed."""
    while state.mark[2] > begun:
        state.mark[2] -= 1
        low, high = state.done[state.mark[2]]
        if low < 0:
            tour.way[-1 - low] = high
        else:
            turn(network, tour, low, high)
    update_skew(network, tour, legs[0], legs[1])


@quick
def undo(network: Network, tour: Tour, state: State) -> None:
    """Undo all that is logged."""
    undo_to(network, tour, state, 0, (state.mark[3], state.mark[4]))
    keep(state)


@quick
def keep(state: State) -> None:
    """Clear the undo log."""
    state.mark[2] = 0
    state.mark[3] = len(state.queue)
    state.mark[4] = 0


@inner
def do_swap(network: Network, tour: Tour, state: State, low: Whole, middle: Whole, high: Whole) -> None:
    """Swap two neighbouring runs, each in its own sense."""
    do_turn(network, tour, state, low, high)
    cut = low + high - middle
    do_turn(network, tour, state, low, cut - 1)
    do_turn(network, tour, state, cut, high)
