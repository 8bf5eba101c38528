"""A bound to the time of spraying: a linear program over poses of least tilt over the faces, without any stripes.

The poses stand on a grid, so that it is an estimate: others, between them or tilted further, might need less.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from geometry.arrays import Directions, Indices, Points
from geometry.coverage.time_bound import least_time_bound
from rulesengine.surface.coverage import Covered, Sight, held_at, strongest_of, view_of
from rulesengine.surface.negotiate import free_leans
from rulesengine.surface.site import PartSite

_APART = 0.16
"""Of the footprint's diameter, between neighbouring poses."""
_MOST_POSES, _MOST_CELLS = 4000, 6000
_FULL = 1.0 - 1e-9


@dataclass(frozen=True, slots=True)
class LeastSpray:
    """What no plan over these poses can beat; other poses might, so that it is an estimate and no proof."""

    seconds: float
    """Bound by a dual solution."""
    poses: int
    apart_mm: float
    """About, between neighbouring places of the poses."""
    cells: int
    """Of those that the plan holds: so many are required to be held."""


def least_spray(site: PartSite, covered: Covered, sight: Sight) -> LeastSpray:
    """Bound the time that poses of least tilt need to hold what a plan holds.

    The poses are free, at the least tilt over places of the faces, in every azimuth that has it; times may be shared
    among them at will, with no way between. Fewer cells are required than the plan holds, so that the bound stays one.
    """
    tcp, approach = _upright(site)
    view = view_of(site, held_at(tcp, approach))
    rates = csr_array(view.T)
    strongest = strongest_of(rates)
    held = covered.seconds >= site.spec.required_s * _FULL
    cells = np.flatnonzero(sight.visible & held & (strongest >= _FULL))
    cells = cells[_evenly(len(cells), _MOST_CELLS)]
    count, apart = len(tcp), _apart_mm(site)
    if not len(cells):
        return LeastSpray(0.0, count, apart, 0)
    required = site.spec.required_s
    seconds = least_time_bound(csr_array(rates[cells]), np.full(len(cells), required))
    return LeastSpray(seconds, count, apart, len(cells))


def _upright(site: PartSite) -> tuple[Points, Directions]:
    """(n, 3) orifices and directions at the least tilt over places of the served faces."""
    places = _places(site)
    points, normals = site.cells.points[places], site.cells.normals[places]
    leans = free_leans(site, points, normals, site.across(normals))
    least = np.full(len(places), np.inf)
    np.minimum.at(least, leans.point, leans.tilt_deg)
    best = np.flatnonzero(leans.tilt_deg <= least[leans.point] + 1e-9)
    best = best[_evenly(len(best), _MOST_POSES)]
    outward = leans.outward[best]
    return points[leans.point[best]] + outward * site.spec.standoff_mm, -outward


def _places(site: PartSite) -> Indices:
    """One cell in each cube of each face, ascending."""
    cubes = np.floor(site.cells.points / _apart_mm(site)).astype(np.int64)
    _, first = np.unique(np.column_stack([cubes, site.cell_face]), axis=0, return_index=True)
    return np.sort(first).astype(np.int64)


def _apart_mm(site: PartSite) -> float:
    """Edge of the cubes; larger for large parts."""
    return max(_APART * site.diameter_mm, float(np.sqrt(site.cells.areas_mm2.sum() / _MOST_POSES)))


def _evenly(count: int, most: int) -> Indices:
    return np.unique(np.linspace(0, max(count - 1, 0), min(count, most)).round().astype(np.int64))
