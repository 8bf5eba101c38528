"""The boxes and balls around bodies, for many rows of joints: where they are, and how far apart at least. Metres."""

import math

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Points, Scalars
from geometry.compiled import compiled, inner

Turns = NDArray[np.float64]  # (..., 3, 3)


@compiled
def write_places(
    links: NDArray[np.float64], carriers: Indices, mounted: NDArray[np.float64], turns: Turns, middles: Points
) -> None:
    """Write turns (n, s, 3, 3) and middles (n, s, 3) of s bodies, given links (n, l, 4, 4).

    Args:
        links: Poses of what carries bodies.
        carriers: (s,) the link of each body; -1 where it stands still.
        mounted: (s, 4, 4) where each is on its link.
        turns: Receives the one.
        middles: Receives the other.
    """
    for row in range(len(links)):
        for body in range(len(carriers)):
            link = carriers[body]
            for line in range(3):
                for column in range(4):
                    value = mounted[body, line, column]
                    if link >= 0:
                        value = links[row, link, line, 3] if column == 3 else 0.0
                        for between in range(3):
                            value += links[row, link, line, between] * mounted[body, between, column]
                    if column == 3:
                        middles[row, body, line] = value
                    else:
                        turns[row, body, line, column] = value


@compiled
def mark_near(
    places: tuple[Turns, Points],
    pairs: tuple[Indices, Indices],
    sizes: tuple[Scalars, Points],
    margins: NDArray[np.float64],
    near: NDArray[np.bool_],
) -> None:
    """Mark of (n, p) pairs those whose balls and boxes come within the margins (n, p); none where those are below 0.

    Args:
        places: Turns and middles of the bodies.
        pairs: (p,) the first and the second body of each.
        sizes: (s,) radii, and (s, 3) half the edges of the boxes.
        margins: Least distances.
        near: Receives the marks.
    """
    middles, (radii, half) = places[1], sizes
    turned, between = np.empty((3, 3)), np.empty(3)
    for row in range(len(near)):
        for pair in range(len(pairs[0])):
            first, second = pairs[0][pair], pairs[1][pair]
            far, apart = radii[first] + radii[second] + margins[row, pair], 0.0
            for axis in range(3):
                apart += (middles[row, second, axis] - middles[row, first, axis]) ** 2
            near[row, pair] = False
            if far >= 0.0 and apart <= far * far:
                _see(places, row, (first, second), turned, between)
                near[row, pair] = _box_gap(turned, between, half[first], half[second]) <= margins[row, pair]


@compiled
def gaps_of(
    places: tuple[Turns, Points], rows: Indices, pairs: tuple[Indices, Indices], half: Points, found: Scalars
) -> None:
    """Write the lower bounds (m,) of the distances of pairs of bodies (m,) at rows (m,) of the places."""
    turned, between = np.empty((3, 3)), np.empty(3)
    for item in range(len(rows)):
        first, second = pairs[0][item], pairs[1][item]
        _see(places, rows[item], (first, second), turned, between)
        found[item] = _box_gap(turned, between, half[first], half[second])


@compiled
def box_gaps(turned: Turns, between: Points, half_first: Points, half_second: Points) -> Scalars:
    """Give (m,) lower bounds of the distances of boxes, along the axes of each.

    Args:
        turned: (m, 3, 3) from the second box's axes to those of the first.
        between: (m, 3) from the middle of the first to that of the second, in the axes of the first.
        half_first: (m, 3) half the edges of the first.
        half_second: (m, 3) half the edges of the second.
    """
    found = np.empty(len(between))
    for item in range(len(between)):
        found[item] = _box_gap(turned[item], between[item], half_first[item], half_second[item])
    return found


@inner
def _see(places: tuple[Turns, Points], row: int, pair: tuple[int, int], turned: Turns, between: Scalars) -> None:
    """Write where the second body is as the first one sees it."""
    (turns, middles), (first, second) = places, pair
    for axis in range(3):
        between[axis] = 0.0
        for world in range(3):
            between[axis] += turns[row, first, world, axis] * (middles[row, second, world] - middles[row, first, world])
        for other in range(3):
            turned[axis, other] = 0.0
            for world in range(3):
                turned[axis, other] += turns[row, first, world, axis] * turns[row, second, world, other]


@inner
def _box_gap(turned: Turns, between: Scalars, half_first: Scalars, half_second: Scalars) -> float:
    """Give the lower bound of the distance of two boxes."""
    one = other = 0.0
    for axis in range(3):
        seen, across, back = abs(between[axis]) - half_first[axis], 0.0, -half_second[axis]
        for along in range(3):
            seen -= abs(turned[axis, along]) * half_second[along]
            across += turned[along, axis] * between[along]
            back -= abs(turned[along, axis]) * half_first[along]
        back += abs(across)
        one += max(seen, 0.0) ** 2
        other += max(back, 0.0) ** 2
    return math.sqrt(max(one, other))


@compiled
def write_travels(
    motions: tuple[NDArray[np.float64], NDArray[np.float64]],
    chain: tuple[NDArray[np.bool_], Scalars],
    links: tuple[Indices, Indices],
    levers: Scalars,
    travels: NDArray[np.float64],
) -> None:
    """Write (n, p) the farthest that the bodies of a pair can move against each other on a motion.

    Args:
        motions: (n, dof) joints at the beginning and the end of each.
        chain: (dof,) whether a joint slides, and how far it stands from the one before.
        links: (p,) of the first and of the second body of each pair.
        levers: (p,) how far a point of the second is from its last joint at most.
        travels: Receives the ways.
    """
    (start, end), (slides, steps) = motions, chain
    for row in range(len(travels)):
        for pair in range(len(levers)):
            lever, total = levers[pair], 0.0
            for joint in range(links[1][pair] - 1, links[0][pair] - 1, -1):
                total += abs(end[row, joint] - start[row, joint]) * (1.0 if slides[joint] else lever)
                out = max(abs(start[row, joint]), abs(end[row, joint])) if slides[joint] else 0.0
                lever += steps[joint] + out
            travels[row, pair] = total
