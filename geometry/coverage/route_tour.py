"""A route that changes in place: turning a run of strokes around, swapping two runs, going another way."""

from typing import NamedTuple

import numpy as np

from geometry.arrays import Indices
from geometry.coverage.compiled import compiled, quick
from geometry.coverage.route_network import Network, Whole, leg


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


@quick
def rejoin(network: Network, before: Whole, joint: tuple[Whole, Whole], after: Whole) -> tuple[Whole, Whole, Whole]:
    """The best ways through two strokes that follow each other, between two that stay as they are.

    Returns:
        What they add to the length, at most 0, and the two ways.
    """
    first, second = network.stroke[joint[0]], network.stroke[joint[1]]
    old = leg(network, before, joint[0]) + leg(network, joint[0], joint[1]) + leg(network, joint[1], after)
    best, best_a, best_b = old, joint[0], joint[1]
    for a in range(network.first[first], network.first[first + 1]):
        reached = leg(network, before, a)
        if reached >= best:
            continue
        for b in range(network.first[second], network.first[second + 1]):
            length = reached + leg(network, a, b) + leg(network, b, after)
            if length < best:
                best, best_a, best_b = length, a, b
    return best - old, best_a, best_b
