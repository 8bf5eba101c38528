"""Compares steps other than lines with the plan: joint motions, pauses, outputs, calls, loops."""

import re

import numpy as np

from programs.motion.installation import Channel, Installation
from programs.motion.lower import Capability
from programs.motion.steps import Await, Call, EndRepeat, Hold, Moment, Mount, Pause, Reach, Repeat, Step, Switch
from programs.pose import Pose
from programs.posts.proving.agreement import Record
from programs.posts.proving.production import routine_names, same_joints
from programs.posts.rebuilt import (
    Axes,
    ReadAwait,
    ReadCall,
    ReadEndRepeat,
    ReadHold,
    ReadLine,
    ReadMount,
    ReadPause,
    ReadReach,
    ReadRepeat,
    ReadStep,
    ReadSwitch,
)
from programs.posts.writing.axes import in_degrees_and_mm
from programs.posts.writing.wording import make_name

JOINT = 0.001
"""mm and degrees, of a joint."""
TICK_S = 2e-4
"""Twice the last digit of a time in a table."""
_PAUSE_S = 6e-4
"""Half of the last digit, or of the language's step where that is more."""


def is_same_step(step: Step, found: ReadStep | None, record: Record) -> bool:
    """Whether a step other than a line was read as planned."""
    installation, capability = record.installation, record.capability
    match step, found:
        case Reach(), ReadReach(target=Axes(values=axes)):
            return _same_joints(in_degrees_and_mm(step.joints, installation), axes)
        case Reach(), ReadReach(target=Pose() as target):
            reached = _is_reached(step, found.joints, record) and _is_way(step, found.way, record)
            return record.is_same_pose(step.target, target) and reached
        case Pause(), ReadPause():
            return abs(step.duration_s - found.duration_s) <= max(_PAUSE_S, 0.51 * capability.step_s)
        case Switch(), ReadSwitch():
            return is_same_output(step.channel, step.value, (found.channel, found.value), capability)
        case Await(), ReadAwait():
            return found.channel in (step.contact.name, str(step.contact.number)) and step.state == found.state
        case Mount(), ReadMount() | ReadCall():
            return _is_mounted(step, found, installation)
        case Call(), ReadCall():
            return _is_name_of(found.label, step.name)
        case Repeat(), ReadRepeat():
            return step.count == found.count and _is_condition(step, found, capability)
        case (EndRepeat(), ReadEndRepeat()) | (Hold(), ReadHold()):
            return True
        case _:
            return False


def _is_mounted(step: Mount, found: ReadMount | ReadCall, installation: Installation) -> bool:
    """Whether a tool is mounted by a person, or by its routine where there is one."""
    if isinstance(found, ReadCall):
        return found.label.lower() in routine_names(installation, step.number)
    return not installation.tool_routine and step.number == found.number


def is_same_output(channel: Channel, planned: float, read: tuple[str, float], capability: Capability) -> bool:
    """Whether an output is the planned one and gets the planned value; an analog one as volts at its terminal."""
    label, value = read
    if not channel.is_called(label):
        return False
    if channel.kind != "analog":
        return abs(planned - value) <= 1e-6
    return abs(planned - capability.analog.value(channel, value)) <= capability.analog.tolerance(channel)


def _is_reached(step: Reach, counted: tuple[float, ...], record: Record) -> bool:
    """Whether joint values that were read are the planned ones when they are counted as the cell does."""
    if not step.joints or not record.rebuilt.has_joints:
        return not counted  # some languages have no joint values, but none has them where none are known
    return same_joints(step.joints, counted, record.installation)


def _is_way(step: Reach, way: tuple[ReadLine, ...], record: Record) -> bool:
    """Whether the small steps of a joint motion, where the text has them, are the planned ones."""
    if not way:
        return True
    seconds = np.cumsum([each.duration_s or 0.0 for each in way])
    planned = step.way or (Moment(0.0, step.target, step.joints),)
    return len(planned) == len(way) and all(
        abs(due.seconds - at) <= TICK_S
        and isinstance(each.target, Pose)
        and record.is_same_pose(due.pose, each.target)
        and each.axes is not None
        and _same_joints(in_degrees_and_mm(due.joints, record.installation), each.axes.values)
        for due, each, at in zip(planned, way, seconds, strict=True)
    )


def _is_condition(step: Repeat, found: ReadRepeat, capability: Capability) -> bool:
    """Whether a loop that reads an input ends at the same volts."""
    if step.sensor is None or not capability.reads_sensors:
        return found.least is None or found.reading is None
    if found.least is None or found.channel not in ("", step.sensor.name, str(step.sensor.number)):
        return False
    pairs = [(found.least, step.least)]
    if found.reading is not None:
        pairs += zip(found.reading, capability.analog.reading(step.sensor), strict=True)
    return all(abs(read - planned) <= 1e-6 * max(1.0, abs(planned)) for read, planned in pairs)


def _is_name_of(label: str, name: str) -> bool:
    """Whether a label is what a language makes of a name: its letters and digits, cut or numbered."""
    plain_label, plain_name = (re.sub(r"[^a-z0-9]", "", make_name(each, 200).lower()) for each in (label, name))
    stem = re.sub(r"\d+$", "", plain_label)
    return bool(stem) and (plain_name.startswith(plain_label) or plain_name.startswith(stem))


def _same_joints(planned: tuple[float, ...], read: tuple[float, ...]) -> bool:
    """Whether joint values in degrees and mm are the same to the digits that languages write."""
    return len(planned) == len(read) and all(abs(a - b) <= JOINT for a, b in zip(planned, read, strict=True))
