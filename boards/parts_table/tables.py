"""Several tables of one board, joined by designator, with places in the unit under which they fit the board."""

from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree

from boards.formats.archive import is_archive, read_members
from boards.formats.names import listed
from boards.packages.families import package_family, package_sizes
from boards.parts_table.fit import NEAR_MM, fit_pairs
from boards.parts_table.read import NoTableError, PartsTable, Row, is_table_name, read_table
from geometry.arrays import Points2
from specs.finding import Finding
from specs.finding_rules import PARTS_CONTRADICT, PARTS_NOT_IN_TABLE, PARTS_UNIT, UNIT_GUESSED

NOT_FITTED = "components are not fitted by the parts table and are left out: {}."
_UNITS = (("mm", 1.0), ("mil", 0.0254), ("inch", 25.4))
_BEYOND_MM = 5.0
"""Places of parts may spread that much wider than the board."""
_HEAP = 0.1
"""Places that spread over a smaller part of the board are a heap."""
_APART_MM = 1.5
"""Neighbours in a heap are typically farther apart than this if its unit is right."""


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """What a table's places are compared with. Frame of the board, mm."""

    centres: Mapping[str, Points2]
    """(2,) of the parts whose names are known, by their names in small letters."""
    box: Points2
    """Least and largest corner of the board (2, 2)."""


def join_tables(tables: Iterable[PartsTable], board: Reference) -> tuple[tuple[Row, ...], tuple[Finding, ...]]:
    """Join tables by designator, whatever their order.

    Of two statements the first stands, those of tables with places before the others; but a package of a known size
    or family stands before another, and a part that one of the tables leaves out is not fitted.
    """
    notes: list[Finding] = []
    tables = sorted((_in_unit(table, board, notes) for table in tables), key=lambda table: not _places(table))
    rows: list[Row] = []
    known: dict[str, int] = {}
    clashes: list[str] = []
    for table in tables:
        before = dict(known)
        for row in table.rows:
            name = row.ref.casefold()
            if name in before:
                rows[before[name]] = _merge(rows[before[name]], row, clashes)
            else:
                known.setdefault(name, len(rows))
                rows.append(row)
    lists = [table for table in tables if not _places(table)]
    if 0 < len(lists) < len(tables):
        named = {row.ref.casefold() for table in lists for row in table.rows}
        alone = [row.ref for row in rows if row.ref.casefold() not in named]
        files = ", ".join(table.file.name for table in lists)
        notes += listed(PARTS_NOT_IN_TABLE, alone, f"placed components have no row in {files}: {{}}.")
    notes += listed(PARTS_CONTRADICT, clashes, "entries of the parts tables contradict each other: {}.")
    return tuple(rows), tuple(notes)


def tables_in(path: Path) -> tuple[PartsTable, ...]:
    """Read the tables that an order holds beside its board, by their content; none where it is a file alone.

    Raises:
        BoardError: It cannot be read, or a cell of a table does not fit its column.
    """
    found: list[PartsTable] = []
    if is_archive(path):
        for name, content in sorted(read_members(path, is_table_name)[1].items()):
            with suppress(NoTableError):
                found.append(read_table(path / name, content))
    return tuple(found)


def _places(table: PartsTable) -> list[Row]:
    return [row for row in table.rows if row.xy_mm is not None]


def _merge(row: Row, other: Row, clashes: list[str]) -> Row:
    """Fill what a row leaves open from another of the same designator."""
    if row.side and other.side and row.side != other.side:
        clashes.append(f"{row.ref} side {row.side} and {other.side} (the first is taken)")
    if row.xy_mm and other.xy_mm and np.hypot(*np.subtract(row.xy_mm, other.xy_mm)) > NEAR_MM:
        clashes.append(f"{row.ref} at two places (the first is taken)")
    finer = max((row.package, other.package), key=_fineness)
    return replace(
        row,
        package=finer,
        value=row.value or other.value,
        part=row.part or other.part,
        pins=other.pins if row.pins is None else row.pins,
        gap_height_mm=other.gap_height_mm if row.gap_height_mm is None else row.gap_height_mm,
        height_mm=other.height_mm if row.height_mm is None else row.height_mm,
        side=row.side or other.side,
        xy_mm=row.xy_mm or other.xy_mm,
        turn_deg=other.turn_deg if row.turn_deg is None else row.turn_deg,
        is_fitted=row.is_fitted and other.is_fitted,
    )


def _fineness(package: str) -> tuple[bool, bool, bool]:
    return (
        bool(package) and package_sizes(package).body_mm is not None,
        package_family(package) is not None,
        bool(package),
    )


def _in_unit(table: PartsTable, board: Reference, notes: list[Finding]) -> PartsTable:
    """Read places whose unit is not stated in the one under which they fit the parts or the board."""
    placed = _places(table)
    if table.states_unit or not placed:
        return table
    places = np.array([row.xy_mm for row in placed], dtype=np.float64)
    named = [
        (place, board.centres[row.ref.casefold()])
        for place, row in enumerate(placed)
        if row.ref.casefold() in board.centres
    ]
    if len(named) > 1:
        at, centres = places[[place for place, _ in named]], np.array([each for _, each in named])
        if np.ptp(centres, axis=0).max() <= NEAR_MM:
            return table
        errors = [round(fit_pairs(at * unit_mm, centres).error_mm, 2) for _, unit_mm in _UNITS]
        fitting = [_UNITS[int(np.argmin(errors))]] if min(errors) <= NEAR_MM else []
        reason = f"so {len(named)} of them lie on their components"
    else:
        fitting = [unit for unit in _UNITS if _can_be(places * unit[1], board.box)]
        reason = "in other units they do not fit the board"
    if len(fitting) > 1:
        first, second = (f"{name} ({_spread(places * unit_mm)})" for name, unit_mm in fitting[:2])
        width, depth = np.ptp(board.box, axis=0)
        text = (
            f"{table.file.name} states no unit for its places: {first} and {second} both fit the board of "
            f"{width:.1f} x {depth:.1f} mm. {fitting[0][0]} is taken; state the unit in the title of the column, as "
            "X(mm) or X(mil)."
        )
        notes.append(Finding(PARTS_UNIT, text))
    name, unit_mm = fitting[0] if fitting else _UNITS[0]
    if unit_mm == 1.0:
        return table
    if len(fitting) == 1:
        text = f"The places in {table.file.name} are read as {name}, which it does not state: {reason}."
        notes.append(Finding(UNIT_GUESSED, text))
    rows = (
        replace(row, xy_mm=None if row.xy_mm is None else (row.xy_mm[0] * unit_mm, row.xy_mm[1] * unit_mm))
        for row in table.rows
    )
    return replace(table, rows=tuple(rows))


def _can_be(places: Points2, box: Points2) -> bool:
    """Whether places can be those of parts: not wider spread than the board, and no heap of parts upon each other."""
    board, spread = np.ptp(box, axis=0), np.ptp(places, axis=0)
    if bool((spread > board + _BEYOND_MM).any() and (spread > board[::-1] + _BEYOND_MM).any()):
        return False
    if len(places) == 1:
        return bool(((places[0] >= box[0] - _BEYOND_MM) & (places[0] <= box[1] + _BEYOND_MM)).all())
    apart = np.asarray(KDTree(places).query(places, k=2)[0])[:, 1]
    return bool(spread.max() >= _HEAP * board.max()) or float(np.median(apart)) >= _APART_MM


def _spread(places: Points2) -> str:
    width, depth = np.ptp(places, axis=0)
    return f"spread over {width:.1f} x {depth:.1f} mm"
