"""Compares the production frame of a program's text with what the cell maps."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import degrees

from programs.motion.analog import Counting
from programs.motion.handshake import after_motion, after_waits, before_waits
from programs.motion.installation import Installation, Wait
from programs.motion.steps import Line, MotionProgram, Reach
from programs.pose import Pose, angle, distance
from programs.posts.proving.terms import Wrong
from programs.posts.rebuilt import (
    Axes,
    ReadBoard,
    ReadCall,
    ReadFrame,
    ReadLine,
    ReadMount,
    ReadPause,
    ReadReach,
    ReadStep,
    ReadSwitch,
    ReadTool,
    ReadWait,
    Rebuilt,
)
from programs.posts.writing.axes import from_controller_counts, in_degrees_and_mm, one_row, own_axes
from programs.posts.writing.entries import safe_height
from programs.posts.writing.joint_moves import CAUTIOUS, pace_moves
from programs.posts.writing.wording import make_name
from specs.source import NO_SOURCE

_SAME = 0.01
"""mm or degrees."""
_SAME_NUMBER = 1e-6
_JOINT = 0.001
"""mm and degrees that joint values may differ by."""


def compare_frame(rebuilt: Rebuilt, motion: MotionProgram, installation: Installation) -> Iterator[str]:
    """Describe where the frame that was read differs from what it has to be; nothing for languages without one.

    The motion is that in the controller's terms, as entries begin where lines were divided too.

    Compared are the waits with those of the cell, the outputs that the fault routine shuts with the valves of the
    cell, and what is in force where the program starts at a later part with what the parts before it leave.
    """
    frame = rebuilt.frame
    if frame is None:
        return
    if frame.guards_override is bool(motion.first_run):
        yield f"the speed override is {'' if motion.first_run else 'not '}looked at"
    fault = None if installation.handshake is None else installation.handshake.fault
    for label in frame.faults:
        if bool(label) if fault is None else not fault.is_called(label):
            yield f"where the program stops itself it sets {label or 'no output'}"
    for channel in dict.fromkeys(valve.channel for valve in installation.valves.values()):
        if not any(map(channel.is_called, frame.shut)):
            yield f"the fault routine does not shut {channel.name}"
    yield from _compare_waits(
        frame, rebuilt.analog, [wait for wait in installation.waits if wait.contact or frame.reads_sensors]
    )
    yield from _compare_parts(rebuilt, frame, installation)
    yield from _compare_reaches(frame, motion, installation)


def _compare_waits(frame: ReadFrame, analog: Counting, waits: Sequence[Wait]) -> Iterator[str]:
    if len(frame.waits) != len(waits):
        yield f"{len(frame.waits)} waits before the first motion, the cell maps {len(waits)}"
        return
    for read, wait in zip(frame.waits, waits, strict=True):
        if not _is_same_wait(read, wait, analog):
            yield f"the wait for {wait.words} is read as {read}"
    if frame.watched is None:
        return
    watched = [wait for wait in waits if wait.watched]
    if len(frame.watched) != len(watched):
        yield f"{len(frame.watched)} inputs are watched, not {len(watched)}"
    for (channel, state), wait in zip(frame.watched, watched, strict=False):
        if wait.contact and (channel not in (wait.contact.name, str(wait.contact.number)) or state != wait.state):
            yield f"{wait.words} is watched as {channel}"


def _is_same_wait(read: ReadWait, wait: Wait, analog: Counting) -> bool:
    source = wait.contact or wait.sensor
    if source is None or read.channel not in (source.name, str(source.number)):
        return False
    same = [(read.timeout_s, wait.timeout_s)]
    if wait.sensor is not None:
        if read.condition is None:
            return False
        same += zip(read.condition, (*analog.reading(wait.sensor), wait.least), strict=True)
    elif read.state is not wait.state:
        return False
    return all(abs(one - other) <= _SAME_NUMBER * max(1.0, abs(other)) for one, other in same)


@dataclass(slots=True)
class _State:
    """What is in force after some steps."""

    outputs: dict[str, float] = field(default_factory=dict[str, float])
    place: Pose | Axes | None = None
    tool: str | None = None
    board: ReadBoard | None = None

    @classmethod
    def after(cls, steps: Sequence[ReadStep], outputs: dict[str, float]) -> "_State":
        """Go through some steps."""
        state = cls(dict(outputs))
        for step in steps:
            match step:
                case ReadSwitch():
                    state.outputs[step.channel] = step.value
                case ReadLine():
                    state.outputs |= {signal.channel: signal.value for signal in step.signals}
                    state.place = step.target
                case ReadReach():
                    state.place = step.target
                case ReadTool():
                    state.tool = step.label
                case ReadBoard():
                    state.board = step
                case _:
                    pass
        return state


def _compare_parts(rebuilt: Rebuilt, frame: ReadFrame, installation: Installation) -> Iterator[str]:
    """Compare what each entry leaves with what the parts before it leave."""
    if [part.number for part in frame.parts] != list(range(1, 1 + len(frame.parts))):
        yield f"parts {[part.number for part in frame.parts]} are not numbered in order"
        return
    shut = dict.fromkeys(frame.shut, 0.0)
    for part in frame.parts[1:]:
        planned = _State.after(rebuilt.steps[: part.begins], shut)
        entered = _State.after(part.entry, shut)
        before, after = (_mounted(steps, installation) for steps in (rebuilt.steps[: part.begins], part.entry))
        changed = _mounted(rebuilt.steps[part.begins :], installation, before_motion=True)
        if before and after != before and (entered.place is not None or not changed):
            yield f"started at part {part.number} tool {after or 'of before'} is mounted, not {before}"
        if planned.outputs != entered.outputs:
            yield f"started at part {part.number} the outputs are {entered.outputs}, not {planned.outputs}"
        if entered.place is None:
            if isinstance(_first_motion(rebuilt.steps[part.begins :]), ReadLine):
                yield f"started at part {part.number} it begins with a line from where it stands"
            continue
        if (wrong := _other_motion(rebuilt.steps[: part.begins], part.entry)) is not None:
            yield f"started at part {part.number} it does not go as before: {wrong}"
        if not _is_same_place(planned.place, entered.place):
            yield f"started at part {part.number} it begins at {entered.place}, not {planned.place}"
        if (planned.tool, planned.board) != (entered.tool, entered.board):
            yield f"started at part {part.number} it has tool {entered.tool}, not {planned.tool}, or another frame"


def routine_names(installation: Installation, tool: int) -> tuple[str, ...]:
    """Give what languages make of the name of a tool's routine, in small letters; none where there is none."""
    name = make_name(f"{installation.tool_routine}_{tool}", 200).lower()
    return (name, name.replace("_", "")) if installation.tool_routine else ()


