"""The tables of a study, read again from its folder or from a copy of its table of runs."""

import csv
import io
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from specs.input_file import InputFile
from specs.progress import Progress
from studies.errors import StudyError
from studies.results.summary import CleanShare, Level
from studies.results.tables import COMPONENTS, EFFECTS, RUNS

_BEFORE_VALUES = ("case", "board", "recipe", "parameters")
_SAMPLE, _SECONDS = "sample", "seconds"
"""Columns before the deviations, and after them."""
_VERDICTS = ("clean", "marginal", "dirty", "no verdict")
_LARGEST = 100_000_000
"""Bytes; a study of as many runs as there can be has half of it."""
_PROGRESS_ROWS = 2000


@dataclass(frozen=True, slots=True)
class Combination:
    """A combination as the table has it: as planned, and how it bears the tolerances."""

    number: int
    board: str
    """As the study has it, like recipe and parameter set."""
    recipe: str
    parameters: str
    point: tuple[str, ...]
    """Values, in the order of the study's paths."""
    error: str
    """Why there are no numbers."""
    seconds: float
    litres: float
    verdicts: Mapping[str, int]
    """Components by their verdict; those that are clean first."""
    pareto: bool
    """Whether no other one for the board is better."""
    robot: str
    """What hinders the robot of the study's cell; empty where nothing does, or there is none."""
    shares: tuple[CleanShare, ...] = ()
    """How often each component is clean under the tolerances; empty where the table is not there."""
    all_clean: int = 0
    """Samples in which every component is."""
    samples: int = 0
    """That could be analysed."""

    @property
    def clean(self) -> int:
        """Components that are predicted clean as planned."""
        return self.verdicts["clean"]

    @property
    def components(self) -> int:
        """All components that were judged."""
        return sum(self.verdicts.values())


@dataclass(frozen=True, slots=True)
class StudyTables:
    """The tables of a study, read again."""

    paths: tuple[str, ...]
    """Of the values that were varied."""
    combinations: tuple[Combination, ...]
    effects: tuple[Level, ...]
    """Empty where the table is not there."""

    @property
    def boards(self) -> tuple[str, ...]:
        """Names of the boards, in the order of the study."""
        return tuple(dict.fromkeys(each.board for each in self.combinations))


def begins_runs(head: bytes) -> bool:
    """Whether a file that begins with these bytes is a table of runs."""
    names = head.split(b"\n", 1)[0].decode("utf-8", errors="replace").strip().split(",")
    return tuple(names[:4]) == _BEFORE_VALUES and _SAMPLE in names and _SECONDS in names


def read_tables(runs: Path, progress: Progress) -> StudyTables:
    """Read a table of runs (CSV); the two others of a study too, if they are beside one that is called ``runs.csv``.

    Raises:
        StudyError: one cannot be read, or is none of a study; the message names the line.
    """
    found: dict[int, Combination] = {}
    paths: tuple[str, ...] = ()
    for row in _rows(runs, (*_BEFORE_VALUES, _SAMPLE, _SECONDS, "litres", "error"), progress):
        number = row.whole("case")
        if not found:
            names = list(row.cells)
            paths = tuple(names[len(_BEFORE_VALUES) : names.index(_SAMPLE)])
        if row.whole(_SAMPLE) == 0:
            found[number] = _combination(row, paths)
        elif number not in found:
            raise row.error("case", "its run as planned is not above it")
        elif not row.text("error"):
            clean = row.whole("clean") == row.whole("components")
            of, before = found[number], found[number].samples
            found[number] = replace(of, samples=before + 1, all_clean=of.all_clean + clean)
    beside = {name: runs.with_name(f"{name}.csv") for name in (COMPONENTS, EFFECTS)}
    named = runs.stem == RUNS
    shares = _read_shares(beside[COMPONENTS], progress) if named and beside[COMPONENTS].exists() else {}
    effects = tuple(_read_effects(beside[EFFECTS], progress)) if named and beside[EFFECTS].exists() else ()
    combinations = (replace(each, shares=tuple(shares.get(number, ()))) for number, each in found.items())
    return StudyTables(paths, tuple(combinations), effects)


