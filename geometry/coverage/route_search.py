"""Look for a good order: disturb it, repair it, and keep what is shorter, again and again."""

import math

import numpy as np

from geometry.arrays import Indices
from geometry.coverage.compiled import compiled, quick
from geometry.coverage.descent import descend
from geometry.coverage.route_desk import Desk, do_turn, keep, look_at, new_desk, take_back, touched
from geometry.coverage.route_exact import choose_ways, solve_small, start_order
from geometry.coverage.route_network import Network, Whole, leg
from geometry.coverage.route_tour import Tour, at, new_tour

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


def search_order(network: Network, effort: float = 1.0, seed: int = 0) -> Indices:
    """A good order of the strokes, the best one for a few.

    Args:
        network: the strokes.
        effort: how often to kick, as a multiple of the usual number.
        seed: of the pseudo-random numbers.

    Returns:
        Strokes by position, from the start's to the end's.
    """
    count = len(network.first) - 3
    if count <= MOST_EXACT and (1 << count) * int(network.first[count]) ** 2 < 10_000_000:
        return solve_small(network)
    order, length = start_order(network)
    if count < 3:  # too few to kick, with too many ways for the dynamic programme
        return _best_of_two(network, order)
    mean = max(1.0, length / (count + 1))
    slack = round(SLACK * mean) if _is_choosy(network) else 0
    return kick_often(network, order, round(effort * usual_kicks(network)), (WARMTH * mean, slack), seed)


def usual_kicks(network: Network) -> int:
    """So many that thousands of strokes take seconds; of few strokes each is kicked more often."""
    count = len(network.first) - 3
    kicks = min(10 * count**2, 600_000 // count + 8 * count)
    # every change of a skewed route brings the skew of all that follows up to date
    kicks //= 1 + count // 300 if network.skewed else 1
    if _is_choosy(network):  # a kick takes longer where ways are chosen anew
        kicks = kicks // 3 if count <= FEW else max(kicks // 10, min(10 * count, 2000))
    return kicks


def _is_choosy(network: Network) -> bool:
    """Whether a stroke can be gone through in more ways than there and back."""
    return bool(np.any(np.diff(network.first) > 2))


def _best_of_two(network: Network, order: Indices) -> Indices:
    other = np.concatenate((order[:1], order[-2:0:-1], order[-1:]))
    return min(order, other, key=lambda tried: int(choose_ways(network, tried)[0]))


@compiled
def kick_often(network: Network, order: Indices, kicks: Whole, leave: tuple[float, Whole], seed: Whole) -> Indices:
    """Kick and repair an order; what is longer by too much is taken back (Martin, Otto and Felten 1991).

    ``leave`` holds the warmth and the slack, in micrometres.
    """
    warmth, slack = leave
    length, way = choose_ways(network, order)
    tour, desk = new_tour(network, order, way), new_desk(len(order), slack)
    for position in range(len(order)):
        look_at(tour, desk, position)
    while desk.mark[1] > 0:
        length += descend(network, tour, desk)
        keep(desk)
    best, best_order = length, order.copy()
    best_order[:] = tour.order[:-1]
    dice = np.array([2463534242 ^ seed])
    for count in range(kicks):
        change = kick(network, tour, desk, dice) + descend(network, tour, desk)
        allowed = -warmth * (1 - count / kicks) * math.log(draw(dice) / 4294967296.0)
        if change > allowed:
            take_back(network, tour, desk)
            continue
        keep(desk)
        length += change
        if length < best:
            best = length
            best_order[:] = tour.order[:-1]
    return best_order


@quick
def draw(dice: Indices) -> Whole:
    """The next of 2^32 - 1 pseudo-random numbers above 0 (Marsaglia's xorshift)."""
    x = dice[0]
    x ^= (x << 13) & 0xFFFFFFFF
    x ^= x >> 17
    x ^= (x << 5) & 0xFFFFFFFF
    dice[0] = x
    return x


@quick
def kick(network: Network, tour: Tour, desk: Desk, dice: Indices) -> Whole:
    """Exchange the outer two of three neighbouring short runs: a double bridge, which no repair undoes at once.

    Returns:
        What this added to the length in micrometres.
    """
    count = len(tour.place) - 2
    longest = min(LONGEST_KICKED, count // 3)
    first, middle, second = 1 + draw(dice) % longest, 1 + draw(dice) % longest, 1 + draw(dice) % longest
    low = 1 + draw(dice) % (count - first - middle - second + 1)
    end = low + first + middle + second
    change = 0
    for position in (low, low + first, low + first + middle, end):
        change -= leg(network, at(tour, position - 1), at(tour, position))
    do_turn(network, tour, desk, low, end - 1)
    do_turn(network, tour, desk, low, low + second - 1)
    do_turn(network, tour, desk, low + second, low + second + middle - 1)
    do_turn(network, tour, desk, low + second + middle, end - 1)
    touched(network, tour, desk, low, end)
    for position in (low, low + second, low + second + middle, end):
        change += leg(network, at(tour, position - 1), at(tour, position))
        look_at(tour, desk, position - 1)
        look_at(tour, desk, position)
    return change
