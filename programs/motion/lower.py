"""Expresses the events of a motion as one controller can time them, and how wrong that is."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal, TypeAlias

from programs.motion.analog import IN_OWN_UNIT, Counting, find_out_of_range
from programs.motion.steps import (
    LEAST_S,
    Event,
    Line,
    MotionProgram,
    Mount,
    Reference,
    Repeat,
    Step,
    Switch,
    limit_speed,
    split_line,
)
from programs.timing.forecast import SHORT_S, Forecast
from specs.finding import Finding
from specs.finding_rules import NO_SENSOR, STOPS_FOR_OUTPUT
from specs.source import NO_SOURCE, Source

EventTiming: TypeAlias = Literal["distance and time", "distance", "time", "percent", "boundary", "stop"]
"""How a language places an output on a line.

``distance and time``: so many mm from the reference, so many seconds earlier (class 1).
``distance``: so many mm from the reference (classes 1 and 4).
``time``: so many seconds before the reference; the line is divided at the requested place of the jet (class 1).
``percent``: of the line (class 2).
``boundary``: where a line begins; it is divided there and passed (class 3).
``stop``: only where the robot stands; it is divided there and the robot stops (class 5).
"""

_MOMENT_S = 1e-6
_SHORTEST_SHARE = 1e-4
"""Nearer to an end of its line than this a division would make a line that no controller drives."""
COARSE_MM, _COARSE_S = 0.4, 1.5e-3
"""A percentage that misses the jet's place and time by more is replaced by a division of the line."""
_LATE_S = 0.5 * (LEAST_S + 1e-3)
"""So is one that misses the time by more: where the robot has stopped the speed is 0, and not the way after it."""
_NEARLY = 0.5
"""Share of a step by which a speed may be rounded up."""
_WHOLE = 1e-6
_DIVISION_BLEND_MM = 0.3
"""Zone at a collinear point, or less where the parts are short."""


@dataclass(frozen=True, slots=True)
class Capability:
    """What one controller can time on the path."""

    controller_class: Literal[1, 2, 3, 4, 5]
    timing: EventTiming
    cycle_s: float
    """Largest error of any signal: the cycle of the controller's interpolator or poller."""
    references: tuple[Reference, ...] = ("start", "end")
    """Origins of a distance or a time, the preferred one first."""
    step_mm: float = 1e-3
    """Smallest step of a distance."""
    step_s: float = 1e-3
    """Smallest step of a time."""
    step_percent: float = 1.0
    """Smallest step of a percentage."""
    most_events: int = 8
    """On one line."""
    longest_lead_s: float = math.inf
    """Longest time before its place; a signal that leaves earlier is placed where it leaves."""
    step_mm_s: float = 1e-3
    """Smallest step of a commanded speed."""
    switches_at_rest: bool = False
    """Whether a jet that begins or ends where the robot stands has its signal there, and the robot waits for it."""
    reads_sensors: bool = True
    """Whether a loop can read an analog input."""
    changes_tools: bool = False
    """Whether the word that selects a tool has it mounted too, such as ``T2 M6``."""
    least_part_s: float = LEAST_S + 1e-3
    """A line is not divided for an output into parts that take less, as far as that moves a jet by 0.4 mm at most."""
    analog: Counting = IN_OWN_UNIT
    """How it counts analog channels."""


@dataclass(frozen=True, slots=True)
class EventError:
    """Largest deviation of the jet's begin or end from its requested place in a program, at planned speeds."""

    distance_mm: float
    time_s: float
    made_by: Source


@dataclass(frozen=True, slots=True, eq=False)
class Lowered:
    """A motion in one controller's terms."""

    motion: MotionProgram
    """Its findings include what the controller cannot do."""
    error: EventError
    forecast: Forecast | None = None
    """What the controller's model predicts of the text; ``None`` before there is one, and where there is no model."""


