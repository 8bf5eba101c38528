"""What reaches the exposed surfaces in one stage."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from cleaning.jet.compiled_jet import KNIFE, JetForm, stress_factor
from cleaning.jet.jet import Jet
from cleaning.jet.jet_coordinates import ray_samples_of
from cleaning.process.stages import Samples, Stage
from cleaning.surface.facets import Facets
from cleaning.threads import map_in_threads, thread_count
from geometry.arrays import Indices, Scalars
from geometry.compiled import inner, quick
from geometry.rays import RayScene, cast_rays
from specs.progress import Progress, no_progress

VOLUME, CONE, FRONT, NORMAL, TANGENTIAL, PEAK, HITS, CONE_SQUARES = range(8)
"""Columns of what is added up for each cell: volumes in mm³, the rest times area in mm²; the last squares of what each
ray adds to CONE."""
SUMS = 8
"""A row is one line of the cache."""
_GRAZING = 1e-6


class Rays(NamedTuple):
    """Ray samples for compiled code, one row a ray."""

    rows: NDArray[np.float64]
    """(n, 8): start x, direction, strength, inside, front, spread."""
    per_sample: int
    """How many are placed at each sample."""


class Poses(NamedTuple):
    """The samples of a stage for compiled code."""

    seconds: NDArray[np.float64]
    tcp: NDArray[np.float64]
    axes: NDArray[np.float64]
    maker: NDArray[np.int64]


class SurfaceLookup(NamedTuple):
    """The faces that rays hit, and the cells that they belong to."""

    planes: NDArray[np.float64]
    """(m, 4)"""
    cell: NDArray[np.int32]
    """(m,)"""
    component: NDArray[np.int32]
    """(c,) of each cell; the number of components for what belongs to none."""


class CellSums(NamedTuple):
    """What is added up."""

    cells: NDArray[np.float64]
    """(c, SUMS)"""
    makers: NDArray[np.float64]
    """(makers of some samples, components + 1) mm³; the last column is what belongs to no component."""
    maker: Indices
    """(those samples,) row of each sample's maker."""


class MakerVolumes:
    """What each maker left on each component, mm³: few meet, so that only what is not nothing is kept.

    Sums are made in the order of the samples, whoever made those in between: ``of`` lays out the rows of some samples'
    makers as far as they have come, and ``keep`` takes them back.
    """

    def __init__(self, makers: int, components: int) -> None:
        self._shape = (makers, components + 1)
        self._kept: dict[int, tuple[Indices, NDArray[np.float64]]] = {}

    def of(self, makers: Indices) -> NDArray[np.float64]:
        """Rows of some makers."""
        rows = np.zeros((len(makers), self._shape[1]))
        for row, maker in zip(rows, makers.tolist(), strict=True):
            if maker in self._kept:
                columns, values = self._kept[maker]
                row[columns] = values
        return rows

    def keep(self, makers: Indices, rows: NDArray[np.float64]) -> None:
        """Take rows back."""
        for row, maker in zip(rows, makers.tolist(), strict=True):
            columns = np.flatnonzero(row)
            self._kept[maker] = (columns, row[columns])

    def by_component(self) -> csr_array:
        """(components + 1, makers) all of it."""
        kept = self._kept.items()
        component = np.concatenate([np.empty(0, dtype=np.int64), *(columns for _, (columns, _) in kept)])
        volume = np.concatenate([np.empty(0), *(values for _, (_, values) in kept)])
        maker = np.repeat(list(self._kept), [len(columns) for _, (columns, _) in kept]).astype(np.int64)
        return csr_array((volume, (component, maker)), shape=self._shape[::-1])


