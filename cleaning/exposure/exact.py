"""What reaches chosen cells, summed exactly over all samples: the result that ``expose`` estimates by ray casting.

Each cell is evaluated at places of its facets, evenly spread by area: what every sample of the stage sprays there, and
whether anything stands in between.
"""

import math
from collections import Counter
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cleaning.exposure.exposure import Poses, poses_of
from cleaning.jet.compiled_jet import JetForm, misses, profile, ray_to, stress_factor
from cleaning.jet.jet import Jet
from cleaning.jet.jet_coordinates import FRONT
from cleaning.process.stages import Stage
from cleaning.surface.facets import Facets
from geometry.arrays import Indices, Points, Scalars
from geometry.compiled import inlined, quick
from geometry.disc_grid import DiscGrid, build_disc_grid
from geometry.rays import RayScene, are_blocked, cast

_CONE, _FRONT, _VOLUME, _NORMAL, _TANGENTIAL, _PEAK, _COLUMNS = range(7)
_RAYS = 200_000
PLACES = 48
"""Of each cell, at which it is evaluated: those of one cell follow those of the cell before in one sequence."""
_LARGEST = 12
_MOMENTS = 24
_LIFT_MM = 1e-3
_WIDE = 2.0
"""Sigmas beyond the half angle that still count as within the cone."""
_FLAT = 1e-3
_R3 = (0.8191725133961645, 0.6710436067037893, 0.5497004779019703)
"""1/g, 1/g² and 1/g³, g the real root of g⁴ = g + 1."""
_FLATTEST = np.radians(89.5)
"""Angle from the vertical beyond which a ray meets the board anywhere."""


class CellPlaces(NamedTuple):
    """The exposed facets of k cells, for compiled code."""

    number: NDArray[np.int64]
    """(k,) index of each cell among all, from which its places follow."""
    centre: Points
    """(k, 3)"""
    normal: Points
    """(k, 3) mean; zero where the facets do not lie in one plane."""
    reach_mm: Scalars
    """(k,) distance from the centre that no facet exceeds."""
    start: NDArray[np.int64]
    """(k + 1,) where the facets of each begin below."""
    triangles: NDArray[np.float64]
    """(m, 3, 3)"""
    normals: Points
    """(m, 3)"""
    passed_mm2: Scalars
    """(m,) area of the facets of the cell up to and with this one."""


@dataclass(frozen=True, slots=True, eq=False)
class ExactExposure:
    """What reaches each of k chosen cells in one stage: the same quantities as in ``Exposure``."""

    cells: Indices
    """(k,) index into the cells of the facets."""
    cone_s: Scalars
    front_s: Scalars
    volume_mm: Scalars
    peak_pa: Scalars
    impulse_n_pa_s: Scalars
    impulse_t_pa_s: Scalars


def exact_exposure(stage: Stage, jet: Jet, facets: Facets, scene: RayScene, cells: Indices) -> ExactExposure:
    """Add up, over all samples, what each chosen cell gets.

    Args:
        stage: With samples.
        jet: ``jet_of`` the stage.
        facets: ``build_facets`` of the scene.
        scene: What stands in between.
        cells: (k,) each at most once.
    """
    shown = np.flatnonzero(facets.cell_exposed[cells])
    layout = places_of(facets, cells[shown])
    places, normals = np.empty((PLACES * len(shown), 3)), np.empty((PLACES * len(shown), 3))
    _spread_places(layout, places, normals)
    found = _reached(stage, jet, scene, places, normals).reshape(len(shown), PLACES, _COLUMNS)
    share = shown_share(facets, cells[shown])
    means, peak = np.zeros((len(cells), _COLUMNS)), np.zeros(len(cells))
    means[shown], peak[shown] = found.mean(axis=1) * share[:, None], found[:, :, _PEAK].max(axis=1, initial=0.0)
    cone, front, volume, normal, tangential = (means[:, k].copy() for k in range(_PEAK))
    volume *= 0.0 if jet.gas else 1.0
    return ExactExposure(cells, cone, front, volume, peak, normal, tangential)


