"""Commands lines so that a controller takes the planned time on them: the one place that decides their speeds."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import groupby

from programs.motion.steps import LEAST_S, Event, Line, MotionProgram, Step
from programs.posts.proving.agreement import Firing
from programs.posts.proving.predict import TextRun
from programs.timing.fitting import MOST_FACTOR, PlannedLine, fit_factors
from programs.timing.ways import Way

NEAR_MM = 0.1
"""What a jet that begins or ends no farther from its place is left at."""
_SAME_SPEED = 5e-3
"""Share by which all speeds may be off those that were found anew, and are kept."""


def fit_times(run: TextRun, planned: MotionProgram) -> MotionProgram:
    """Command the lines of a motion so that the controller, by its model, takes the planned time on each.

    Args:
        run: Of the text at the speeds that are commanded so far.
        planned: The same motion at the greatest speeds of the plan.

    Returns:
        The motion of the run itself where it keeps all its speeds.
    """
    motion = run.motion
    fastest = {
        id(line): MOST_FACTOR * _rate(first) / max(_rate(line), 1e-9)
        for first, line in zip(planned.lines, motion.lines, strict=True)
    }
    factors: dict[int, float] = {}
    for chain in run.chains:
        lines, commanded = _lines_of(run, chain, fastest)
        fitted = fit_factors(run.machine, [way for _, way in chain], lines)
        factors |= {id(line): factor for line, factor in zip(commanded, fitted, strict=True)}
    if all(abs(factor - 1.0) <= _SAME_SPEED for factor in factors.values()):
        return motion
    steps: list[Step] = []
    for step in motion.steps:
        if isinstance(step, Line):
            factor = factors.get(id(step), 1.0)
            steps.append(replace(step, speed_mm_s=factor * step.speed_mm_s, turn_rad_s=factor * step.turn_rad_s))
        else:
            steps.append(step)
    return replace(motion, steps=tuple(steps))


def place_signals(run: TextRun) -> MotionProgram:
    """Place the signals on lines so that jets begin and end in their places as the controller, by its model, drives.

    Where a signal would leave before its line begins, it leaves there.
    """
    run.build()
    motion = run.motion
    moved: dict[int, Event] = {}
    for firing, off_mm, late_s in run.event_errors:
        if off_mm > NEAR_MM:
            event, signal_s = firing.event, _signal_before(run, firing, late_s)
            moved[id(event)] = replace(event, signal_s=signal_s, early_s=event.early_s + event.signal_s - signal_s)
    steps: list[Step] = []
    for step in motion.steps:
        if isinstance(step, Line) and any(id(each) in moved for each in step.events):
            events = tuple(moved.get(id(each), each) for each in step.events)
            steps.append(
                replace(step, events=events) if sorted(events, key=lambda each: each.signal_s) == list(events) else step
            )
        else:
            steps.append(step)
    return replace(motion, steps=tuple(steps))


def _signal_before(run: TextRun, firing: Firing, late_s: float) -> float:
    """Give the planned time on its line at which a signal is placed that is to leave so much earlier when driven."""
    line, signal = firing.line, firing.signal
    if signal.offset_s:  # the text states a time, in which the controller is right
        return min(max(firing.event.signal_s - late_s, 0.0), line.duration_s)
    done = run.drives.get(firing.step)
    leaves_s = run.begins[firing.step] + (0.0 if done is None else done.second_at(signal.share)) - late_s
    parts = [at for at, match in run.matches.items() if match.planned is line and at in run.drives]
    at = max((each for each in parts if run.begins[each] <= leaves_s), default=parts[0])
    done, match = run.drives[at], run.matches[at]
    share = min(done.way_at(max(leaves_s - run.begins[at], 0.0)) / done.lane.length, 1.0)
    return line.samples.second_at(match.begin + share * (match.end - match.begin))


def _rate(line: Line) -> float:
    """Commanded speed of a line, or rate of its turn where it goes nowhere."""
    return line.speed_mm_s or line.turn_rad_s


def _lines_of(
    run: TextRun, chain: Sequence[tuple[int, Way]], fastest: Mapping[int, float]
) -> tuple[list[PlannedLine], list[Line]]:
    """Give the planned lines that follow each other in a chain: for the fit, and as they were planned."""
    found: list[PlannedLine] = []
    planned: list[Line] = []
    first = stroke = 0
    for _, group in groupby(chain, key=lambda each: id(run.matches[each[0]].planned)):
        steps = [at for at, _ in group]
        line = run.planned_line(steps[0])
        pieces = [(first + number, *shares) for number, at in enumerate(steps) for shares in run.jet_shares(at)] or [
            (first + number, 0.0, 1.0) for number in range(len(steps))
        ]
        planned_s = sum(run.planned_s(steps[way - first], (begin, end)) for way, begin, end in pieces)
        planned_s -= run.rest_s(steps[-1])
        stroke += bool(planned) and line.made_by != planned[-1].made_by
        most = fastest[id(line)]
        if line.speed_mm_s > 0.0 and line.duration_s >= LEAST_S:
            most = min(line.length_mm / line.speed_mm_s / LEAST_S, most)
        found.append(PlannedLine(first, first + len(steps), tuple(pieces), planned_s, stroke, max(most, 1.0)))
        planned.append(line)
        first += len(steps)
    return found, planned
