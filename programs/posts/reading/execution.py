"""Executes a program's routines: each statement does what the table of forms gives for it."""

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import copy
from typing import Any, Generic, Self, TypeAlias, TypeVar

from programs.errors import ProgramError
from programs.posts.dialect import ProgramFiles
from programs.posts.rebuilt import ReadStep, TextPlace
from programs.posts.writing.forms import NUMBER, beginning_of, pattern_of

Values: TypeAlias = Mapping[str, str]
"""What stands in the fields of a form, by their names; optional ones only where they are there."""
FormAction: TypeAlias = Callable[[Values], object]
"""What statements do, by the values of their forms."""
Block: TypeAlias = tuple[Sequence[str], FormAction]
"""Forms of statements that belong together, and what they do."""

N = rf"({NUMBER})"
"""A number that is kept."""
_Key = TypeVar("_Key")
_Value = TypeVar("_Value")


class Statement(str):
    """A statement without its comment and the blanks around it, and where it stands."""

    __slots__ = ("place",)

    def __new__(cls, text: str, place: TextPlace | None = None) -> Self:
        """Make a statement; text that the reader puts together stands nowhere."""
        made = super().__new__(cls, text)
        made.place = place
        return made

    place: TextPlace | None

    def become(self, text: str) -> "Statement":
        """Give other text at the same place."""
        return Statement(text, self.place)


def statements_of(file: str, text: str, comment: str = "") -> Iterator[Statement]:
    """Give the lines of a file without the blanks around them; empty ones too.

    Args:
        file: Its name.
        text: All of it.
        comment: What begins a comment, to the end of the line; nothing if comments stay.
    """
    for number, line in enumerate(text.splitlines(), start=1):
        kept = line.partition(comment)[0] if comment else line
        yield Statement(kept.strip(), TextPlace(file, number))


def refusal(line: str, why: str) -> ProgramError:
    """Make the error of a line that cannot be read: the line, why, and where it stands."""
    return located(f"{line!r} {why}.", line)


def located(message: str, line: str) -> ProgramError:
    """Make an error at the place of a line, where that is known."""
    place = line.place if isinstance(line, Statement) else None
    return ProgramError(message, file=place and place.file, line=place and place.line)


def differing(found: Sequence[str], due: Sequence[str]) -> str:
    """Give the first statement that is another than is due, or the last where one is missing; empty without any."""
    return next((line for line, other in zip(found, due, strict=False) if line != other), found[-1] if found else "")


def look_up(table: Mapping[_Key, _Value], key: _Key, what: str) -> _Value:
    """Give what a program has declared.

    Raises:
        ProgramError: it has not.
    """
    if key not in table:
        raise ProgramError(f"{what} is not declared.")
    return table[key]


class Declared(Generic[_Key, _Value]):
    """What a program declares of one kind: each once, and all of it used."""

    def __init__(self, what: str) -> None:
        self.what = what
        self.values: dict[_Key, _Value] = {}
        self.used: set[_Key] = set()
        self.lines: dict[_Key, str] = {}
        """Where it is declared."""

    def __copy__(self) -> Self:
        """Give the same declarations and uses, for another controller to add to."""
        other = type(self)(self.what)
        other.values, other.used, other.lines = dict(self.values), set(self.used), dict(self.lines)
        return other

    def add(self, key: _Key, value: _Value, line: str = "") -> None:
        """Declare a value.

        Raises:
            ProgramError: it is declared already.
        """
        if key in self.values:
            raise located(f"{self.what} {_words(key)} is declared twice.", line)
        self.values[key], self.lines[key] = value, line

    def use(self, key: _Key) -> _Value:
        """Give a value that is used.

        Raises:
            ProgramError: it is not declared.
        """
        self.used.add(key)
        return look_up(self.values, key, f"{self.what} {_words(key)}")

    def check(self) -> None:
        """Make sure that all of it was used.

        Raises:
            ProgramError: something was not.
        """
        if unused := next((key for key in self.values if key not in self.used), None):
            raise located(f"{self.what} {_words(unused)} is declared and never used.", self.lines[unused])


