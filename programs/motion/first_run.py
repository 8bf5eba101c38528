"""The first run of a program: the same motion without water, slow, with a stop before each step of the sequence."""

from collections.abc import Iterator
from dataclasses import replace

from programs.motion.installation import Channel, Installation
from programs.motion.steps import Hold, Line, MotionProgram, Pause, Reach, Repeat, Step, Switch
from specs.finding_rules import VALVE_PULSE_LENGTHENED, VALVE_STAYS_OPEN, WAITS_FOR_VALVE

SPEED_SHARE = 0.25
"""Of the program's speeds; at most 250 mm/s, as in manual mode, for lines of 1 m/s."""
LONGEST_PAUSE_S = 2.0
_OF_VALVES = (VALVE_PULSE_LENGTHENED, VALVE_STAYS_OPEN, WAITS_FOR_VALVE)


def as_first_run(motion: MotionProgram, installation: Installation) -> MotionProgram:
    """Give the first run of a motion: no valve opens, it is slow, and stops before each step of the sequence.

    What opens valves switches the cell's lamp in their place, or nothing where it has none. Pauses are short, and
    loops are done once, as nothing that they wait for will come.
    """
    valves = {valve.channel for valve in installation.valves.values()}
    steps = tuple(_held(_dry(motion.steps, valves, installation.lamp)))
    instead = f"; {installation.lamp.name} is on in their place" if installation.lamp else ""
    words = (
        f"no valve opens{instead}; other outputs, such as a pump's, as in the program; "
        f"lines, turns and joint motions at {SPEED_SHARE:.0%} of their speeds, pauses of "
        f"{LONGEST_PAUSE_S:g} s at most, loops once; a stop before each step of the sequence"
    ).replace("%", " %")
    lasting = sum(step.duration_s for step in steps if isinstance(step, Line | Reach | Pause))
    findings = tuple(each for each in motion.findings if each.rule not in _OF_VALVES)
    return replace(motion, steps=steps, duration_s=lasting, findings=findings, first_run=words)


def _dry(steps: tuple[Step, ...], valves: set[Channel], lamp: Channel | None) -> Iterator[Step]:
    """Slow steps down, and switch the lamp in place of valves."""
    lit: float | None = None
    for step in steps:
        match step:
            case Line():
                yield _slow(step, valves, lamp)
                lit = next((event.value for event in reversed(step.events) if event.channel in valves), lit)
            case Switch() if step.channel in valves:
                if lamp is not None and step.value != lit:
                    yield replace(step, channel=lamp)
                lit = step.value
            case Reach():
                way = tuple(replace(moment, seconds=moment.seconds / SPEED_SHARE) for moment in step.way)
                yield replace(step, way=way)
            case Pause():
                yield replace(step, duration_s=min(step.duration_s, LONGEST_PAUSE_S))
            case Repeat():
                yield replace(step, count=1, sensor=None)
            case _:
                yield step


def _slow(line: Line, valves: set[Channel], lamp: Channel | None) -> Line:
    """Slow a line down: its signals leave where they did, and as long before their places."""
    samples = replace(line.samples, seconds=line.samples.seconds / SPEED_SHARE)
    events = tuple(
        replace(
            event,
            channel=lamp if lamp is not None and event.channel in valves else event.channel,
            signal_s=(event.signal_s - event.offset_s) / SPEED_SHARE + event.offset_s,
            speed_mm_s=SPEED_SHARE * event.speed_mm_s,
        )
        for event in line.events
        if lamp is not None or event.channel not in valves
    )
    speed, turn = SPEED_SHARE * line.speed_mm_s, SPEED_SHARE * line.turn_rad_s
    return replace(
        line, speed_mm_s=speed, turn_rad_s=turn, samples=samples, time_s=line.time_s / SPEED_SHARE, events=events
    )


def _held(steps: Iterator[Step]) -> Iterator[Step]:
    """Stop before the first motion of each step of the sequence, and of the program."""
    kept, number = list[Step](), -1
    for step in steps:
        began = step.made_by.step if isinstance(step, Line | Reach) else None
        if isinstance(step, Line | Reach) and (number < 0 or began not in (None, number)):
            number = began or 0
            if kept and isinstance(last := kept[-1], Line):
                kept[-1] = replace(last, blend_mm=0.0)
            kept.append(Hold(number + 1, step.made_by))
        kept.append(step)
    yield from kept
