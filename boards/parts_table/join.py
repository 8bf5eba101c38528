"""Join a parts table to the bodies of a board: by name, and by where its positions lie on the board."""

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from boards.board import NOMINAL_HEIGHT, STATED_HEIGHT, UNFITTED, Body, Side
from boards.formats.names import copy_marks, listed
from boards.packages.heights import HeightEvidence, checked_height
from boards.parts_table.columns import COLUMNS_FILE
from boards.parts_table.fit import NEAR_MM, fit_pairs, fit_points
from boards.parts_table.read import Row
from boards.parts_table.tables import (
    HEIGHT_MM,
    Reference,
    Statements,
    files_of,
    fineness,
    join_tables,
    not_fitted,
    not_on_board,
    spread_rows,
)
from boards.parts_table.turns import TurnedPart, judge_turns
from geometry.arrays import Points2
from specs.finding import Finding
from specs.finding_rules import (
    PARTS_BY_POSITION,
    PARTS_FRAME,
    PARTS_NOT_IN_TABLE,
    PARTS_NOT_ON_BOARD,
    PARTS_POSITION,
)

_REFERENCE = re.compile(r"[A-Za-z]{1,4}\d+[A-Za-z]?")
"""What a reference designator looks like; a body of another name takes that of its row."""

_BOARD = "board"
"""What its file states or draws, as a source."""


@dataclass(frozen=True, slots=True)
class Slab:
    """Lower and upper face of the board, mm."""

    low: float
    high: float

    def side_of(self, body: Body) -> Side:
        """Side on which a body lies."""
        return "top" if self.height_of(body, "top") >= self.height_of(body, "bottom") else "bottom"

    def height_of(self, body: Body, side: Side) -> float:
        """How far a body reaches above the surface of a side."""
        heights = body.patches[:, :, 2]
        return float(heights.max()) - self.high if side == "top" else self.low - float(heights.min())


def slab_of(bodies: Sequence[Body]) -> Slab:
    """Faces of the bare board among bodies."""
    heights = next((body.patches[:, :, 2] for body in bodies if body.role == "board"), np.zeros(1))
    return Slab(float(heights.min()), float(heights.max()))


def join_parts(bodies: Sequence[Body], given: Statements) -> tuple[tuple[Body, ...], tuple[Finding, ...]]:
    """Fill the bodies' attributes from tables of placements and bills of materials.

    Rows join components by name (in any case), the rest by position: nearest centre of the same side, the position
    within 1 mm of it or within the body's outline, one to one. Whether the table is mirrored, turned or shifted is
    found first. What the table states wins over the file; a contradiction is a warning. A height in the table
    replaces a nominal one (``x-height``) and is compared with a drawn one.

    Args:
        bodies: Every body of the board, board included.
        given: Tables of placements and bills of materials; what contradicts the board is added to it.

    Returns:
        The bodies in their order, and what was noticed.
    """
    named = {body.name.casefold(): centre(body) for body in bodies if body.role == "component"}
    plan = np.concatenate(
        [body.patches[:, :, :2].reshape(-1, 2) for body in bodies if body.role == "board"] or [[[0.0, 0.0]]]
    )
    rows, noticed = join_tables(given, Reference(named, np.array([plan.min(axis=0), plan.max(axis=0)])))
    rows = spread_rows(rows, _copies(bodies, {row.ref.casefold() for row in rows}))
    slab = slab_of(bodies)
    parts = {number: body for number, body in enumerate(bodies) if body.role == "component"}
    joined = _join_names(rows, parts)
    by_place, notes = _join_places(rows, parts, joined, slab)
    result = list(bodies)
    for row, number in sorted({**joined, **by_place}.items()):
        result[number] = fill_row(bodies[number], rows[row], slab, given)
    taken = {body.name for body in bodies}
    for row, number in by_place.items():  # a body whose name is no reference designator takes that of its row
        ref = rows[row].ref
        if not _REFERENCE.fullmatch(bodies[number].name) and ref not in taken:
            result[number] = replace(result[number], name=ref)
            taken.add(ref)
    pairs = [f"{rows[row].ref} = {bodies[number].name}" for row, number in sorted(by_place.items())]
    found = {*joined.values(), *by_place.values()}
    unmounted = not_mounted(bodies)
    for row in rows:
        if row.is_fitted and row.states_fitted and row.ref.casefold() in unmounted:
            given.contradict(row, "fitted", ("not fitted", _BOARD), ("fitted", row.source("fitted")))
    lost = [
        row.ref
        for place, row in enumerate(rows)
        if place not in joined and place not in by_place and row.is_fitted and row.ref.casefold() not in unmounted
    ]
    left = [body.name for number, body in parts.items() if number not in found]
    turned = [
        TurnedPart(
            replace(rows[row], ref=body.name, package=body.package or rows[row].package),
            body.side or slab.side_of(body),
            tuple(("", pad) for pad in body.pads),
            math.radians(turn),
        )
        for row, number in sorted({**joined, **by_place}.items())
        if (body := result[number]).pads and (turn := rows[row].turn_deg) is not None
    ]
    unnamed = [ref for each in given.netlists for ref in each.names(taken).values() if ref not in taken]
    out = {number: rows[row] for row, number in {**joined, **by_place}.items() if not rows[row].is_fitted}
    return tuple(body for number, body in enumerate(result) if number not in out), (
        *noticed,
        *notes,
        *judge_turns(turned, given)[1],
        *listed(PARTS_NOT_ON_BOARD, unnamed, "components that the netlist names are not on the board: {}."),
        *not_fitted(list(out.values()), [result[number].name for number in out]),
        *listed(
            PARTS_BY_POSITION, pairs, f"rows of {files_of([rows[row] for row in by_place])} joined by position: {{}}."
        ),
        *not_on_board(lost, [row for row in rows if row.is_fitted]),
        *listed(PARTS_NOT_IN_TABLE, left, f"components are not in {files_of(rows)}: {{}}."),
    )