@dataclass(frozen=True, slots=True)
class _Row:
    """A row of a table."""

    file: Path
    line: int
    cells: Mapping[str, str]

    def error(self, column: str, message: str) -> StudyError:
        return StudyError(message, path=column, file=self.file, line=self.line)

    def text(self, column: str) -> str:
        """Raises StudyError: there is no such column."""
        if column not in self.cells:
            raise self.error(column, "the column is missing")
        return self.cells[column]

    def number(self, column: str) -> float:
        """Raises StudyError: it is no number."""
        text = self.text(column)
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise self.error(column, f"{text[:40]!r} is no number")
        return value

    def whole(self, column: str) -> int:
        """Raises StudyError: it is no whole number that can count something."""
        value = self.number(column)
        if not value.is_integer() or not 0 <= value <= 1e9:
            raise self.error(column, f"{value:g} counts nothing")
        return int(value)


def _rows(file: Path, needed: Iterable[str], progress: Progress) -> Iterator[_Row]:
    """Read a table row by row.

    Raises:
        StudyError: it cannot be read, lacks a column, or a row has other cells than the header.
    """
    content = InputFile(file, StudyError, "table of a study", _LARGEST).read()
    lines = csv.reader(io.StringIO(content.decode("utf-8-sig", errors="replace"), newline=""))
    try:
        names = next(lines, [])
        missing = next((each for each in needed if each not in names), None)
        if missing is not None:
            raise StudyError(f"is no such table of a study: it has no column {missing}", file=file)
        for count, cells in enumerate(lines):
            if len(cells) != len(names):
                raise StudyError(f"{len(cells)} cells; the header has {len(names)}", file=file, line=lines.line_num)
            if count % _PROGRESS_ROWS == 0:
                progress(f"reading {file.name}", 0.0)
            yield _Row(file, lines.line_num, dict(zip(names, cells, strict=True)))
    except csv.Error as error:
        raise StudyError(f"{error}", file=file, line=lines.line_num) from None


def _combination(row: _Row, paths: tuple[str, ...]) -> Combination:
    error = row.text("error")
    verdicts = {name: 0 if error else row.whole(name.replace(" ", "_")) for name in _VERDICTS}
    robot = ""
    if row.cells.get("robot_can") == "False":
        robot = row.text("robot_errors") or "cannot be done"
    return Combination(
        number=row.whole("case"),
        board=row.text("board"),
        recipe=row.text("recipe"),
        parameters=row.text("parameters"),
        point=tuple(map(row.text, paths)),
        error=error,
        seconds=0.0 if error else row.number(_SECONDS),
        litres=0.0 if error else row.number("litres"),
        verdicts=verdicts,
        pareto=row.text("pareto") == "True",
        robot=robot,
    )


def _read_shares(file: Path, progress: Progress) -> dict[int, list[CleanShare]]:
    found: dict[int, list[CleanShare]] = {}
    for row in _rows(file, ("case", "component", "as_planned", "samples", "clean"), progress):
        clean, samples = row.whole("clean"), row.whole("samples")
        if not samples or clean > samples:
            raise row.error("clean", f"{clean} of {samples} samples is no share")
        share = CleanShare(row.text("component"), row.text("as_planned"), clean, samples)
        found.setdefault(row.whole("case"), []).append(share)
    return found


def _read_effects(file: Path, progress: Progress) -> Iterator[Level]:
    numbers = ("seconds", "litres", "clean_pct", "seconds_effect", "litres_effect", "clean_pct_effect")
    for row in _rows(file, ("factor", "level", "runs", *numbers), progress):
        yield Level(row.text("factor"), row.text("level"), row.whole("runs"), *map(row.number, numbers))