def shown_share(facets: Facets, cells: Indices) -> Scalars:
    """(k,) area of the exposed facets of cells over the area that results are stated for.

    A place that sees no sky gets next to nothing and its area is not counted: as where rays are followed.
    """
    shown = np.bincount(facets.cell, facets.areas_mm2 * facets.exposed, len(facets.cell_areas_mm2))[cells]
    return shown / facets.cell_areas_mm2[cells]


def places_of(facets: Facets, cells: Indices) -> CellPlaces:
    """Lay out the exposed facets of cells for compiled code."""
    row = np.full(len(facets.cell_areas_mm2), -1, dtype=np.int64)
    row[cells] = np.arange(len(cells))
    chosen = np.flatnonzero((row[facets.cell] >= 0) & facets.exposed)
    chosen = chosen[np.argsort(row[facets.cell[chosen]], kind="stable")]
    whose, areas = row[facets.cell[chosen]], facets.areas_mm2[chosen]
    start = np.searchsorted(whose, np.arange(len(cells) + 1))
    before = np.concatenate([[0.0], np.cumsum(areas)])
    centre, normal = facets.cell_centres[cells], facets.cell_normals[cells].copy()
    away = np.linalg.norm(facets.triangles[chosen] - centre[whose, None], axis=2).max(axis=1)
    reach = np.zeros(len(cells))
    np.maximum.at(reach, whose, away)
    turned = np.abs(facets.normals[chosen] - normal[whose]).max(axis=1) > _FLAT
    normal[np.bincount(whose, turned, len(cells)) > 0] = 0.0
    triangles, normals = (np.ascontiguousarray(each[chosen]) for each in (facets.triangles, facets.normals))
    number, passed = cells.astype(np.int64), before[1:] - before[start[whose]]
    return CellPlaces(number, centre, normal, reach, start.astype(np.int64), triangles, normals, passed)


@quick
def _spread_places(places: CellPlaces, found: Points, normals: Points) -> None:
    """Fill in ``PLACES`` places of each cell, all of one cell after those of the other, and the normals there."""
    for k in range(len(places.number)):
        for number in range(PLACES):
            row = k * PLACES + number
            facet = place_of(places, k, places.number[k] % 1024 * PLACES + number + 0.5, found[row])
            for axis in range(3):
                normals[row, axis] = places.normals[facet, axis]


@inlined
def place_of(places: CellPlaces, k: int, number: float, place: Scalars) -> int:
    """Fill in a place of a cell by its number in Roberts' R3 sequence, evenly by area, and give its facet."""
    facet, end = places.start[k], places.start[k + 1]
    passing_mm2 = fraction(number * _R3[0]) * places.passed_mm2[end - 1]
    while facet < end - 1 and places.passed_mm2[facet] < passing_mm2:
        facet += 1
    u, v = fraction(number * _R3[1]), fraction(number * _R3[2])
    if u + v > 1.0:
        u, v = 1.0 - u, 1.0 - v
    triangle = places.triangles[facet]
    for axis in range(3):
        corner = triangle[0, axis]
        place[axis] = corner + u * (triangle[1, axis] - corner) + v * (triangle[2, axis] - corner)
    return facet


@inlined
def fraction(number: float) -> float:
    """Fractional part of a number that is not negative: the remainder of a division takes ten times as long."""
    return number - math.floor(number)


def occluder(cells: Indices, stage: Stage, jet: Jet, facets: Facets, scene: RayScene, in_sight: DiscGrid) -> int:
    """Find the body that most often stands before cells that a stage misses.

    Rays go from the largest of the cells to the nozzle at moments, evenly chosen, in which it points at them.

    Args:
        cells: (k,) cells that are missed.
        stage: Has the nozzle's way.
        jet: Its jet.
        facets: The surface.
        scene: What may stand in the way.
        in_sight: ``samples_in_sight`` of the stage, for these cells among others.

    Returns:
        Index of the body; -1 where nothing stands in the way: the jet never points there, or only from behind.
    """
    largest = cells[np.argsort(-facets.cell_areas_mm2[cells], kind="stable")[:_LARGEST]]
    least = np.cos(jet.half_angle + _WIDE * jet.sigma)
    seen: Counter[int] = Counter()
    for cell in largest.tolist():
        place, normal = facets.cell_centres[cell], facets.cell_normals[cell]
        near = in_sight.near(*place[:2].tolist())
        away = stage.samples.tcp[near] - place
        distance = np.linalg.norm(away, axis=1)
        along = -np.einsum("ij,ij->i", away, stage.samples.axes[near, :, 2]) / distance
        pointing = np.flatnonzero((along > least) & (away @ normal > 0))
        chosen = pointing[np.linspace(0, len(pointing) - 1, min(_MOMENTS, len(pointing))).astype(np.int64)]
        ways = away[chosen] / distance[chosen, None]
        faces, reach = cast(scene, place + _LIFT_MM * normal + np.zeros((len(chosen), 3)), ways)
        blocked = (faces >= 0) & (reach < distance[chosen])
        seen.update(scene.body[faces[blocked]].tolist())
    return min(seen, key=lambda body: (-seen[body], body), default=-1)


