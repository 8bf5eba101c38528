"""Join a parts table to the bodies of a board."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from boards.board import Body, Side
from boards.formats.names import some
from boards.formats.prism import NOMINAL_HEIGHT
from boards.parts_table.fit import Fit, assign, centre, fit_pairs, fit_points
from boards.parts_table.read import Row, read_table
from specs.finding import Finding
from specs.finding_rules import (
    PARTS_BY_POSITION,
    PARTS_CONTRADICT,
    PARTS_FRAME,
    PARTS_NOT_IN_TABLE,
    PARTS_NOT_ON_BOARD,
    PARTS_POSITION,
)

_REFERENCE = re.compile(r"[A-Za-z]{1,4}\d+[A-Za-z]?")
"""What a reference designator looks like; a body of another name takes that of its row."""

_HEIGHT_MM = 0.2
"""A drawn height may differ from the table's by this, or by a tenth."""


@dataclass(frozen=True, slots=True)
class _Slab:
    """Lower and upper face of the board, mm."""

    low: float
    high: float


def join_parts(bodies: Sequence[Body], table: Path) -> tuple[tuple[Body, ...], tuple[Finding, ...]]:
    """Fill the bodies' attributes from a table of placements or a bill of materials.

    Rows join components by name (in any case), the rest by position: nearest centre of the same side, the position
    within 1 mm of it or within the body's outline, one to one. Whether the table is mirrored, turned or shifted is
    found first. What the table states wins over the file; a contradiction is a warning. A height in the table
    replaces a nominal one (``x-height``) and is compared with a drawn one.

    Args:
        bodies: Every body of the board, board included.
        table: CSV, TSV, semicolons, or KiCad's ``.pos``.

    Returns:
        The bodies in their order, and what was noticed.

    Raises:
        BoardError: The table cannot be read.
    """
    rows = read_table(table)
    slab = _slab(bodies)
    parts = [number for number, body in enumerate(bodies) if body.role == "component"]
    joined = _join_names(rows, bodies, parts)
    notes: list[Finding] = []
    by_place = _join_places(rows, bodies, [number for number in parts if number not in joined.values()], joined, notes)
    result = list(bodies)
    clashes: list[str] = []
    for row, number in sorted({**joined, **by_place}.items()):
        result[number] = _fill(bodies[number], rows[row], slab, clashes)
    if by_place:
        result = _rename(result, {number: rows[row].ref for row, number in by_place.items()})
        pairs = [f"{rows[row].ref} = {bodies[number].name}" for row, number in sorted(by_place.items())]
        notes.append(Finding(PARTS_BY_POSITION, f"{len(pairs)} rows joined by position: {some(pairs)}."))
    taken = {*joined.values(), *by_place.values()}
    notes.extend(
        _unmatched(rows, [*joined, *by_place], [bodies[number].name for number in parts if number not in taken])
    )
    if clashes:
        text = f"{len(clashes)} entries of the parts table contradict the board file: {some(clashes)}."
        notes.append(Finding(PARTS_CONTRADICT, text))
    return tuple(result), tuple(notes)


def _slab(bodies: Sequence[Body]) -> _Slab:
    heights = [body.patches[:, :, 2] for body in bodies if body.role == "board"] or [np.zeros(1)]
    return _Slab(float(heights[0].min()), float(heights[0].max()))


def _join_names(rows: Sequence[Row], bodies: Sequence[Body], parts: Sequence[int]) -> dict[int, int]:
    """Row to body by name; the first of two rows with one reference."""
    exact = {bodies[number].name: number for number in reversed(parts)}
    loose = {name.casefold(): number for name, number in exact.items()}
    joined: dict[int, int] = {}
    free = set(parts)
    for place, row in enumerate(rows):
        number = exact.get(row.ref, loose.get(row.ref.casefold()))
        if number in free:
            joined[place] = number
            free.remove(number)
    return joined


def _unmatched(rows: Sequence[Row], joined: Iterable[int], left: Sequence[str]) -> list[Finding]:
    """Say what found no partner, both ways."""
    known = set(joined)
    lost = [row.ref for place, row in enumerate(rows) if place not in known]
    notes: list[Finding] = []
    if lost:
        text = f"{len(lost)} rows of the parts table are not on the board: {some(lost)}."
        notes.append(Finding(PARTS_NOT_ON_BOARD, text))
    if left:
        text = f"{len(left)} components are not in the parts table: {some(left)}."
        notes.append(Finding(PARTS_NOT_IN_TABLE, text))
    return notes


def _join_places(
    rows: Sequence[Row], bodies: Sequence[Body], free: Sequence[int], joined: dict[int, int], notes: list[Finding]
) -> dict[int, int]:
    """Row to body by position, each side of the table on its own: programs mirror the bottom alone."""
    found: dict[int, int] = {}
    middle = _slab(bodies)
    for side in ("top", "bottom", None):
        placed = [place for place, row in enumerate(rows) if row.xy_mm is not None and row.side == side]
        open_rows = [place for place in placed if place not in joined]
        named = [place for place in placed if place in joined]
        here = [
            number
            for number in free
            if number not in found.values() and (side is None or _side(bodies[number], middle) == side)
        ]
        fit = _fit(rows, bodies, named, joined, open_rows, here)
        if fit is None:
            if open_rows and here:
                text = f"{len(open_rows)} positions of the parts table fit no arrangement of the components of the "
                notes.append(Finding(PARTS_POSITION, f"{text}{side or 'board'}: not joined by position."))
            continue
        notes.extend(_say_fit(fit, side, rows, bodies, {place: joined[place] for place in named}))
        for place, number in assign(fit.apply(_positions(rows, open_rows)), [bodies[number] for number in here]):
            found[open_rows[place]] = here[number]
    return found


