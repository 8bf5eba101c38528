"""Reading measured cleanliness: one row for each component and method, with the limit that it is judged by."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from cleaning.calibration.measurements import Column, TableRows
from specs.errors import printable
from specs.yaml.schema import name_nearest

_SQUARE_INCH_CM2 = 6.4516
_ANY = Column(-1e15, 1e15)
_COLUMNS = {"component": _ANY, "method": _ANY, "value": _ANY, "unit": _ANY, "limit": _ANY}
_PER_AREA = {"ug/cm2": 1.0, "µg/cm²": 1.0, "ug/in2": 1.0 / _SQUARE_INCH_CM2, "µg/in²": 1.0 / _SQUARE_INCH_CM2}


@dataclass(frozen=True, slots=True)
class Method:
    """One way to measure cleanliness."""

    name: str
    """As the table has it."""
    meaning: str
    units: Mapping[str, float]
    """Unit to what one of it is in the first one."""
    more_is_cleaner: bool = False
    most: float = 1e15
    """Largest value in the first unit."""
    sees_surface: bool = True
    """Whether it sees what is on exposed surfaces; under parts every method looks."""

    @property
    def unit(self) -> str:
        """The first one, in which results are given."""
        return next(iter(self.units))


METHODS: dict[str, Method] = {
    each.name: each
    for each in (
        Method("sir", "surface insulation resistance", {"Mohm": 1.0, "Gohm": 1e3, "kohm": 1e-3, "ohm": 1e-6}, True),
        Method("ic", "ion chromatography", _PER_AREA),
        Method("rose", "resistivity of solvent extract", _PER_AREA),
        Method("tear-off", "share of the area with residue under the removed part",
               {"%": 1.0, "share": 100.0}, most=100.0, sees_surface=False),
    )
}  # fmt: skip
"""Methods by name."""


@dataclass(frozen=True, slots=True)
class Measured:
    """One figure of one component, in the method's first unit."""

    component: str
    method: Method
    value: float
    limit: float
    """Up to which it passes; where more is cleaner, from which on."""
    line: int

    @property
    def passed(self) -> bool:
        """Whether it keeps its limit; the limit itself passes."""
        return self.value >= self.limit if self.method.more_is_cleaner else self.value <= self.limit

    @property
    def dirt(self) -> float:
        """The figure with the sign by which more is dirtier: for ranks."""
        return -self.value if self.method.more_is_cleaner else self.value


@dataclass(frozen=True, slots=True)
class MeasuredTable:
    """All rows of one table and where they come from."""

    file: str
    """Its name without folders."""
    sha256: str
    synthetic: bool
    """Whether a comment in it marks it as made up."""
    rows: tuple[Measured, ...]


def read_measured(path: Path, components: Sequence[str]) -> MeasuredTable:
    """Read a table of measured cleanliness.

    Args:
        path: CSV whose columns are ``component``, ``method`` (of ``METHODS``), ``value``, ``unit`` and ``limit``, value
            and limit in that unit; comments and separators as for calibrations.
        components: Reference designators that it may name.

    Raises:
        CleaningError: it cannot be read or used; the message names the line.
    """
    table = TableRows(path)
    first: dict[tuple[str, str], int] = {}
    rows: list[Measured] = []
    for line, cells in table.records(_COLUMNS):
        row = _row(table, cells, line, components)
        earlier = first.setdefault((row.component, row.method.name), line)
        if earlier != line:
            name = f"{row.component} by {row.method.name}"
            raise table.error(f"{name} stands on line {earlier} already; keep one of them", line=line)
        rows.append(row)
    return MeasuredTable(path.name, table.sha256, table.synthetic, tuple(rows))


def _row(table: TableRows, cells: Mapping[str, str], line: int, components: Sequence[str]) -> Measured:
    name, method = cells["component"], METHODS.get(cells["method"].lower())
    if name not in components:
        raise table.error(f"the board has no {_quoted(name)}; {name_nearest(name, components)}", "component", line)
    if method is None:
        message = f"unknown method {_quoted(cells['method'])}; {name_nearest(cells['method'], METHODS)}"
        raise table.error(message, "method", line)
    if cells["unit"] not in method.units:
        known = ", ".join(method.units)
        raise table.error(f"{method.name} is not measured in {_quoted(cells['unit'])}; use {known}", "unit", line)
    factor = method.units[cells["unit"]]
    bounds = Column(0.0, method.most / factor)
    value, limit = (table.number(cells[key], key, bounds, line) * factor for key in ("value", "limit"))
    return Measured(name, method, value, limit, line)


def _quoted(text: str) -> str:
    return repr(printable(text[:40]))