class SightLines(NamedTuple):
    """Lines of sight from the nozzle to places, for compiled code; as ``geometry.rays`` takes them."""

    origins: NDArray[np.float32]
    directions: NDArray[np.float32]
    lengths: NDArray[np.float32]
    values: NDArray[np.float64]
    """(n, 6) what reaches the place if nothing stands in between: s, s, mm, Pa s, Pa s, Pa."""
    samples: NDArray[np.int32]
    """(n,)"""
    moments: NDArray[np.int32]
    """(n,) as ``sparse_cells`` numbers them."""
    owners: NDArray[np.int32]
    """(n,) row of the cell in ``sparse_cells``."""


def room_for(lines: int) -> SightLines:
    """Make arrays for lines of sight."""
    origins, directions = (np.empty((lines, 3), dtype=np.float32) for _ in range(2))
    samples, moments, owners = (np.empty(lines, dtype=np.int32) for _ in range(3))
    lengths, values = np.empty(lines, dtype=np.float32), np.empty((lines, _COLUMNS))
    return SightLines(origins, directions, lengths, values, samples, moments, owners)


def samples_in_sight(stage: Stage, jet: Jet, places: Points, reach_mm: Scalars | None = None) -> DiscGrid:
    """Sort the samples of a stage by which of (n, 3) places their jets may point at; at least one place.

    With ``reach_mm`` they may point at any place that is no farther from these than the greatest of it.

    A cone of half angle a about a jet that is tilted by b meets a plane at the depth d between d tan(b - a) and
    d tan(b + a) from the foot of the orifice along the tilt: the disc between the outermost of both over all depths
    holds every place that it meets.
    """
    samples = stage.samples
    jets, low, high = samples.axes[:, :, 2], float(places[:, 2].min()), float(places[:, 2].max())
    down = jets[:, 2] <= 0.0
    deepest = np.maximum(np.where(down, samples.tcp[:, 2] - low, high - samples.tcp[:, 2]), 0.0)
    nearest = np.maximum(np.where(down, samples.tcp[:, 2] - high, low - samples.tcp[:, 2]), 0.0)
    lean = np.hypot(jets[:, 0], jets[:, 1])
    tilt = np.arctan2(lean, np.abs(jets[:, 2]))
    half = max(math.atan(math.sqrt(jet.form.steepest)), jet.half_angle + _WIDE * jet.sigma)
    open_ = tilt + half > _FLATTEST
    outer, inner = np.tan(np.where(open_, 0.0, tilt + half)), np.tan(np.where(open_, 0.0, tilt - half))
    far, close = deepest * outer, np.minimum(deepest * inner, nearest * inner)
    along = jets[:, :2] / np.maximum(lean, 1e-12)[:, None]
    centres = samples.tcp[:, :2] + (0.5 * (far + close))[:, None] * along
    more = 0.0 if reach_mm is None else float(reach_mm.max())
    radii = np.where(open_, np.inf, 0.5 * (far - close) + more)
    return build_disc_grid(centres, radii, places[:, :2])


