"""A timed program in the language of a robot."""

from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np
from numpy.typing import NDArray

from programs.errors import ProgramError
from programs.motion.installation import Installation
from programs.motion.lower import EventError, lower
from programs.motion.make_motion import make_motion
from programs.posts.dialects import DIALECTS, Dialect
from programs.program import TimedProgram
from specs.finding import Finding


@dataclass(frozen=True, slots=True)
class Exported:
    """The files of a robot program, and what has to be known about them."""

    files: Mapping[str, str]
    """Text by file name, the one to start with first; ASCII."""
    findings: tuple[Finding, ...]
    """What the cell, the valves and the language did not allow."""
    error: EventError
    """The worst event error."""


def export(
    program: TimedProgram, installation: Installation, dialect: str, joints: NDArray[np.float64] | None = None
) -> Exported:
    """Write a program in a robot's language.

    Args:
        program: As the robot is to do it.
        installation: The cell.
        dialect: Its name in ``DIALECTS``.
        joints: (moves, dof) joint motion aligned with the program's moves, radians or mm; ``None`` if not known.

    Raises:
        ProgramError: there is no such dialect, the program cannot be driven, or the language needs the joint motion.
    """
    language = find_dialect(dialect)
    if language.needs_joints and joints is None:
        raise ProgramError(f"{dialect} is made of joint values; track the program in a cell first.")
    lowered = lower(make_motion(program, installation, joints), language.capability)
    return Exported(language.render(lowered, installation), lowered.motion.findings, lowered.error)


def find_dialect(name: str) -> Dialect:
    """Give a dialect by its name.

    Raises:
        ProgramError: there is none; the message names those that exist.
    """
    if name not in DIALECTS:
        nearest = get_close_matches(name.lower(), DIALECTS, n=1)
        hint = f"did you mean {nearest[0]}?" if nearest else f"there are {', '.join(DIALECTS)}."
        raise ProgramError(f"there is no dialect {name!r}; {hint}")
    return DIALECTS[name]
