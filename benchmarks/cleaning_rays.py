"""How fast rays are dealt, cast and added up, against embree alone on the same rays; and how good the sums are.

Run: ``OMP_NUM_THREADS=1 python benchmarks/cleaning_rays.py [--rays 64] [BOARD]``

A ring of 60 degrees sweeps the board 50 mm above its surface, a row every 5 mm, a pose every 0.25 mm. Rates are the
best of some rounds taken in turn. The sums are compared with the exact integral (``exact_exposure``) on cells that are
taken evenly from those that face up. Exposure keeps two processors busy and embree alone one: where others want them
too, the ratio of processor times says more than that on the clock.
"""

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from boards.board import Board
from boards.load import load_board
from cleaning.exposure.exact import exact_exposure
from cleaning.exposure.exposure import Exposure, expose, place_rays, poses_of, rays_of
from cleaning.jet.jet import Jet, jet_of
from cleaning.parameters.load import load_parameters
from cleaning.process.stages import Samples, Stage
from cleaning.surface.facets import Facets, build_facets, build_scene
from geometry.rays import RayScene
from recipes.nozzles import HollowCone
from specs.source import Source

ROUNDS = 5
BATCH = 200_000
HEIGHT_MM, ROW_MM, STEP_MM, SPEED_MM_S = 50.0, 5.0, 0.25, 50.0
CELLS = 150


def sweep(board: Board) -> Samples:
    """Rows along x, there and back."""
    west, south, east, north = board.outline.bounds
    along = np.arange(west - 20, east + 20, STEP_MM)
    rows = [
        np.column_stack([along[:: 1 - 2 * (i % 2)], np.full(len(along), y), np.zeros(len(along))])
        for i, y in enumerate(np.arange(south, north + ROW_MM, ROW_MM))
    ]
    tcp = np.concatenate(rows)
    tcp[:, 2] = board.top_z_mm + HEIGHT_MM
    lasting = np.full(len(tcp), STEP_MM / SPEED_MM_S)
    axes = np.broadcast_to(np.diag([1.0, -1.0, -1.0]), (len(tcp), 3, 3)).copy()
    return Samples(
        np.cumsum(lasting) - lasting / 2,
        lasting,
        tcp,
        axes,
        np.zeros(len(tcp), dtype=np.int64),
        (Source.parse("sweep"),),
    )


def wash(board: Board) -> tuple[Stage, Jet]:
    parameters, samples = load_parameters(), sweep(board)
    stage = Stage(
        made_by=Source.parse("sweep"),
        function="clean",
        use="wash",
        nozzle_name="ring60",
        nozzle=HollowCone(half_angle_deg=30, flow_lpm=2.0),
        solution="saponifier-15",
        liquid=parameters.liquids["saponifier-15"],
        pressure_pa=3.5e5,
        temperature_c=60.0,
        begin_s=0.0,
        end_s=float(samples.seconds.sum()),
        samples=samples,
    )
    return stage, jet_of(stage, parameters.spray)


def bare(stage: Stage, jet: Jet, scene: RayScene, per_sample: int) -> Callable[[], None]:
    """Give embree the same rays, dealt beforehand."""
    rays, poses = rays_of(jet, per_sample), poses_of(stage.samples)
    step = max(1, BATCH // per_sample)
    batches: list[tuple[NDArray[np.float32], NDArray[np.float32]]] = []
    for first in range(0, len(stage.samples.times), step):
        count = min(step, len(stage.samples.times) - first) * per_sample
        out = np.empty((count, 3), dtype=np.float32), np.empty((count, 3), dtype=np.float32)
        place_rays(rays, poses, scene.origin, first, out)
        batches.append(out)

    def run() -> None:
        for origins, directions in batches:
            scene.embree.run(origins, directions)

    return run


def seconds(work: Callable[[], object]) -> NDArray[np.float64]:
    """On the clock, and of all processors together."""
    begin = time.perf_counter(), time.process_time()
    work()
    return np.array([time.perf_counter() - begin[0], time.process_time() - begin[1]])


def judge(stage: Stage, jet: Jet, facets: Facets, scene: RayScene, exposure: Exposure) -> None:
    up = np.flatnonzero(facets.cell_exposed & (facets.cell_normals[:, 2] > 0.9) & (facets.cell_areas_mm2 > 0.5))
    cells = up[:: max(1, len(up) // CELLS)]
    begin = time.perf_counter()
    exact = exact_exposure(stage, jet, facets, scene, cells)
    took = time.perf_counter() - begin
    hits = exposure.hits[cells]
    print(f"exact integral of {len(cells)} cells: {took:.2f} s; {np.median(hits):.0f} hits a cell (median)")
    for name in ("volume_mm", "cone_s", "front_s", "impulse_n_pa_s", "impulse_t_pa_s"):
        known, found = getattr(exact, name), getattr(exposure, name)[cells]
        error = (found - known)[known > 0] / known[known > 0]
        print(f"  {name:15s} whole {found.sum() / known.sum() - 1:+.2%}, rms of a cell {error.std():.1%}")


def main(words: list[str]) -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("board", nargs="?", type=Path, default=Path("smt-demo"))
    parser.add_argument("--rays", type=int, default=64)
    arguments = parser.parse_args(words)
    board = load_board(arguments.board)
    begin = time.perf_counter()
    scene = build_scene(board)
    middle = time.perf_counter()
    facets = build_facets(board, scene)
    end = time.perf_counter()
    triangles = sum(len(body.patches) for body in board.bodies)
    print(
        f"{board.name}: {triangles:,} triangles, scene of {len(facets.areas_mm2):,} in {middle - begin:.2f} s, "
        f"{len(facets.cell_areas_mm2):,} cells in {end - middle:.2f} s"
    )
    stage, jet = wash(board)
    exposure = expose(stage, jet, facets, scene, arguments.rays)
    alone = bare(stage, jet, scene, arguments.rays)
    ours, theirs = np.full(2, np.inf), np.full(2, np.inf)
    for _ in range(ROUNDS):
        ours = np.minimum(ours, seconds(lambda: expose(stage, jet, facets, scene, arguments.rays)))
        theirs = np.minimum(theirs, seconds(alone))
    print(
        f"{exposure.rays:,} rays: exposure {exposure.rays / ours[0] / 1e6:.2f} M/s ({ours[0]:.2f} s), "
        f"embree alone {exposure.rays / theirs[0] / 1e6:.2f} M/s, ratio {theirs[0] / ours[0]:.2f} on the clock, "
        f"{theirs[1] / ours[1]:.2f} of processor time; landed {exposure.landed_mm3 / exposure.sprayed_mm3:.1%}"
    )
    judge(stage, jet, facets, scene, exposure)


if __name__ == "__main__":
    main(sys.argv[1:])
