"""Rows of parts tables on copper: the pads that are around their places, and how the places come to lie there."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial import KDTree

from boards.board import Pad, Side
from boards.formats.gerber.gerber import GerberBoard, with_copper
from boards.formats.names import listed
from boards.packages.families import pins_of, plan_size
from boards.parts_table.fit import NEAR_MM, Fit, fit_pairs, fit_points
from boards.parts_table.read import Row
from boards.parts_table.tables import Statements, files_of, scaled
from boards.parts_table.words import UNIT_NAMES
from geometry.arrays import Points2
from specs.finding import Finding
from specs.finding_rules import PARTS_FRAME, PARTS_NOT_IN_TABLE, PARTS_POSITION

_OFF_MM = 0.3
_OFF = 0.1
"""The middle of a part's pads lies within 0.3 mm, or a tenth of their extent, of its place."""
_SEPARATE = 1.3
"""Other pads are farther from those of a part than the widest gap between its own, times this."""
_FEWEST_UNKNOWN, _SEPARATE_UNKNOWN = 3, 2.5
"""Of a part whose number of pins is not known."""
_FAR_PITCHES = 3.0
_MOST_TABS = 4
"""Pads of a connector that are no pins."""
_FARTHEST_MM = 60.0
"""No pad is farther from the place of its part."""
FEWEST_PINS = 2
_SIDES: tuple[Side, ...] = ("top", "bottom")
_OTHER: dict[Side, Side] = {"top": "bottom", "bottom": "top"}

NamedPads = Mapping[str, tuple[tuple[str, Pad, Side, bool], ...]]
"""By reference designator: pin, pad, side, and whether it is soldered flat."""


def lay_rows(rows: Sequence[Row], board: GerberBoard, given: Statements) -> tuple[list[Row], NamedPads, list[Finding]]:
    """Bring the places of rows onto the copper, and find the pads of each.

    Where a side's places lie on no copper, but mirrored, turned or shifted they do, they are laid so, with a finding.
    Rows without pads on their side are looked for on the other.

    Returns:
        The rows with their places on the board, pads by designator, and what was noticed.
    """
    notes: list[Finding] = []
    pads = dict(board.pads)
    laid = [_on_its_side(row, pads.get(row.ref, ()), given) for row in rows]
    placed = [number for number, row in enumerate(laid) if row.xy_mm is not None]
    sides: dict[Side, list[int]] = {side: [n for n in placed if (laid[n].side or "top") == side] for side in _SIDES}
    homes = {side: _home(side, [laid[n] for n in sides[side]], pads, board) for side in _SIDES}
    sides = {side: [n for each in _SIDES if homes[each] == side for n in sides[each]] for side in _SIDES}
    copper: dict[Side, _Copper] = {side: _Copper(board.unnamed.get(side, ())) for side in _SIDES}
    fits: list[Fit] = []
    lost: list[int] = []
    for side in sorted(_SIDES, key=lambda each: -len(sides[each])):
        here = [laid[place] for place in sides[side]]
        fit = _find_fit(here, pads, copper[side], fits, board)
        if fit is not None:
            fits.append(fit)
            if words := fit.describe():
                files = files_of(here, "xy_mm")
                text = f"The positions of the {side} in {files} were {words} to fit the copper."
                notes.append(Finding(PARTS_FRAME, text))
            at = fit.apply(_places(here)).tolist()
            here = [replace(row, xy_mm=(x, y)) for row, (x, y) in zip(here, at, strict=True)]
        for place, row in zip(sides[side], here, strict=True):
            laid[place] = row if row.side in (side, None) else _on_copper(row, side, given)
        lost += [n for n in sides[side] if laid[n].ref in pads and not _lies_among(laid[n], pads[laid[n].ref])]
        lost += _claimed([n for n in sides[side] if laid[n].ref not in pads], laid, copper, side, pads)
    lost = _from_the_other_side(lost, laid, copper, pads, given)
    lost = [n for n in lost if laid[n].ref in pads or not _claim_off_centre(laid[n], copper, pads)]
    off = [
        row
        for n in placed
        if n not in lost and (own := pads.get((row := laid[n]).ref)) is not None
        and not _is_around(_spots([pad for _, pad, *_ in own]), np.array(row.xy_mm), row)
    ]  # fmt: skip
    files = files_of(off, "xy_mm")
    text = f"places in {files} are not the middle of their pads, but a pin or a corner: {{}}. The pads are taken."
    notes += listed(PARTS_FRAME, [row.ref for row in off], text)
    for side in _SIDES if rows else ():
        if free := copper[side].free():
            text = f"{len(free)} of {len(copper[side].pads)} pads on the {side} belong to no row of {files_of(rows)}"
            spot = f"({free[0].x_mm:.2f}, {free[0].y_mm:.2f})"
            notes.append(Finding(PARTS_NOT_IN_TABLE, f"{text}, such as that at {spot}."))
    for side in _SIDES if any(each.pads for each in copper.values()) else ():
        blind = [laid[n] for n in lost if (laid[n].side or "top") == side and not copper[side].pads]
        text = (
            f"places in {files_of(blind, 'xy_mm')} are on the {side}, whose copper has no pad, and cannot be checked: "
            "{}. Is its layer missing, or are its pads drawn instead of flashed?"
        )
        notes += listed(PARTS_POSITION, [row.ref for row in blind if row.ref not in pads], text)
    without = [laid[n] for n in lost if laid[n].ref in pads or copper[laid[n].side or "top"].pads]
    for row in without:
        _contradict_place(row, pads.get(row.ref, ()), given)
    text = (
        f"places in {files_of(without, 'xy_mm')} do not lie on the copper of their parts: {{}}. Check sides, origin "
        "and revision of the table."
    )
    return laid, pads, notes + listed(PARTS_POSITION, [row.ref for row in without], text)


