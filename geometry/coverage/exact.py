"""What can be solved exactly: the best ways for a given order, and small routes altogether."""

import numpy as np

from geometry.arrays import Indices
from geometry.compiled import compiled
from geometry.coverage.network import Network, Whole, leg

UNREACHED = 1 << 62


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