def not_mounted(bodies: Sequence[Body]) -> set[str]:
    """Components that the file of a board states not to be fitted, in small letters; those of copies by either name."""
    marks = (value for body in bodies if body.role == "board" for key, value in body.extra if key == UNFITTED)
    names = [name for value in marks for name in value.split(";")]
    return {each.casefold() for name in names for each in (name, *(plain for _, plain in copy_marks(name)))}


def _copies(bodies: Sequence[Body], stated: set[str]) -> dict[str, list[str]]:
    """Names of the copies of each stated component: of repeated names, and those to which tools add a number."""
    names = [body.name for body in bodies if body.role == "component"]
    found: dict[str, list[str]] = {}
    for name in names:
        bases = [name, *(plain for _, plain in copy_marks(name))]
        base = next((each.casefold() for each in bases if each.casefold() in stated), None)
        if base is not None:
            found.setdefault(base, []).append(name)
    return found


def _join_names(rows: Sequence[Row], parts: dict[int, Body]) -> dict[int, int]:
    """Row to body by name; the first of two rows with one reference."""
    exact = {body.name: number for number, body in reversed(parts.items())}
    loose = {name.casefold(): number for name, number in exact.items()}
    joined: dict[int, int] = {}
    free = set(parts)
    for place, row in enumerate(rows):
        number = exact.get(row.ref, loose.get(row.ref.casefold()))
        if number in free:
            joined[place] = number
            free.remove(number)
    return joined