def _reached(stage: Stage, jet: Jet, scene: RayScene, places: Points, normals: Points) -> NDArray[np.float64]:
    """(n, 6) of (n, 3) places: seconds in cone and front, mm, Pa s, Pa s, the highest stress."""
    found = np.zeros((len(places), _COLUMNS))
    if not len(places):
        return found
    poses, in_sight = poses_of(stage.samples), samples_in_sight(stage, jet, places)
    sights = room_for(_RAYS + int(np.diff(in_sight.start).max()))
    begin, filled, counts = 0, 0, np.zeros(len(places), dtype=np.int64)
    for k, (place, normal) in enumerate(zip(places, normals, strict=True)):
        near = in_sight.near(float(place[0]), float(place[1]))
        counts[k] = lay_sight_lines(jet.form, poses, near, (place, normal, scene.origin), (sights, filled))
        filled += int(counts[k])
        if filled >= _RAYS or k == len(places) - 1:
            blocked = are_blocked(scene, sights.origins[:filled], sights.directions[:filled], sights.lengths[:filled])
            add_visible(sights, blocked, counts[begin : k + 1], found[begin : k + 1])
            begin, filled = k + 1, 0
    return found


@quick
def add_visible(sights: SightLines, blocked: NDArray[np.bool_], counts: Indices, found: NDArray[np.float64]) -> None:
    """Add what is not blocked to its place: each has ``counts`` lines of sight, one after the other."""
    values, k = sights.values, 0
    for place in range(len(counts)):
        for _ in range(counts[place]):
            if not blocked[k]:
                for column in range(_PEAK):
                    found[place, column] += values[k, column]
                found[place, _PEAK] = max(found[place, _PEAK], values[k, _PEAK])
            k += 1


@quick
def lay_sight_lines(
    jet: JetForm,
    poses: Poses,
    near: NDArray[np.int32],
    target: tuple[Points, Points, Points],
    out: tuple[SightLines, int],
) -> int:
    """Lay a line of sight from each sample that sprays a place, or has it in its outer cone.

    Args:
        jet: Whose shape.
        poses: The samples.
        near: Those that may.
        target: (3,) place, (3,) outward normal, and (3,) origin from which the lines are counted.
        out: What is filled, and its first free row.

    Returns:
        How many there are.
    """
    sights, begin = out
    row = begin
    for number in range(len(near)):
        i = near[number]
        if lay_sight_line(jet, poses, i, float(poses.seconds[i]), target, (sights, row)):
            row += 1
    return row - begin


@inlined
def lay_sight_line(
    jet: JetForm,
    poses: Poses,
    i: int,
    seconds: float,
    target: tuple[Points, Points, Points],
    out: tuple[SightLines, int],
) -> bool:
    """Lay one line of sight, as ``lay_sight_lines`` does, from sample ``i`` as if it lasted so many seconds.

    Returns:
        Whether the sample sprays the place.
    """
    place, normal, origin = target
    sights, row = out
    turn, tcp = poses.axes[i], poses.tcp[i]
    dx, dy, dz = place[0] - tcp[0], place[1] - tcp[1], place[2] - tcp[2]
    z = turn[0, 2] * dx + turn[1, 2] * dy + turn[2, 2] * dz
    x = turn[0, 0] * dx + turn[1, 0] * dy + turn[2, 0] * dz
    y = turn[0, 1] * dx + turn[1, 1] * dy + turn[2, 1] * dz
    if misses(jet, x, y, z):
        return False
    ux, uy, uz, length, spread = ray_to(jet, x, y, z)
    cosine = 0.0
    for axis in range(3):
        along = turn[axis, 0] * ux + turn[axis, 1] * uy + turn[axis, 2] * uz
        cosine -= along * normal[axis]
        sights.directions[row, axis] = along
        sights.origins[row, axis] = place[axis] - along * length - origin[axis]
    if cosine <= 0.0:
        return False
    strength, within = profile(jet, ux, uy, uz)
    if strength <= 0.0 and not within:
        return False
    sights.lengths[row], sights.samples[row] = length, i
    values = sights.values[row]
    stress = stress_factor(jet, strength, length, spread) * cosine * cosine
    values[_CONE] = seconds if within else 0.0
    values[_FRONT] = seconds if strength > FRONT else 0.0
    values[_VOLUME] = jet.flow_m3_s * 1e9 * jet.scale * strength / spread * cosine * seconds
    values[_NORMAL] = stress * seconds
    values[_TANGENTIAL] = stress * math.sqrt(max(1.0 - cosine * cosine, 0.0)) / cosine * seconds
    values[_PEAK] = stress
    return True
