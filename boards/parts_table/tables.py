"""Several tables of one board, joined by designator, with places in the unit under which they fit the board."""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree

from boards.board import Contradiction, SourceFile
from boards.bounds import FARTHEST_MM
from boards.errors import Line
from boards.formats.names import listed, natural_key, some
from boards.packages.families import package_family, package_sizes, plan_size
from boards.parts_table.columns import COLUMNS_FILE
from boards.parts_table.fit import NEAR_MM, fit_pairs
from boards.parts_table.netlist import Netlist
from boards.parts_table.read import PartsTable, Row
from boards.parts_table.words import UNIT_NAMES, UNITS_MM, letters
from geometry.arrays import Points2
from specs.finding import Finding
from specs.finding_rules import (
    PARTS_CONTRADICT,
    PARTS_NOT_FITTED,
    PARTS_NOT_IN_TABLE,
    PARTS_NOT_ON_BOARD,
    PARTS_TABLES,
    PARTS_UNIT,
    UNIT_GUESSED,
)

HEIGHT_MM = 0.2
"""Two statements on a height may differ by this."""
_BEYOND_MM = 5.0
"""Places of parts may spread that much wider than the board."""
_HEAP = 0.1
"""Places that spread over a smaller part of the board are a heap."""
_SAME_PLAN_MM, _SAME_DEG = 0.3, 1.0
_SHOWN = 0.5
"""Part of the contradicting places of a table that lie on copper, which shows that it is the one that is meant."""
_APART_MM = 1.5
"""Neighbours in a heap are typically farther apart than this if its unit is right."""


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """What a table's places are compared with. Frame of the board, mm."""

    centres: Mapping[str, Points2]
    """(2,) of the parts whose names are known, by their names in small letters."""
    box: Points2
    """Least and largest corner of the board (2, 2)."""
    on_pads: Callable[[Sequence[Row]], Sequence[bool]] | None = None
    """Which rows have the pads of their parts around their places; ``None`` where pads are named or not known."""

    def lie(self, rows: Sequence[Row]) -> list[bool]:
        """Which rows lie on their parts, by name or else on copper."""
        on_pads = [False] * len(rows) if self.on_pads is None else self.on_pads(rows)
        centres = [self.centres.get(row.ref.casefold()) for row in rows]
        return [
            bool(pads) if at is None else bool(np.hypot(*np.subtract(row.xy_mm or (np.inf, np.inf), at)) <= NEAR_MM)
            for row, at, pads in zip(rows, centres, on_pads, strict=True)
        ]


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
    tables = sorted(_in_units(given, board, notes), key=lambda table: not _places(table))
    tables = _best_first(tables, board, notes)
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


def files_of(rows: Sequence[Row], key: str = "ref") -> str:
    """Tables that state a value of rows."""
    return some(list(dict.fromkeys(file for row in rows if (file := row.source(key))))) or "the parts table"


def not_fitted(rows: Sequence[Row], names: Sequence[str]) -> list[Finding]:
    """One finding on rows that are not fitted, by what their components are called."""
    text = f"components are not fitted by {files_of(rows, 'fitted')} and are left out: {{}}."
    return listed(PARTS_NOT_FITTED, names, text)


def not_on_board(lost: Sequence[str], rows: Sequence[Row]) -> list[Finding]:
    """One finding on rows without a component; an error where no row has one: the tables are of another board."""
    names = {*lost}
    text = f"rows of {files_of([row for row in rows if row.ref in names])} are not on the board: {{}}."
    if len(lost) < len(rows):
        return listed(PARTS_NOT_ON_BOARD, lost, text)
    found = listed(PARTS_NOT_ON_BOARD, lost, f"{text} No row has a component: is a placement table missing, or is the "
                                             "board another one?")  # fmt: skip
    return [replace(each, override="error") for each in found]


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
        if len(numbers) == 1 and not names:
            result[first] = [rows[first]]
            continue
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