def lower(motion: MotionProgram, capability: Capability) -> Lowered:
    """Express a motion in one controller's terms: events in its manner, lines divided where that needs it.

    Places and speeds are rounded to the controller's steps, speeds downwards. The offsets of the events that remain are
    those that the language prints.
    """
    steps: list[Step] = []
    errors = [EventError(0.0, 0.0, NO_SOURCE)]
    findings: list[Finding] = []
    for step in motion.steps:
        if isinstance(step, Line):
            lowered = [_at_speed(each, capability) for each in _lower_line(step, capability)]
            steps += lowered
            errors += _error_of(step, lowered, capability)
        elif isinstance(step, Repeat) and step.sensor is not None and not capability.reads_sensors:
            message = f"this language cannot read {step.key}; the loop is done {step.count} times."
            findings.append(Finding(NO_SENSOR, message, step.made_by))
            steps.append(replace(step, sensor=None))
        elif not (isinstance(step, Mount) and capability.changes_tools):
            steps.append(step)
    if capability.timing == "stop" and (count := sum(len(line.events) for line in motion.lines)):
        message = f"this controller stops for an output: the robot stands {count} times where the jet begins or ends."
        findings.append(Finding(STOPS_FOR_OUTPUT, message))
    findings += find_out_of_range(steps, capability.analog)
    worst = max(errors, key=lambda error: (round(error.distance_mm, 6), round(error.time_s, 9)))
    return Lowered(replace(motion, steps=tuple(steps), findings=(*motion.findings, *findings)), worst)


def _lower_line(line: Line, capability: Capability) -> Iterator[Step]:
    if not line.events:
        yield line
        return
    match capability.timing:
        case "distance" | "distance and time" if line.turns_on_the_spot and not _is_near_end(line, capability):
            yield from _divided_at_signals(line, capability.least_part_s)
        case "percent" if not _is_fine_enough(line, capability):
            yield from _divided_at_signals(line, capability.least_part_s)
        case "distance and time" | "distance" | "percent":
            yield from _in_place(line, capability)
        case "time":
            yield from _divided_at_jets(line, capability)
        case "boundary":
            yield from _divided_at_signals(line, capability.least_part_s)
        case "stop":
            yield from _stopped_at_signals(line)


def _at_speed(step: Step, capability: Capability) -> Step:
    """Command a line at a speed that the language has, at which it is no short move; turns on the spot keep their rate.

    Where a speed that is rounded up would make a short move it is rounded down.

    A controller takes the rate of such a turn from its motion as a whole, wherever it is divided for a signal.
    """
    if not isinstance(step, Line):
        return step
    line = limit_speed(step) if capability.least_part_s and not step.turns_on_the_spot else step
    if line.speed_mm_s == 0.0:
        return line
    # A plateau of 40 mm/s reads 39.98 where its time was rounded up: what is nearly a step is one.
    down, near = (max(math.floor(line.speed_mm_s / capability.step_mm_s + spare), 1) for spare in (_WHOLE, _NEARLY))
    is_short = line.length_mm < SHORT_S * near * capability.step_mm_s
    return replace(line, speed_mm_s=(down if is_short else near) * capability.step_mm_s)


def _is_fine_enough(line: Line, capability: Capability) -> bool:
    """Whether whole percents of a line place its jets well."""
    step = capability.step_percent / 100.0
    for event in line.events:
        share = line.samples.share_at(event.signal_s)
        late_s = abs(line.samples.second_at(round(share / step) * step) - event.signal_s)
        if late_s > _LATE_S or (late_s * event.speed_mm_s > COARSE_MM and late_s > _COARSE_S):
            return False
    return True


def _is_near_end(line: Line, capability: Capability) -> bool:
    """Whether a time before the end can express all signals: a turn on the spot has no distances."""
    longest = capability.longest_lead_s if capability.timing == "distance and time" else 0.0
    return all(line.duration_s - event.signal_s <= longest for event in line.events)


def _in_place(line: Line, capability: Capability) -> Iterator[Line]:
    """Keep the line whole unless it has more events than the language allows; then divide it between two signals."""
    most, events = capability.most_events, line.events
    if len(events) > most:
        share = line.samples.share_at(0.5 * (events[most - 1].signal_s + events[most].signal_s))
        if _SHORTEST_SHARE < share < 1.0 - _SHORTEST_SHARE:
            first, rest = split_line(line, (share,), _division_blend(line, (share,)))
            yield from _in_place(_holding(first, line, events[:most], share), capability)
            yield from _in_place(_holding(rest, line, events[most:], share), capability)
            return
    yield replace(line, events=tuple(_expressed(line, event, capability) for event in events))


