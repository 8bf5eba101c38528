"""A bound to the time of spraying: what no stripes and speeds of a family of poses can beat.

The family has the poses of least tilt over places all over the sprayed faces, in every azimuth that has the least tilt,
with no stripes and no ways between. Its linear program is solved by column generation until no pose of the family is
left to add: a dual solution proves the bound for all of them.
"""

from dataclasses import dataclass, fields, replace

import numpy as np
from scipy.sparse import csr_array

from geometry.arrays import Directions, Indices, Points, Scalars
from geometry.coverage.time_bound import least_time_bound
from geometry.solids.cone_view import Cells, cut_cells
from rulesengine.surface.coverage import Covered, Sight, held_at, strongest_of, view_of
from rulesengine.surface.negotiate import free_leans
from rulesengine.surface.site import PartSite

_FINE = 0.06
"""Of the footprint's diameter, between neighbouring places of poses; the first program has every third."""
_REQUIRED = 0.11
"""As ``_FINE``, between neighbouring places that are required to be held."""
_MOST_POSES, _MOST_REQUIRED = 10_000, 3000
"""About, and as many places again at rims: a bound of fewer is proven as well, and lower by about 1 %."""
_FIRST = 3
_CUT = 0.08
"""As ``_FINE``: longest edge of the triangles whose middles are looked at, so that no triangulation shows."""
_MOST_CUT = 120_000
_FULL = 1.0 - 1e-9


@dataclass(frozen=True, slots=True)
class LeastSpray:
    """What no plan over the poses of the family can beat; poses that are tilted further might."""

    seconds: float
    """Proven for the family by a dual solution."""
    poses: int
    """In the family."""
    apart_mm: float
    """About, between neighbouring places of its poses."""
    cells: int
    """Of those that the plan holds: so many places are required to be held."""


def least_spray(site: PartSite, covered: Covered, sight: Sight) -> LeastSpray:
    """Bound the time that poses of least tilt need to hold what a plan holds.

    Fewer places are required than the plan holds, and times may be shared among poses at will, so that it stays one.
    """
    held = sight.visible & (covered.seconds >= site.spec.required_s * _FULL)
    area = float(site.cells.areas_mm2.sum())
    longest = max(_CUT * site.diameter_mm, float(np.sqrt(4.0 * area / _MOST_CUT)))
    fine = cut_cells(site.cells.triangles, longest)
    face, is_held = site.cell_face[fine.patch], held[fine.patch]
    apart = max(_FINE * site.diameter_mm, float(np.sqrt(area / _MOST_POSES)))
    places = _one_a_cube(fine, face, apart)
    tcp, approach, first = _family(site, fine, places, face, apart)
    spacing = max(_REQUIRED * site.diameter_mm, apart, float(np.sqrt(area / _MOST_REQUIRED)))
    # Those at the rims too: what holds them can hold less else.
    required = np.union1d(_one_a_cube(fine, face, spacing), _outermost(fine, face, spacing))
    required = required[is_held[required]]
    rates = csr_array(view_of(_required_of(site, fine, required), held_at(tcp, approach)).T)
    reached = np.flatnonzero((strongest_of(rates) >= _FULL) & (strongest_of(csr_array(rates[:, first])) >= _FULL))
    if not len(reached):
        return LeastSpray(0.0, len(tcp), apart, 0)
    needed = np.full(len(reached), site.spec.required_s)
    seconds = least_time_bound(csr_array(rates[reached]), needed, first)
    return LeastSpray(seconds, len(tcp), apart, len(reached))


def _one_a_cube(cells: Cells, face: Indices, edge_mm: float) -> Indices:
    """One cell in each cube of each face, the one that is nearest to its middle, ascending."""
    cubes = np.floor(cells.points / edge_mm)
    off = np.linalg.norm(cells.points - (cubes + 0.5) * edge_mm, axis=1)
    return _least_of_each(np.column_stack([face, cubes]).astype(np.int64), off)


def _outermost(cells: Cells, face: Indices, edge_mm: float) -> Indices:
    """One cell in each cube of each face, the one that is farthest from the face's middle, ascending."""
    cubes = np.floor(cells.points / edge_mm)
    total = np.maximum(np.bincount(face, cells.areas_mm2), 1e-12)
    middles = np.column_stack([np.bincount(face, cells.areas_mm2 * along) / total for along in cells.points.T])
    off = -np.linalg.norm(cells.points - middles[face], axis=1)
    return _least_of_each(np.column_stack([face, cubes]).astype(np.int64), off)


def _least_of_each(keys: Indices, values: Scalars) -> Indices:
    """(k,) rows with the least value among those of the same keys (n, m), ascending."""
    order = np.lexsort((np.arange(len(values)), np.round(values, 3), *keys.T))
    changes = (np.diff(keys[order], axis=0) != 0).any(axis=1)
    return np.sort(order[np.concatenate([[True], changes])])


def _family(
    site: PartSite, cells: Cells, places: Indices, face: Indices, apart_mm: float
) -> tuple[Points, Directions, Indices]:
    """(n, 3) orifices and directions at the least tilt over places, and (k,) those of the first program."""
    points, normals = cells.points[places], cells.normals[places]
    leans = free_leans(site, points, normals, site.across(normals))
    least = np.full(len(places), np.inf)
    np.minimum.at(least, leans.point, leans.tilt_deg)
    best = np.flatnonzero(leans.tilt_deg <= least[leans.point] + 1e-9)
    outward, at = leans.outward[best], leans.point[best]
    some = replace(cells, triangles=cells.triangles[places], points=points, normals=normals)
    coarse = np.zeros(len(places), dtype=np.bool_)
    coarse[_one_a_cube(some, face[places], _FIRST * apart_mm)] = True
    return points[at] + outward * site.spec.standoff_mm, -outward, np.flatnonzero(coarse[at])


def _required_of(site: PartSite, cells: Cells, some: Indices) -> PartSite:
    """Give a part with some of its cells alone."""
    fewer = Cells(**{each.name: getattr(cells, each.name)[some] for each in fields(Cells)})
    return replace(site, cells=fewer, cell_face=site.cell_face[fewer.patch])
