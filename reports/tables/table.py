"""One model of a table for terminal, HTML and page: columns, and rows of cells whose text may be emphasised."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from cleaning.verdicts.rules import Outcome
from specs.finding import Severity

Emphasis: TypeAlias = Literal["", "strong", "quiet", "code", "small"]
Tone: TypeAlias = Outcome | Severity
"""What a colour stands for."""
Facts: TypeAlias = Sequence[tuple[str, str]]
"""Names with their values, one a line."""


@dataclass(frozen=True, slots=True)
class Text:
    """A run of text, emphasised or in the colour of an outcome or a severity."""

    text: str
    emphasis: Emphasis = ""
    tone: Tone | None = None


Line: TypeAlias = str | Text | tuple[str | Text, ...]


@dataclass(frozen=True, slots=True)
class Lines:
    """Content of a cell with lines below its first one."""

    first: Line
    below: tuple[Line, ...]


Cell: TypeAlias = Line | Lines


@dataclass(frozen=True, slots=True)
class Column:
    """Heading of a column, and how its cells are set."""

    heading: str
    align: Literal["left", "right"] = "left"
    emphasis: Emphasis = ""
    width: str = ""
    """Share of a table of fixed layout on the page, such as ``"20%"``; empty where it follows the content."""
    at_least: int = 0
    """Characters on a terminal."""
    at_most: int = 0
    """Characters on a terminal, beyond which text is cut; 0 for no limit."""


@dataclass(frozen=True, slots=True)
class Table:
    """Columns and rows; every row has a cell for each column."""

    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    title: str = ""

    @classmethod
    def of(cls, headings: Iterable[str | Column], rows: Iterable[Sequence[Cell]], title: str = "") -> "Table":
        """Build a table; a heading that begins with > has its column flush right."""
        columns = (
            Column(each.removeprefix(">"), "right" if each.startswith(">") else "left")
            if isinstance(each, str)
            else each
            for each in headings
        )
        return cls(tuple(columns), tuple(map(tuple, rows)), title)


def lines_of(cell: Cell) -> list[list[Text]]:
    """Split a cell into its lines, each a list of runs."""
    lines = [cell.first, *cell.below] if isinstance(cell, Lines) else [cell]
    runs = [line if isinstance(line, tuple) else (line,) for line in lines]
    return [[Text(run) if isinstance(run, str) else run for run in line] for line in runs]