def _mounted(steps: Sequence[ReadStep], installation: Installation, *, before_motion: bool = False) -> str:
    """Give what has the last tool mounted: its number, or the routine; empty where nothing does."""
    if before_motion:
        motions = (at for at, step in enumerate(steps) if isinstance(step, ReadLine | ReadReach))
        steps = steps[: next(motions, len(steps))]
    routines = {name for tool in installation.tools for name in routine_names(installation, tool)}
    labels = (
        str(step.number) if isinstance(step, ReadMount) else step.label
        for step in steps
        if isinstance(step, ReadMount) or (isinstance(step, ReadCall) and step.label.lower() in routines)
    )
    return next(reversed([*labels]), "")


def _compare_reaches(frame: ReadFrame, motion: MotionProgram, installation: Installation) -> Iterator[str]:
    """Compare the joint values by which entries come from home with those of the plan there, and pauses with lags."""
    planned = [(step.target, step.joints) for step in motion.steps if isinstance(step, Line | Reach) and step.joints]
    lag_s = max((valve.open_lag_s for valve in installation.valves.values()), default=0.0)
    for part in frame.parts[1:]:
        if any(step.duration_s > lag_s + _TIME_S for step in part.entry if isinstance(step, ReadPause)):
            yield f"started at part {part.number} it waits longer than for a valve"
        reach = next((step for step in part.entry if isinstance(step, ReadReach)), None)
        if reach is None or not reach.joints or not planned:
            continue
        if reach.duration_s is not None or reach.speed_share not in (None, 0.01 * CAUTIOUS.percent):
            yield f"started at part {part.number} the joint motion from home is not at {CAUTIOUS.percent} %"
        at_pose = [joints for pose, joints in planned if _is_same_place(pose, reach.target)]
        if not any(same_joints(joints, reach.joints, installation) for joints in at_pose):
            at = f"{reach.joints}, which are not those of {reach.target}"
            yield f"started at part {part.number} the joints go to {at}"