def _best_first(tables: list[PartsTable], board: Reference, notes: list[Finding]) -> list[PartsTable]:
    """Put the table first whose places lie on the parts, where several place the same components otherwise."""
    at: dict[str, dict[str, Row]] = {}
    for table in tables:
        counts = Counter(row.ref.casefold() for row in _places(table))
        for row in _places(table):
            if counts[row.ref.casefold()] == 1:
                at.setdefault(row.ref.casefold(), {})[table.file.name] = row
    apart = {ref: own for ref, own in at.items() if any(_is_apart(*pair) for pair in combinations(own.values(), 2))}
    files = list(dict.fromkeys(name for own in apart.values() for name in own))
    if len(files) < 2:
        return tables
    rows = {name: [own[name] for own in apart.values() if name in own] for name in files}
    shares = {name: sum(board.lie(own)) / len(own) for name, own in rows.items()}
    first, second = sorted(files, key=lambda name: -shares[name])[:2]
    is_shown = shares[first] > 2.0 * shares[second] and shares[first] >= _SHOWN
    text = f"{' and '.join(files)} place {len(apart)} of {len(at)} components otherwise: {_places_of(apart)}. "
    if is_shown:
        text += f"{first} is taken, whose places lie on their pads; `tables` in {COLUMNS_FILE} states another choice."
    else:
        one, other = ([table.file.name for table in tables if table.file.name not in {*files} - {name}] for name in
                      (first, second))  # fmt: skip
        text += (
            f"{first} is taken; state `tables: [{', '.join(one)}]` or `tables: [{', '.join(other)}]` in {COLUMNS_FILE} "
            "beside the order, or give one of them with --parts."
        )
    notes.append(Finding(PARTS_TABLES, text, override="warning" if is_shown else None))
    return sorted(tables, key=lambda table: (not _places(table), -shares.get(table.file.name, 1.0)))


def _is_apart(one: Row, other: Row) -> bool:
    return np.hypot(*np.subtract(one.xy_mm or (0.0, 0.0), other.xy_mm or (0.0, 0.0))) > NEAR_MM


def _places_of(apart: Mapping[str, Mapping[str, Row]]) -> str:
    """Where the first of components lies by each table."""
    own = min(apart.values(), key=lambda own: natural_key(next(iter(own.values())).ref))
    words = ("({:.2f}, {:.2f}) in {}".format(*(row.xy_mm or (0.0, 0.0)), name) for name, row in own.items())
    return f"{next(iter(own.values())).ref} {', '.join(words)}"


def _places(table: PartsTable) -> list[Row]:
    return [row for row in table.rows if row.xy_mm is not None]


def _merge(row: Row, other: Row, given: Statements) -> Row:
    """Fill what a row leaves open from another of the same designator."""
    if row.side and other.side and row.side != other.side:
        given.contradict(row, "side", (row.side, row.source("side")), (other.side, other.file))
    if row.xy_mm and other.xy_mm and np.hypot(*np.subtract(row.xy_mm, other.xy_mm)) > NEAR_MM:
        first, second = (f"({x:z.2f}, {y:z.2f})" for x, y in (row.xy_mm, other.xy_mm))
        given.contradict(row, "place", (first, row.source("xy_mm")), (second, other.file))
    if row.height_mm and other.height_mm and abs(row.height_mm - other.height_mm) > HEIGHT_MM:
        first, second = (f"{mm:g} mm" for mm in (row.height_mm, other.height_mm))
        given.contradict(row, "height", (first, row.source("height_mm")), (second, other.file))
    if _turns_differ(row, other):
        first, second = (f"{deg:g} degrees" for deg in (row.turn_deg, other.turn_deg))
        given.contradict(row, "turn", (first, row.source("turn_deg")), (second, other.file))
    for key in ("value", "part"):
        first, second = (getattr(each, key) for each in (row, other))
        if first and second and letters(first) not in letters(second) and letters(second) not in letters(first):
            given.contradict(row, key, (first, row.source(key)), (second, other.file))
    sizes = plan_size(row.package), plan_size(other.package)
    if sizes[0] is not None and sizes[1] is not None and not np.allclose(sizes[0], sizes[1], atol=_SAME_PLAN_MM):
        taken, left = sorted((row, other), key=lambda each: fineness(each.package), reverse=True)
        given.contradict(row, "package", (taken.package, taken.source("package")), (left.package, left.file))
    if row.states_fitted and other.states_fitted and row.is_fitted != other.is_fitted:
        out, fitted = (row, other) if not row.is_fitted else (other, row)
        given.contradict(row, "fitted", ("not fitted", out.source("fitted")), ("fitted", fitted.source("fitted")))
    keys = ("value", "part", "pins", "gap_height_mm", "height_mm", "side", "xy_mm", "turn_deg")
    filled = {key: getattr(other, key) for key in keys if getattr(row, key) in (None, "")}
    return replace(
        row,
        **filled,
        package=max((row.package, other.package), key=fineness),
        is_fitted=row.is_fitted and other.is_fitted,
        states_fitted=row.states_fitted or other.states_fitted,
        merged={
            **dict.fromkeys((key for key, value in filled.items() if value not in (None, "")), other.file),
            **({"fitted": other.file} if other.states_fitted and not row.states_fitted else {}),
            **({"package": other.file} if fineness(other.package) > fineness(row.package) else {}),
            **row.merged,
        },
    )


