"""What reaches the exposed surfaces in one stage."""

from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from cleaning.exposure import accumulate
from cleaning.exposure.accumulate import (
    CellSums,
    MakerVolumes,
    SurfaceLookup,
    accumulate_hits,
    poses_of,
    rays_of,
    trace_batches,
)
from cleaning.jet.jet import Jet
from cleaning.process.stages import Samples, Stage
from cleaning.surface.facets import Facets
from geometry.arrays import Indices, Scalars
from geometry.rays import RayScene
from specs.progress import Progress, no_progress

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
    cell: Indices
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
        return self.volume_mm + self.run_off_mm


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
    components = int(facets.component.max(initial=-1)) + 1
    belongs = np.where(facets.cell_component < 0, components, facets.cell_component)
    surface = SurfaceLookup(scene.planes, facets.cell.astype(np.int32), belongs.astype(np.int32))
    cells = np.zeros((len(facets.cell_areas_mm2), accumulate.SUMS))
    by_maker = MakerVolumes(len(samples.makers), components)
    # Blocks of the growth are even, and end where another template begins.
    evenly = np.linspace(0, len(samples.times), _BLOCKS + 1).round().astype(np.int64)
    blocks = np.union1d(evenly, np.flatnonzero(samples.templates[1:] != samples.templates[:-1]) + 1)
    step, count = max(1, _BATCH_RAYS // rays_per_sample), len(samples.times)
    batches = [(first, min(first + step, count)) for first in range(0, count, step)]
    grown: list[tuple[Indices, Scalars]] = []
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
                wetter = np.flatnonzero(cells[:, accumulate.VOLUME] > before)
                grown.append((wetter, cells[wetter, accumulate.VOLUME] - before[wetter]))
                before = cells[:, accumulate.VOLUME].copy()
                progress(str(stage.made_by), last / count)
    growth = _growth(grown, samples, blocks, facets)
    exposure = _exposure_of(stage, jet, facets, rays_per_sample, cells, growth)
    return replace(exposure, by_maker_mm3=by_maker.by_component())


def _growth(grown: list[tuple[Indices, Scalars]], samples: Samples, blocks: Indices, facets: Facets) -> Growth:
    last = blocks[1:] - 1
    ends = samples.times[last] + samples.seconds[last] / 2
    cells = [cells for cells, _ in grown]
    start = np.cumsum([0, *(len(some) for some in cells)]).astype(np.int64)
    cell = np.concatenate([np.empty(0, dtype=np.int64), *cells])
    volumes = np.concatenate([np.empty(0), *(volumes for _, volumes in grown)])
    return Growth(ends, start, cell, (volumes / facets.cell_areas_mm2[cell]).astype(np.float32))


def _exposure_of(
    stage: Stage, jet: Jet, facets: Facets, rays_per_sample: int, sums: NDArray[np.float64], growth: Growth
) -> Exposure:
    means = sums / facets.cell_areas_mm2[:, None]
    return Exposure(
        cone_s=means[:, accumulate.CONE],
        front_s=means[:, accumulate.FRONT],
        volume_mm=means[:, accumulate.VOLUME],
        peak_pa=sums[:, accumulate.PEAK].copy(),
        impulse_n_pa_s=means[:, accumulate.NORMAL],
        impulse_t_pa_s=means[:, accumulate.TANGENTIAL],
        hits=sums[:, accumulate.HITS].astype(np.int64),
        cone_error_s=np.sqrt(sums[:, accumulate.CONE_SQUARES]) / facets.cell_areas_mm2,
        cone_shared_error_s=_STEP_ERROR * means[:, accumulate.CONE],
        sprayed_mm3=jet.flow_m3_s * 1e9 * stage.spray_s,
        landed_mm3=float(sums[:, accumulate.VOLUME].sum()),
        rays=len(stage.samples.times) * rays_per_sample,
        growth=growth,
    )
