"""Several tables of one board, joined by designator, with places in the unit under which they fit the board."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree

from boards.board import Contradiction, SourceFile
from boards.formats.names import listed, natural_key, some
from boards.packages.families import package_family, package_sizes
from boards.parts_table.columns import COLUMNS_FILE
from boards.parts_table.fit import NEAR_MM, fit_pairs
from boards.parts_table.netlist import Netlist
from boards.parts_table.read import UNIT_NAMES, PartsTable, Row
from geometry.arrays import Points2
from specs.finding import Finding
from specs.finding_rules import PARTS_CONTRADICT, PARTS_NOT_IN_TABLE, PARTS_UNIT, UNIT_GUESSED

NOT_FITTED = "components are not fitted by the parts table and are left out: {}."
HEIGHT_MM = 0.2
"""Two statements on a height may differ by this."""
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


@dataclass(frozen=True, slots=True)
class Statements:
    """What comes with a board: tables and netlists, and what in them contradicts each other, as it is met."""

    tables: tuple[PartsTable, ...] = ()
    netlists: tuple[Netlist, ...] = ()
    heights_mm: Mapping[str, float] = field(default_factory=dict[str, float])
    """By reference designator or package."""
    others: list[SourceFile] = field(default_factory=list[SourceFile])
    """Further files: layers, and what is not read."""
    contradictions: list[Contradiction] = field(default_factory=list[Contradiction])
    units: dict[Path, str] = field(default_factory=dict[Path, str])
    """Of the places in a table whose unit is not stated in it: the one that is taken."""

    def contradict(self, row: Row, about: str, taken: tuple[str, str], other: tuple[str, str]) -> None:
        """Note two statements on a component, each with its source; the first is taken."""
        self.contradictions.append(Contradiction(row.ref, about, *taken, *other))


def contradiction_findings(found: Sequence[Contradiction]) -> list[Finding]:
    """One finding on the contradictions about each kind of statement."""
    words: dict[str, list[str]] = {}
    for each in sorted(found, key=lambda each: natural_key(each.component)):
        text = f"{each.component} {each.about} {each.taken} ({each.source}), not {each.other} ({each.other_source})"
        words.setdefault(each.about, []).append(text)
    return [
        Finding(
            PARTS_CONTRADICT, f"{len(own)} statements on {about} contradict others, which are not taken: {some(own)}."
        )
        for about, own in sorted(words.items())
    ]


def join_tables(given: Statements, board: Reference) -> tuple[tuple[Row, ...], tuple[Finding, ...]]:
    """Join tables by designator, whatever their order.

    Of two statements the first stands, those of tables with places before the others; but a package of a known size
    or family stands before another, and a part that one of the tables leaves out is not fitted.
    """
    notes: list[Finding] = []
    in_units = (_in_unit(table, board, notes, given.units) for table in given.tables)
    tables = sorted(in_units, key=lambda table: not _places(table))
    rows: list[Row] = []
    known: dict[str, list[int]] = {}
    for table in tables:
        before = {name: list(places) for name, places in known.items()}
        for row in table.rows:
            name = row.ref.casefold()
            for place in before.get(name, ()):  # on a panel a designator is placed several times
                rows[place] = _merge(rows[place], row, given)
            if name not in before:
                known.setdefault(name, []).append(len(rows))
                rows.append(row)
    lists = [table for table in tables if not _places(table)]
    if 0 < len(lists) < len(tables):
        named = {row.ref.casefold() for table in lists for row in table.rows}
        alone = [row.ref for row in rows if row.ref.casefold() not in named]
        files = ", ".join(table.file.name for table in lists)
        notes += listed(PARTS_NOT_IN_TABLE, alone, f"placed components have no row in {files}: {{}}.")
    return tuple(rows), tuple(notes)


def spread_rows(rows: Sequence[Row], copies: Mapping[str, Sequence[str]]) -> tuple[Row, ...]:
    """Give each copy of a component on a panel a row of its own.

    Rows of one designator with places are those of its copies in the order of their places. Else a row holds for all.

    Args:
        rows: Of tables that were joined.
        copies: By designator in small letters, the names of its copies in the order of their places.
    """
    own: dict[str, list[int]] = {}
    for number, row in enumerate(rows):
        own.setdefault(row.ref.casefold(), []).append(number)
    result: dict[int, list[Row]] = {}
    for ref, numbers in own.items():
        names = copies.get(ref, ())
        first = numbers[0]
        placed = [number for number in numbers if rows[number].xy_mm is not None]
        if len(placed) > 1:
            placed.sort(key=lambda number: np.round(rows[number].xy_mm or (0.0, 0.0), 3).tolist())
            base = rows[first].ref
            called = (
                names if len(names) == len(placed) else [base, *(f"{base}-{n + 2}" for n in range(len(placed) - 1))]
            )
            for number, name in zip(placed, called, strict=True):
                result[number] = [replace(rows[number], ref=name)]
        else:
            bare = [replace(rows[first], ref=name, xy_mm=None, turn_deg=None) for name in names[1:]]
            result[first] = [replace(rows[first], ref=(names or [rows[first].ref])[0]), *bare]
            result |= {number: [rows[number]] for number in numbers[1:]}
    return tuple(row for number in sorted(result) for row in result[number])


def _places(table: PartsTable) -> list[Row]:
    return [row for row in table.rows if row.xy_mm is not None]


def _merge(row: Row, other: Row, given: Statements) -> Row:
    """Fill what a row leaves open from another of the same designator."""
    if row.side and other.side and row.side != other.side:
        given.contradict(row, "side", (row.side, row.source("side")), (other.side, other.file))
    if row.xy_mm and other.xy_mm and np.hypot(*np.subtract(row.xy_mm, other.xy_mm)) > NEAR_MM:
        first, second = (f"({x:.2f}, {y:.2f})" for x, y in (row.xy_mm, other.xy_mm))
        given.contradict(row, "place", (first, row.source("xy_mm")), (second, other.file))
    if row.height_mm and other.height_mm and abs(row.height_mm - other.height_mm) > HEIGHT_MM:
        first, second = (f"{mm:g} mm" for mm in (row.height_mm, other.height_mm))
        given.contradict(row, "height", (first, row.source("height_mm")), (second, other.file))
    keys = ("value", "part", "pins", "gap_height_mm", "height_mm", "side", "xy_mm", "turn_deg")
    filled = {key: getattr(other, key) for key in keys if getattr(row, key) in (None, "")}
    return replace(
        row,
        **filled,
        package=max((row.package, other.package), key=fineness),
        is_fitted=row.is_fitted and other.is_fitted,
        merged={
            **dict.fromkeys((key for key, value in filled.items() if value not in (None, "")), other.file),
            **row.merged,
        },
    )


def fineness(package: str) -> tuple[bool, bool, bool]:
    """Order of packages by what their names state: a size, a family, anything."""
    return (
        bool(package) and package_sizes(package).body_mm is not None,
        package_family(package) is not None,
        bool(package),
    )


def _in_unit(table: PartsTable, board: Reference, notes: list[Finding], units: dict[Path, str]) -> PartsTable:
    """Read places whose unit is not stated in the one under which they fit the parts or the board."""
    placed = _places(table)
    if table.unit or not placed:
        return table
    places = np.array([row.xy_mm for row in placed], dtype=np.float64)
    counts = Counter(row.ref.casefold() for row in placed)
    named = [
        (place, board.centres[ref])
        for place, row in enumerate(placed)
        if (ref := row.ref.casefold()) in board.centres and counts[ref] == 1
    ]
    if len(named) > 1:
        at, centres = places[[place for place, _ in named]], np.array([each for _, each in named])
        if np.ptp(centres, axis=0).max() <= NEAR_MM:
            return table
        errors = [round(fit_pairs(at * unit_mm, centres).error_mm, 2) for unit_mm in UNIT_NAMES]
        fitting = [[*UNIT_NAMES][int(np.argmin(errors))]] if min(errors) <= NEAR_MM else []
        reason = f"so {len(named)} of them lie on their components"
    else:
        fitting = [unit_mm for unit_mm in UNIT_NAMES if _can_be(places * unit_mm, board.box)]
        reason = "in other units they do not fit the board"
    if len(fitting) > 1:
        first, second = (f"{UNIT_NAMES[unit_mm]} ({_spread(places * unit_mm)})" for unit_mm in fitting[:2])
        width, depth = np.ptp(board.box, axis=0)
        text = (
            f"{table.file.name} states no unit for its places: {first} and {second} both fit the board of "
            f"{width:.1f} x {depth:.1f} mm. {UNIT_NAMES[fitting[0]]} is taken; state `unit: {UNIT_NAMES[fitting[0]]}` "
            f"or `unit: {UNIT_NAMES[fitting[1]]}` in {COLUMNS_FILE} beside the board."
        )
        notes.append(Finding(PARTS_UNIT, text))
    unit_mm = fitting[0] if fitting else 1.0
    name = UNIT_NAMES[unit_mm]
    units[table.file] = f"{name} ({'one of two that fit' if len(fitting) > 1 else 'fits' if fitting else 'assumed'})"
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