def _holding(part: Line, line: Line, events: tuple[Event, ...], cut: float) -> Line:
    """Give a part of a line its events, counted in time from its end where their places are not on it."""
    is_first = part.start is line.start
    begin, size = (0.0, cut) if is_first else (cut, 1.0 - cut)
    begin_s = 0.0 if is_first else line.samples.second_at(cut)
    own: list[Event] = []
    for event in events:
        share, signal_s = (event.share - begin) / size, event.signal_s - begin_s
        if 0.0 <= share <= 1.0:
            place_mm = share * part.length_mm - (part.length_mm if event.reference == "end" else 0.0)
            own.append(replace(event, share=share, offset_mm=place_mm, signal_s=signal_s))
        else:
            offset_s = signal_s - part.duration_s
            own.append(replace(event, reference="end", share=1.0, offset_mm=0.0, offset_s=offset_s, signal_s=signal_s))
    return replace(part, events=tuple(own))


def _expressed(line: Line, event: Event, capability: Capability) -> Event:
    """Express one event in the language's own terms on its line."""
    reference = event.reference if event.reference in capability.references else capability.references[0]
    if capability.timing == "percent":
        step = capability.step_percent / 100.0
        share = min(max(round(line.samples.share_at(event.signal_s) / step) * step, 0.0), 1.0)
        return replace(event, reference="start", share=share, offset_mm=share * line.length_mm, offset_s=0.0)
    if capability.timing == "distance and time" and -event.offset_s <= capability.longest_lead_s:
        share, offset_s = event.share, round(event.offset_s / capability.step_s) * capability.step_s
    else:
        share, offset_s = line.samples.share_at(event.signal_s), 0.0
    exact_mm = (share - (1.0 if reference == "end" else 0.0)) * line.length_mm
    offset_mm = round(exact_mm / capability.step_mm) * capability.step_mm
    return replace(event, reference=reference, share=share, offset_mm=offset_mm, offset_s=offset_s)


def _divided_at_jets(line: Line, capability: Capability) -> Iterator[Line]:
    """Divide a line at the requested places of its jets; each signal leaves so long before the end of a part."""
    shares = _inner({_part_end(line, number, capability) for number in range(len(line.events))})
    left, step, begin_s = list(line.events), capability.step_s, 0.0
    for part in split_line(line, shares, _division_blend(line, shares)):
        end_s = begin_s + part.duration_s
        own = [event for event in left if event.signal_s <= end_s + _MOMENT_S]
        left = left[len(own) :]
        events: list[Event] = []
        for event in own:
            offset_s = min(round((event.signal_s - end_s) / step) * step, 0.0)
            timed = replace(event, offset_s=offset_s, signal_s=event.signal_s - begin_s)
            events.append(replace(timed, reference="end", share=1.0, offset_mm=0.0))
        yield replace(part, events=tuple(events))
        begin_s = end_s


def _part_end(line: Line, number: int, capability: Capability) -> float:
    """Where the part ends whose end a signal counts from, as a share of the line.

    That is the requested place of the jet, or near to it, whole steps after the signal. No part has more signals than
    allowed.
    """
    event, step = line.events[number], capability.step_s
    lead = (line.samples.second_at(event.share) - event.signal_s) / step
    after = line.events[number + capability.most_events :][:1]
    most = ((after[0].signal_s if after else line.duration_s) - event.signal_s - 2 * _MOMENT_S) / step
    late_s = abs(round(lead) - lead) * step
    is_near = event.share == 1.0 and min(late_s / _COARSE_S, late_s * event.speed_mm_s / COARSE_MM) < 1.0
    if (late_s < _MOMENT_S or is_near) and (lead <= most or not after):
        return event.share
    return line.samples.share_at(event.signal_s + max(min(round(lead), math.floor(most)), 0) * step)


