"""Order of strokes: exact for a few; else kicked, repaired, and kept where shorter (Martin, Otto and Felten 1991)."""

import math
from typing import NamedTuple

import numpy as np

from geometry.arrays import Indices
from geometry.compiled import compiled, inner
from geometry.coverage.descent import descend
from geometry.coverage.tour import (
    Network,
    State,
    Tour,
    Whole,
    at,
    do_turn,
    keep,
    leg,
    look_at,
    new_state,
    new_tour,
    touched,
    undo,
)
from specs.progress import Progress, no_progress

UNREACHED = 1 << 62
MOST_EXACT = 9
"""Up to so many strokes the best order is found by dynamic programming"""
FEW = 40
"""Up to so many strokes the order is to be the best one; beyond, within two per cent of it"""
WARMTH = 1.0
"""By how much a repaired order may be longer than the one before at first, in mean legs; it falls to 0"""
LONGEST_KICKED = 26
"""Strokes in each of the three runs that a kick exchanges, at most"""
SLACK = 8.0
"""By how much a change may lengthen the route before the ways around it are chosen anew, in mean legs"""
ROUNDS = 50
"""After each of so many parts of the kicks a search reports its progress"""


@compiled
def choose_ways(network: Network, order: Indices) -> tuple[Whole, Indices]:
    """The best way through each stroke for a given order, by dynamic programming over the order.

    Args:
        network: the strokes.
        order: strokes by position, from the start's to the end's.

    Returns:
        The length in micrometres, and the way of each stroke (by stroke).
    """
    ways = len(network.stroke)
    cost = np.full(ways, UNREACHED, dtype=np.int64)
    came = np.full(ways, -1, dtype=np.int64)
    cost[network.first[order[0]]] = 0
    for position in range(1, len(order)):
        s, previous = order[position], order[position - 1]
        for b in range(network.first[s], network.first[s + 1]):
            for a in range(network.first[previous], network.first[previous + 1]):
                reached = cost[a] + leg(network, a, b)
                if reached < cost[b]:
                    cost[b] = reached
                    came[b] = a
    chosen = np.empty(len(order), dtype=np.int64)
    way = network.first[order[-1]]
    length = cost[way]
    for position in range(len(order) - 1, -1, -1):
        chosen[order[position]] = way
        way = came[way]
    return length, chosen


@compiled
def solve_small(network: Network) -> Indices:
    """The best order of a few strokes (Held and Karp's dynamic programme over sets of strokes).

    ``cost[done, b]`` is the least length at which the strokes in ``done`` are behind us and ``b`` was the last way.

    Returns:
        Strokes by position, from the start's to the end's.
    """
    count = len(network.first) - 3
    ways = network.first[count]
    cost = np.full((1 << count, ways), UNREACHED, dtype=np.int64)
    came = np.full((1 << count, ways), -1, dtype=np.int64)
    for b in range(ways):
        cost[1 << network.stroke[b], b] = leg(network, ways, b)
    for done in range(1, 1 << count):
        for a in range(ways):
            if cost[done, a] == UNREACHED:
                continue
            for b in range(ways):
                grown = done | (1 << network.stroke[b])
                if grown != done and cost[done, a] + leg(network, a, b) < cost[grown, b]:
                    cost[grown, b] = cost[done, a] + leg(network, a, b)
                    came[grown, b] = a
    done = (1 << count) - 1
    last = np.argmin(np.array([cost[done, a] + leg(network, a, ways + 1) for a in range(ways)]))
    order = np.arange(count + 2)
    order[0] = count
    for position in range(count, 0, -1):
        order[position] = network.stroke[last]
        done, last = done & ~(1 << network.stroke[last]), came[done, last]
    return order


@compiled
def start_order(network: Network) -> tuple[Indices, Whole]:
    """Always the nearest stroke next, from the start.

    Returns:
        Strokes by position, and the length in micrometres.
    """
    count = len(network.first) - 3
    order = np.arange(count + 2)
    order[0] = count
    taken = np.zeros(count, dtype=np.bool_)
    way, length = network.first[count], 0
    for position in range(1, count + 1):
        best, following = UNREACHED, -1
        for b in network.after[way]:
            if b >= 0 and not taken[network.stroke[b]] and leg(network, way, b) < best:
                best, following = leg(network, way, b), b
        if following < 0:
            for b in range(network.first[count]):
                if not taken[network.stroke[b]] and leg(network, way, b) < best:
                    best, following = leg(network, way, b), b
        way = following
        order[position] = network.stroke[way]
        taken[order[position]] = True
        length += best
    return order, length + leg(network, way, network.first[count + 1])


class Search(NamedTuple):
    """A search under way."""

    tour: Tour
    state: State
    rng: Indices
    """The last pseudo-random number"""
    best: Indices
    """The shortest order so far"""
    length: Indices
    """Micrometres of the tour, and of the shortest order so far"""