def _from_the_other_side(
    lost: Sequence[int],
    laid: list[Row],
    copper: Mapping[Side, "_Copper"],
    pads: dict[str, tuple[tuple[str, Pad, Side, bool], ...]],
    given: Statements,
) -> list[int]:
    """Lay rows without pads on their side on the other where they have theirs there; returns those that have none."""
    left = list(lost)
    for side in _SIDES:
        others = [n for n in lost if laid[n].ref not in pads and (laid[n].side or "top") == _OTHER[side]]
        rest = {*_claimed(others, laid, copper, side, pads)} if copper[side].pads else {*others}
        for number in (each for each in others if each not in rest):
            laid[number] = _on_copper(laid[number], side, given)
            left.remove(number)
    return left


def _on_copper(row: Row, side: Side, given: Statements) -> Row:
    """Lay a row on a side, which contradicts the one that it states."""
    if row.side is not None:
        given.contradict(row, "side", (side, "copper"), (row.side, row.source("side")))
    return replace(row, side=side)


def _home(side: Side, rows: Sequence[Row], pads: NamedPads, board: GerberBoard) -> Side:
    """Side on whose copper most rows of a stated side lie: the other one, where the sides were swapped."""
    bare = [row for row in rows if row.ref not in pads]
    own, other = (
        sum(map(bool, _Copper(board.unnamed.get(each, ())).claim(bare, _places(bare)))) for each in (side, _OTHER[side])
    )
    return _OTHER[side] if other > 2 * own and 2 * other > len(rows) else side


def find_copper(board: GerberBoard, rows: Sequence[Row]) -> tuple[GerberBoard, list[Finding]]:
    """Find the copper of sides that no layer is called after: where most of their places have their pads around them.

    Of layers that fit alike, such as copper, mask and paste, the first is taken.
    """
    names: dict[Side, str] = {}
    notes: list[Finding] = []
    for side in _SIDES:
        here = [row for row in rows if row.xy_mm is not None and (row.side or side) == side]
        if board.unnamed.get(side) or not here or not board.open_layers:
            continue
        found: list[tuple[int, int, str]] = []
        for number, (name, pads) in enumerate(sorted(board.open_layers.items())):
            copper = _Copper(tuple((pad, True) for pad in pads))
            hits = max(copper.most_hits([scaled(row, unit_mm) for row in here], board) for unit_mm in UNIT_NAMES)
            found.append((hits, -number, name))
        hits, _, name = max(found)
        if 2 * hits > len(here) and name not in names.values():
            names[side] = name
            text = f"{name} is read as the copper of the {side}, which nothing states: {hits} of {len(here)} places in "
            notes.append(Finding(PARTS_FRAME, f"{text}{files_of(here, 'xy_mm')} have their pads in it."))
    return (with_copper(board, names), notes) if names else (board, [])


