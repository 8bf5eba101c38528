"""When a valve's signal has to leave so that the jet begins and ends at the requested moments."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import accumulate

from programs.motion.installation import Installation, Valve
from programs.motion.steps import Event, Line, Note, Pause, Reach, Step, Switch
from specs.finding import Finding
from specs.finding_rules import NO_VALVE, VALVE_PULSE_LENGTHENED, VALVE_STAYS_OPEN, WAITS_FOR_VALVE
from specs.source import NO_SOURCE, Source

_MOMENT_S = 1e-7
"""Times nearer than this are one."""


@dataclass(frozen=True, slots=True)
class SwitchRequest:
    """The jet is to begin or to end here."""

    step: int
    """The step that runs then, or, at ``seconds`` 0, may be about to begin."""
    seconds: float
    """Since that step began."""
    spraying: bool
    nozzle: str
    made_by: Source


@dataclass(slots=True)
class _Signal:
    """A request and when its signal leaves: ``shift_s`` later than requested, so mostly negative."""

    request: SwitchRequest
    valve: Valve
    requested_s: float
    shift_s: float
    rest_s: float = 0.0
    """Pause before it so that the valve has been shut long enough."""

    @property
    def leaves_s(self) -> float:
        return self.requested_s + self.shift_s


@dataclass(frozen=True, slots=True)
class _Spot:
    """Where a signal leaves: in a step, or at rest before it with pauses around it."""

    step: int
    seconds: float
    hold_before_s: float = 0.0
    hold_after_s: float = 0.0


@dataclass(slots=True)
class _Placed:
    """What the signals add to the steps."""

    at_rest: dict[int, list[Step]] = field(default_factory=dict[int, list[Step]])
    inside: dict[int, list[tuple[float, Switch]]] = field(default_factory=dict[int, list[tuple[float, Switch]]])
    events: dict[int, list[Event]] = field(default_factory=dict[int, list[Event]])
    waits: list[float] = field(default_factory=list[float])


def open_valves(
    steps: Sequence[Step], requests: Sequence[SwitchRequest], installation: Installation, *, at_rest: bool = False
) -> tuple[list[Step], list[Finding]]:
    """Put the valves' signals into the steps, each earlier than its request by the valve's lag.

    A signal that would leave before the robot stands ready, such as before a loop begins, leaves then, and the robot
    waits for the jet. A signal shorter than the valve follows is lengthened; two jets with less than that between
    them become one. Before anything else all valves of the cell are shut: what ran before, another
    program too, may have been interrupted.

    Args:
        steps: Of the motion.
        requests: When jets are to begin and to end.
        installation: Whose valves.
        at_rest: A jet that begins or ends where the robot has stopped has its signal there, and the robot waits for
            it: on a line that slows down to a stop the moment depends on how the controller does that.
    """
    clock = [0.0, *accumulate(_duration(step) for step in steps)]
    missing: dict[str, Finding] = {}
    signals: list[_Signal] = []
    placed = _Placed()
    for request in _shut_on_joint_moves(steps, requests):
        valve, jet = installation.valves.get(request.nozzle), "on" if request.spraying else "off"
        if valve is None:
            name = request.nozzle or "(none)"
            message = f"nozzle {name} has no valve in cell {installation.cell}; its jet is a comment."
            missing.setdefault(name, Finding(NO_VALVE, message, request.made_by))
            placed.at_rest.setdefault(request.step, []).append(Note(f"spray {jet}", request.made_by))
            continue
        lag = valve.open_lag_s if request.spraying else valve.close_lag_s
        signals.append(_Signal(request, valve, clock[request.step] + request.seconds, -lag))
    findings = list(missing.values())
    kept = _with_whole_pulses(steps, signals, findings)
    for signal in kept:
        _place(steps, signal, placed, keeps_to_stops=at_rest)
    if placed.waits:
        message = (
            f"the robot waits {len(placed.waits)} times, {sum(placed.waits):.2f} s in all, for a valve that is not "
            "switched earlier: the robot comes to rest right before."
        )
        findings.append(Finding(WAITS_FOR_VALVE, message))
    valves = dict.fromkeys(valve.channel for valve in installation.valves.values())
    shut = (Switch(channel, 0.0, NO_SOURCE) for channel in valves)
    return [*shut, *_assemble(steps, placed)], findings


def _shut_on_joint_moves(steps: Sequence[Step], requests: Sequence[SwitchRequest]) -> list[SwitchRequest]:
    """Interrupt a jet that would go on during a joint move, until the next line or pause."""
    kept: list[SwitchRequest] = []
    is_on = False
    for number, request in enumerate(requests):
        if not request.spraying:
            kept += [request] if is_on else []
            is_on = False
            continue
        until = requests[number + 1] if number + 1 < len(requests) else None
        end = len(steps) if until is None else until.step + (until.seconds > 0.0)
        shut = False
        for at in range(request.step, end):
            step = steps[at]
            if isinstance(step, Line | Pause) and not is_on:
                kept.append(replace(request, step=at, seconds=0.0) if shut else request)
                is_on = True
            elif isinstance(step, Reach) and step.way:
                kept += [replace(request, step=at, seconds=0.0, spraying=False)] if is_on else []
                is_on, shut = False, True
        if not is_on and not shut:
            kept.append(request)
            is_on = True
    return kept


def _with_whole_pulses(steps: Sequence[Step], signals: list[_Signal], findings: list[Finding]) -> list[_Signal]:
    """Lengthen signals that are too short for the valve, and leave out interruptions that are."""
    kept: list[_Signal] = []
    for signal in signals:
        last, valve, nozzle = kept[-1] if kept else None, signal.valve, signal.request.nozzle
        kept.append(signal)
        if last is None or last.valve.channel != valve.channel or last.request.spraying == signal.request.spraying:
            continue
        missing = valve.min_pulse_s - (signal.leaves_s - last.leaves_s)
        between = steps[last.request.step : signal.request.step]
        if not signal.request.spraying:
            if missing > _MOMENT_S:
                signal.shift_s += missing
                message = (
                    f"the valve of {nozzle} follows no signal shorter than {1e3 * valve.min_pulse_s:g} ms: "
                    f"the jet ends {1e3 * missing:.0f} ms late. Spray for longer, or slower."
                )
                findings.append(Finding(VALVE_PULSE_LENGTHENED, message, signal.request.made_by))
        elif not all(isinstance(step, Line | Pause) for step in between):  # something happens at rest
            signal.rest_s = max(missing, 0.0)
        elif max(missing, last.leaves_s - signal.leaves_s) > _MOMENT_S:
            shut_s = signal.requested_s - last.requested_s
            message = (
                f"the valve of {nozzle} cannot shut for the {1e3 * shut_s:.0f} ms before "
                f"{signal.request.made_by or 'this'} (shortest signal {1e3 * valve.min_pulse_s:g} ms, lags "
                f"{1e3 * valve.open_lag_s:g} and {1e3 * valve.close_lag_s:g} ms): it stays open. "
                "Leave more way between the two, or go slower."
            )
            findings.append(Finding(VALVE_STAYS_OPEN, message, last.request.made_by))
            del kept[-2:]
    return kept


def _place(steps: Sequence[Step], signal: _Signal, placed: _Placed, *, keeps_to_stops: bool) -> None:
    """Put one signal where it leaves."""
    request = signal.request
    spot = _find_spot(steps, signal, keeps_to_stops=keeps_to_stops)
    switch = Switch(signal.valve.channel, 1.0 if request.spraying else 0.0, request.made_by)
    step = steps[spot.step] if spot.step < len(steps) else None
    if isinstance(step, Line) and spot.seconds > _MOMENT_S:
        placed.events.setdefault(spot.step, []).append(_event(step, spot, signal, steps))
        return
    if step is not None and spot.seconds > max(_duration(step) - _MOMENT_S, _MOMENT_S):
        spot = replace(spot, step=spot.step + 1, seconds=0.0)
    if spot.seconds > _MOMENT_S:
        placed.inside.setdefault(spot.step, []).append((spot.seconds, switch))
        return
    around = (Pause(spot.hold_before_s, request.made_by), switch, Pause(spot.hold_after_s, request.made_by))
    added = [each for each in around if isinstance(each, Switch) or each.duration_s > _MOMENT_S]
    placed.waits += [each.duration_s for each in added if isinstance(each, Pause)]
    placed.at_rest.setdefault(spot.step, []).extend(added)


def _event(line: Line, spot: _Spot, signal: _Signal, steps: Sequence[Step]) -> Event:
    """Place a signal by the requested place of the jet, if that is on the same line; else by time."""
    request = signal.request
    step = steps[request.step] if request.step < len(steps) else None
    speed = step.speed_at(request.seconds) if isinstance(step, Line) and request.seconds > _MOMENT_S else 0.0
    channel, value = signal.valve.channel, 1.0 if request.spraying else 0.0
    if spot.step != request.step or line.turns_on_the_spot:
        offset_s = spot.seconds - line.duration_s
        return Event(channel, value, "end", 0.0, offset_s, 1.0, spot.seconds, speed, request.made_by)
    share = line.samples.share_at(request.seconds)
    reference, from_share = ("start", 0.0) if share <= 0.5 else ("end", 1.0)
    place_mm = (share - from_share) * line.length_mm
    return Event(channel, value, reference, place_mm, signal.shift_s, share, spot.seconds, speed, request.made_by)


def _find_spot(steps: Sequence[Step], signal: _Signal, *, keeps_to_stops: bool) -> _Spot:
    """Go from the requested place as far back, or on, along the program as the signal is shifted."""
    step, seconds = signal.request.step, signal.request.seconds
    if keeps_to_stops and step < len(steps) and _stops(steps[step]) and seconds > _duration(steps[step]) - _MOMENT_S:
        step, seconds = step + 1, 0.0
    seconds += signal.shift_s
    while seconds < -_MOMENT_S:
        before = steps[step - 1] if step > 0 else None
        if (keeps_to_stops and _stops(before)) or not isinstance(before, Line | Pause):
            return _Spot(step, 0.0, hold_before_s=signal.rest_s, hold_after_s=-seconds)
        step -= 1
        seconds += _duration(before)
    while step < len(steps) and isinstance(steps[step], Line | Pause) and seconds > _duration(steps[step]) + _MOMENT_S:
        seconds -= _duration(steps[step])
        step += 1
    if step == len(steps) or not isinstance(steps[step], Line | Pause):
        return _Spot(step, 0.0, hold_before_s=max(seconds, 0.0))
    passes = step > 0 and isinstance(before := steps[step - 1], Line) and before.blend_mm > 0
    if seconds <= _MOMENT_S and passes:
        return _Spot(step - 1, _duration(steps[step - 1]))
    return _Spot(step, max(seconds, 0.0))


def _assemble(steps: Sequence[Step], placed: _Placed) -> Iterator[Step]:
    """Add to the steps what the signals add."""
    for index, step in enumerate(steps):
        yield from placed.at_rest.get(index, ())
        if isinstance(step, Line) and index in placed.events:
            yield replace(step, events=tuple(placed.events[index]))
        elif isinstance(step, Pause) and index in placed.inside:
            done = 0.0
            for seconds, switch in placed.inside[index]:
                yield from (Pause(seconds - done, step.made_by),) if seconds - done > _MOMENT_S else ()
                yield switch
                done = seconds
            yield Pause(step.duration_s - done, step.made_by)
        else:
            yield step
    yield from placed.at_rest.get(len(steps), ())


def _stops(step: Step | None) -> bool:
    """Whether a line ends with a stop."""
    return isinstance(step, Line) and step.blend_mm == 0.0


def _duration(step: Step) -> float:
    return step.duration_s if isinstance(step, Line | Pause) else 0.0