def _divided_at_signals(line: Line, least_s: float) -> Iterator[Line]:
    """Divide a line where its signals leave; each is at the start of a part, or in its last moment at its end."""
    cuts, chosen = _cuts_of(line, [_shift(line, event, least_s) for event in line.events])
    parts = split_line(line, cuts[1:-1], _division_blend(line, cuts[1:-1]))
    for number, part in enumerate(parts):
        is_last = number == len(parts) - 1
        begins = [_at_end_of(part, event, "start") for event, cut in chosen if cut == number]
        ends = [_at_end_of(part, event, "end") for event, cut in chosen if is_last and cut == number + 1]
        yield replace(part, events=(*begins, *ends))


def _at_end_of(part: Line, event: Event, reference: Reference) -> Event:
    share, signal_s = (1.0, part.duration_s) if reference == "end" else (0.0, 0.0)
    return replace(event, reference=reference, share=share, offset_mm=0.0, offset_s=0.0, signal_s=signal_s)


def _stopped_at_signals(line: Line) -> Iterator[Step]:
    """Divide a line where its signals leave, and stop there for each."""
    cuts, chosen = _cuts_of(line, [event.signal_s for event in line.events])
    stops = {cut for _, cut in chosen}
    for number, part in enumerate([None, *split_line(line, cuts[1:-1], 0.0)]):
        if part is not None:
            yield replace(part, blend_mm=0.0) if number in stops else part
        yield from (Switch(event.channel, event.value, event.made_by) for event, cut in chosen if cut == number)


def _shift(line: Line, event: Event, least_s: float) -> float:
    """When a signal leaves that is not to leave a part of less time: later or earlier by half of that at most."""
    nearest = min(event.signal_s, line.duration_s - event.signal_s)
    due = least_s if nearest > 0.5 * least_s else 0.0
    by_s = abs(due - nearest)
    if len(line.events) > 1 or nearest >= least_s or by_s * event.speed_mm_s > COARSE_MM:
        return event.signal_s
    if due and line.duration_s < 2.0 * least_s:
        return event.signal_s
    return due if nearest == event.signal_s else line.duration_s - due


def _cuts_of(line: Line, signals_s: list[float]) -> tuple[tuple[float, ...], list[tuple[Event, int]]]:
    """Shares at which a line is divided for its signals, both ends among them, and which of them each event takes."""
    shares = [line.samples.share_at(signal_s) for signal_s in signals_s]
    cuts = (0.0, *_inner(set(shares)), 1.0)
    nearest = [min(range(len(cuts)), key=lambda at: (abs(cuts[at] - share), at)) for share in shares]
    return cuts, list(zip(line.events, nearest, strict=True))


def _error_of(line: Line, lowered: list[Step], capability: Capability) -> Iterator[EventError]:
    """Compare the moments at which signals leave on the planned motion with those at which they should."""
    placed = [(part, event) for part in lowered if isinstance(part, Line) for event in part.events]
    if len(placed) != len(line.events):  # the robot stands for each: they are late by the stop, not misplaced
        return
    for requested, (part, event) in zip(line.events, placed, strict=True):
        share = event.share
        if not part.turns_on_the_spot:
            share = event.offset_mm / part.length_mm + (1.0 if event.reference == "end" else 0.0)
        leaves_s = part.time_s - line.time_s + part.samples.second_at(share) + event.offset_s
        late_s = abs(leaves_s - requested.signal_s - requested.early_s) + capability.cycle_s
        yield EventError(late_s * requested.speed_mm_s, late_s, requested.made_by)


def _inner(shares: set[float]) -> tuple[float, ...]:
    """Shares at which a line can be divided, in order and not too near to each other."""
    kept: list[float] = []
    for share in sorted(shares):
        if _SHORTEST_SHARE < share < 1.0 - _SHORTEST_SHARE and (not kept or share > kept[-1] + _SHORTEST_SHARE):
            kept.append(share)
    return tuple(kept)


def _division_blend(line: Line, shares: tuple[float, ...]) -> float:
    shortest = min(b - a for a, b in pairwise((0.0, *shares, 1.0)))
    return max(min(_DIVISION_BLEND_MM, 0.4 * shortest * line.length_mm), 0.01)
