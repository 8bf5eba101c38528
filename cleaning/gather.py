"""What reaches chosen cells, worked out exactly: the answer that ``expose`` estimates by following rays.

Each facet is asked at three places inside it: what every sample of the stage sprays there, and whether anything stands
in between.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cleaning.deck import FRONT
from cleaning.facet_sky import inner_points
from cleaning.facets import Facets
from cleaning.flight import poses_of
from cleaning.jet import Jet
from cleaning.jet_form import JetForm, misses, profile, ray_to, stress_factor
from cleaning.scatter import Poses
from cleaning.scene import Scene, occluded
from cleaning.stages import Stage
from geometry.arrays import Indices, Points, Scalars
from geometry.coverage.compiled import compiled

_START, _CONE, _FRONT, _VOLUME, _NORMAL, _TANGENTIAL, _PEAK, _COLUMNS = 0, 3, 4, 5, 6, 7, 8, 9
_RAYS = 200_000


@dataclass(frozen=True, slots=True, eq=False)
class Gathered:
    """What reaches each of k chosen cells in one stage: the same quantities as in ``Exposure``."""

    cells: Indices
    """(k,) index into the cells of the facets."""
    cone_s: Scalars
    front_s: Scalars
    volume_mm: Scalars
    peak_pa: Scalars
    impulse_n_pa_s: Scalars
    impulse_t_pa_s: Scalars


def gather(stage: Stage, jet: Jet, facets: Facets, scene: Scene, cells: Indices) -> Gathered:
    """Add up, over all samples, what each chosen cell gets.

    Args:
        stage: With samples.
        jet: ``jet_of`` the stage.
        facets: ``build_facets`` of the scene.
        scene: What stands in between.
        cells: (k,) each at most once.
    """
    row = np.full(len(facets.cell_areas_mm2), -1, dtype=np.int64)
    row[cells] = np.arange(len(cells))
    chosen = np.flatnonzero((row[facets.cell] >= 0) & facets.exposed)
    places = inner_points(facets.triangles[chosen]).reshape(-1, 3)
    facet = np.repeat(chosen, 3)
    found = _reached(stage, jet, scene, places, facets.normals[facet])
    whose = row[facets.cell[facet]]
    weights = facets.areas_mm2[facet] / 3
    # A place that sees no sky gets next to nothing and its area is not counted: as where rays are followed.
    sums = [np.bincount(whose, found[:, k] * weights, len(cells)) for k in range(_PEAK - _CONE)]
    peak = np.zeros(len(cells))
    np.maximum.at(peak, whose, found[:, -1])
    cone, front, volume, normal, tangential = (each / facets.cell_areas_mm2[cells] for each in sums)
    return Gathered(cells, cone, front, volume * (0.0 if jet.gas else 1.0), peak, normal, tangential)


def _reached(stage: Stage, jet: Jet, scene: Scene, places: Points, normals: Points) -> NDArray[np.float64]:
    """(n, 6) of (n, 3) places: seconds in cone and front, mm, Pa s, Pa s, and the highest stress."""
    poses = poses_of(stage.samples)
    found = np.zeros((len(places), _COLUMNS - _CONE))
    rows = np.empty((_RAYS + len(poses.tcp), _COLUMNS))
    begin, filled, counts = 0, 0, np.zeros(len(places), dtype=np.int64)
    for k, (place, normal) in enumerate(zip(places, normals, strict=True)):
        counts[k] = look(jet.form, poses, place, normal, rows[filled:])
        filled += int(counts[k])
        if filled >= _RAYS or k == len(places) - 1:
            which = np.repeat(np.arange(begin, k + 1), counts[begin : k + 1])
            _add(scene, rows[:filled], places[which], which, found)
            begin, filled = k + 1, 0
    return found


def _add(scene: Scene, rows: NDArray[np.float64], targets: Points, which: Indices, found: NDArray[np.float64]) -> None:
    """Add what reaches its target unhindered to the place ``which`` it is."""
    free = ~occluded(scene, rows[:, _START:_CONE], targets)
    which, rows = which[free], rows[free]
    for column in range(_CONE, _PEAK):
        found[:, column - _CONE] += np.bincount(which, rows[:, column], len(found))
    np.maximum.at(found[:, _PEAK - _CONE], which, rows[:, _PEAK])


@compiled
def look(
    jet: JetForm,
    poses: Poses,
    place: NDArray[np.float64],
    normal: NDArray[np.float64],
    rows: NDArray[np.float64],
) -> int:
    """Fill one row for each sample that sprays a place, or has it in its outer cone; give back how many there are."""
    count = 0
    for i in range(len(poses.tcp)):
        turn, tcp = poses.axes[i], poses.tcp[i]
        dx, dy, dz = place[0] - tcp[0], place[1] - tcp[1], place[2] - tcp[2]
        z = turn[0, 2] * dx + turn[1, 2] * dy + turn[2, 2] * dz
        x = turn[0, 0] * dx + turn[1, 0] * dy + turn[2, 0] * dz
        y = turn[0, 1] * dx + turn[1, 1] * dy + turn[2, 1] * dz
        if misses(jet, x, y, z):
            continue
        ux, uy, uz, length, spread = ray_to(jet, x, y, z)
        strength, within = profile(jet, ux, uy, uz)
        if strength <= 0.0 and not within:
            continue
        cosine = 0.0
        for axis in range(3):
            along = turn[axis, 0] * ux + turn[axis, 1] * uy + turn[axis, 2] * uz
            cosine -= along * normal[axis]
            rows[count, axis] = place[axis] - along * length
        if cosine <= 0.0:
            continue
        seconds = poses.seconds[i]
        stress = stress_factor(jet, strength, length, spread) * cosine * cosine
        rows[count, _CONE] = seconds if within else 0.0
        rows[count, _FRONT] = seconds if strength > FRONT else 0.0
        rows[count, _VOLUME] = jet.flow_m3_s * 1e9 * jet.scale * strength / spread * cosine * seconds
        rows[count, _NORMAL] = stress * seconds
        rows[count, _TANGENTIAL] = stress * math.sqrt(max(1.0 - cosine * cosine, 0.0)) / cosine * seconds
        rows[count, _PEAK] = stress
        count += 1
    return count
