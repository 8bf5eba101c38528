"""Automatic repair: speeds along the stripes that hold what they see, and poses of their own for the rest."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from geometry.arrays import Scalars
from rulesengine.surface.coverage import Covered, Sight, cover, held_at, poses_around, refine, share_held, view_of
from rulesengine.surface.piece import Piece, spot
from rulesengine.surface.selection import choose_stripes
from rulesengine.surface.site import PartSite
from rulesengine.surface.speeds import MARGIN, choose_speeds
from specs.progress import Progress, no_progress

ENOUGH = 0.995
"""Share of the visible area from which on nothing is repaired: measured on other cells it is a little less."""
ENOUGH_OF_A_FACE = 0.993
_ROUNDS = 5
_MUCH = 0.31
_LOOKED_AT = 120
"""Cells at most around which poses are looked for."""
_NEARLY_ALL = 0.97
_LEAST_SHARE = 4e-5
"""Of the visible area that a pose must help at least."""
_MOST_AT_ONCE = 150


@dataclass(frozen=True, slots=True, eq=False)
class Round:
    """One round of a repair."""

    what: str
    share: float
    """Of the visible area that is held for the required time after it."""
    spray_s: float
    """Time with the jet on after it."""


def _is_enough(site: PartSite, covered: Covered, sight: Sight) -> bool:
    """Whether nothing is repaired any more: of no face much is missing, and little of all."""
    areas = site.cells.areas_mm2 * sight.visible
    held = areas * (covered.seconds >= site.spec.required_s * (1 - 1e-9))
    whole, mine = (np.bincount(site.cell_face, each) for each in (areas, held))
    return bool(held.sum() >= ENOUGH * areas.sum() and (mine >= ENOUGH_OF_A_FACE * whole).all())


def repair(
    site: PartSite, covered: Covered, sight: Sight, progress: Progress = no_progress
) -> tuple[Covered, tuple[Round, ...]]:
    """Repair in at most five rounds: stripes and speeds; then poses for what is still missing, and speeds with them.

    What is held is measured on smaller cells than the part's.
    """
    own, known = site, sight
    site, sight = refine(site, sight)
    rounds: list[Round] = []
    for number in range(_ROUNDS):
        if number:
            if _is_enough(site, covered, sight):
                break
            spots = _poses(site, covered, sight)
            if not spots:
                break
            covered = cover(site, [*covered.pieces, *spots])
            what = f"pauses at {len(spots)} poses of their own, and the speeds again"
        else:
            what, pieces = _stripes(own, covered, known)
            covered = cover(site, pieces)
        covered = choose_speeds(site, covered, sight)
        rounds.append(Round(what, share_held(site, covered, sight), covered.spray_s))
        progress("repairing", (number + 1) / _ROUNDS)
    return cover(own, covered.pieces), tuple(rounds)


def _stripes(site: PartSite, covered: Covered, sight: Sight) -> tuple[str, Sequence[Piece]]:
    chosen = choose_stripes(site, sight)
    speeds = "a speed for each segment, by a linear program"
    if chosen is None:
        return speeds, covered.pieces
    return f"{len(chosen.pieces)} stripes chosen among {chosen.candidates}, and {speeds}", chosen.pieces


def _greedy(site: PartSite, view: csr_array, missing: Scalars, sight: Sight) -> list[tuple[int, float]]:
    """Choose rows of a view and seconds for each, the one that helps most first, until what is left is little."""
    areas = site.cells.areas_mm2
    least = _LEAST_SHARE * float((areas * sight.visible).sum()) * site.spec.required_s
    chosen: list[tuple[int, float]] = []
    missing = missing.copy()
    while len(chosen) < _MOST_AT_ONCE:
        gains = np.asarray(view @ (areas * missing))
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


def _poses(site: PartSite, covered: Covered, sight: Sight) -> list[Piece]:
    """Pauses at poses of their own, of those that are known to see what nothing else does."""
    required = MARGIN * site.spec.required_s
    missing = np.where(sight.visible, np.maximum(required - covered.seconds, 0.0), 0.0)
    lacking = np.flatnonzero(missing > _MUCH * site.spec.required_s)  # what hardly misses it depends on rounding
    if not len(lacking):
        return []
    some = lacking[np.unique(np.linspace(0, len(lacking) - 1, _LOOKED_AT).round().astype(np.int64))]
    tcp, approach = poses_around(site, some)
    known = lacking[np.isfinite(sight.tcp[lacking, 0])]
    tcp, approach = np.vstack([tcp, sight.tcp[known]]), np.vstack([approach, sight.approach[known]])
    view = view_of(site, held_at(tcp, approach))
    found: list[Piece] = []
    for row, seconds in _greedy(site, view, missing, sight):
        cells = view.indices[view.indptr[row] : view.indptr[row + 1]]
        helped = np.bincount(site.cell_face[cells], (site.cells.areas_mm2 * missing)[cells])
        found.append(spot(site, site.part.faces[int(np.argmax(helped))].name, tcp[row], approach[row], seconds))
    return found
