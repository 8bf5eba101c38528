"""Shorten a route by simulated annealing over the strokes near to each other."""

import math

import numpy as np
from numba import njit

from geometry.arrays import Indices
from geometry.coverage.route_exact import choose_ways
from geometry.coverage.route_network import Network, Whole, leg
from geometry.coverage.route_tour import (
    Tour,
    at,
    new_tour,
    rejoin,
    swap,
    swap_change,
    turn,
    turn_change,
    update_skew,
)

FAR = 1 << 60
LONGEST_MOVED = 3


@njit(cache=True)
def draw(dice: Indices) -> Whole:
    """The next of 2^32 - 1 pseudo-random numbers above 0 (Marsaglia's xorshift)."""
    x = dice[0]
    x ^= (x << 13) & 0xFFFFFFFF
    x ^= x >> 17
    x ^= (x << 5) & 0xFFFFFFFF
    dice[0] = x
    return x


@njit(cache=True)
def below(bits: Whole, bound: Whole) -> Whole:
    """A number from 0 to ``bound - 1`` from the lowest 16 bits."""
    return (bits & 0xFFFF) * bound >> 16


@njit(cache=True)
def tolerance(dice: Indices, warmth: float) -> float:
    """By how many micrometres the next change may lengthen the route (Metropolis)."""
    return -warmth * math.log(draw(dice) / 4294967296.0)


@njit(cache=True)
def turn_some(network: Network, tour: Tour, dice: Indices, warmth: float, tries: Whole) -> Whole:
    """Put near strokes next to each other by turning around what lies between, with the best ways at both joints."""
    last, mirror, gained = len(tour.place) - 2, network.mirror, 0
    for _ in range(tries):
        bits = draw(dice)
        p = 1 + below(bits, last)
        way = at(tour, p)
        if bits >> 31:
            q = tour.place[network.stroke[network.after[way, below(bits >> 12, network.after.shape[1])]]]
            low, high = min(p, q) + 1, max(p, q)
        else:
            q = tour.place[network.stroke[network.before[way, below(bits >> 12, network.before.shape[1])]]]
            low, high = min(p, q), max(p, q) - 1
        if (bits >> 16) & 63 == 0:
            low, high = (1, p) if bits >> 31 else (p, last)
        change = turn_change(network, tour, low, high)
        joint = at(tour, low - 1), mirror[at(tour, high)]
        other = mirror[at(tour, low)], at(tour, high + 1)
        saved, a, b, c, d = 0, joint[0], joint[1], other[0], other[1]
        if high > low:
            saved, a, b = rejoin(network, at(tour, low - 2), joint, mirror[at(tour, high - 1)])
            change += saved
        if high > low + 1:
            saved, c, d = rejoin(network, mirror[at(tour, low + 1)], other, at(tour, high + 2))
            change += saved
        if change > tolerance(dice, warmth):
            continue
        turn(network, tour, low, high)
        gained += change
        if high > low:
            for chosen in (a, b, c, d):
                tour.way[network.stroke[chosen]] = chosen
        update_skew(network, tour, low - 1, high + 2)
    return gained


@njit(cache=True)
def move_some(network: Network, tour: Tour, dice: Indices, warmth: float, tries: Whole) -> Whole:
    """Move a stroke and up to two before or after it next to a near stroke, in either sense."""
    last, gained = len(tour.place) - 2, 0
    for _ in range(tries):
        bits = draw(dice)
        p = 1 + below(bits, last)
        turned, follows = bits >> 31 == 1, (bits >> 30) & 1 == 1
        length = 1 + below(bits >> 14, LONGEST_MOVED)
        way = network.mirror[at(tour, p)] if turned else at(tour, p)
        near = network.after[way] if follows else network.before[way]
        q = tour.place[network.stroke[near[below(bits >> 7, len(near))]]]
        gap = q - 1 if follows else q
        low = p - length + 1 if follows != turned else p
        high = low + length - 1
        if low < 1 or high > last or low - 1 <= gap <= high:
            continue
        before, after = at(tour, gap), at(tour, gap + 1)
        first, end = at(tour, low), at(tour, high)
        change = leg(network, at(tour, low - 1), at(tour, high + 1)) - leg(network, before, after)
        change -= leg(network, at(tour, low - 1), first) + leg(network, end, at(tour, high + 1))
        if length == 1:
            first = best_between(network, before, tour.order[p], after)
            end = first
        elif turned:
            first, end = network.mirror[end], network.mirror[first]
            change += tour.skew[high] - tour.skew[low]
        change += leg(network, before, first) + leg(network, end, after)
        if change <= tolerance(dice, warmth):
            move(network, tour, (low, high, gap), first, end)
            gained += change
    return gained


