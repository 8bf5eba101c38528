"""Order of pieces with little travel between them: in two stages as in Sandia 1993, section 2.2, or in one."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from geometry.arrays import Points
from geometry.coverage.route import Choices, Route, exact_route, shortest_route
from rulesengine.surface.site import Piece
from specs.progress import Progress, no_progress, subprogress

_FEW = 12
"""Pieces of a face up to which every one of them is tried as the first, and up to which an order is proved the best."""
_MOST_STATES = 10**9
_OUTER = 2
"""Of a face with more: so many at either side are."""
_SAME_MM = 0.1
_STEPS = 50.0
"""Legs are compared in steps of 0.05 mm, not of a micrometre: coordinates of a part are rounded to a tenth of that, and
which of two equal ways is taken must not depend on where the part lies."""


@dataclass(frozen=True, slots=True, eq=False)
class OrderedPieces:
    """Pieces in the order and sense in which they are sprayed."""

    pieces: tuple[Piece, ...]
    air_mm: float
    """Straight travel of the orifice from the start and between them."""
    number: tuple[int, ...]
    """(pieces,) which of the given pieces each is."""


@dataclass(frozen=True, slots=True)
class _Way:
    """A way through all pieces of a face: their order, the sense of each, and the travel between them."""

    order: tuple[int, ...]
    turned: tuple[bool, ...]
    air_mm: float


def order_pieces(
    pieces: Sequence[Piece], start: Points, order: Literal["two_stage", "one_stage"], progress: Progress = no_progress
) -> OrderedPieces:
    """Order pieces from a starting point (3,) of the orifice.

    In two stages each face is finished before the next: every shortest way through a face is an edge from its entry to
    its exit, and the faces are ordered over those edges.
    """
    if not pieces:
        return OrderedPieces((), 0.0, ())
    if order == "one_stage":
        way = _route(pieces, list(range(len(pieces))), start, progress)
        return _ordered(pieces, [way], way.air_mm)
    faces: dict[str, list[int]] = {}
    for number, piece in enumerate(pieces):
        faces.setdefault(piece.face, []).append(number)
    ways: list[list[_Way]] = []
    for done, members in enumerate(faces.values()):
        ways.append(shortest_ways(pieces, members, subprogress(progress, 0.0, 0.0)))
        progress("ordering the stripes", 0.9 * (done + 1) / len(faces))
    choices = Choices(
        tuple(np.array([_end(pieces, way, 0) for way in each]) / _STEPS for each in ways),
        tuple(np.array([_end(pieces, way, -1) for way in each]) / _STEPS for each in ways),
    )
    route = _best_route(choices, start / _STEPS, progress)
    chosen = [ways[face][choice] for face, choice in zip(route.order, route.choice, strict=True)]
    return _ordered(pieces, chosen, _STEPS * route.length_mm + sum(way.air_mm for way in chosen))


def shortest_ways(pieces: Sequence[Piece], members: list[int], progress: Progress = no_progress) -> list[_Way]:
    """All equally short ways through some pieces, from any end of them to any other, one for each entry and exit."""
    firsts = members if len(members) <= _FEW else [*members[:_OUTER], *members[-_OUTER:]]
    found: list[_Way] = []
    for first in firsts:
        rest = [each for each in members if each != first]
        for turned in (False, True):
            exit_at = pieces[first].tcp[0 if turned else -1]
            onward = _route(pieces, rest, exit_at, progress)
            way = _Way((first, *onward.order), (turned, *onward.turned), onward.air_mm)
            back = _Way(way.order[::-1], tuple(not each for each in way.turned[::-1]), way.air_mm)
            found += [way, back]
    least = min(way.air_mm for way in found)
    unique: dict[tuple[int, bool, int, bool], _Way] = {}
    for way in found:
        if way.air_mm <= least + _SAME_MM:
            unique.setdefault((way.order[0], way.turned[0], way.order[-1], way.turned[-1]), way)
    return list(unique.values())


def _route(pieces: Sequence[Piece], members: list[int], start: Points, progress: Progress) -> _Way:
    """Shortest way found through some pieces from a point, open at its end."""
    if not members:
        return _Way((), (), 0.0)
    choices = Choices(
        tuple(pieces[each].tcp[[0, -1]] / _STEPS for each in members),
        tuple(pieces[each].tcp[[-1, 0]] / _STEPS for each in members),
    )
    route = _best_route(choices, start / _STEPS, progress)
    order = tuple(members[index] for index in route.order)
    turned = tuple(bool(choice) for choice in route.choice)
    ends = [
        (pieces[each].tcp[-1 if back else 0], pieces[each].tcp[0 if back else -1])
        for each, back in zip(order, turned, strict=True)
    ]
    legs = zip([start, *(leave for _, leave in ends)], (enter for enter, _ in ends), strict=False)
    return _Way(order, turned, float(sum(np.linalg.norm(enter - leave) for leave, enter in legs)))


def _best_route(choices: Choices, start: Points, progress: Progress) -> Route:
    """Shortest route, proved for up to a dozen strokes."""
    ways = sum(len(each) for each in choices.entries)
    if len(choices.entries) <= _FEW and ways**2 << len(choices.entries) <= _MOST_STATES:
        return exact_route(choices, start)
    return shortest_route(choices, start, progress=progress)


def _end(pieces: Sequence[Piece], way: _Way, which: Literal[0, -1]) -> Points:
    piece, turned = pieces[way.order[which]], way.turned[which]
    return piece.tcp[-1 - which if turned else which]


def _ordered(pieces: Sequence[Piece], ways: Sequence[_Way], air_mm: float) -> OrderedPieces:
    done = [
        (pieces[number].reversed() if turned else pieces[number], number)
        for way in ways
        for number, turned in zip(way.order, way.turned, strict=True)
    ]
    return OrderedPieces(tuple(piece for piece, _ in done), air_mm, tuple(number for _, number in done))