@quick
def place_rays(
    rays: Rays,
    poses: Poses,
    origin: NDArray[np.float64],
    first: int,
    out: tuple[NDArray[np.float32], NDArray[np.float32]],
) -> None:
    """Place the rays of some samples, beginning with sample ``first``; origins are counted from ``origin``."""
    origins, directions = out
    count, total = rays.per_sample, len(rays.rows)
    for i in range(len(origins) // count):
        tcp, axes = poses.tcp[first + i], poses.axes[first + i]
        next_ray = (first + i) * count % total
        for k in range(count):
            row = rays.rows[next_ray]
            next_ray = next_ray + 1 if next_ray + 1 < total else 0
            ray = i * count + k
            for axis in range(3):
                origins[ray, axis] = tcp[axis] - origin[axis] + axes[axis, 0] * row[0]
                directions[ray, axis] = axes[axis, 0] * row[1] + axes[axis, 1] * row[2] + axes[axis, 2] * row[3]


@inner
def spread_at(jet: JetForm, z: float, y: float, length: float) -> float:
    """Area at right angles to a ray over which a unit of density coordinates has spread, mm²; (y, z) its direction."""
    if jet.kind != KNIFE:
        return length * length
    return length * z * (z + y * y / z) * (jet.half_slot_mm + length * z * math.tan(jet.wide))


@quick
def accumulate_hits(
    jet: JetForm,
    rays: Rays,
    poses: Poses,
    surface: SurfaceLookup,
    landed: tuple[int, NDArray[np.int32], bool],
    totals: CellSums,
) -> None:
    """Add up what the rays of some samples bring.

    Args:
        jet: Whose rays.
        rays: Its samples.
        poses: The samples.
        surface: What is hit.
        landed: The first sample, (n,) faces hit or -1, and whether the jet leaves liquid.
        totals: What is added to.
    """
    first, faces, wets = landed
    count, total = rays.per_sample, len(rays.rows)
    flow_mm3_s = jet.flow_m3_s * 1e9
    for i in range(len(faces) // count):
        sample = first + i
        seconds = poses.seconds[sample] / count
        tcp, axes = poses.tcp[sample], poses.axes[sample]
        by_maker = totals.makers[totals.maker[i]]
        next_ray = sample * count % total
        for k in range(count):
            row = rays.rows[next_ray]
            next_ray = next_ray + 1 if next_ray + 1 < total else 0
            face = faces[i * count + k]
            if face < 0:
                continue
            plane = surface.planes[face]
            facing = 0.0
            away = plane[3]
            for axis in range(3):
                along = axes[axis, 0] * row[1] + axes[axis, 1] * row[2] + axes[axis, 2] * row[3]
                facing += plane[axis] * along
                away -= plane[axis] * (tcp[axis] + axes[axis, 0] * row[0])
            cell = surface.cell[face]
            sums = totals.cells[cell]
            sums[HITS] += 1.0
            volume = flow_mm3_s * jet.scale * row[4] * row[7] * seconds
            if wets:
                sums[VOLUME] += volume
                by_maker[surface.component[cell]] += volume
            cosine = abs(facing)
            if cosine < _GRAZING:
                continue
            length = max(away / facing, 1e-3)
            spread = spread_at(jet, row[3], row[2], length)
            area_s = spread / cosine * row[7] * seconds
            sums[CONE] += row[5] * area_s
            sums[CONE_SQUARES] += row[5] * area_s * area_s
            sums[FRONT] += row[6] * area_s
            stress = stress_factor(jet, row[4], length, spread) * cosine * cosine
            sums[NORMAL] += stress * area_s
            sums[TANGENTIAL] += stress * math.sqrt(max(1.0 - cosine * cosine, 0.0)) / cosine * area_s
            sums[PEAK] = max(sums[PEAK], stress)


def poses_of(samples: Samples) -> Poses:
    """Lay samples out for compiled code."""
    given = (samples.seconds, samples.tcp, samples.axes)
    seconds, tcp, axes = (np.ascontiguousarray(each, dtype=np.float64) for each in given)
    return Poses(seconds, tcp, axes, np.ascontiguousarray(samples.made_by, dtype=np.int64))


def rays_of(jet: Jet, per_sample: int) -> Rays:
    """Lay the ray samples of a jet out for compiled code, so many rays to a pose."""
    samples = ray_samples_of(jet.form)
    columns = [samples.starts, *samples.directions.T, samples.strength, samples.inside, samples.front, samples.spread]
    return Rays(np.column_stack(columns).astype(np.float64), per_sample)


def trace_batches(
    rays: Rays, poses: Poses, scene: RayScene, batches: Sequence[tuple[int, int]]
) -> Iterator[NDArray[np.int32]]:
    """Follow the rays of batch after batch of samples, given by first and last + 1.

    With several threads the next batches are traced while the caller works on one.

    Yields:
        (n,) face that each ray of a batch hits, or -1.
    """
    most = max((last - first for first, last in batches), default=0) * rays.per_sample
    rooms = [
        (np.empty((most, 3), dtype=np.float32), np.empty((most, 3), dtype=np.float32)) for _ in range(thread_count())
    ]

    def trace(number: int) -> NDArray[np.int32]:
        first, last = batches[number]
        count = (last - first) * rays.per_sample
        # The batch that had this room before is done: its result was taken before this one was begun.
        origins, directions = (each[:count] for each in rooms[number % len(rooms)])
        place_rays(rays, poses, scene.origin, first, (origins, directions))
        return cast_rays(scene, origins, directions)

    yield from map_in_threads(trace, range(len(batches)))


_BLOCKS = 160
_BATCH_RAYS = 50_000
"""What they need fits into the cache of a processor."""
_STEP_ERROR = 0.01
"""Share of a time in the cone; cells whose rays are not replaced belong to surfaces that many passes cross."""


@dataclass(frozen=True, slots=True, eq=False)
class Growth:
    """The deposited volume as it grows with time: in block k cell ``cell[i]`` gains ``volume_mm[i]``.

    No block holds what two templates of the recipe spray.
    """

    until_s: Scalars
    """(b,) end of each block, from the beginning of the program, ascending."""
    start: Indices
    """(b + 1,) where each block's entries begin in the arrays below, and where the last ends."""
    cell: NDArray[np.int32]
    """(k,) index into the cells of the facets."""
    volume_mm: NDArray[np.float32]
    """(k,)"""
    film_mm: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 0), dtype=np.float32))
    """(b, nodes) what the film supplies to each node of the board in each block; none where it was not followed."""


