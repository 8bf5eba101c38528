"""Pads of bare copper given to the rows of a table: which of them lie around a row's place as its package's pins do."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import KDTree

from boards.board import Pad, Side
from boards.formats.gerber.gerber import GerberBoard
from boards.formats.names import listed
from boards.packages.families import pins_of
from boards.parts_table.fit import NEAR_MM, Fit, fit_pairs, fit_points
from boards.parts_table.read import Row
from geometry.arrays import Points2
from specs.finding import Finding
from specs.finding_rules import PARTS_FRAME, PARTS_NOT_IN_TABLE, PARTS_POSITION

_OFF_MM = 0.3
_OFF = 0.1
"""The middle of a part's pads lies within 0.3 mm, or a tenth of their extent, of its place."""
_FARTHEST_MM = 60.0
"""No pad is farther from the place of its part."""
_FEWEST_PINS = 2

NamedPads = Mapping[str, tuple[tuple[str, Pad, Side, bool], ...]]


def lay_rows(rows: Sequence[Row], board: GerberBoard) -> tuple[list[Row], NamedPads, list[Finding]]:
    """Bring the places of rows onto the copper, and find the pads of each.

    Where a side's places lie on no copper, but mirrored, turned or shifted they do, they are laid so, with a finding.

    Returns:
        The rows with their places on the board, pads by designator, and what was noticed.
    """
    notes: list[Finding] = []
    laid = list(rows)
    pads = dict(board.pads)
    loose = {name.casefold(): name for name in pads}
    lost: list[str] = []
    for side in ("top", "bottom"):
        here = [place for place, row in enumerate(rows) if row.xy_mm is not None and (row.side or "top") == side]
        if not here:
            continue
        at = np.array([rows[place].xy_mm for place in here], dtype=np.float64)
        copper = _Copper(board.unnamed.get(side, ()))
        fit = (
            _fit_named(rows, here, at, board, loose)
            if board.pads
            else copper.fit([rows[each] for each in here], at, board)
        )
        if fit is not None and (words := fit.describe()):
            notes.append(
                Finding(PARTS_FRAME, f"The positions of the {side} in the parts table were {words} to fit the copper.")
            )
            at = fit.apply(at)
        for place, (x, y) in zip(here, at.tolist(), strict=True):
            laid[place] = replace(rows[place], xy_mm=(x, y))
        if board.pads:
            known = ((place, pads[loose[name]]) for place in here if (name := rows[place].ref.casefold()) in loose)
            lost += [rows[place].ref for place, own in known if not _lies_among(laid[place], own)]
            continue
        claimed = copper.claim([laid[place] for place in here], at)
        for place, own in zip(here, claimed, strict=True):
            if own:
                pads[rows[place].ref] = tuple(("", pad, side, flat) for pad, flat in own)
        lost += [rows[place].ref for place, own in zip(here, claimed, strict=True) if not own and copper.pads]
        free = len(copper.pads) - sum(map(len, claimed))
        if free:
            text = f"{free} of {len(copper.pads)} pads on the {side} belong to no row of the parts table."
            notes.append(Finding(PARTS_NOT_IN_TABLE, text))
    text = (
        "places in the parts table do not lie on the copper of their parts: {}. Check sides, origin and revision of "
        "the table."
    )
    return laid, pads, notes + listed(PARTS_POSITION, lost, text)


def _fit_named(
    rows: Sequence[Row], here: Sequence[int], at: Points2, board: GerberBoard, loose: Mapping[str, str]
) -> Fit | None:
    """Map from the places of one side onto the middles of the pads that carry their names."""
    known = [number for number, place in enumerate(here) if rows[place].ref.casefold() in loose]
    if len(known) < 3:
        return None
    middles = [middle_of([pad for _, pad, *_ in board.pads[loose[rows[here[each]].ref.casefold()]]]) for each in known]
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

    def spots(self) -> Points2:
        return np.array([(pad.x_mm, pad.y_mm) for pad, _ in self.pads]).reshape(-1, 2)

    def fit(self, rows: Sequence[Row], at: Points2, board: GerberBoard) -> Fit | None:
        """Map under which most places have their pads around them; ``None`` if the places themselves have, or none."""
        if not self.pads:
            return None
        found = [(sum(map(bool, self.claim(rows, at))), 0, Fit("", np.eye(2), np.zeros(2), 0.0))]
        if 2 * found[0][0] > len(rows):
            return None
        x0, y0, x1, y1 = board.outline.bounds
        flip_x, flip_y = np.diag([-1.0, 1.0]), np.diag([1.0, -1.0])
        tried = [
            Fit("mirrored in x", flip_x, np.array([x0 + x1, 0.0]), 0.0),
            Fit("mirrored in x", flip_x, np.zeros(2), 0.0),
            Fit("mirrored in y", flip_y, np.array([0.0, y0 + y1]), 0.0),
            Fit("", np.eye(2), np.array([x0, y0]), 0.0),
        ]
        spots = self.spots()
        if len(spots) > 1:
            near = np.asarray(KDTree(spots).query(spots, k=2)[1])[:, 1]
            voted = fit_points(at, np.unique(np.round((spots + spots[near]) / 2.0, 3), axis=0))
            tried += [voted] if voted is not None else []
        found += [
            (sum(map(bool, self.claim(rows, fit.apply(at)))), -number, fit) for number, fit in enumerate(tried, 1)
        ]
        best = max(found, key=lambda each: each[:2])
        return best[2] if best[0] > 2 * found[0][0] and 2 * best[0] > len(rows) else None

    def claim(self, rows: Sequence[Row], at: Points2) -> list[list[tuple[Pad, bool]]]:
        """Give each row the pads nearest to its place, as many as it has pins, the fewest pins first.

        Rows whose pins are not known come last, and take what of the rest is nearer to them than to each other.
        """
        claimed: list[list[tuple[Pad, bool]]] = [[] for _ in rows]
        spots = self.spots()
        if not len(spots):
            return claimed
        tree = KDTree(spots)
        free = np.ones(len(spots), dtype=np.bool_)
        counts = [row.pins or pins_of(row.package) or 0 for row in rows]
        for number in sorted(range(len(rows)), key=lambda each: (counts[each], each)):
            count = counts[number]
            if count < _FEWEST_PINS or count > len(spots):
                continue
            reached = min(3 * count + 8, len(spots))
            far, near = (np.atleast_1d(each) for each in tree.query(at[number], k=reached))
            open_ = [int(each) for each, mm in zip(near, far, strict=True) if free[each] and mm <= _FARTHEST_MM]
            for chosen in (open_[:count], open_[: count + 1]):  # a pad below the middle is not counted as a pin
                if len(chosen) >= count and _is_around(spots[chosen], at[number]):
                    claimed[number] = [self.pads[each] for each in chosen]
                    free[chosen] = False
                    break
        open_rows = [number for number, count in enumerate(counts) if count < _FEWEST_PINS]
        if open_rows and free.any():
            rest = np.flatnonzero(free)
            far, nearest = (np.asarray(each) for each in KDTree(at[open_rows]).query(spots[rest]))
            for member, number in enumerate(open_rows):
                own = rest[(nearest == member) & (far <= _FARTHEST_MM)]
                if len(own) and _is_around(spots[own], at[number]):
                    claimed[number] = [self.pads[each] for each in own.tolist()]
        return claimed


def _is_around(spots: Points2, at: Points2) -> bool:
    low, high = spots.min(axis=0), spots.max(axis=0)
    off = float(np.abs((low + high) / 2.0 - at).max())
    return off <= max(_OFF_MM, _OFF * float((high - low).max()))
