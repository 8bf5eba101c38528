"""Choice of stripes: few of many candidates, with which all is held in little time.

Stripes of equal bands are as wide as the cone allows; where they lie is left to chance. Here candidates lie so near to
each other that any place is near one, from edge to edge; one program over the times of all their segments, in which
each stripe that is used costs a fixed time too, leaves few.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array

from geometry.coverage.time_bound import times_of_few_groups
from geometry.solids.cone_view import Cells
from recipes.paths import Surface
from rulesengine.surface.coverage import Sight, cover, strongest_of
from rulesengine.surface.negotiate import negotiate_sides
from rulesengine.surface.piece import Piece, seconds_along
from rulesengine.surface.site import PartSite
from rulesengine.surface.speeds import rates_of
from rulesengine.surface.striping.divide import candidate_stripes

_APART = 0.125
"""Of the footprint's diameter, between neighbouring candidates."""
_WIDEST = 0.35
"""As ``_APART``: farther from each other they are no choice."""
_DIRECTIONS = 2
_MOST_POSES = 15_000
"""Of all candidates."""
_SETUP_S = 0.3
"""What a stripe costs beside its spraying: the way to it, and its beginning and end at rest."""
_LEAST_S = 0.1
_REACHED = 0.9
_MOST_CELLS = 8000


@dataclass(frozen=True, slots=True, eq=False)
class Chosen:
    """Pieces of the stripes that were chosen."""

    pieces: list[Piece]
    candidates: int
    """Pieces that they were chosen of."""


def choose_stripes(site: PartSite, sight: Sight) -> Chosen | None:
    """Choose stripes for the faces of a part among candidates an eighth of the footprint's diameter apart.

    Returns:
        ``None`` where the template states how wide stripes are, or the part is too large for as many candidates.
    """
    area = sum(face.area_mm2 for face in site.part.served)
    apart = max(_APART * site.diameter_mm, _DIRECTIONS * area / (_MOST_POSES * site.step_mm))
    if not isinstance(site.spec, Surface) or site.spec.width_mm != "auto" or apart > _WIDEST * site.diameter_mm:
        return None
    fine = replace(site, spec=site.spec.model_copy(update={"width_mm": apart}))
    stripes = [stripe for face in site.part.served for stripe in candidate_stripes(fine, face)]
    candidates = [piece for piece in negotiate_sides(fine, stripes) if len(piece.tcp) > 1]
    if not candidates:
        return None
    owner = np.repeat(np.arange(len(candidates)), [len(piece.seconds) for piece in candidates])
    rates = csr_array(rates_of(cover(_with_some_cells(site, sight), candidates))[:, : len(owner)])
    cells = np.flatnonzero(strongest_of(rates) >= _REACHED)
    required = np.full(len(cells), site.spec.required_s)
    fastest = [seconds_along(site, each.targets, each.tcp, each.approach, site.max_speed_mm_s) for each in candidates]
    times = times_of_few_groups(csr_array(rates[cells]), required, owner, np.concatenate(fastest), _SETUP_S)
    spent = np.bincount(owner, times, len(candidates))
    chosen = [_may_pause(site, piece) for piece, time in zip(candidates, spent, strict=True) if time > _LEAST_S]
    return Chosen(chosen, len(candidates))


def _with_some_cells(site: PartSite, sight: Sight) -> PartSite:
    """Give a part with some of its visible cells, evenly spread in their order."""
    visible = np.flatnonzero(sight.visible)
    some = visible[np.unique(np.linspace(0, len(visible) - 1, min(len(visible), _MOST_CELLS)).round().astype(np.int64))]
    cells = site.cells
    fewer = Cells(
        cells.triangles[some], cells.points[some], cells.normals[some], cells.areas_mm2[some], cells.patch[some]
    )
    return replace(site, cells=fewer, cell_face=site.cell_face[some])


def _may_pause(site: PartSite, piece: Piece) -> Piece:
    """Give a piece pauses at its ends, where it is at rest: a program chooses how long they are."""
    pauses = np.zeros(len(piece.tcp))
    pauses[[0, -1]] = site.spec.required_s
    return replace(piece, pauses_s=pauses)