def _other_motion(before: Sequence[ReadStep], entry: Sequence[ReadStep]) -> ReadStep | None:
    """Give a motion of an entry that is none of those before it, in their order, or one of those that it leaves out.

    Points at which lines were divided for outputs may be left out: the entry switches nothing on its way.
    """
    due = [step for step in before if isinstance(step, ReadLine | ReadReach)]
    first = _first_motion(entry)
    starts = [at for at, step in enumerate(due) if first is not None and _is_same_motion(step, first)]
    left, at = due[max(starts, default=len(due)) :], None
    for step in entry:
        if not isinstance(step, ReadLine | ReadReach):
            continue
        skipped: list[ReadLine | ReadReach] = []
        while left and not _is_same_motion(left[0], step):
            skipped.append(left.pop(0))
        if not left or any(not _lies_between(at, each, step) for each in skipped):
            return step
        at = left.pop(0)
    return next((each for each in left if at is None or not _is_same_place(each.target, at.target)), None)


def _is_same_motion(one: ReadLine | ReadReach, other: ReadLine | ReadReach) -> bool:
    if not _is_same_place(one.target, other.target):
        return False
    match one, other:
        case ReadLine(), ReadLine():
            return (one.stops, one.speed_mm_s) == (other.stops, other.speed_mm_s)
        case ReadReach(), ReadReach():
            return one.joints == other.joints
        case ReadLine(), ReadReach():  # what a line ends at may be reached by joints at the start
            return True
        case _:
            return False


def _lies_between(begin: ReadStep | None, step: ReadStep, end: ReadStep) -> bool:
    """Whether a line ends on the straight line between two others at the speed of the last, as where it was divided."""
    places = [each.target if isinstance(each, ReadLine | ReadReach) else None for each in (begin, step, end)]
    is_other = isinstance(step, ReadLine) and isinstance(end, ReadLine) and step.speed_mm_s != end.speed_mm_s
    if is_other or not isinstance(step, ReadLine) or any(not isinstance(place, Pose) for place in places):
        return False
    first, middle, last = (place for place in places if isinstance(place, Pose))
    return distance(first, middle) + distance(middle, last) - distance(first, last) <= _SAME


def _first_motion(steps: Sequence[ReadStep]) -> ReadLine | ReadReach | None:
    return next((step for step in steps if isinstance(step, ReadLine | ReadReach)), None)


def same_joints(planned: tuple[float, ...], counted: tuple[float, ...], installation: Installation) -> bool:
    """Whether joint values that were read are planned ones, to the digits that languages write.

    Args:
        planned: As the cell counts them, radians or mm.
        counted: As the robot's controller counts them, degrees or mm; RAPID has six at least.
        installation: The cell.
    """
    dof = len(planned)
    if len(counted) < dof or any(counted[dof:]):
        return False
    read, due = from_controller_counts(counted[:dof], installation), in_degrees_and_mm(planned, installation)
    return all(abs(one - other) <= _JOINT for one, other in zip(read, due, strict=True))


