"""Order of strokes, and where each begins, such that the nozzle travels least with the jet off."""

from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Points
from geometry.coverage.route import Choices, Effort, shortest_route
from rulesengine.strokes.stroke import Stroke, StrokeSet
from specs.finding import Finding
from specs.finding_rules import ORDER_GAIN
from specs.progress import Progress, no_progress
from specs.source import Source

_AS_NEAR_MM = 1e-3
"""Places that are no farther apart than this are as near: the first is taken."""

_SAME_MM = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Ordered:
    """Open strokes in the order and sense in which they are done."""

    strokes: tuple[Stroke, ...]
    findings: tuple[Finding, ...]
    settled: bool = True
    """Whether the full effort would give the same."""


def order_strokes(
    strokes: StrokeSet, start: Points, made_by: Source, effort: Effort = "full", progress: Progress = no_progress
) -> Ordered:
    """Fix order, beginnings and senses, as far as the set leaves them open, from a starting point (3,)."""
    todo = list(strokes.strokes)
    if strokes.freedom == "either_end" and len(todo) > 1:
        first, last = (float(np.linalg.norm(s.tcp[0] - start)) for s in (todo[0], todo[-1]))
        if last < first - _AS_NEAR_MM:
            todo.reverse()
    if not todo:
        return Ordered((), ())
    ways = [_ways(stroke) for stroke in todo]
    if strokes.freedom != "free":  # the order stays; each begins where it is nearest
        kept: list[Stroke] = []
        for stroke, way in zip(todo, ways, strict=True):
            away = np.linalg.norm(stroke.tcp[[begin for begin, _ in way]] - start, axis=1)
            kept.append(_begun(stroke, way[int(np.argmax(away < away.min() + _AS_NEAR_MM))]))
            start = kept[-1].tcp[-1]
        return Ordered(tuple(kept), ())
    choices = Choices(
        tuple(stroke.tcp[[begin for begin, _ in way]] for stroke, way in zip(todo, ways, strict=True)),
        tuple(stroke.tcp[[end for _, end in way]] for stroke, way in zip(todo, ways, strict=True)),
    )
    route = shortest_route(choices, start, effort=effort, progress=progress)
    done = tuple(
        _begun(todo[index], ways[index][choice]) for index, choice in zip(route.order, route.choice, strict=True)
    )
    length, given = route.length_mm, route.given_length_mm
    if len(todo) < 2 or given <= 0:
        return Ordered(done, (), route.settled)
    message = (
        f"Order of {len(todo)} strokes: {length:.0f} mm between them instead of {given:.0f} mm in the given order "
        f"({100 * (1 - length / given):.0f} % less)."
    )
    return Ordered(done, (Finding(ORDER_GAIN, message, made_by),), route.settled)


def _ways(stroke: Stroke) -> list[tuple[int, int]]:
    """Where a stroke may begin and would then end, as indices of its points."""
    if stroke.closed:
        return [(entry, entry) for entry in stroke.entries]
    last = len(stroke.tcp) - 1
    return [(0, last), (last, 0)] if stroke.sense == "either" else [(0, last)]


def _begun(stroke: Stroke, way: tuple[int, int]) -> Stroke:
    """Open a stroke at the place that was chosen; a ring is unrolled, lap after lap."""
    begin, end = way
    count = len(stroke.tcp)
    if not stroke.closed:
        return stroke if begin < end or count == 1 else stroke.pick(np.arange(count)[::-1])
    lap = np.roll(np.arange(count), -begin)
    # A ring that does not turn where it closes passes its first point again at the end of each lap.
    turns_there = bool(np.abs(stroke.tcp[lap[0]] - stroke.tcp[lap[-1]]).max() < _SAME_MM)
    laps = np.tile(lap, stroke.laps)
    opened = stroke.pick(laps if turns_there else np.append(laps, begin))
    delays = opened.delays.copy()
    if not turns_there:
        delays[0] = 0.0  # nothing has arrived there yet
    return replace(opened, delays=delays, closed=False, laps=1, entries=(0,))
