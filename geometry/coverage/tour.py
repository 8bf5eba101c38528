"""A route that changes in place, with an undo log: turn a run of strokes around, swap two runs, go another way."""

from typing import NamedTuple

import numpy as np

from geometry.arrays import Indices
from geometry.compiled import compiled, quick
from geometry.coverage.network import Network, Whole, leg

ROOM = 4096
"""Changes that can be taken back"""


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


@compiled
def new_tour(network: Network, order: Indices, way: Indices) -> Tour:
    """A tour from the strokes by position and their ways by stroke."""
    tour = Tour(np.append(order, order[0]), np.argsort(order), way.copy(), np.zeros(len(order), dtype=np.int64))
    update_skew(network, tour, 1, len(order) - 1)
    return tour


@quick
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


@quick
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


@compiled
def new_state(network: Network, slack: Whole) -> State:
    """An empty state for a tour, and a slack."""
    count, most = len(network.first) - 1, np.max(np.diff(network.first))
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


@quick
def do_turn(network: Network, tour: Tour, state: State, low: Whole, high: Whole) -> None:
    """Turn positions around and log it. The skew is left behind."""
    turn(network, tour, low, high)
    state.done[state.mark[2], 0] = low
    state.done[state.mark[2], 1] = high
    state.mark[2] += 1


@quick
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


@quick
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


@quick
def do_swap(network: Network, tour: Tour, state: State, low: Whole, middle: Whole, high: Whole) -> None:
    """Swap two neighbouring runs, each in its own sense."""
    do_turn(network, tour, state, low, high)
    cut = low + high - middle
    do_turn(network, tour, state, low, cut - 1)
    do_turn(network, tour, state, cut, high)
