"""Reading measurements: a CSV file with a header, numbers only; every mistake is reported with its line."""

import csv
import hashlib
import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cleaning.errors import CleaningError
from geometry.arrays import Indices, Scalars
from specs.read_file import read_file
from specs.yaml.schema import name_nearest

_LARGEST_FILE = 20_000_000
_MOST_ROWS = 50_000
_SEPARATORS = ",;\t"


@dataclass(frozen=True, slots=True)
class Column:
    """What a column may hold."""

    low: float
    high: float
    default: float | None = None
    """Where the column is left out; ``None`` if it is needed."""
    optional: bool = False
    """Whether it may be left out without a default."""


@dataclass(frozen=True, slots=True, eq=False)
class Measurements:
    """A table of n measurements and where it comes from."""

    path: Path
    sha256: str
    synthetic: bool
    """Whether a comment in it marks it as made up, not measured."""
    columns: Mapping[str, Scalars]
    """(n,) each."""
    lines: Indices
    """(n,) line in the file, from 1."""
    header_line: int

    @property
    def repeated(self) -> list[tuple[int, int]]:
        """Lines that repeat an earlier one to the last digit, each with that one."""
        first: dict[tuple[float, ...], int] = {}
        rows = zip(*(column.tolist() for column in self.columns.values()), strict=True)
        pairs = [(line, first.setdefault(row, line)) for line, row in zip(self.lines.tolist(), rows, strict=True)]
        return [(line, earlier) for line, earlier in pairs if line != earlier]

    def __len__(self) -> int:
        """Number of measurements."""
        return len(self.lines)

    @property
    def source(self) -> str:
        """Provenance of a value that was fitted to it: its name without folders is the same on whatever machine."""
        return f"{self.path.name}, sha256 {self.sha256[:16]}"

    def error(self, message: str, column: str = "", row: int | None = None) -> CleaningError:
        """Make the error of a column in a row, or of the whole table."""
        line = self.header_line if row is None else int(self.lines[row])
        return CleaningError(message, path=column, file=self.path, line=line)

    def require_variation(self, name: str, advice: str) -> None:
        """Refuse a table in which a column never changes although the fit needs that it does.

        Raises:
            CleaningError: all its values are the same.
        """
        values = self.columns[name]
        if float(np.ptp(values)) == 0.0:
            raise self.error(f"all {len(values)} rows have {values[0]:g}; {advice}", name, 0)


def read_measurements(path: Path, known: Mapping[str, Column], least: int) -> Measurements:
    """Read a table of measurements.

    Lines that begin with ``#`` are comments; one that begins with ``# synthetic`` marks the table as made up.

    Args:
        path: CSV with commas, semicolons or tabs; numbers with a decimal point.
        known: Columns by name; others are refused, because a misspelt one would be left out silently.
        least: Rows that are needed.

    Raises:
        CleaningError: it cannot be read or used.
    """
    rows = TableRows(path)
    columns = rows.columns(known, least)
    return Measurements(path, rows.sha256, rows.synthetic, columns, rows.lines, rows.header_line)


class TableRows:
    """The rows of one CSV file, whose first line that is no comment names the columns.

    Raises:
        CleaningError: it cannot be read as such.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        content = read_file(path, CleaningError, "table of measurements", _LARGEST_FILE)
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            line = content.count(b"\n", 0, error.start) + 1
            raise CleaningError("is not UTF-8 text; save it as CSV in UTF-8", file=path, line=line) from None
        self.sha256 = hashlib.sha256(content).hexdigest()
        lines = text.splitlines()
        comments = [line for line in lines if line.startswith("#")]
        self.synthetic = any(line.lstrip("# ").lower().startswith("synthetic") for line in comments)
        numbered = [(number, line) for number, line in enumerate(lines, 1) if line.strip() and line[0] != "#"]
        if not numbered:
            raise CleaningError("the table is empty; its first line names the columns", file=path, line=1)
        self.header_line, header = numbered[0]
        separator = max(_SEPARATORS, key=header.count)
        self._names = [name.strip() for name in self._split(header, separator, self.header_line)]
        self._rows = [(number, self._split(line, separator, number)) for number, line in numbered[1:]]
        self.lines: Indices = np.array([number for number, _ in self._rows], dtype=np.int64)

    def columns(self, known: Mapping[str, Column], least: int) -> dict[str, Scalars]:
        """Give every known column, from the file or by default."""
        self._check(known, least)
        found: dict[str, Scalars] = {}
        for name, column in known.items():
            if name in self._names:
                place = self._names.index(name)
                values = [self.number(cells[place], name, column, number) for number, cells in self._rows]
                found[name] = np.array(values, dtype=np.float64)
            elif column.default is not None:
                found[name] = np.full(len(self._rows), column.default, dtype=np.float64)
        return found

    def records(self, known: Mapping[str, Column]) -> list[tuple[int, dict[str, str]]]:
        """Give every row as text by column, with its line, for tables that are not of numbers alone."""
        self._check(known, 1)
        return [(number, dict(zip(self._names, map(str.strip, cells), strict=True))) for number, cells in self._rows]

    def _check(self, known: Mapping[str, Column], least: int) -> None:
        self._check_names(known)
        if len(self._rows) < least:
            raise self.error(f"{len(self._rows)} rows are too few; at least {least} are needed")
        if len(self._rows) > _MOST_ROWS:
            raise self.error(f"{len(self._rows):,} rows are too many; thin them out to {_MOST_ROWS:,} at most")
        for number, cells in self._rows:
            if len(cells) != len(self._names):
                raise self.error(f"has {len(cells)} cells; the header names {len(self._names)} columns", line=number)

    def _check_names(self, known: Mapping[str, Column]) -> None:
        for place, name in enumerate(self._names):
            if name not in known:
                raise self.error(f"unknown column {name!r}; {name_nearest(name, known)}")
            if name in self._names[:place]:
                raise self.error(f"column {name!r} stands twice")
        needed = [name for name, column in known.items() if column.default is None and not column.optional]
        missing = [name for name in needed if name not in self._names]
        if missing:
            raise self.error(f"column {missing[0]!r} is missing; needed are {', '.join(needed)}")

    def error(self, message: str, column: str = "", line: int | None = None) -> CleaningError:
        """Make the error of a column in a line, or of the whole table."""
        return CleaningError(message, path=column, file=self._path, line=self.header_line if line is None else line)

    def number(self, cell: str, name: str, column: Column, line: int) -> float:
        """Read a number that a column may hold."""
        text = cell.strip()
        try:
            value = float(text.replace("_", "?"))  # Python would take 1_000 for a number
        except ValueError:
            raise self.error(f"must be a number with a decimal point, not {text[:40]!r}", name, line) from None
        if not math.isfinite(value):
            raise self.error(f"must be a finite number, not {text!r}; remove the row", name, line)
        if not column.low <= value <= column.high:
            raise self.error(f"must lie in {column.low:g} to {column.high:g}, not {value:g}", name, line)
        return value

    def _split(self, line: str, separator: str, number: int) -> Sequence[str]:
        try:
            return next(csv.reader(io.StringIO(line), delimiter=separator, strict=True))
        except csv.Error as error:
            raise self.error(f"not valid CSV: {error}", line=number) from None