@njit(cache=True)
def move(network: Network, tour: Tour, what: tuple[Whole, Whole, Whole], first: Whole, end: Whole) -> None:
    """Move positions low to high between gap and gap + 1, turned around if necessary so that ``first`` comes first."""
    low, high, gap = what
    length = high - low + 1
    if gap > high:
        swap(network, tour, low, high, gap)
        low, high, p = low, gap, gap - length + 1
    else:
        swap(network, tour, gap + 1, low - 1, high)
        low, high, p = gap + 1, high, gap + 1
    if length == 1:
        tour.way[tour.order[p]] = first
    elif at(tour, p) != first:
        turn(network, tour, p, p + length - 1)
    update_skew(network, tour, low, high + 1)


@njit(cache=True)
def best_between(network: Network, before: Whole, stroke: Whole, after: Whole) -> Whole:
    """The best way through a stroke between two others."""
    best, best_way = FAR, -1
    for way in range(network.first[stroke], network.first[stroke + 1]):
        length = leg(network, before, way) + leg(network, way, after)
        if length < best:
            best, best_way = length, way
    return best_way


@njit(cache=True)
def swap_some(network: Network, tour: Tour, dice: Indices, warmth: float, tries: Whole) -> Whole:
    """Put a near stroke behind another by swapping two runs of any length, each in its own sense."""
    gained = 0
    for _ in range(tries):
        bits = draw(dice)
        p = 1 + below(bits, len(tour.place) - 2)
        near, following = network.after[at(tour, p)], network.before[at(tour, p + 1)]
        q = tour.place[network.stroke[near[below(bits >> 8, len(near))]]]
        k = tour.place[network.stroke[following[below(bits >> 16, len(following))]]]
        if p + 1 < q <= k:
            low, middle, high = p + 1, q - 1, k
        elif q <= k < p:
            low, middle, high = q, k, p
        else:
            continue
        change = swap_change(network, tour, low, middle, high)
        if change <= tolerance(dice, warmth):
            swap(network, tour, low, middle, high)
            update_skew(network, tour, low, high + 1)
            gained += change
    return gained


@njit(cache=True)
def switch_some(network: Network, tour: Tour, dice: Indices, warmth: float, tries: Whole) -> Whole:
    """Go other ways through strokes where they are."""
    gained = 0
    for _ in range(tries):
        bits = draw(dice)
        p = 1 + below(bits, len(tour.place) - 2)
        stroke = tour.order[p]
        way = network.first[stroke] + below(bits >> 16, network.first[stroke + 1] - network.first[stroke])
        before, old, after = at(tour, p - 1), at(tour, p), at(tour, p + 1)
        change = leg(network, before, way) + leg(network, way, after)
        change -= leg(network, before, old) + leg(network, old, after)
        if change <= tolerance(dice, warmth):
            tour.way[stroke] = way
            update_skew(network, tour, p, p + 1)
            gained += change
    return gained


@njit(cache=True)
def anneal(
    network: Network, order: Indices, rounds: Whole, hot: float, cold: float, seed: Whole
) -> tuple[Indices, Indices, Whole]:
    """Change the order at random, less and less often for the worse, and keep the best that was seen."""
    length, way = choose_ways(network, order)
    tour = new_tour(network, order, way)
    best, best_order, best_way = length, tour.order.copy(), tour.way.copy()
    dice = np.array([2463534242 ^ seed])
    for count in range(rounds):
        warmth = hot * (cold / hot) ** (count / rounds)
        length += turn_some(network, tour, dice, warmth, 24)
        length += move_some(network, tour, dice, warmth, 24)
        length += swap_some(network, tour, dice, warmth, 8)
        length += switch_some(network, tour, dice, warmth, 8)
        if length < best:
            best = length
            best_order[:] = tour.order
            best_way[:] = tour.way
    return best_order[:-1], best_way, best