def _fit(
    rows: Sequence[Row],
    bodies: Sequence[Body],
    named: Sequence[int],
    joined: dict[int, int],
    open_rows: Sequence[int],
    here: Sequence[int],
) -> Fit | None:
    """By the rows whose component is known if there are three, else by voting."""
    if len(named) >= 3 or (named and not open_rows):
        centres = np.array([centre(bodies[joined[place]]) for place in named])
        return fit_pairs(_positions(rows, named), centres)
    if not open_rows or not here:
        return None
    return fit_points(_positions(rows, open_rows), np.array([centre(bodies[number]) for number in here]))


def _positions(rows: Sequence[Row], places: Sequence[int]) -> np.ndarray:
    return np.array([rows[place].xy_mm or (0.0, 0.0) for place in places], dtype=np.float64).reshape(-1, 2)


def _say_fit(
    fit: Fit, side: Side | None, rows: Sequence[Row], bodies: Sequence[Body], named: dict[int, int]
) -> list[Finding]:
    """Say how the table was laid on the board, and which named components it has somewhere else."""
    notes: list[Finding] = []
    words = fit.describe()
    if words:
        where = f" of the {side}" if side else ""
        notes.append(Finding(PARTS_FRAME, f"The positions{where} in the parts table were {words}."))
    mapped = fit.apply(_positions(rows, list(named)))
    hits = {place for place, _ in assign(mapped, [bodies[number] for number in named.values()])} if named else set()
    away = [rows[place].ref for count, place in enumerate(named) if count not in hits]
    if away:
        text = f"{len(away)} components lie elsewhere in the parts table than on the board: {some(away)}."
        notes.append(Finding(PARTS_POSITION, f"{text} Check that it is of the same revision."))
    return notes


def _side(body: Body, slab: _Slab) -> Side:
    """Side that is stated, else where the body lies."""
    if body.side is not None:
        return body.side
    return _lies(body, slab)


def _lies(body: Body, slab: _Slab) -> Side:
    heights = body.patches[:, :, 2]
    return "top" if heights.max() - slab.high >= slab.low - heights.min() else "bottom"


def _rename(bodies: Sequence[Body], refs: dict[int, str]) -> list[Body]:
    """Give a body without a reference designator that of its row, unless another body has it."""
    taken = {body.name for body in bodies}
    result = list(bodies)
    for number, ref in refs.items():
        if not _REFERENCE.fullmatch(bodies[number].name) and ref not in taken:
            result[number] = replace(result[number], name=ref)
            taken.add(ref)
    return result


def _fill(body: Body, row: Row, slab: _Slab, clashes: list[str]) -> Body:
    """Take over what the row states."""
    stated = (
        ("package", body.package, row.package or None),
        ("part", body.part, row.part or None),
        ("value", body.value, row.value or None),
        ("pins", body.pins, row.pins),
        ("standoff_mm", body.gap_height_mm, row.gap_height_mm),
    )
    for key, before, value in stated:
        if value is not None and before is not None and _plain(before) != _plain(value):
            clashes.append(f"{row.ref} {key} {before} → {value} (taken)")
    body = replace(
        body,
        package=row.package or body.package,
        part=row.part or body.part,
        value=row.value or body.value,
        pins=body.pins if row.pins is None else row.pins,
        gap_height_mm=body.gap_height_mm if row.gap_height_mm is None else row.gap_height_mm,
    )
    return _fill_height(_fill_side(body, row, slab, clashes), row, slab, clashes)


def _plain(value: str | float) -> str | float:
    return value.casefold().strip() if isinstance(value, str) else round(float(value), 4)


def _fill_side(body: Body, row: Row, slab: _Slab, clashes: list[str]) -> Body:
    """A side that the drawn body contradicts would put it into the board: where it lies wins then."""
    if row.side is None or row.side == body.side:
        return body
    if _lies(body, slab) != row.side:
        clashes.append(f"{row.ref} side {row.side}, the body is on the {_lies(body, slab)} (kept)")
        return replace(body, side=_lies(body, slab))
    if body.side is not None:
        clashes.append(f"{row.ref} side {body.side} → {row.side} (taken)")
    return replace(body, side=row.side)


def _fill_height(body: Body, row: Row, slab: _Slab, clashes: list[str]) -> Body:
    """Stretch a body of nominal height to what the table states; compare a drawn one."""
    heights = body.patches[:, :, 2]
    up = _lies(body, slab) == "top"
    far = float(heights.max()) - slab.high if up else slab.low - float(heights.min())
    near = float(heights.min()) - slab.high if up else slab.low - float(heights.max())
    nominal = any(key == NOMINAL_HEIGHT for key, _ in body.extra)
    if not nominal:
        if row.height_mm is not None and abs(row.height_mm - far) > max(_HEIGHT_MM, 0.1 * far):
            clashes.append(f"{row.ref} height {row.height_mm:g} mm, drawn {far:.2f} mm (kept)")
        return body
    low = near if row.gap_height_mm is None else row.gap_height_mm
    high = far if row.height_mm is None or row.height_mm <= 0.0 else row.height_mm
    low = low if low < high else 0.0
    share = (heights - slab.high if up else slab.low - heights) - near
    stretched = low + share * (high - low) / (far - near)
    patches = body.patches.copy()
    patches[:, :, 2] = slab.high + stretched if up else slab.low - stretched
    extra = body.extra if row.height_mm is None else tuple(pair for pair in body.extra if pair[0] != NOMINAL_HEIGHT)
    return replace(body, patches=patches, extra=extra)