def _words(key: object) -> str:
    return " ".join(map(str, key)) if isinstance(key, tuple) else str(key)  # type: ignore[reportUnknownArgumentType,reportUnknownVariableType]


_DIFFERENCES = {
    "height": "the orifice is compared with one height and raised to another.",
    **dict.fromkeys(
        ("input", "name", "state", "scale", "offset", "least"), "what is waited for is not what is looked at then."
    ),
    **dict.fromkeys(
        ("label", "ready", "index", "after"),
        "the program goes on elsewhere than after the statements that belong together.",
    ),
}
"""Messages on fields that are not the same in all statements of a block."""


class StatementBlock:
    """Patterns of statements that belong together, and what they do."""

    def __init__(self, forms: Sequence[str], fields: Mapping[str, str], action: FormAction) -> None:
        self.patterns = [re.compile(pattern_of(form, fields)) for form in forms]
        self.begin = beginning_of(forms[0])
        """Of the first statement: comparing that is a fifth of the work of a pattern."""
        self.action = action

    def follow(self, statements: Sequence[str]) -> dict[str, str] | ProgramError | None:
        """Give the values of the statements to come, or why they are none of these; ``None`` where the first is not."""
        values: dict[str, str] = {}
        for at, pattern in enumerate(self.patterns):
            statement = statements[at] if at < len(statements) else ""
            match = pattern.fullmatch(statement)
            if match is None:
                why = "is not what belongs to the statement before it"
                return refusal(statement or statements[at - 1], why) if at else None
            for name, value in match.groupdict().items():
                if value is not None and values.setdefault(name, value) != value:
                    why = f"the {name} is not the same in the statements that belong together."
                    return located(_DIFFERENCES.get(name, why), statement)
        return values


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
        self._as_loaded: dict[str, Any] = {}
        """Attributes before anything was executed."""
        self.main = ""
        """The routine to start with."""

    @classmethod
    def loaded(cls, files: ProgramFiles) -> Self:
        """Give a controller that has loaded the files."""
        reader = cls()
        try:
            reader.main = reader.load(files)
            reader._as_loaded = _copied(vars(reader))
            reader.use_blocks()
        except _UNREADABLE as error:
            raise ProgramError(f"a declaration cannot be read ({error}).", file=next(iter(files), None)) from None
        return reader

    def reloaded(self) -> Self:
        """Give another controller that has loaded the same files: they are read once for all its runs."""
        reader = type(self)()
        vars(reader).update(_copied(self._as_loaded))
        reader.use_blocks()
        return reader

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
            raise located(f"routine {left} is never called.", next(iter(self.routines[left]), ""))
        for each in self.declared:
            each.check()

    # Execution

    @property
    def statement(self) -> str:
        """That which is executed."""
        return self.routines[self.routine][self.at]

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
            if not statement.startswith(block.begin):
                continue
            end = self.at + len(block.patterns)
            values = block.follow([statement, *self.routines[self.routine][self.at + 1 : end]])
            if values is None:
                continue
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
        wrong = (line for line, pattern in zip(statements, patterns, strict=False) if not re.fullmatch(pattern, line))
        line = next(wrong, "")
        if line or len(statements) != len(patterns):
            raise located(f"{routine} is not as it is written.", line or next(reversed(statements), ""))


def _copied(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Copy what is added to during the execution; a list of declarations has the copies of its attribute."""
    declared = {id(each): copy(each) for each in attributes["declared"]}
    copies = {
        name: declared[id(value)]
        if id(value) in declared
        else copy(value)
        if isinstance(value, dict | list | set)
        else value
        for name, value in attributes.items()
    }
    return {**copies, "declared": list(declared.values())}


def skip(found: object) -> None:
    """Pass over a statement that has no effect on motion and outputs."""