def _turns_differ(one: Row, other: Row) -> bool:
    """Whether two rows of one place state other turns."""
    if one.xy_mm is None or other.xy_mm is None or one.turn_deg is None or other.turn_deg is None:
        return False
    return abs(math.remainder(one.turn_deg - other.turn_deg, 360.0)) > _SAME_DEG and not _is_apart(one, other)


def fineness(package: str) -> tuple[bool, bool, bool]:
    """Order of packages by what their names state: a size, a family, anything."""
    return (
        bool(package) and package_sizes(package).body_mm is not None,
        package_family(package) is not None,
        bool(package),
    )


def _in_units(given: Statements, board: Reference, notes: list[Finding]) -> list[PartsTable]:
    """Read places in the unit under which they fit the parts or the board, where none is stated or it is not that one.

    Tables of the same titles have one unit.
    """
    result = {table.file: table for table in given.tables}
    groups: dict[tuple[str, ...], list[PartsTable]] = {}
    for table in given.tables:
        if _places(table):
            groups.setdefault((table.unit, *table.titles.values()), []).append(table)
    for tables in groups.values():
        factor = _factor(tables, board, notes, given.units)
        for table in tables if factor != 1.0 else ():
            result[table.file] = replace(table, rows=tuple(scaled(row, factor) for row in table.rows))
        for table in tables:
            for row in result[table.file].rows:
                _check_place(row, table)
    return [*result.values()]


def _check_place(row: Row, table: PartsTable) -> None:
    if row.xy_mm is not None and max(map(abs, row.xy_mm)) > FARTHEST_MM:
        raise Line(table.file, row.line).error(
            f"{row.ref} is farther than {FARTHEST_MM / 1000.0:g} m away. Correct it, or state the `unit` of the table "
            f"in {COLUMNS_FILE} beside the board."
        )


def _factor(tables: Sequence[PartsTable], board: Reference, notes: list[Finding], units: dict[Path, str]) -> float:
    """What the places of tables of one kind are multiplied with."""
    placed = [row for table in tables for row in _places(table)]
    stated = tables[0].unit
    own = UNITS_MM[stated.split()[0]] if stated else 1.0
    files = ", ".join(table.file.name for table in tables)
    factors = {unit_mm / own: name for unit_mm, name in UNIT_NAMES.items()}
    fitting, reason = _decided(placed, board, [*factors])
    if stated and (not fitting or 1.0 in fitting or not reason):
        return 1.0
    if not reason:
        places = np.array([row.xy_mm for row in placed], dtype=np.float64)
        fitting = [each for each in factors if _can_be(places * each, board.box)]
        reason = "in other units they do not fit the board"
        if len(fitting) > 1:
            first, second = (f"{factors[each]} ({_spread(places * each)})" for each in fitting[:2])
            width, depth = np.ptp(board.box, axis=0)
            text = (
                f"{files} states no unit for its places: {first} and {second} both fit the board of "
                f"{width:.1f} x {depth:.1f} mm. {factors[fitting[0]]} is taken; state `unit: {factors[fitting[0]]}` "
                f"or `unit: {factors[fitting[1]]}` in {COLUMNS_FILE} beside the board."
            )
            notes.append(Finding(PARTS_UNIT, text))
    factor = fitting[0] if fitting else 1.0
    known = "one of two that fit" if len(fitting) > 1 else "fits" if fitting else "assumed"
    units.update(dict.fromkeys((table.file for table in tables), f"{factors[factor]} ({known})"))
    if factor != 1.0 and len(fitting) == 1:
        which = f"not as {stated}" if stated else "which it does not state"
        notes.append(Finding(UNIT_GUESSED, f"The places in {files} are read as {factors[factor]}, {which}: {reason}."))
    return factor


def _decided(placed: Sequence[Row], board: Reference, factors: Sequence[float]) -> tuple[list[float], str]:
    """Factor under which places lie on their parts, by their names or else on copper, and why; nothing without."""
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
            return [1.0], "their parts are in one place"
        errors = [round(fit_pairs(at * each, centres).error_mm, 2) for each in factors]
        fitting = [factors[int(np.argmin(errors))]] if min(errors) <= NEAR_MM else []
        return fitting, f"so {len(named)} of them lie on their components"
    if board.on_pads is not None and len(placed) > 1:
        hits = [sum(board.on_pads([scaled(row, each) for row in placed])) for each in factors]
        best, *rest = sorted(hits, reverse=True)
        if best > 1 and best > 2 * rest[0] and 2 * best > len(placed):
            return [factors[hits.index(best)]], f"so {best} of them lie on the pads of their parts"
    return [], ""


def scaled(row: Row, factor: float) -> Row:
    """A row whose place is multiplied."""
    return row if row.xy_mm is None else replace(row, xy_mm=(row.xy_mm[0] * factor, row.xy_mm[1] * factor))


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
