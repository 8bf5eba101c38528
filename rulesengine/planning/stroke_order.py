"""Strokes of a single board brought to the instances of a panel, and in the order with the least travel, jet off."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from boards.board import Instance
from geometry.arrays import Points, Scalars
from geometry.coverage.route import Choices, Effort, shortest_route
from rulesengine.modifiers import raise_over
from rulesengine.strokes.safe_height import Floors
from rulesengine.strokes.stroke import Stroke, StrokeSet
from specs.finding import Finding
from specs.finding_rules import ORDER_GAIN
from specs.progress import Progress, no_progress
from specs.source import Source

_LIFTED_MM = 1e-6
_AS_NEAR_MM = 1e-3
"""Places that are no farther apart than this are as near: the first is taken."""
_SAME_MM = 1e-6


def place_on_panel(instances: Sequence[Instance], sets: Sequence[StrokeSet], floors: Floors) -> StrokeSet:
    """Bring the strokes of one template to every instance of a panel, as one set whose order is found together.

    Each stroke is that of the single board, turned and moved. Only one that would come too near a body of a neighbour
    is raised over it.

    Args:
        instances: Of the panel.
        sets: Strokes of the board of each instance.
        floors: Of the panel, on the side that is sprayed.
    """
    strokes: list[Stroke] = []
    findings: dict[Finding, None] = {}
    for instance, planned in zip(instances, sets, strict=True):
        findings |= dict.fromkeys(planned.findings)
        for stroke in planned.strokes:
            placed = move_stroke(stroke, instance)
            raised = raise_over(StrokeSet((placed,), planned.freedom), floors)
            before, after = (_heights(each) for each in (placed, raised.strokes[0]))
            # What its own board made it rise over is in the way on the panel as well, and is cleared already.
            if (after[1] - np.interp(after[0], *before)).max() < _LIFTED_MM:
                strokes.append(placed)
            else:
                strokes += raised.strokes
                findings |= dict.fromkeys(raised.findings)
    planned = next((each for each in sets if each.strokes), sets[0])
    return StrokeSet(tuple(strokes), planned.freedom, planned.retract, tuple(findings))


def _heights(stroke: Stroke) -> tuple[Scalars, Scalars]:
    """Plan length from the beginning to each point, the first one again at the end of a ring, and the heights."""
    steps = np.linalg.norm(np.diff(stroke.lap[:, :2], axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)]), stroke.lap[:, 2]


def move_stroke(stroke: Stroke, instance: Instance) -> Stroke:
    """Bring a stroke of an instance's board onto the panel; its components get the name of the instance."""
    tcp, approach = stroke.tcp.copy(), stroke.approach.copy()
    tcp[:, :2], approach[:, :2] = instance.points(tcp[:, :2]), instance.directions(approach[:, :2])
    return replace(
        stroke,
        tcp=tcp,
        approach=approach,
        azimuth=instance.directions(stroke.azimuth),
        made_by=replace(stroke.made_by, components=tuple(map(instance.rename, stroke.made_by.components))),
        pauses=tuple(instance.rename(name) if name else "" for name in stroke.pauses),
    )


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
