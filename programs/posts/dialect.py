"""One language in which programs are exported: what it can express, how it is written, how it is read back."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from programs.motion.installation import Installation, Maker
from programs.motion.lower import Capability, Lowered
from programs.posts.rebuilt import ReadStep, Rebuilt

ProgramFiles: TypeAlias = Mapping[str, str]
"""Text by file name, the one to start with first."""


@dataclass(frozen=True, slots=True)
class Dialect:
    """One controller's language. A room exports its own as ``DIALECT``."""

    title: str
    notes: str
    """Conditions for the integrator, one or two sentences."""
    capability: Capability
    longest_line: int
    """Characters; a test holds every program to it."""
    write: "Callable[[Dialect, Lowered, Installation], ProgramFiles]"
    """Pure: the same motion and cell give the same bytes."""
    rebuild: Callable[[ProgramFiles], Sequence[ReadStep]]
    """Executes a program's text."""
    most_steps: int = 0
    """Of one routine; 0 where the language has no routines."""
    move: re.Pattern[str] | None = None
    """The beginning of a line of text that moves to one pose; ``None`` where a motion takes several lines of text, or
    other instructions look alike."""
    needs_joints: bool = False
    """Whether the joint motion has to be known."""
    maker: Maker | None = None
    """Whose robots it is for: joint values are written as that maker's controllers count them; ``None`` for any."""
    without_joints: str = ""
    """What the integrator has to do where no joint values are written; empty where each position states the arm's
    configuration, which only joint values give."""

    def render(self, lowered: Lowered, installation: Installation) -> ProgramFiles:
        """Write a program."""
        return self.write(self, lowered, installation)

    def read(self, files: ProgramFiles) -> Rebuilt:
        """Rebuild what a program does.

        Raises:
            ProgramError: a file is missing, or holds a statement that this language's writer does not write.
        """
        return Rebuilt(tuple(self.rebuild(files)), self.capability.analog)