@dataclass(frozen=True, slots=True, eq=False)
class Exposure:
    """What reaches each of c cells (``Facets``) in one stage. Zero where nothing does."""

    cone_s: Scalars
    """(c,) time in the outer cone, visible: the 1993 metric."""
    front_s: Scalars
    """(c,) time in which the flux is above a tenth of its peak."""
    volume_mm: Scalars
    """(c,) deposited volume per area."""
    peak_pa: Scalars
    """(c,) highest normal stress."""
    impulse_n_pa_s: Scalars
    """(c,) normal stress over time."""
    impulse_t_pa_s: Scalars
    """(c,) tangential stress over time."""
    hits: Indices
    """(c,) rays that landed: fewer than 30 are too few."""
    cone_error_s: Scalars
    """(c,) standard error of ``cone_s``: of rays as if each fell at random, which is more than it is."""
    cone_shared_error_s: Scalars
    """(c,) standard error of ``cone_s`` that neighbouring cells share, such as from following the way in steps."""
    sprayed_mm3: float
    """Volume that left the nozzle."""
    landed_mm3: float
    """Share of it that landed on a facet; the rest missed the board."""
    rays: int
    growth: Growth
    run_off_mm: Scalars = field(default_factory=lambda: np.zeros(1))
    """(c,) volume per area that flows over what has landed elsewhere: in the film, and from a top down its walls.
    (1,) where that was not followed."""
    by_maker_mm3: csr_array = field(default_factory=lambda: csr_array((1, 0)))
    """(components + 1, makers of the stage's samples) volume that each maker left on each component; in the last row
    what lies on the bare board and on fixtures."""

    @property
    def supply_mm(self) -> Scalars:
        """(c,) volume per area that lands on a cell or flows over it."""
        return self.supply_on(slice(None))

    def supply_on(self, cells: Indices | slice) -> Scalars:
        """``supply_mm`` of some cells."""
        return self.volume_mm[cells] + np.broadcast_to(self.run_off_mm, self.volume_mm.shape)[cells]