def find_hits(board: GerberBoard, rows: Sequence[Row]) -> list[bool]:
    """Which rows have pads of either side around their places."""
    copper = [_Copper(board.unnamed.get(side, ())) for side in _SIDES]
    claims = [each.claim(rows, _places(rows)) for each in copper]
    return [any(own) for own in zip(*claims, strict=True)]


def _claimed(
    numbers: Sequence[int],
    rows: Sequence[Row],
    copper: Mapping[Side, "_Copper"],
    side: Side,
    pads: dict[str, tuple[tuple[str, Pad, Side, bool], ...]],
) -> list[int]:
    """Give rows the pads of a side that lie around their places, and return those that have none there."""
    bare = [rows[number] for number in numbers]
    claimed = copper[side].claim(bare, _places(bare))
    for row, own in zip(bare, claimed, strict=True):
        if own:
            pads[row.ref] = tuple(("", pad, side, flat) for pad, flat in own)
    copper[side].taken.update(id(pad) for own in claimed for pad, _ in own)
    return [number for number, own in zip(numbers, claimed, strict=True) if not own]


def _claim_off_centre(
    row: Row, copper: Mapping[Side, "_Copper"], pads: dict[str, tuple[tuple[str, Pad, Side, bool], ...]]
) -> bool:
    """Give a row the pads at whose corner its place is, as connectors are placed by their first pin or by a corner."""
    side = row.side or "top"
    own = copper[side].grown(row)
    if own:
        pads[row.ref] = tuple(("", pad, side, flat) for pad, flat in own)
        copper[side].taken.update(id(pad) for pad, _ in own)
    return bool(own)


def _spots(pads: Sequence[Pad]) -> Points2:
    return np.array([(pad.x_mm, pad.y_mm) for pad in pads]).reshape(-1, 2)


def _places(rows: Sequence[Row]) -> Points2:
    return np.array([row.xy_mm for row in rows], dtype=np.float64).reshape(-1, 2)


def _find_fit(
    rows: Sequence[Row], pads: NamedPads, copper: "_Copper", known: Sequence[Fit], board: GerberBoard
) -> Fit | None:
    """Map of the places of one side onto the copper, by its names or else by where pads lie; ``None`` without one.

    Args:
        rows: With places.
        pads: By designator.
        copper: Of the side.
        known: Maps of the other side.
        board: Whose outline places are mirrored in.
    """
    at = _places(rows)
    fit = _fit_named(rows, at, pads)
    if fit is not None or not rows or any(row.ref in pads for row in rows):
        return fit
    own = sum(map(bool, copper.claim(rows, at)))
    return None if 2 * own > len(rows) else copper.fit(rows, own, known, board)


def _contradict_place(row: Row, pads: Sequence[tuple[str, Pad, Side, bool]], given: Statements) -> None:
    """Note a place that does not lie on the pads of its part; where they are named, they are where it is."""
    x, y = row.xy_mm or (0.0, 0.0)
    stated = f"({x:.2f}, {y:.2f})", row.source("xy_mm")
    if pads:
        x, y = middle_of([pad for _, pad, *_ in pads]).tolist()
        given.contradict(row, "place", (f"({x:z.2f}, {y:z.2f})", "copper"), stated)
    else:
        given.contradict(row, "place", stated, ("no such pads there", "copper"))


def _on_its_side(row: Row, pads: Sequence[tuple[str, Pad, Side, bool]], given: Statements) -> Row:
    """Put a part whose pads are all on the other side there."""
    sides = {side for _, _, side, _ in pads}
    if row.side is None or len(sides) != 1 or row.side in sides or not all(flat for *_, flat in pads):
        return row
    (side,) = sides
    given.contradict(row, "side", (side, "copper"), (row.side, row.source("side")))
    return replace(row, side=side)


def _fit_named(rows: Sequence[Row], at: Points2, pads: NamedPads) -> Fit | None:
    """Map from the places of one side onto the middles of the pads that carry their names."""
    known = [number for number, row in enumerate(rows) if row.ref in pads]
    if len(known) < 3:
        return None
    middles = [middle_of([pad for _, pad, *_ in pads[rows[each].ref]]) for each in known]
    fit = fit_pairs(at[known], np.array(middles))
    return fit if fit.error_mm <= NEAR_MM else None


def middle_of(pads: Sequence[Pad]) -> Points2:
    """Middle (2,) of the box around the middles of pads, mm."""
    spots = np.array([(pad.x_mm, pad.y_mm) for pad in pads])
    return (spots.min(axis=0) + spots.max(axis=0)) / 2.0


