"""References: folders of a table with its source and what is accepted; read by name from the library, or by path."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, TypeAlias

import numpy as np
from pydantic import Field

from cleaning.calibration.measurements import Column, TableRows
from cleaning.errors import CleaningError
from cleaning.parameters.model import Word
from cleaning.validation.quantities import LABEL, QUANTITIES, QuantityName, Rows
from geometry.arrays import Scalars
from specs.spec import Bounds, Share, Spec
from specs.yaml.file_kind import FileKind
from specs.yaml.load import find_file, parse_spec, read_text
from specs.yaml.located import read_yaml
from specs.yaml.problems import Problem, raise_problems
from specs.yaml.schema import name_nearest

_LIBRARY = Path(__file__).parents[1] / "library" / "validation"
_FILE, _DATA = "reference.yaml", "data.csv"
Ratio: TypeAlias = Annotated[float, Bounds(0, 1000, what="ratios of what is predicted to what was published")]
Power: TypeAlias = Annotated[float, Bounds(-100, 100, what="exponents")]
Condition: TypeAlias = Annotated[float, Bounds(-1e9, 1e9, what="conditions")]
Between: TypeAlias = tuple[Ratio, Ratio]


class Accept(Spec):
    """What is accepted, stated before the comparison is run. Everything that is stated must hold."""

    ratio: Between | None = Field(default=None, description="Predicted over published, of every row.")
    mean_ratio: Between | None = Field(default=None, description="The same, geometric mean of the rows.")
    exponent: dict[Word, tuple[Power, Power]] = Field(
        default={}, description="Power with which the prediction goes with a column, all others held."
    )
    in_range: Share | None = Field(
        default=None, description="Least share of rows that lie within the range which the model states."
    )
    ranking: bool = Field(default=False, description="Whether the order of the rows must be that published.")
    order: list[str] = Field(default=[], description="Labels of rows whose predictions must fall in this order.")

    def checks(self) -> list[str]:
        """Name what is checked, in the order of the keys."""
        plain = [name for name in ("ratio", "mean_ratio") if getattr(self, name) is not None]
        rest = [("in_range", self.in_range is not None), ("ranking", self.ranking), ("order", bool(self.order))]
        return [*plain, *(f"exponent.{name}" for name in self.exponent), *(name for name, stated in rest if stated)]


class ExpectedFailure(Spec):
    """What fails today, and why; as soon as one of it holds, that is reported as a failure too."""

    checks: list[str] = Field(min_length=1, description="What fails, such as ratio or exponent.flow_g_s.")
    reason: str = Field(min_length=1, description="Why.")
    needs: str = Field(min_length=1, description="Law or data by which it would hold.")


class Reference(Spec):
    """What others published, and how near the model has to come."""

    reference: Word = Field(description="Name.")
    title: str = Field(min_length=1, description="What is compared.")
    holds: Literal["readings", "law"] = Field(
        description="readings: what was read off an experiment; law: a law, order or practice; no readings can be had."
    )
    source: str = Field(min_length=1, description="Where it was published.")
    read: str = Field(min_length=1, description="How the numbers of data.csv came about, and what is ours in them.")
    quantity: QuantityName = Field(description="What is predicted.")
    conditions: dict[Word, Condition] = Field(default={}, description="Columns that all rows share.")
    accept: Accept = Field(description="What is accepted.")
    expected_failure: ExpectedFailure | None = Field(default=None, description="What fails today; out: nothing.")


def reference_library() -> dict[str, Path]:
    """Give the references that come with Washboard: name to file, in alphabetical order."""
    return {path.parent.name: path for path in sorted(_LIBRARY.glob(f"*/{_FILE}"))}


REFERENCE = FileKind(
    "reference",
    "reference: NAME",
    "washboard validate",
    CleaningError,
    Reference,
    reference_library,
    named=frozenset({"conditions"}),
)


@dataclass(frozen=True, slots=True, eq=False)
class LoadedReference:
    """A reference and its table."""

    reference: Reference
    rows: Rows


def load_reference(source: str | Path) -> LoadedReference:
    """Read a reference and the table beside it.

    Args:
        source: A name of the library, a folder, or its ``reference.yaml``.

    Raises:
        CleaningError: it cannot be found or used; the message names the file and the line.
    """
    if isinstance(source, Path) or source not in reference_library():
        folder = Path(source)
        source = folder / _FILE if folder.is_dir() else source
    path = find_file(source, REFERENCE)
    reference = read_reference(path)
    rows = read_rows(path.with_name(_DATA), reference)
    missing = [label for label in reference.accept.order if label not in rows.labels]
    if missing:
        raise rows.error(f"accept.order has {missing[0]!r}, and no row has; {name_nearest(missing[0], rows.labels)}")
    return LoadedReference(reference, rows)


def read_reference(path: Path) -> Reference:
    """Read the file of a reference.

    Raises:
        CleaningError: it cannot be read or used; the message names the line.
    """
    root = read_yaml(read_text(path, REFERENCE), path, REFERENCE)
    reference = parse_spec(root, REFERENCE)
    raise_problems(_problems(reference), root, REFERENCE)
    return reference


def _problems(reference: Reference) -> list[Problem]:
    quantity, accept = QUANTITIES[reference.quantity], reference.accept
    known, checks = list(quantity.columns), accept.checks()
    found = [
        Problem(("conditions", name), f"no column of {reference.quantity}; {name_nearest(name, known)}")
        for name in reference.conditions
        if name not in known
    ]
    found += [
        Problem(("conditions", name), f"must lie in {column.low:g} to {column.high:g}, not {value:g}")
        for name, value in reference.conditions.items()
        if (column := quantity.columns.get(name)) is not None and not column.low <= value <= column.high
    ]
    found += [
        Problem(("accept", "exponent", name), f"no column of {reference.quantity}; {name_nearest(name, known)}")
        for name in accept.exponent
        if name not in known
    ]
    pairs = {("accept", "ratio"): accept.ratio, ("accept", "mean_ratio"): accept.mean_ratio}
    pairs |= {("accept", "exponent", name): pair for name, pair in accept.exponent.items()}
    found += [
        Problem(path, f"[{pair[0]:g}, {pair[1]:g}]: the lower number comes first")
        for path, pair in pairs.items()
        if pair is not None and pair[0] > pair[1]
    ]
    if not checks:
        found.append(Problem(("accept",), f"accepts anything; state one of {', '.join(Accept.model_fields)}"))
    if reference.expected_failure is not None:
        found += [
            Problem(("expected_failure", "checks", at), f"{name!r} is not accepted; {name_nearest(name, checks)}")
            for at, name in enumerate(reference.expected_failure.checks)
            if name not in checks
        ]
    return found


def read_rows(path: Path, reference: Reference) -> Rows:
    """Read the table of a reference: labels, the columns of its quantity, what was published, which may be blank.

    Raises:
        CleaningError: it cannot be read or used; the message names the line.
    """
    quantity, table = QUANTITIES[reference.quantity], TableRows(path)
    published = Column(-1e12, 1e12)
    needed = {name: column for name, column in quantity.columns.items() if name not in reference.conditions}
    label = Column(0.0, 0.0, optional=True)
    records = table.records({LABEL: label, quantity.published: published, **needed})
    columns: dict[str, Scalars] = {}
    for name, column in needed.items():
        columns[name] = _numbers([table.number(cells[name], name, column, line) for line, cells in records])
    for name, value in reference.conditions.items():
        columns[name] = _numbers([value] * len(records))
    cells = [(line, each[quantity.published]) for line, each in records]
    values = [table.number(cell, quantity.published, published, line) if cell else math.nan for line, cell in cells]
    labels = tuple(each.get(LABEL, "") or f"line {line}" for line, each in records)
    return Rows(labels, columns, _numbers(values), table.error)


def _numbers(values: Sequence[float]) -> Scalars:
    return np.array(values, dtype=np.float64)