def expose(
    stage: Stage, jet: Jet, facets: Facets, scene: RayScene, rays_per_sample: int = 64, progress: Progress = no_progress
) -> Exposure:
    """Follow rays of the jet from every sample of a stage, and add up what they bring to each cell.

    Args:
        stage: With samples; no sample, no exposure.
        jet: ``jet_of`` the stage.
        facets: ``build_facets`` of the scene.
        scene: What casts shadows.
        rays_per_sample: At least 1; all in all a cell should be hit 30 times.
        progress: Receives the stage and the share done.
    """
    samples = stage.samples
    rays, poses = rays_of(jet, rays_per_sample), poses_of(samples)
    # Of int64, the look-up would need twice the memory that compiled code jumps about in.
    components = int(facets.cell_component.max(initial=-1)) + 1
    belongs = np.where(facets.cell_component < 0, components, facets.cell_component)
    surface = SurfaceLookup(scene.planes, facets.cell.astype(np.int32), belongs.astype(np.int32))
    cells = np.zeros((len(facets.cell_areas_mm2), SUMS))
    by_maker = MakerVolumes(len(samples.makers), components)
    # Blocks of the growth are even, and end where another template begins.
    evenly = np.linspace(0, len(samples.times), _BLOCKS + 1).round().astype(np.int64)
    blocks = np.union1d(evenly, np.flatnonzero(samples.templates[1:] != samples.templates[:-1]) + 1)
    step, count = max(1, _BATCH_RAYS // rays_per_sample), len(samples.times)
    batches = [(first, min(first + step, count)) for first in range(0, count, step)]
    grown: list[tuple[NDArray[np.int32], NDArray[np.float32]]] = []
    before = np.zeros(len(cells))
    for (begin, end), traced in zip(batches, trace_batches(rays, poses, scene, batches), strict=True):
        inner = blocks[(blocks > begin) & (blocks < end)].tolist()
        for first, last in pairwise([begin, *inner, end]):
            faces = traced[(first - begin) * rays_per_sample : (last - begin) * rays_per_sample]
            makers, maker = np.unique(poses.maker[first:last], return_inverse=True)
            totals = CellSums(cells, by_maker.of(makers), maker.astype(np.int64))
            accumulate_hits(jet.form, rays, poses, surface, (first, faces, not jet.gas), totals)
            by_maker.keep(makers, totals.makers)
            if last in blocks:
                wetter = np.flatnonzero(cells[:, VOLUME] > before)
                more = (cells[wetter, VOLUME] - before[wetter]) / facets.cell_areas_mm2[wetter]
                grown.append((wetter.astype(np.int32), more.astype(np.float32)))
                before = cells[:, VOLUME].copy()
                progress(str(stage.made_by), last / count)
    lasts = blocks[1:] - 1
    growth = Growth(
        samples.times[lasts] + samples.seconds[lasts] / 2,
        np.cumsum([0, *(len(wetter) for wetter, _ in grown)]).astype(np.int64),
        np.concatenate([np.empty(0, dtype=np.int32), *(wetter for wetter, _ in grown)]),
        np.concatenate([np.empty(0, dtype=np.float32), *(more for _, more in grown)]),
    )
    exposure = _exposure_of(stage, jet, facets, rays_per_sample, cells, growth)
    return replace(exposure, by_maker_mm3=by_maker.by_component())


def _exposure_of(
    stage: Stage, jet: Jet, facets: Facets, rays_per_sample: int, sums: NDArray[np.float64], growth: Growth
) -> Exposure:
    means = sums / facets.cell_areas_mm2[:, None]
    return Exposure(
        cone_s=means[:, CONE],
        front_s=means[:, FRONT],
        volume_mm=means[:, VOLUME],
        peak_pa=sums[:, PEAK].copy(),
        impulse_n_pa_s=means[:, NORMAL],
        impulse_t_pa_s=means[:, TANGENTIAL],
        hits=sums[:, HITS].astype(np.int64),
        cone_error_s=np.sqrt(sums[:, CONE_SQUARES]) / facets.cell_areas_mm2,
        cone_shared_error_s=_STEP_ERROR * means[:, CONE],
        sprayed_mm3=jet.flow_m3_s * 1e9 * stage.spray_s,
        landed_mm3=float(sums[:, VOLUME].sum()),
        rays=len(stage.samples.times) * rays_per_sample,
        growth=growth,
    )