def _join_places(
    rows: Sequence[Row], parts: dict[int, Body], joined: dict[int, int], slab: Slab
) -> tuple[dict[int, int], list[Finding]]:
    """Row to body by position, each side of the table on its own: programs mirror the bottom alone."""
    found: dict[int, int] = {}
    notes: list[Finding] = []
    free = [number for number in parts if number not in joined.values()]
    for side in ("top", "bottom", None):
        placed = [place for place, row in enumerate(rows) if row.xy_mm is not None and row.side == side]
        named = {place: parts[joined[place]] for place in placed if place in joined}
        open_rows = [place for place in placed if place not in joined]
        here = [
            number
            for number in free
            if number not in found.values()
            and (side is None or (parts[number].side or slab.side_of(parts[number])) == side)
        ]
        bodies = [parts[number] for number in here]
        named_mm, open_mm = _positions(rows, named), _positions(rows, open_rows)
        if len(named) >= 3 or (named and not open_rows):
            fit = fit_pairs(named_mm, np.array([centre(body) for body in named.values()]))
        elif open_rows and here:
            fit = fit_points(open_mm, np.array([centre(body) for body in bodies]))
        else:
            continue
        if fit is None:
            files = files_of([rows[place] for place in open_rows], "xy_mm")
            text = f"{len(open_rows)} positions of {files} fit no arrangement of the components of the "
            notes.append(Finding(PARTS_POSITION, f"{text}{side or 'board'}: not joined by position."))
            continue
        if words := fit.describe():
            where = f" of the {side}" if side else ""
            files = files_of([rows[place] for place in placed], "xy_mm")
            notes.append(Finding(PARTS_FRAME, f"The positions{where} in {files} were {words}."))
        hits = {place for place, _ in assign(fit.apply(named_mm), list(named.values()))}
        away = [rows[place] for count, place in enumerate(named) if count not in hits]
        files = files_of(away, "xy_mm")
        text = f"components lie elsewhere in {files} than on the board: {{}}. Check that it is of the same revision."
        notes += listed(PARTS_POSITION, [row.ref for row in away], text)
        found |= {open_rows[place]: here[number] for place, number in assign(fit.apply(open_mm), bodies)}
    return found, notes


def _positions(rows: Sequence[Row], places: Iterable[int]) -> Points2:
    return np.array([rows[place].xy_mm or (0.0, 0.0) for place in places], dtype=np.float64).reshape(-1, 2)


def fill_row(body: Body, row: Row, slab: Slab, given: Statements) -> Body:
    """Give a body what a row states; what contradicts it is added to the statements."""
    package = max((row.package, body.package or ""), key=fineness) or None
    if package and package != row.package and row.package:
        given.contradict(row, "package", (package, _BOARD), (row.package, row.file))
    stated = (
        ("package", body.package, package),
        ("part", body.part, row.part or None),
        ("value", body.value, row.value or None),
        ("pins", body.pins, row.pins),
        ("standoff_mm", body.gap_height_mm, row.gap_height_mm),
    )
    for key, before, value in stated:
        if value is not None and before is not None and _plain(before) != _plain(value):
            given.contradict(row, key, (f"{value}", row.source(key)), (f"{before}", _BOARD))
    lies = slab.side_of(body)
    side = row.side or body.side
    if row.side is not None and row.side != body.side:
        if lies != row.side:  # the row's side would put the drawn body into the board
            given.contradict(row, "side", (lies, _BOARD), (row.side, row.source("side")))
            side = lies
        elif body.side is not None:
            given.contradict(row, "side", (row.side, row.source("side")), (body.side, _BOARD))
    body = replace(
        body,
        package=package,
        part=row.part or body.part,
        value=row.value or body.value,
        pins=body.pins if row.pins is None else row.pins,
        side=side,
        gap_height_mm=body.gap_height_mm if row.gap_height_mm is None else row.gap_height_mm,
    )
    return _fill_height(body, row, slab, given)


def _plain(value: str | float) -> str | float:
    return value.casefold().strip() if isinstance(value, str) else round(float(value), 4)


