"""The data of a VAL3 project: frames, tools, points, movements, inputs and outputs."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from programs.motion.installation import Channel, Installation
from programs.motion.steps_of_robot import MotionProgram, Repeat, Switch
from programs.pose import Pose
from programs.posts.val3.text import OUTPUTS, QUEUE, movement, place, variable
from programs.posts.writing.routines import joint_words

_REACH = movement(100.0, 30.0, 0.0)
_GROUP_BITS = 8


@dataclass(slots=True)
class Data:
    """What the programs use, in the order of its use."""

    tools: dict[str, Pose] = field(default_factory=dict[str, Pose])
    boards: dict[str, Pose] = field(default_factory=dict[str, Pose])
    movements: dict[str, str] = field(default_factory=dict[str, str])
    points: dict[str, list[str]] = field(default_factory=dict[str, list[str]])
    joints: list[str] = field(default_factory=list[str])
    channels: list[Channel] = field(default_factory=list[Channel])
    """Outputs that change on the path, by their number in the task."""

    def point(self, array: str, pose: Pose, board: str) -> str:
        """Put a point into an array."""
        values = self.points.setdefault(array, [])
        values.append(place(pose, board) + ' shoulder="ssame" elbow="esame" wrist="wsame"')
        return f"{array}[{len(values) - 1}]"

    def joint(self, joints: tuple[float, ...], installation: Installation) -> str:
        """Put joint values into their array."""
        self.joints.append(_joint_value(joints, installation))
        return f"jReach[{len(self.joints) - 1}]"


def variables(data: Data, motion: MotionProgram, installation: Installation) -> Iterator[str]:
    """Declare all variables."""
    for name, pose in data.boards.items():
        yield variable(name, "frame", [place(pose, "world")])
    for name, pose in data.tools.items():
        yield variable(name, "tool", [place(pose, "flange")])
    yield from _signals(data.channels, motion)
    for name in ("nMove", "nOutput", "nValue"):
        yield variable(name, "num", (), QUEUE)
    loops = sum(isinstance(step, Repeat) for step in motion.steps)
    for name in ("nHead", "nTail", "nId", *(f"nLoop{number}" for number in range(1, loops + 1))):
        yield variable(name, "num", (), 1)
    yield variable("bOverrun", "bool", (), 1)
    yield variable("mReach", "mdesc", [_REACH])
    for name, said in data.movements.items():
        yield variable(name, "mdesc", [said])
    if installation.home:
        yield variable("jHome", "jointRx", [_joint_value(installation.home, installation)])
    if data.joints:
        yield variable("jReach", "jointRx", data.joints)
    for name, values in data.points.items():
        yield variable(name, "pointRx", values)


def signal_name(channel: Channel) -> str:
    """Name the variable of an output."""
    return f"{OUTPUTS[channel.kind]}{channel.number}"


def _signals(channels: Sequence[Channel], motion: MotionProgram) -> Iterator[str]:
    """Declare outputs and inputs; what they are linked to is the integrator's."""
    used = {*channels, *(step.channel for step in motion.steps if isinstance(step, Switch))}
    for name, kind in sorted({(signal_name(channel), channel.kind) for channel in used}):
        yield variable(name, "aio" if kind == "analog" else "dio", (), _GROUP_BITS if kind == "group" else 1)
    sensors = (step.sensor for step in motion.steps if isinstance(step, Repeat))
    for number in sorted({sensor.number for sensor in sensors if sensor is not None}):
        yield variable(f"ai{number}", "aio", (), 1)


def _joint_value(joints: tuple[float, ...], installation: Installation) -> str:
    words = joint_words(joints, installation, 4)
    return " ".join(f'j{number}="{word}"' for number, word in enumerate(words, start=1))