def _is_same_place(one: Pose | Axes | None, other: Pose | Axes) -> bool:
    if isinstance(one, Pose) and isinstance(other, Pose):
        return distance(one, other) <= _SAME and degrees(angle(one, other)) <= _SAME
    if isinstance(one, Axes) and isinstance(other, Axes):
        apart = [abs(a - b) for a, b in zip(one.values, other.values, strict=False)]
        return len(one.values) == len(other.values) and max(apart, default=0.0) <= _SAME
    return False


_TIME_S, _SHARE = 6e-4, 1e-6


def compare_joint_moves(
    rebuilt: Rebuilt, reaches: Mapping[int, Reach], motion: MotionProgram, installation: Installation
) -> Iterator[Wrong]:
    """List joint motions that differ from the plan in their speed, and motions home that are missing or end elsewhere.

    Args:
        rebuilt: What the reader found.
        reaches: The planned joint motion of each step that is one.
        motion: What ``make_motion`` gave.
        installation: The cell; its home counts.
    """
    rise, found = safe_height(motion, installation), rebuilt.rise_mm
    if rebuilt.dues is not None and rise != (None if found is None else round(found, 3)):  # axes raise one of them
        yield f"the orifice is first raised to {found} mm above the base, planned {rise}", NO_SOURCE, 0
    yield from _compare_homes(rebuilt, installation)
    if rebuilt.controller is None:
        return
    paces = pace_moves(motion.steps, installation, rebuilt.controller)
    read = {at: step for at in reaches if isinstance(step := rebuilt.steps[at], ReadReach)}
    states_paces = any(step.duration_s is not None or step.speed_share is not None for step in read.values())
    for at, step in read.items() if states_paces else ():
        due = paces.get(id(reaches[at]), CAUTIOUS)
        has_pace = due.seconds is None
        if step.duration_s is not None:
            has_pace = due.seconds is not None and abs(step.duration_s - due.seconds) <= _TIME_S
        elif step.speed_share is not None:
            has_pace = abs(step.speed_share - 0.01 * due.percent) <= _SHARE
        if not has_pace:
            stated = f"{100.0 * step.speed_share:g} %" if step.duration_s is None and step.speed_share else "no speed"
            stated = f"{step.duration_s:g} s" if step.duration_s is not None else stated
            planned = f"{due.percent} %" if due.seconds is None else f"{due.percent} %, {due.seconds:g} s"
            yield f"the joint motion states {stated}, planned {planned}", reaches[at].made_by, at


def _compare_homes(rebuilt: Rebuilt, installation: Installation) -> Iterator[Wrong]:
    """Compare the motions home: one before anything else, one after everything."""
    if rebuilt.homes is None:
        return
    around = len(before_waits(line := installation.handshake)) + len(after_waits(line))
    due = [around, len(rebuilt.steps) - len(after_motion(line))] if installation.home else []
    found = [home.after for home in rebuilt.homes]
    if found != due:
        message = f"the program goes home {len(found)} times, planned {len(due)}, first and last"
        yield message, NO_SOURCE, min(found[0] if found else 0, max(len(rebuilt.steps) - 1, 0))
        return
    machine, planned, counting = installation.tool_point, installation.home, installation
    if rebuilt.dues is None:  # axes are counted as the cell does
        counting = replace(installation, convention=None)
        if machine is not None:
            planned = one_row(machine, planned) if rebuilt.home_in_tool_points else own_axes(machine, planned)
    shares = any(step.speed_share is not None for step in rebuilt.steps if isinstance(step, ReadReach))
    for home in rebuilt.homes:
        is_cautious = not shares
        if home.speed_share is not None:
            is_cautious = abs(home.speed_share - 0.01 * CAUTIOUS.percent) <= _SHARE
        if not same_joints(planned, home.joints, counting):
            yield f"the joints go to {home.joints} for home", NO_SOURCE, max(home.after - 1, 0)
        elif not is_cautious:
            share = "no" if home.speed_share is None else f"{100.0 * home.speed_share:g} %"
            message = f"the motion home has {share} speed, planned {CAUTIOUS.percent} % of the joints'"
            yield message, NO_SOURCE, max(home.after - 1, 0)
