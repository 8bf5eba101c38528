"""Change a route in place so that the changes can be taken back."""

from typing import NamedTuple

import numpy as np

from geometry.arrays import Indices
from geometry.coverage.compiled import compiled, quick
from geometry.coverage.route_network import Network, Whole
from geometry.coverage.route_tour import Tour, turn, update_skew

ROOM = 4096
"""Changes that can be taken back"""


class Desk(NamedTuple):
    """What a descent keeps: the strokes it has to look at, and what it has done, so that it can be taken back."""

    queue: Indices
    """(n + 2,) strokes in the order in which they are looked at, from ``mark[0]`` on, around the end"""
    waiting: Indices
    """(n + 2,) 1 for each stroke that is in the queue"""
    done: Indices
    """(room, 2) positions turned around, or -1 - stroke and its old way"""
    mark: Indices
    """Head of the queue, its length, the number of things done, lowest and highest position touched"""
    slack: int
    """A change that adds less than so many micrometres is tried, in the hope of better ways around it"""


@compiled
def new_desk(count: Whole, slack: Whole) -> Desk:
    """An empty desk for a tour of so many strokes, start and end included, and a slack."""
    return Desk(
        np.zeros(count, dtype=np.int64),
        np.zeros(count, dtype=np.int64),
        np.zeros((ROOM, 2), dtype=np.int64),
        np.array([0, 0, 0, count, 0]),
        slack,
    )


@quick
def look_at(tour: Tour, desk: Desk, position: Whole) -> None:
    """Queue the stroke at a position."""
    stroke = tour.order[position]
    if desk.waiting[stroke]:
        return
    desk.waiting[stroke] = 1
    desk.queue[(desk.mark[0] + desk.mark[1]) % len(desk.queue)] = stroke
    desk.mark[1] += 1


@quick
def do_turn(network: Network, tour: Tour, desk: Desk, low: Whole, high: Whole) -> None:
    """Turn positions around and note it. The skew is left behind."""
    turn(network, tour, low, high)
    desk.done[desk.mark[2], 0] = low
    desk.done[desk.mark[2], 1] = high
    desk.mark[2] += 1


@quick
def do_way(network: Network, tour: Tour, desk: Desk, way: Whole) -> None:
    """Go another way through a stroke and note it. The skew is left behind."""
    stroke = network.stroke[way]
    if tour.way[stroke] == way:
        return
    desk.done[desk.mark[2], 0] = -1 - stroke
    desk.done[desk.mark[2], 1] = tour.way[stroke]
    desk.mark[2] += 1
    tour.way[stroke] = way


@quick
def touched(network: Network, tour: Tour, desk: Desk, low: Whole, high: Whole) -> None:
    """The legs that end at positions ``low`` to ``high`` have changed: bring the skew up to date."""
    update_skew(network, tour, low, high)
    desk.mark[3] = min(desk.mark[3], low)
    desk.mark[4] = max(desk.mark[4], high)


@quick
def take_back_to(network: Network, tour: Tour, desk: Desk, begun: Whole, legs: tuple[Whole, Whole]) -> None:
    """Undo what was noted from number ``begun`` on; only legs that end between two positions had changed."""
    while desk.mark[2] > begun:
        desk.mark[2] -= 1
        low, high = desk.done[desk.mark[2]]
        if low < 0:
            tour.way[-1 - low] = high
        else:
            turn(network, tour, low, high)
    update_skew(network, tour, legs[0], legs[1])


@quick
def take_back(network: Network, tour: Tour, desk: Desk) -> None:
    """Undo all that is noted."""
    take_back_to(network, tour, desk, 0, (desk.mark[3], desk.mark[4]))
    keep(desk)


@quick
def keep(desk: Desk) -> None:
    """Forget what was noted."""
    desk.mark[2] = 0
    desk.mark[3] = len(desk.queue)
    desk.mark[4] = 0


@quick
def do_swap(network: Network, tour: Tour, desk: Desk, low: Whole, middle: Whole, high: Whole) -> None:
    """Swap two neighbouring runs, each in its own sense."""
    do_turn(network, tour, desk, low, high)
    cut = low + high - middle
    do_turn(network, tour, desk, low, cut - 1)
    do_turn(network, tour, desk, cut, high)
