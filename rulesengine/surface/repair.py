"""Automatic repair: stripes are slowed, paused on or added to where visible points get less than the required time."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array

from geometry.arrays import Scalars
from rulesengine.surface.coverage import Moments, Sight, moments_of, poses_around, view_of
from rulesengine.surface.piece import Piece, spot
from rulesengine.surface.site import PartSite
from specs.progress import Progress, no_progress

ENOUGH = 0.995
"""Share of the visible area from which on nothing is repaired: measured on other cells it is a little less."""
ENOUGH_OF_A_FACE = 0.993
MARGIN = 1.03
"""Times the required time that a repair aims at."""
_SLOWEST = 1.6
"""Times as long that a stripe may take for the sake of its own middle."""
_INNER = 0.7
"""Worth of a pause inside a stripe, where the nozzle has to stop, against one at an end."""
_MUCH = 0.31
_LOOKED_AT = 120
"""Cells at most around which poses are looked for."""
_NEARLY_ALL = 0.97
_LEAST_SHARE = 4e-5
"""Of the visible area that a pause or a pose must help at least."""
_MOST_AT_ONCE = 150


@dataclass(frozen=True, slots=True, eq=False)
class Round:
    """One round of a repair."""

    what: str
    share: float
    """Of the visible area that is held for the required time after it."""
    spray_s: float
    """Time with the jet on after it."""


@dataclass(frozen=True, slots=True, eq=False)
class Covered:
    """Pieces, and how long they keep each cell in the cone."""

    pieces: tuple[Piece, ...]
    moments: Moments
    view: csr_array
    """(moments, cells)"""
    seconds: Scalars
    """(c,)"""


def cover(site: PartSite, pieces: Sequence[Piece]) -> Covered:
    """Find how long pieces keep each cell in the cone."""
    moments = moments_of(pieces)
    view = view_of(site, moments)
    return Covered(tuple(pieces), moments, view, np.asarray(view.T @ moments.seconds, dtype=np.float64))


def share_held(site: PartSite, covered: Covered, sight: Sight) -> float:
    """Share of the visible area that is in the cone for the required time."""
    areas = site.cells.areas_mm2 * sight.visible
    held = covered.seconds >= site.spec.required_s * (1 - 1e-9)
    return float((areas * held).sum() / max(areas.sum(), 1e-12))


def _is_enough(site: PartSite, covered: Covered, sight: Sight) -> bool:
    """Whether nothing is repaired any more: of no face much is missing, and little of all."""
    areas = site.cells.areas_mm2 * sight.visible
    held = areas * (covered.seconds >= site.spec.required_s * (1 - 1e-9))
    whole, mine = (np.bincount(site.cell_face, each) for each in (areas, held))
    return bool(held.sum() >= ENOUGH * areas.sum() and (mine >= ENOUGH_OF_A_FACE * whole).all())


def repair(
    site: PartSite, covered: Covered, sight: Sight, progress: Progress = no_progress
) -> tuple[Covered, tuple[Round, ...]]:
    """Repair in at most five rounds of one remedy each: slow down, pause at ends, add poses, pause inside, both."""
    remedies: tuple[Callable[[PartSite, Covered, Sight], tuple[list[Piece], str]], ...] = (
        _slow_down, _pause_at_ends, _add_poses, _pause_inside, _add_poses,
    )  # fmt: skip
    rounds: list[Round] = []
    for number, remedy in enumerate(remedies):
        if _is_enough(site, covered, sight):
            break
        pieces, what = remedy(site, covered, sight)
        if pieces == list(covered.pieces):
            continue
        covered = cover(site, pieces)
        rounds.append(Round(what, share_held(site, covered, sight), sum(piece.spray_s for piece in pieces)))
        progress("repairing", (number + 1) / len(remedies))
    return covered, tuple(rounds)


def _missing(site: PartSite, covered: Covered, sight: Sight) -> Scalars:
    """(c,) seconds that visible cells lack."""
    return np.where(sight.visible, np.maximum(MARGIN * site.spec.required_s - covered.seconds, 0.0), 0.0)


def _slow_down(site: PartSite, covered: Covered, sight: Sight) -> tuple[list[Piece], str]:
    """Slow stripes whose own middle is not held long enough; what only their ends see is left to pauses."""
    pieces = list(covered.pieces)
    moments, required = covered.moments, MARGIN * site.spec.required_s
    slowed = 0
    for number, piece in enumerate(pieces):
        if len(piece.targets) < 2:
            continue
        mine = np.flatnonzero(moments.piece == number)
        own = np.asarray(covered.view[mine].T @ moments.seconds[mine])
        ends = np.concatenate([mine[:1], mine[-1:]])
        beside = np.asarray(covered.view[ends].sum(axis=0)).ravel() > 0
        chosen = sight.visible & ~beside & (own > 0.5 * covered.seconds) & (own > 0.3 * site.spec.required_s)
        lacking = chosen & (covered.seconds < required)
        if site.cells.areas_mm2[lacking].sum() > 0.02 * max(site.cells.areas_mm2[chosen].sum(), 1e-9):
            ratios = (required - (covered.seconds - own)[lacking]) / own[lacking]
            factor = float(np.clip(np.quantile(ratios, 0.9), 1.0, _SLOWEST))
            pieces[number] = piece.slowed(factor)
            slowed += 1
    return pieces, f"{slowed} stripes slowed down"


def _pause_at_ends(site: PartSite, covered: Covered, sight: Sight) -> tuple[list[Piece], str]:
    poses = [(number, index) for number, piece in enumerate(covered.pieces) for index in {0, len(piece.tcp) - 1}]
    return _pause(site, covered, sight, poses, "ends of stripes")


def _pause_inside(site: PartSite, covered: Covered, sight: Sight) -> tuple[list[Piece], str]:
    poses = [(number, index) for number, piece in enumerate(covered.pieces) for index in range(len(piece.tcp))]
    return _pause(site, covered, sight, poses, "places on stripes")


def _pause(
    site: PartSite, covered: Covered, sight: Sight, poses: list[tuple[int, int]], where: str
) -> tuple[list[Piece], str]:
    """Pause at poses of pieces, each time where most is still missing."""
    pieces = list(covered.pieces)
    tcp = np.array([pieces[number].tcp[index] for number, index in poses])
    approach = np.array([pieces[number].approach[index] for number, index in poses])
    none = np.zeros(len(poses))
    view = view_of(site, Moments(tcp, approach, none, none.astype(np.int64), none.astype(np.int64)))
    worth = np.array([1.0 if index in (0, len(pieces[number].tcp) - 1) else _INNER for number, index in poses])
    missing = _missing(site, covered, sight)
    added = 0
    for row, seconds in _greedy(site, view, worth, missing, sight):
        number, index = poses[row]
        pieces[number] = pieces[number].paused(index, seconds)
        added += 1
    return pieces, f"pauses at {added} {where}"


def _greedy(site: PartSite, view: csr_array, worth: Scalars, missing: Scalars, sight: Sight) -> list[tuple[int, float]]:
    """Choose rows of a view and seconds for each, the one that helps most first, until what is left is little."""
    areas = site.cells.areas_mm2
    least = _LEAST_SHARE * float((areas * sight.visible).sum()) * site.spec.required_s
    chosen: list[tuple[int, float]] = []
    missing = missing.copy()
    while len(chosen) < _MOST_AT_ONCE:
        gains = np.asarray(view @ (areas * missing)) * worth
        if not len(gains) or gains.max() < least:
            break
        row = int(np.argmax(np.round(gains / gains.max(), 3)))  # the first of equal ones, wherever the part lies
        cells = view.indices[view.indptr[row] : view.indptr[row + 1]]
        cells = cells[missing[cells] > 0]
        seconds = _enough(missing[cells], areas[cells])
        missing[cells] = np.maximum(missing[cells] - seconds, 0.0)
        chosen.append((row, seconds))
    return chosen


def _enough(missing: Scalars, areas: Scalars) -> float:
    """Seconds after which nearly all of an area lacks nothing."""
    order = np.argsort(missing, kind="stable")
    share = np.cumsum(areas[order]) / areas.sum()
    return float(missing[order][min(int(np.searchsorted(share, _NEARLY_ALL)), len(order) - 1)])


def _add_poses(site: PartSite, covered: Covered, sight: Sight) -> tuple[list[Piece], str]:
    """Add pauses at poses of their own, of those that are known to see what nothing else does."""
    pieces, missing = list(covered.pieces), _missing(site, covered, sight)
    lacking = np.flatnonzero(missing > _MUCH * site.spec.required_s)  # what hardly misses it depends on rounding
    if not len(lacking):
        return pieces, "nothing is missing"
    some = lacking[np.unique(np.linspace(0, len(lacking) - 1, _LOOKED_AT).round().astype(np.int64))]
    tcp, approach = poses_around(site, some)
    known = lacking[np.isfinite(sight.tcp[lacking, 0])]
    tcp, approach = np.vstack([tcp, sight.tcp[known]]), np.vstack([approach, sight.approach[known]])
    none = np.zeros(len(tcp))
    view = view_of(site, Moments(tcp, approach, none, none.astype(np.int64), none.astype(np.int64)))
    added = 0
    for row, seconds in _greedy(site, view, np.ones(len(tcp)), missing, sight):
        cells = view.indices[view.indptr[row] : view.indptr[row + 1]]
        helped = np.bincount(site.cell_face[cells], (site.cells.areas_mm2 * missing)[cells])
        pieces.append(spot(site, site.part.faces[int(np.argmax(helped))].name, tcp[row], approach[row], seconds))
        added += 1
    return pieces, f"pauses at {added} poses of their own"


def with_pieces(covered: Covered, pieces: Sequence[Piece]) -> Covered:
    """Give the same with its pieces in another order; the times stay."""
    return replace(covered, pieces=tuple(pieces))
