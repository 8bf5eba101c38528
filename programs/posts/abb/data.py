"""How RAPID writes values, and the names that it keeps for itself."""

import math

from programs.motion.installation import Installation
from programs.pose import Pose
from programs.posts.writing.wording import fixed

NO_AXES = "[9E9,9E9,9E9,9E9,9E9,9E9]"
RESERVED = frozenset({
    "main", "define_events", "alias", "and", "backward", "case", "connect", "const", "default", "div", "do", "else",
    "elseif", "endfor", "endfunc", "endif", "endmodule", "endproc", "endrecord", "endtest", "endtrap", "endwhile",
    "error", "exit", "false", "for", "from", "func", "goto", "if", "inout", "local", "mod", "module", "nostepin",
    "not", "noview", "or", "pers", "proc", "raise", "readonly", "record", "retry", "return", "step", "sysmodule",
    "test", "then", "to", "trap", "true", "trynext", "undo", "var", "viewonly", "while", "with", "xor",
})  # fmt: skip
"""Words of the language, and the routines that every program has."""


def jointtarget(joints: tuple[float, ...], installation: Installation) -> str:
    """Write joint values in degrees and mm; up to six joints are the robot's, what follows are external axes."""
    kinds = [joint.kind for joint in installation.joints] or ["revolute"] * len(joints)
    values = [
        fixed(math.degrees(value) if kind == "revolute" else value, 4)
        for value, kind in zip(joints, kinds, strict=True)
    ]
    robot = [*values[:6], *["0"] * (6 - len(values[:6]))]
    outside = [*values[6:12], *["9E9"] * (6 - len(values[6:12]))]
    return f"[[{','.join(robot)}],[{','.join(outside)}]]"


def pose_data(pose: Pose) -> str:
    """Write a pose: position in mm, quaternion w, x, y, z."""
    position = ",".join(fixed(value, 3) for value in pose.position)
    return f"[[{position}],[{','.join(fixed(value, 7) for value in pose.quaternion)}]]"
