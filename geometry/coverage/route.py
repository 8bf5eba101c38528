"""The order of strokes with the least travel between them (open rural postman with a choice of ways)."""

import threading
from collections import OrderedDict
from collections.abc import Hashable
from dataclasses import dataclass
from typing import Generic, Literal, TypeAlias, TypeVar

import numpy as np

from geometry.arrays import Points
from specs.progress import Progress, no_progress

Effort: TypeAlias = Literal["sketch", "full"]
"""A sketch is made in a moment: an order that is repaired, without the search for a better one."""

_CACHED = 64
V = TypeVar("V")


class LruCache(Generic[V]):
    """Cache of results, the least recently used dropped first. Threads may share it; nobody may change a result."""

    def __init__(self, size: int) -> None:
        """Make an empty cache of so many results."""
        self._size = size
        self._results: OrderedDict[Hashable, V] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, key: Hashable) -> V | None:
        """Result of a key, ``None`` if it is not cached."""
        with self._lock:
            if key in self._results:
                self._results.move_to_end(key)
            return self._results.get(key)

    def put(self, key: Hashable, result: V) -> V:
        """Cache a result and return it."""
        with self._lock:
            self._results[key] = result
            self._results.move_to_end(key)
            if len(self._results) > self._size:
                self._results.popitem(last=False)
        return result

    def clear(self) -> None:
        """Drop all results."""
        with self._lock:
            self._results.clear()


@dataclass(frozen=True, slots=True, eq=False)
class Choices:
    """The ways to go through each stroke: in at an entry, out at the exit of the same number.

    An open stroke has two (there and back) or one (fixed sense), a ring one for each point at which it may begin and
    end. One frame, mm; every stroke has at least one way.
    """

    entries: tuple[Points, ...]
    """(m, 3) per stroke"""
    exits: tuple[Points, ...]
    """(m, 3) per stroke"""


@dataclass(frozen=True, slots=True)
class Route:
    """An order of strokes and the way through each."""

    order: tuple[int, ...]
    """Stroke at each position."""
    choice: tuple[int, ...]
    """Chosen way at each position: ``choice[i]`` belongs to stroke ``order[i]``."""
    length_mm: float
    """From the start through all strokes to the end, without the strokes themselves."""
    given_length_mm: float
    """The same for the strokes in the order they were given, with the best ways for that order."""
    settled: bool = True
    """Whether this is what the full effort finds; a sketch may be settled too."""


_routes: LruCache[Route] = LruCache(_CACHED)
"""Settled routes, so that an edit that moves no stroke does not search again."""


def shortest_route(
    choices: Choices,
    start: Points,
    end: Points | None = None,
    *,
    effort: Effort = "full",
    progress: Progress = no_progress,
) -> Route:
    """Order the strokes so that the straight legs between them are short: optimal in practice for a few dozen.

    Legs count in whole micrometres and ties go to the lower number, so the route turns and moves with its strokes.
    The search is a fixed number of steps with fixed random numbers: the same strokes give the same route.

    Args:
        choices: the strokes, mm.
        start: (3,) where the nozzle is, mm.
        end: (3,) where it has to go at last, or ``None`` if the route may stop anywhere.
        effort: a sketch is the settled route where that is cached or found at once.
        progress: Receives the stage and the share done; it may end the search by raising something.

    Returns:
        A route that is never longer than the best one in the given order.
    """
    if not choices.entries:
        length = 0.0 if end is None else float(np.linalg.norm(end - start))
        return Route((), (), length, length)
    counts = tuple(len(entry) for entry in choices.entries)
    places = np.concatenate([*choices.entries, *choices.exits, start[None], *([] if end is None else [end[None]])])
    key = counts, end is not None, places.astype(np.float64).tobytes()
    known = _routes.get(key)
    if known is not None:
        return known
    # numba takes a moment to load: only those who plan should wait for it
    from geometry.coverage.local_search import choose_ways, is_kicked, search_order
    from geometry.coverage.tour import MICRONS_PER_MM, build_network

    network = build_network(choices.entries, choices.exits, start, end)
    count = len(choices.entries)
    given = np.array([count, *range(count), count + 1])
    given_um, given_ways = choose_ways(network, given)
    order = search_order(network, 1.0 if effort == "full" else 0.0, progress=progress)
    length_um, ways = choose_ways(network, order)
    if length_um >= given_um:
        order, ways, length_um = given, given_ways, given_um
    strokes = order[1:-1]
    route = Route(
        order=tuple(strokes.tolist()),
        choice=tuple((ways[strokes] - network.first[strokes]).tolist()),
        length_mm=length_um / MICRONS_PER_MM,
        given_length_mm=given_um / MICRONS_PER_MM,
        settled=effort == "full" or not is_kicked(network),
    )
    return _routes.put(key, route) if route.settled else route


def exact_route(choices: Choices, start: Points) -> Route:
    """Order the strokes so that the legs between them are shortest, proved by dynamic programming; open at the end.

    Time and memory grow with 2 to the power of the number of strokes: for a dozen of them it takes a moment. Legs count
    as in ``shortest_route``.

    Args:
        choices: the strokes, mm.
        start: (3,) where the nozzle is, mm.
    """
    if len(choices.entries) < 2:
        return shortest_route(choices, start)
    from geometry.coverage.local_search import choose_ways, solve_small
    from geometry.coverage.tour import MICRONS_PER_MM, build_network

    network = build_network(choices.entries, choices.exits, start, None)
    count = len(choices.entries)
    given_um, _ = choose_ways(network, np.array([count, *range(count), count + 1]))
    order = solve_small(network)
    length_um, ways = choose_ways(network, order)
    strokes = order[1:-1]
    return Route(
        order=tuple(strokes.tolist()),
        choice=tuple((ways[strokes] - network.first[strokes]).tolist()),
        length_mm=length_um / MICRONS_PER_MM,
        given_length_mm=given_um / MICRONS_PER_MM,
    )


def forget_routes() -> None:
    """Clear the cache of routes, so that the search can be measured."""
    _routes.clear()
