"""One model of cards and tables for terminal, HTML and page: what they state, and nothing of how it is drawn."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

from cleaning.verdicts.rules import Outcome
from reports.tables.wording import shorten
from specs.finding import Finding, Severity

if TYPE_CHECKING:
    from programs.plan import Origin

Emphasis: TypeAlias = Literal["", "strong", "quiet", "code", "small", "changed"]
"""Of the lines of a text that changed, the first letter states how: ``+``, ``-``, or ``@`` for where."""
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


@dataclass(frozen=True, slots=True)
class Bar:
    """A share drawn as a bar, with its value."""

    share: float
    """0 to 1."""
    text: str
    marked: bool = False


Cell: TypeAlias = Line | Lines | Bar


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
    is_name: bool = False
    """The heading is a name, whose letters stay as they are."""


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


@dataclass(frozen=True, slots=True)
class FactList:
    """Names with their values, one a line."""

    facts: Facts


@dataclass(frozen=True, slots=True)
class FindingList:
    """Findings in any order; they are listed worst first."""

    findings: tuple[Finding, ...]


@dataclass(frozen=True, slots=True)
class Verbatim:
    """Text whose lines are kept as they are, such as YAML or a command."""

    text: str
    emphasis: Emphasis = ""


@dataclass(frozen=True, slots=True)
class Note:
    """A statement with the weight of its tone: what it is about, and what it states."""

    tone: Tone
    head: Line
    below: tuple[Line, ...]


Block: TypeAlias = Line | Note | Table | FactList | FindingList | Verbatim
"""A line is a paragraph; an empty one parts what stands above from what stands below."""


@dataclass(frozen=True, slots=True)
class Card:
    """What is known of one subject, in the order in which it is read."""

    title: Line
    blocks: tuple[Block, ...]


def more_words(count: int, what: str = "more") -> tuple[Text, ...]:
    """How many entries are left out of a list; nothing where none is."""
    return (Text(f"and {count} {what}", "quiet"),) if count > 0 else ()


def program_title(origin: "Origin", *words: str | Text) -> tuple[str | Text, ...]:
    """Board and recipe of a program, and what results from it."""
    return (Text(origin.board, "strong"), " with ", Text(origin.recipe, "strong"), *words)


def source_lines(name: str, description: str, source: str) -> tuple[Line, Block]:
    """Name of what a card shows with its description, and the file that it was read from."""
    return (Text(name, "strong"), f"  {description}"), Verbatim(source, "quiet")


def lines_of(cell: Cell) -> list[list[Text]]:
    """Split a cell into its lines, each a list of runs."""
    if isinstance(cell, Bar):
        return [[Text(cell.text)]]
    lines = [cell.first, *cell.below] if isinstance(cell, Lines) else [cell]
    runs = [line if isinstance(line, tuple) else (line,) for line in lines]
    return [[Text(run) if isinstance(run, str) else run for run in line] for line in runs]


def capital(text: str) -> str:
    """Begin a label or a heading with a capital, as HTML has it."""
    return text[:1].upper() + text[1:]


def heading_of(column: Column) -> str:
    """Heading of a column as HTML has it, in one line."""
    heading = " ".join(column.heading.split())
    return heading if column.is_name else capital(heading)


def finding_note(finding: Finding) -> Note:
    """A finding by itself: its rule, what caused it, where it is, what was seen."""
    place = "" if finding.where is None else "  at " + ", ".join(f"{value:z.1f}" for value in finding.where) + " mm"
    rule = Text(f"{finding.severity} {finding.rule.id}", tone=finding.severity)
    origin = f"  {shorten(str(finding.made_by))}" if finding.made_by else ""
    return Note(finding.severity, (rule, Text(f"{origin}{place}", "quiet")), (shorten(finding.message),))
