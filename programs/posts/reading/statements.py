"""Statements of a program's text: where they stand, what they declare, and the forms that they have."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Generic, Self, TypeAlias, TypeVar

from programs.errors import ProgramError
from programs.posts.rebuilt import TextPlace
from programs.posts.writing.forms import NUMBER, pattern_of

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

    def add(self, key: _Key, value: _Value, line: str = "") -> None:
        """Declare a value.

        Raises:
            ProgramError: it is declared already.
        """
        if key in self.values:
            raise located(f"{self.what} {_words(key)} is declared twice.", line)
        self.values[key] = value

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
            raise ProgramError(f"{self.what} {_words(unused)} is declared and never used.")


def _words(key: object) -> str:
    return " ".join(map(str, key)) if isinstance(key, tuple) else str(key)  # type: ignore[reportUnknownArgumentType,reportUnknownVariableType]


class StatementBlock:
    """Patterns of statements that belong together, and what they do."""

    def __init__(self, forms: Sequence[str], fields: Mapping[str, str], action: FormAction) -> None:
        self.patterns = [re.compile(pattern_of(form, fields)) for form in forms]
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
                    return located(_differs(name), statement)
        return values


def _differs(name: str) -> str:
    """Describe a field that is not the same in all statements."""
    if name == "height":
        return "the orifice is compared with one height and raised to another."
    if name in ("input", "name", "state", "scale", "offset", "least"):
        return "what is waited for is not what is looked at then."
    if name in ("label", "ready", "index", "after"):
        return "the program goes on elsewhere than after the statements that belong together."
    return f"the {name} is not the same in the statements that belong together."
