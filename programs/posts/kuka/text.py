"""How KRL is written, whatever it does."""

import math
from collections.abc import Sequence

from programs.motion.analog import Counting
from programs.motion.installation import Channel, Installation
from programs.pose import Pose
from programs.posts.writing.angles import fixed_xyz
from programs.posts.writing.wording import fixed, short

ANALOG = Counting(full=1.0)
"""``$ANOUT`` and ``$ANIN`` count from -1 to 1 of full scale."""


def assign(channel: Channel, value: float) -> str:
    """Set an output."""
    match channel.kind:
        case "digital":
            return f"$OUT[{channel.number}]={'TRUE' if value else 'FALSE'}"
        case "group":
            return f"{channel.name}={short(value, 6)}"
        case "analog":
            return f"$ANOUT[{channel.number}]={short(ANALOG.count(channel, value), 6)}"


def operand(value: float, digits: int = 6) -> str:
    """Write a number; a negative one stands in brackets."""
    text = short(value, digits)
    return f"({text})" if text.startswith("-") else text


def axes(joints: tuple[float, ...], installation: Installation) -> str:
    """Degrees and mm; up to six joints are the robot's, what follows are external axes."""
    kinds = [joint.kind for joint in installation.joints] or ["revolute"] * len(joints)
    names = [*(f"A{number}" for number in range(1, 7)), *(f"E{number}" for number in range(1, 7))]
    values = (
        f"{name} {fixed(math.degrees(value) if kind == 'revolute' else value, 4)}"
        for name, value, kind in zip(names, joints, kinds, strict=False)
    )
    return f"{{{','.join(values)}}}"


def frame(pose: Pose) -> str:
    """Write a frame; A, B, C turn about z, the new y, the new x."""
    c, b, a = fixed_xyz(pose.quaternion)
    numbers = (*(fixed(value, 3) for value in pose.position), *(fixed(value, 4) for value in (a, b, c)))
    return "{" + ",".join(f"{name} {number}" for name, number in zip("XYZABC", numbers, strict=True)) + "}"


def source(name: str, body: Sequence[str], after: Sequence[str]) -> str:
    """Write a .src: a routine, and what comes after it."""
    lines = ["&ACCESS RVP", "&REL 1", f"DEF {name}( )", *body, "END", *after]
    return "".join(f"{line}\n" for line in lines)


def data_list(name: str, declarations: Sequence[str]) -> str:
    """Write a .dat."""
    lines = ["&ACCESS RVP", "&REL 1", f"DEFDAT {name} PUBLIC", *declarations, "ENDDAT"]
    return "".join(f"{line}\n" for line in lines)
