"""Reading measurements: CSV files of numbers, mistakes reported with their line; spray patterns on flat sheets.

A sheet lies flat below the orifice. Places on it are measured from the point that the nozzle's axis meets; azimuth 0,
which is x, points to where the axis tilts, and azimuths grow clockwise as seen from the nozzle, as in a recipe's wave
front. The nozzle's reference azimuth lies in the plane of the tilt.
"""

import csv
import hashlib
import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cleaning.errors import CleaningError
from geometry.arrays import Indices, Scalars
from specs.input_file import InputFile
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

    def distinct(self, *names: str) -> tuple[list[tuple[float, ...]], Indices]:
        """Distinct values of some columns in the order of the file; and which are each row's (n,)."""
        keys = list(zip(*(self.columns[name].tolist() for name in names), strict=True))
        order = {key: index for index, key in enumerate(dict.fromkeys(keys))}
        return list(order), np.array([order[key] for key in keys], dtype=np.int64)

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
        content = InputFile(path, CleaningError, "table of measurements", _LARGEST_FILE).read()
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


_LENGTH = 2000.0
_HIGHEST = 1000.0
"""As in a recipe."""
_COLUMNS: Mapping[str, Column] = {
    "height_mm": Column(1.0, _HIGHEST),
    "tilt_deg": Column(0.0, 80.0, default=0.0),
    "azimuth_deg": Column(-360.0, 360.0, optional=True),
    "inner_mm": Column(0.01, _LENGTH, optional=True),
    "outer_mm": Column(0.01, _LENGTH, optional=True),
    "radius_mm": Column(0.0, _LENGTH, optional=True),
    "x_mm": Column(-_LENGTH, _LENGTH, optional=True),
    "y_mm": Column(-_LENGTH, _LENGTH, optional=True),
    "intensity": Column(0.0, 1e12, optional=True),
}
_LEAST_ROWS = 8
_MOST_SHEETS = 100


@dataclass(frozen=True, slots=True, eq=False)
class Rays:
    """The rays from the orifice to n places on sheets. Radians, mm."""

    polar: Scalars
    """(n,) angle from the nozzle's axis."""
    azimuth: Scalars
    """(n,) about it, from the nozzle's reference."""
    length: Scalars
    """(n,) of the ray."""
    incidence_cosine: Scalars
    """(n,) of the angle between ray and the normal of the sheet."""


def read_sheets(path: Path) -> Measurements:
    """Read measured patterns: edges of the ring, or intensities.

    Raises:
        CleaningError: it cannot be used; the message names the line.
    """
    sheets = read_measurements(path, _COLUMNS, _LEAST_ROWS)
    columns = sheets.columns
    if "intensity" in columns:
        if ("x_mm" in columns and "y_mm" in columns) == ("azimuth_deg" in columns and "radius_mm" in columns):
            message = "intensities need places: either x_mm and y_mm, or azimuth_deg and radius_mm"
            raise sheets.error(message)
        if float(columns["intensity"].max()) == 0.0:
            raise sheets.error("no intensity is above 0", "intensity", 0)
    else:
        for name in ("azimuth_deg", "inner_mm", "outer_mm"):
            if name not in columns:
                raise sheets.error(
                    f"column {name!r} is missing; edges of the ring need it, intensities need 'intensity'"
                )
        wrong = np.flatnonzero(columns["inner_mm"] >= columns["outer_mm"])
        if wrong.size:
            message = f"{columns['inner_mm'][wrong[0]]:g} is not below outer_mm, {columns['outer_mm'][wrong[0]]:g}"
            raise sheets.error(message, "inner_mm", int(wrong[0]))
    count = len(sheet_of(sheets)[0])
    if count > _MOST_SHEETS:
        message = f"{count} pairs of height_mm and tilt_deg are too many; each is a sheet, {_MOST_SHEETS} at most"
        raise sheets.error(message)
    sheets.require_variation("height_mm", "measure at two heights at least, so that a cone can be fitted")
    return sheets


def rays_to(sheets: Measurements, x_mm: Scalars, y_mm: Scalars) -> Rays:
    """Find the rays that arrive at places on sheets.

    With z down and the orifice at the origin, the axis is (sin b, 0, cos b), the nozzle's reference (cos b, 0, -sin b).
    """
    height, tilt = sheets.columns["height_mm"], np.radians(sheets.columns["tilt_deg"])
    forward = x_mm + height * np.tan(tilt)
    along = forward * np.sin(tilt) + height * np.cos(tilt)
    reference = forward * np.cos(tilt) - height * np.sin(tilt)
    length = np.sqrt(forward**2 + y_mm**2 + height**2)
    return Rays(
        polar=np.asarray(np.arctan2(np.hypot(reference, y_mm), along), dtype=np.float64),
        azimuth=np.asarray(np.arctan2(y_mm, reference), dtype=np.float64),
        length=length,
        incidence_cosine=height / length,
    )


def meet(height_mm: float, tilt: float, polar: Scalars, azimuth: Scalars) -> tuple[Scalars, Scalars]:
    """Give x and y on one sheet of where rays arrive, mm: the reverse of ``rays_to``; far away if they never do.

    Args:
        height_mm: Of the sheet.
        tilt: Of the nozzle, rad.
        polar: (n,) angles from its axis, rad.
        azimuth: (n,) about it, rad.
    """
    reference, across, along = np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)
    forward = reference * np.cos(tilt) + along * np.sin(tilt)
    down = np.maximum(along * np.cos(tilt) - reference * np.sin(tilt), 1e-3)
    return height_mm * forward / down - height_mm * np.tan(tilt), height_mm * across / down


def places(sheets: Measurements, radius_mm: Scalars) -> tuple[Scalars, Scalars]:
    """Give x and y on the sheets of places at a radius along the measured azimuths, mm."""
    around = np.radians(sheets.columns["azimuth_deg"])
    return radius_mm * np.cos(around), radius_mm * np.sin(around)


def sheet_of(sheets: Measurements) -> tuple[list[tuple[float, float]], Indices]:
    """Give the sheets of a table, height and tilt of each in the order of the file, and which is each row's."""
    keys, which = sheets.distinct("height_mm", "tilt_deg")
    return [(height_mm, tilt_deg) for height_mm, tilt_deg in keys], which


def harmonics(azimuth: Scalars, order: int) -> NDArray[np.float64]:
    """(n, 2 order) cosines and sines of the multiples of an azimuth: what a table about the axis is made of."""
    waves = [wave(turn * azimuth) for turn in range(1, order + 1) for wave in (np.cos, np.sin)]
    return np.column_stack(waves) if waves else np.zeros((len(azimuth), 0))
