"""Reads the production frame around a program: guard, waits, faults, and the parts that it may start at."""

import re
from abc import ABC
from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from dataclasses import replace
from typing import ClassVar

from programs.errors import ProgramError
from programs.posts.dialect import ProgramFiles
from programs.posts.reading.execution import Action, EnteredError, Execution
from programs.posts.rebuilt import ReadFrame, ReadPart, ReadStep, ReadSwitch, ReadWait


class FrameReader(Execution, ABC):
    """A controller that keeps what belongs to the frame apart from the steps of the plan."""

    shut_name: str = "shut_valves"
    """The fault routine; it is called before the first motion too."""
    reads_sensors: ClassVar[bool] = True
    """Whether the language can wait for a quantity."""
    watches_inputs: bool = True
    """Whether the program can watch inputs while it runs."""
    handlers: ClassVar[AbstractSet[str]] = frozenset()
    """What has to call the fault routine, by the names that ``shut`` is given; none in languages without a frame."""

    def __init__(self) -> None:
        super().__init__()
        self.start = 1
        """The part to start at."""
        self.parts: list[ReadPart] = []
        self.waits: list[ReadWait] = []
        self.watched: list[tuple[str, bool]] = []
        self.shut_by: set[str] = set()
        self.guards_override: bool | None = False

    def read_frame(self, files: ProgramFiles) -> ReadFrame | None:
        """Give the frame of a program that was executed; ``None`` in languages without one.

        Raises:
            ProgramError: it cannot start at one of its parts, or its fault routine does not do what it has to.
        """
        if not self.handlers:
            return None
        parts = tuple(replace(part, entry=self.enter_at(files, part.number)) for part in self.parts)
        shut = self.read_shut()  # some languages watch inputs where they shut the valves
        waits, watched = tuple(self.waits), tuple(self.watched) if self.watches_inputs else None
        return ReadFrame(waits, watched, parts, shut, self.guards_override, self.reads_sensors)

    def enter_at(self, files: ProgramFiles, part: int) -> tuple[ReadStep, ...]:
        """Execute a program that starts at a part, as far as that part's own steps; what it uses counts as used."""
        if part == 1:
            return ()
        reader, main = self.loaded(files)
        reader.start = part
        try:
            reader.run(main)
        except EnteredError:
            self.called |= reader.called
            for own, there in zip(self.declared, reader.declared, strict=True):
                own.used |= there.used
            return tuple(reader.steps)
        raise ProgramError(f"the program cannot start at part {part}.")

    def read_shut(self) -> tuple[str, ...]:
        """Give the outputs that the fault routine shuts.

        Raises:
            ProgramError: something does not call it, or it does something else too.
        """
        if missing := sorted(self.handlers - self.shut_by):
            raise ProgramError(f"the valves are not shut by {', '.join(missing)}.")
        self.steps, self.places = [], []
        self.run(self.shut_name)
        if any(not isinstance(step, ReadSwitch) or step.value for step in self.steps):
            raise ProgramError(f"{self.shut_name} does more than to shut valves.")
        return tuple(step.channel for step in self.steps if isinstance(step, ReadSwitch))

    def shut(self, by: str) -> Action:
        """Give the action of a statement that calls the fault routine, by what has it called."""

        def note(match: re.Match[str]) -> None:
            self.shut_by.add(by)

        return note

    def guard(self, match: re.Match[str]) -> None:
        """Refuse to start where the speed override is not 100 %."""
        self.guards_override = True

    def begin_part(self, number: str, end: str = "") -> bool:
        """Begin a part of main; whether it is done. Where it is not, go on after the statement that ends it.

        Args:
            number: Of the part.
            end: Pattern of that statement; nothing where the part is one statement.
        """
        self.parts.append(ReadPart(int(number), len(self.steps)))
        if self.start <= int(number):
            return True
        if end:
            self.at = self.pass_to(end)
        return False

    def enter(self, number: str, end: str) -> None:
        """Begin what a part does first if the program starts there; pass over it otherwise."""
        at = self.pass_to(end)
        if self.start == int(number):
            self.start, self.entry_end = 1, (self.routine, at)
        else:
            self.at = at

    def call_part(self, number: str, routine: str) -> None:
        """Do a part of main that is one statement, unless the start is at a later one."""
        if self.begin_part(number):
            self.run(routine)

    def run_part(self, number: str, call: str, end: str) -> None:
        """Do a part of main whose call and end are the next statements, unless the start is at a later one."""
        done = self.begin_part(number)
        called, *_ = self.pass_on(call, end)
        if done:
            self.run(called[1])

    def wait_for(self, channel: str, state: bool, timeout_s: float) -> None:
        """Wait for a contact."""
        self.waits.append(ReadWait(channel, state, timeout_s))

    def wait_least(self, channel: str, condition: Sequence[str], timeout_s: float) -> None:
        """Wait for a quantity: scale, offset, least value."""
        scale, offset, least = map(float, condition)
        self.waits.append(ReadWait(channel, None, timeout_s, (scale, offset, least)))