def _lies_among(row: Row, pads: Sequence[tuple[str, Pad, Side, bool]]) -> bool:
    spots = np.array([(pad.x_mm, pad.y_mm) for _, pad, *_ in pads])
    reach = NEAR_MM + max(max(pad.length_mm, pad.width_mm) for _, pad, *_ in pads) / 2.0
    at = np.array(row.xy_mm)
    return bool(((at >= spots.min(axis=0) - reach) & (at <= spots.max(axis=0) + reach)).all())


@dataclass(frozen=True, slots=True, eq=False)
class _Copper:
    """The pads of one side that no attribute names, and whether each is on this side only."""

    pads: tuple[tuple[Pad, bool], ...]
    taken: set[int] = field(default_factory=set[int])
    """Identities of the pads that rows have."""

    def spots(self) -> Points2:
        return np.array([(pad.x_mm, pad.y_mm) for pad, _ in self.pads]).reshape(-1, 2)

    def free(self) -> list[Pad]:
        """Pads that no row has."""
        return [pad for pad, _ in self.pads if id(pad) not in self.taken]

    def most_hits(self, rows: Sequence[Row], board: GerberBoard) -> int:
        """How many rows have pads around their places, as they are or moved."""
        at = _places(rows)
        own = sum(map(bool, self.claim(rows, at)))
        fit = self.fit(rows, own, (), board) if 2 * own <= len(rows) else None
        return own if fit is None else sum(map(bool, self.claim(rows, fit.apply(at))))

    def fit(self, rows: Sequence[Row], here: int, known: Sequence[Fit], board: GerberBoard) -> Fit | None:
        """Map under which most places have their pads around them, and far more than ``here``; ``None`` without one."""
        if not self.pads:
            return None
        at = _places(rows)
        x0, y0, x1, y1 = board.outline.bounds
        flip_x, flip_y = np.diag([-1.0, 1.0]), np.diag([1.0, -1.0])
        tried = [
            Fit("mirrored in x", flip_x, np.array([x0 + x1, 0.0]), 0.0),
            Fit("mirrored in x", flip_x, np.zeros(2), 0.0),
            Fit("mirrored in y", flip_y, np.array([0.0, y0 + y1]), 0.0),
            Fit("", np.eye(2), np.array([x0, y0]), 0.0),
        ]
        # As the other side lies, or mirrored before or after that.
        tried = [*known, *tried, *(first.then(fit) for fit in known for first in tried[:3]),
                 *(fit.then(last) for fit in known for last in tried[:3])]  # fmt: skip
        spots = self.spots()
        if len(spots) > 1:
            near = np.asarray(KDTree(spots).query(spots, k=2)[1])[:, 1]
            voted = fit_points(at, np.unique(np.round((spots + spots[near]) / 2.0, 3), axis=0))
            tried += [voted] if voted is not None else []
        found = [(sum(map(bool, self.claim(rows, fit.apply(at)))), -number, fit) for number, fit in enumerate(tried)]
        best = max(found, key=lambda each: each[:2])
        return best[2] if best[0] > 2 * here and 2 * best[0] > len(rows) else None

    def grown(self, row: Row) -> list[tuple[Pad, bool]]:
        """Free pads apart from others, as many as a row has pins, that have its place at a corner; none without them.

        They are gathered from the one nearest to the place, each time the next one nearest to those.
        """
        count = row.pins or pins_of(row.package) or 0
        least, wider = (count, _SEPARATE) if count else (_FEWEST_UNKNOWN, _SEPARATE_UNKNOWN)
        at = np.array(row.xy_mm or (0.0, 0.0))
        free = [each for each in self.pads if id(each[0]) not in self.taken]
        spots = _spots([pad for pad, _ in free])
        near = np.flatnonzero(np.hypot(*(spots - at).T) <= _FARTHEST_MM)
        if least < FEWEST_PINS or len(near) < least:
            return []
        spots = spots[near]
        apart = np.hypot(*(spots - at).T)
        chosen = [int(apart.argmin())]
        widest = 0.0
        apart = np.hypot(*(spots - spots[chosen[0]]).T)
        while len(chosen) < (min(count + _MOST_TABS, len(near)) if count else len(near)):
            apart[chosen] = np.inf
            following = int(apart.argmin())
            if len(chosen) >= least and apart[following] > wider * widest:
                break
            widest = max(widest, float(apart[following]))
            chosen.append(following)
            apart = np.minimum(apart, np.hypot(*(spots - spots[following]).T))
        apart[chosen] = np.inf
        found = [free[near[each]] for each in chosen]
        is_sure = least > FEWEST_PINS or not any(flat for _, flat in found)
        if not is_sure or apart.min() <= wider * widest or not _is_at_corner([pad for pad, _ in found], at, row):
            return []
        return found

    def claim(self, rows: Sequence[Row], at: Points2) -> list[list[tuple[Pad, bool]]]:
        """Give each row the pads nearest to its place, as many as it has pins, the fewest pins first.

        Rows whose pins are not known come last, and take what of the rest is nearer to them than to each other.
        """
        claimed: list[list[tuple[Pad, bool]]] = [[] for _ in rows]
        spots = self.spots()
        if not len(spots):
            return claimed
        tree = KDTree(spots)
        free = np.array([id(pad) not in self.taken for pad, _ in self.pads])
        counts = [row.pins or pins_of(row.package) or 0 for row in rows]
        for number in sorted(range(len(rows)), key=lambda each: (counts[each], each)):
            count = counts[number]
            if count < FEWEST_PINS or count > len(spots):
                continue
            reached = min(3 * count + 8, len(spots))
            far, near = (np.atleast_1d(each) for each in tree.query(at[number], k=reached))
            open_ = [int(each) for each, mm in zip(near, far, strict=True) if free[each] and mm <= _FARTHEST_MM]
            for chosen in (open_[:count], open_[: count + 1]):  # a pad below the middle is not counted as a pin
                pads = [self.pads[each][0] for each in chosen]
                if len(chosen) < count or (len(chosen) > count and not _is_one_part(pads)):
                    continue
                if _is_around(spots[chosen], at[number], rows[number]):
                    claimed[number] = [self.pads[each] for each in chosen]
                    free[chosen] = False
                    break
        open_rows = [number for number, count in enumerate(counts) if count < FEWEST_PINS]
        if open_rows and free.any():
            rest = np.flatnonzero(free)
            far, nearest = (np.asarray(each) for each in KDTree(at[open_rows]).query(spots[rest]))
            for member, number in enumerate(open_rows):
                own = rest[(nearest == member) & (far <= _FARTHEST_MM)]
                if len(own) and _is_around(spots[own], at[number], rows[number]):
                    claimed[number] = [self.pads[each] for each in own.tolist()]
        return claimed


