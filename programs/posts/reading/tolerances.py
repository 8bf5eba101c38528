"""When what was read counts as what was planned."""

from math import degrees

from programs.motion.analog import Counting
from programs.motion.installation import Channel, Installation
from programs.motion.steps_of_robot import Repeat
from programs.pose import Pose, angle, distance
from programs.posts.rebuilt import ReadRepeat
from programs.posts.writing.axes import in_controller_units

POSE_MM, POSE_DEG = 0.01, 0.01


def same_value(channel: Channel, planned: float, read: float, analog: Counting) -> bool:
    """Whether an output is given what was planned; an analog one as the volts at its terminal."""
    if channel.kind != "analog":
        return abs(planned - read) <= 1e-6
    return abs(planned - analog.value(channel, read)) <= analog.tolerance(channel)


def same_condition(step: Repeat, found: ReadRepeat, analog: Counting) -> bool:
    """Whether a loop that looks at its input ends at the same volts."""
    if step.sensor is None or found.least is None:
        return True
    pairs = [(found.least, step.least)]
    if found.reading is not None:
        pairs += zip(found.reading, analog.reading(step.sensor), strict=True)
    return all(abs(read - planned) <= 1e-6 * max(1.0, abs(planned)) for read, planned in pairs)


def is_channel(label: str, channel: Channel) -> bool:
    """Whether a language means a channel by these words."""
    return label in (channel.name, f"{channel.kind} {channel.number}")


def same_axes(joints: tuple[float, ...], axes: tuple[float, ...], installation: Installation) -> bool:
    """Whether joints, in radians or mm, are at the axes that were read."""
    planned = in_controller_units(joints, installation)
    return len(planned) == len(axes) and all(abs(a - b) <= 0.001 for a, b in zip(planned, axes, strict=True))


def apart(one: Pose, other: Pose) -> float:
    """Millimetres or degrees between two poses, whichever are more."""
    return max(distance(one, other), degrees(angle(one, other)))


def same_pose(one: Pose, other: Pose) -> bool:
    """Whether two poses agree within what is allowed."""
    return distance(one, other) <= POSE_MM and degrees(angle(one, other)) <= POSE_DEG