def search_order(network: Network, effort: float = 1.0, seed: int = 0, progress: Progress = no_progress) -> Indices:
    """A good order of the strokes, the best one for a few.

    Args:
        network: the strokes.
        effort: how often to kick, as a multiple of the usual number; with 0 the first order is only repaired.
        seed: of the pseudo-random numbers.
        progress: receives the stage and the share done; it may end the search by raising something.

    Returns:
        Strokes by position, from the start's to the end's.
    """
    if _is_small(network):
        return solve_small(network)
    order, length = start_order(network)
    if not is_kicked(network):
        other = np.concatenate((order[:1], order[-2:0:-1], order[-1:]))
        return min(order, other, key=lambda tried: int(choose_ways(network, tried)[0]))
    mean = max(1.0, length / (len(network.first) - 2))
    slack = round(SLACK * mean) if _has_many_ways(network) else 0
    return _kick_often(network, order, round(effort * usual_kicks(network)), (WARMTH * mean, slack), seed, progress)


def is_kicked(network: Network) -> bool:
    """Whether an order is looked for by kicks, which take most of the time; others are as short as they get."""
    return len(network.first) - 3 >= 3 and not _is_small(network)


def _is_small(network: Network) -> bool:
    """Whether the dynamic programme takes a moment only."""
    count = len(network.first) - 3
    return count <= MOST_EXACT and (1 << count) * int(network.first[count]) ** 2 < 10_000_000


def usual_kicks(network: Network) -> int:
    """So many that thousands of strokes take seconds; of few strokes each is kicked more often."""
    count = len(network.first) - 3
    kicks = min(10 * count**2, 600_000 // count + 8 * count)
    # every change of a skewed route brings the skew of all that follows up to date
    kicks //= 1 + count // 300 if network.skewed else 1
    if _has_many_ways(network):  # a kick takes longer where ways are chosen anew
        kicks = kicks // 3 if count <= FEW else max(kicks // 10, min(10 * count, 2000))
    return kicks


def _has_many_ways(network: Network) -> bool:
    """Whether a stroke can be gone through in more ways than there and back."""
    return bool(np.any(np.diff(network.first) > 2))


def _kick_often(
    network: Network, order: Indices, kicks: int, leave: tuple[float, int], seed: int, progress: Progress
) -> Indices:
    """Kick and repair an order, some kicks at a time."""
    warmth, slack = leave
    length, way = choose_ways(network, order)
    search = Search(
        tour=new_tour(network, order, way),
        state=new_state(network, slack),
        rng=np.array([2463534242 ^ seed]),
        best=np.array(order),
        length=np.array([length, length]),
    )
    repair(network, search)
    step = max(1, math.ceil(kicks / ROUNDS))
    for begin in range(0, kicks, step):
        progress(f"refining the order of {len(order) - 2} strokes", begin / kicks)
        kick_on(network, search, (begin, min(begin + step, kicks), kicks), warmth)
    return search.best


@compiled
def repair(network: Network, search: Search) -> None:
    """Shorten the first order until no change near to any stroke makes it shorter."""
    for position in range(len(search.best)):
        look_at(search.tour, search.state, position)
    while search.state.mark[1] > 0:
        search.length[0] += descend(network, search.tour, search.state)
        keep(search.state)
    search.length[1] = search.length[0]
    search.best[:] = search.tour.order[:-1]


@compiled
def kick_on(network: Network, search: Search, kicks: tuple[Whole, Whole, Whole], warmth: float) -> None:
    """Kick and repair; what is longer by too much is taken back (Martin, Otto and Felten 1991).

    ``kicks`` holds the number of the first one, that of the one after the last, and how many there are altogether.
    """
    tour, state, length = search.tour, search.state, search.length
    for count in range(kicks[0], kicks[1]):
        change = kick(network, tour, state, search.rng) + descend(network, tour, state)
        allowed = -warmth * (1 - count / kicks[2]) * math.log(next_random(search.rng) / 4294967296.0)
        if change > allowed:
            undo(network, tour, state)
            continue
        keep(state)
        length[0] += change
        if length[0] < length[1]:
            length[1] = length[0]
            search.best[:] = tour.order[:-1]


@inner
def next_random(rng: Indices) -> Whole:
    """The next of 2^32 - 1 pseudo-random numbers above 0 (Marsaglia's xorshift)."""
    x = rng[0]
    x ^= (x << 13) & 0xFFFFFFFF
    x ^= x >> 17
    x ^= (x << 5) & 0xFFFFFFFF
    rng[0] = x
    return x


@inner
def kick(network: Network, tour: Tour, state: State, rng: Indices) -> Whole:
    """Exchange the outer two of three neighbouring short runs: a double bridge, which no repair undoes at once.

    Returns:
        What this added to the length in micrometres.
    """
    count = len(tour.place) - 2
    longest = min(LONGEST_KICKED, count // 3)
    first, middle, second = (
        1 + next_random(rng) % longest,
        1 + next_random(rng) % longest,
        1 + next_random(rng) % longest,
    )
    low = 1 + next_random(rng) % (count - first - middle - second + 1)
    end = low + first + middle + second
    change = 0
    for position in (low, low + first, low + first + middle, end):
        change -= leg(network, at(tour, position - 1), at(tour, position))
    do_turn(network, tour, state, low, end - 1)
    do_turn(network, tour, state, low, low + second - 1)
    do_turn(network, tour, state, low + second, low + second + middle - 1)
    do_turn(network, tour, state, low + second + middle, end - 1)
    touched(network, tour, state, low, end)
    for position in (low, low + second, low + second + middle, end):
        change += leg(network, at(tour, position - 1), at(tour, position))
        look_at(tour, state, position - 1)
        look_at(tour, state, position)
    return change