def _fill_height(body: Body, row: Row, slab: Slab, given: Statements) -> Body:
    """Stretch a body of nominal height to what the table states; compare a drawn one."""
    heights = body.patches[:, :, 2]
    up = slab.side_of(body) == "top"
    far = slab.height_of(body, "top" if up else "bottom")
    near = float(heights.min()) - slab.high if up else slab.low - float(heights.max())
    if far <= near or not any(key == NOMINAL_HEIGHT for key, _ in body.extra):
        if row.height_mm is not None and abs(row.height_mm - far) > max(HEIGHT_MM, 0.1 * far):
            given.contradict(
                row, "height", (f"{far:.2f} mm", _BOARD), (f"{row.height_mm:g} mm", row.source("height_mm"))
            )
        return body
    stated_mm = row.height_mm
    if stated_mm is not None and row.file != COLUMNS_FILE:
        length_mm = float(np.ptp(body.patches[:, :, :2].reshape(-1, 2), axis=0).max())
        checked = checked_height(stated_mm, HeightEvidence(body.package or "", row.ref, length_mm=length_mm)).height
        if checked.source != "stated":
            taken = f"{checked.height_mm:g} mm", checked.reason
            given.contradict(row, "height", taken, (f"{stated_mm:g} mm", row.source("height_mm")))
            stated_mm = checked.height_mm
        elif (NOMINAL_HEIGHT, STATED_HEIGHT) in body.extra and abs(stated_mm - far) > max(HEIGHT_MM, 0.1 * far):
            given.contradict(row, "height", (f"{stated_mm:g} mm", row.source("height_mm")), (f"{far:.2f} mm", _BOARD))
    low = near if row.gap_height_mm is None else row.gap_height_mm
    high = far if stated_mm is None or stated_mm <= 0.0 else stated_mm
    low = low if low < high else 0.0
    share = (heights - slab.high if up else slab.low - heights) - near
    stretched = low + share * (high - low) / (far - near)
    patches = body.patches.copy()
    patches[:, :, 2] = slab.high + stretched if up else slab.low - stretched
    extra = (
        body.extra
        if row.height_mm is None or stated_mm != row.height_mm
        else tuple(pair for pair in body.extra if pair[0] != NOMINAL_HEIGHT)
    )
    return replace(body, patches=patches, extra=extra)


def state_heights(bodies: Sequence[Body], given: Statements) -> tuple[tuple[Body, ...], tuple[Finding, ...]]:
    """Give bodies the heights that a columns file states for their name or their package."""
    heights = {key.casefold(): (key, height_mm) for key, height_mm in given.heights_mm.items()}
    slab = slab_of(bodies)
    used: set[str] = set()
    result = list(bodies)
    for number, body in enumerate(bodies):
        hit = heights.get(body.name.casefold(), heights.get((body.package or "").casefold()))
        if body.role == "component" and hit is not None:
            used.add(hit[0])
            row = Row(0, body.name, height_mm=hit[1], file=COLUMNS_FILE)
            result[number] = _fill_height(body, row, slab, given)
    lost = [key for key in given.heights_mm if key not in used]
    text = f"heights in {COLUMNS_FILE} are of no component and no package of the board: {{}}."
    return tuple(result), tuple(listed(PARTS_NOT_ON_BOARD, lost, text))


def centre(body: Body) -> NDArray[np.float64]:
    """Centre of a body in plan ``(2,)``: the mean of its patches, weighed by their area in plan."""
    plan = body.patches[:, :, :2]
    (ax, ay), (bx, by) = (plan[:, 1] - plan[:, 0]).T, (plan[:, 2] - plan[:, 0]).T
    weights = np.abs(ax * by - ay * bx)
    if float(weights.sum()) <= 0.0:
        return plan.reshape(-1, 2).mean(axis=0)
    return np.average(plan.mean(axis=1), axis=0, weights=weights)


def assign(points: Points2, bodies: Sequence[Body]) -> list[tuple[int, int]]:
    """Give each position at most one body, the nearest pairs first.

    Args:
        points: Positions on the board ``(n, 2)``, mm.
        bodies: Bodies that may be taken.

    Returns:
        Pairs of position and body, by number.
    """
    if not len(points) or not bodies:
        return []
    centres = np.array([centre(body) for body in bodies])
    hulls = [shapely.convex_hull(shapely.MultiPoint(body.patches[:, :, :2].reshape(-1, 2))) for body in bodies]
    reach = shapely.union(np.array(hulls), shapely.buffer(shapely.points(centres), NEAR_MM))
    pairs = shapely.STRtree(reach).query(shapely.points(points), predicate="intersects").T.tolist()
    apart = {(row, body): round(float(np.hypot(*(points[row] - centres[body]))), 4) for row, body in pairs}
    taken_rows: set[int] = set()
    taken_bodies: set[int] = set()
    chosen: list[tuple[int, int]] = []
    for row, body in sorted(apart, key=lambda pair: (apart[pair], pair)):
        if row not in taken_rows and body not in taken_bodies:
            chosen.append((row, body))
            taken_rows.add(row)
            taken_bodies.add(body)
    return sorted(chosen)
