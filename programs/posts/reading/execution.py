"""Executes a program's routines: each statement does what the table of forms gives for it."""

import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Self, TypeAlias

from programs.errors import ProgramError
from programs.posts.dialect import ProgramFiles
from programs.posts.reading.statements import Block, Declared, Statement, StatementBlock, located, refusal
from programs.posts.rebuilt import ReadStep, TextPlace
from programs.posts.writing.forms import pattern_of

_UNREADABLE = (ValueError, LookupError, ArithmeticError)
"""What numbers and names that no program has make of a statement that is executed."""

_Broken: TypeAlias = tuple[str, int, int, ProgramError | None]
"""Routine, begin and end of a block that was begun, and where it differs."""


class EnteredError(Exception):
    """The program has come to the part that it starts at."""


class Execution(ABC):
    """A controller while it executes the routines of one program, and the steps that come of them."""

    def __init__(self) -> None:
        self.routines: dict[str, Sequence[str]] = {}
        """Statements by the routine's name."""
        self.steps: list[ReadStep] = []
        self.places: list[TextPlace | None] = []
        """Statement of each step."""
        self.routine, self.at = "", 0
        """The routine that runs, and its statement."""
        self.entry_end: tuple[str, int] | None = None
        """Routine and statement at which what a part does first ends, if the program starts there."""
        self.declared: list[Declared[Any, Any]] = []
        self.called: set[str] = set()
        """Routines that were executed, or that are called in another way."""
        self._running: set[str] = set()
        self._blocks: list[StatementBlock] = []
        self._broken: _Broken = "", 0, 0, None

    @classmethod
    def loaded(cls, files: ProgramFiles) -> tuple[Self, str]:
        """Give a controller that has loaded the files, and its main routine."""
        reader = cls()
        try:
            main = reader.load(files)
            reader.use_blocks()
        except _UNREADABLE as error:
            raise ProgramError(f"a declaration cannot be read ({error}).", file=next(iter(files), None)) from None
        return reader, main

    def use_blocks(self) -> None:
        """Execute statements by the forms of the language: by those of several statements first."""
        fields = self.fields()
        blocks = (StatementBlock(forms, fields, action) for forms, action in self.blocks())
        self._blocks = sorted(blocks, key=lambda block: len(block.patterns) == 1)

    # What a language states

    @abstractmethod
    def load(self, files: ProgramFiles) -> str:
        """Sort the files into routines and data, and give the name of the routine to start with."""

    @abstractmethod
    def blocks(self) -> Iterable[Block]:
        """Give the forms that the writer has, and what their statements do; the first that the statements are counts.

        Forms of several statements go before those of one.
        """

    @abstractmethod
    def fields(self) -> Mapping[str, str]:
        """Give the pattern of each field of a form by its name."""

    def declares(self, what: str) -> "Declared[Any, Any]":
        """Give an empty list of what a program declares of one kind; it is checked at the end."""
        self.declared.append(Declared(what))
        return self.declared[-1]

    def finish(self) -> None:
        """Make sure at the end that nothing is left over.

        Raises:
            ProgramError: a routine was never called, or a declaration was not used.
        """
        if left := next((name for name in self.routines if name not in self.called), None):
            raise ProgramError(f"routine {left} is never called.")
        for each in self.declared:
            each.check()

    # Execution

    def run(self, name: str) -> None:
        """Execute a routine.

        Raises:
            ProgramError: there is none of that name, it calls itself, or one of its statements is unknown.
        """
        if name not in self.routines:
            raise ProgramError(f"there is no routine {name or 'to start with'}.")
        if name in self._running:
            raise ProgramError(f"routine {name} calls itself.")
        caller = self.routine, self.at
        self.routine, self.at = name, 0
        self._running.add(name)
        self.called.add(name)
        while self.at < len(self.routines[name]):
            if (self.routine, self.at) == self.entry_end:
                raise EnteredError
            self.do_statement(self.routines[name][self.at])
            self.at += 1
        self._running.remove(name)
        self.routine, self.at = caller

    def do_statement(self, statement: str) -> None:
        """Execute one statement, and keep where it stands for the steps that it makes.

        Raises:
            ProgramError: it is unknown, or not possible there; the message names file and line.
        """
        try:
            self.execute(statement)
        except ProgramError as refused:
            if refused.file is not None:
                raise
            raise located(str(refused), statement) from None
        except _UNREADABLE as error:
            raise refusal(statement, f"cannot be read ({error})") from None
        place = statement.place if isinstance(statement, Statement) else None
        self.places += [place] * (len(self.steps) - len(self.places))

    def execute(self, statement: str) -> None:
        """Execute one statement, and those that belong to it.

        Raises:
            ProgramError: it is none of the language, or others belong to it.
        """
        routine, at = self.routine, self.at
        try:
            if self._follow(statement):
                return
        except ProgramError:
            if self._broken[:2] != (routine, at):
                raise
        begun, _, end, why = self._broken
        if begun == routine and at < end and why is not None:
            raise why
        raise ProgramError(f"unknown statement {statement!r}.")

    def _follow(self, statement: str) -> bool:
        """Execute the first block that the statements to come are; whether there is one."""
        for block in self._blocks:
            if not block.patterns[0].fullmatch(statement):
                continue
            end = self.at + len(block.patterns)
            values = block.follow([statement, *self.routines[self.routine][self.at + 1 : end]])
            if isinstance(values, dict):
                if len(block.patterns) > 1 and self._broken[:2] == (self.routine, self.at):
                    self._broken = "", 0, 0, None  # another block that begins alike
                self.at = end - 1
                block.action(values)
                return True
            broken = (self.routine, self.at, end, values)
            is_same = self._broken[0] == self.routine and self.at < self._broken[2]
            self._broken = (
                max(self._broken, broken, key=lambda each: (each[3] and each[3].line) or 0) if is_same else broken
            )
        return False

    # Statements that belong together

    def sort(self, lines: Iterable[str], forms: tuple[str, str]) -> Iterator[str]:
        """Keep what stands in routines, and give what stands outside; empty lines count for nothing.

        Args:
            lines: Of a file, comments left out.
            forms: Of the first line of a ``routine``, and of its last.
        """
        begin, end = (re.compile(pattern_of(form, {"routine": r"\w+"})) for form in forms)
        inside: list[str] | None = None
        line = ""
        for line in lines:
            if match := begin.fullmatch(line):
                if inside is not None or match[1] in self.routines:
                    raise refusal(line, "begins within another, or twice")
                inside = []
                self.routines[match[1]] = inside
            elif end.fullmatch(line):
                if inside is None:
                    raise refusal(line, "ends nothing")
                inside = None
            elif line and inside is not None:
                inside.append(line)
            elif line:
                yield line
        if inside is not None:
            raise refusal(line, "is the last line, and a routine has no end")

    def pass_to(self, pattern: str) -> int:
        """Give the number of the next statement of the routine that matches a pattern.

        Raises:
            ProgramError: there is none.
        """
        matches = re.compile(pattern).fullmatch
        statements = self.routines[self.routine]
        found = next((at for at in range(self.at + 1, len(statements)) if matches(statements[at])), None)
        if found is None:
            raise ProgramError(f"nothing ends {statements[self.at]!r}.")
        return found

    def expect(self, routine: str, forms: Sequence[str]) -> None:
        """Make sure that a routine which is not run has the statements that it has to have.

        Raises:
            ProgramError: it has others.
        """
        statements, fields = self.routines.get(routine, []), self.fields()
        self.called.add(routine)
        patterns = [pattern_of(form, fields) for form in forms]
        if len(statements) != len(patterns) or not all(map(re.fullmatch, patterns, statements)):
            raise ProgramError(f"{routine} is not as it is written.")


def skip(found: object) -> None:
    """Pass over a statement that has no effect on motion and outputs."""