def _is_one_part(pads: Sequence[Pad]) -> bool:
    """Whether no pad is far from the others, by their usual pitch and its own size."""
    spots = _spots(pads)
    apart = np.asarray(KDTree(spots).query(spots, k=2)[0])[:, 1]
    sizes = np.array([max(pad.length_mm, pad.width_mm) for pad in pads])
    return bool((apart - sizes / 2.0 <= _FAR_PITCHES * np.median(apart)).all())


def _is_at_corner(pads: Sequence[Pad], at: Points2, row: Row) -> bool:
    """Whether a place is that of the pad at a corner, or the corner of the box around pads or of the body."""
    spots = _spots(pads)
    body = plan_size(row.package)
    for angle in {0.0, row.turn_deg or 0.0, -(row.turn_deg or 0.0)}:
        cos, sin = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        own = (spots - at) @ np.array([[cos, -sin], [sin, cos]])
        low, high = own.min(axis=0), own.max(axis=0)
        away = np.abs(low + high) / 2.0
        rim = max(max(pad.length_mm, pad.width_mm) for pad in pads) / 2.0
        halves = [(high - low) / 2.0, (high - low) / 2.0 + rim]
        halves += [np.array(size) / 2.0 for size in ((body, body[::-1]) if body is not None else ())]
        if any(float(np.abs(away - half).max()) <= _OFF_MM for half in halves):
            return True
    return False


def _is_around(spots: Points2, at: Points2, row: Row) -> bool:
    """Whether the box around pads has its middle at the place of a part, in its own frame or that of the board."""
    turn = row.turn_deg or 0.0
    for angle in {0.0, turn, -turn} if turn % 90.0 else {0.0}:
        cos, sin = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        own = (spots - at) @ np.array([[cos, -sin], [sin, cos]])
        low, high = own.min(axis=0), own.max(axis=0)
        if float(np.abs(low + high).max()) / 2.0 <= max(_OFF_MM, _OFF * float((high - low).max())):
            return True
    return False
