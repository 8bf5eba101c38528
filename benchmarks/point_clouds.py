"""From a cloud of 460,000 points to poses without CAD: time, normals, area, and what is held.

    python benchmarks/point_clouds.py [SHAPE ...] [--path surface|geodesic|plane]

The points have 0.1 mm of noise; normals, area and volume are compared with the shape they were drawn from. `poses` is
the time of the clock and of the processor from the file to the plan of `part-degrease`, before timing and pictures, and
its ratio to 20 s. Seconds are those of this machine as it is loaded now.
"""

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from boards.part.load import load_part
from recipes.load import load_recipe, parse_recipe, recipe_library
from rulesengine.planning.pipeline import run
from specs.progress import no_progress

Array = NDArray[np.float64]
COUNT, NOISE_MM, BAR_S = 460_000, 0.1, 20.0
TORUS_MM = (120.0, 40.0)
BOX_MM = np.array([100.0, 80.0, 60.0])


def sheet(rng: np.random.Generator) -> Array:
    x, y = rng.uniform((0, 0), (400, 500), (COUNT, 2)).T
    return np.column_stack([x, y, 10 * np.sin(2 * np.pi * x / 400) * np.cos(2 * np.pi * y / 500)])


def sheet_normals(points: Array) -> Array:
    u, v = 2 * np.pi * points[:, 0] / 400, 2 * np.pi * points[:, 1] / 500
    found = [-np.pi / 20 * np.cos(u) * np.cos(v), np.pi / 25 * np.sin(u) * np.sin(v), np.ones(len(points))]
    return unit(np.column_stack(found))


def sheet_area() -> float:
    x, y = (each.ravel() + 0.5 for each in np.meshgrid(np.arange(400), np.arange(500)))
    return float((1 / sheet_normals(np.column_stack([x, y, 0 * x]))[:, 2]).sum())


def torus(rng: np.random.Generator) -> Array:
    wide, thin = TORUS_MM
    u, v, keep = rng.uniform((0, 0, 0), (np.pi / 2, 2 * np.pi, wide + thin), (2 * COUNT, 3)).T
    even = keep < wide + thin * np.cos(v)
    u, v = u[even][:COUNT], v[even][:COUNT]
    away = wide + thin * np.cos(v)
    return np.column_stack([away * np.cos(u), away * np.sin(u), thin * np.sin(v)])


def torus_normals(points: Array) -> Array:
    ring = TORUS_MM[0] * unit(points * [1, 1, 0])
    return unit(points - ring)


def tube(rng: np.random.Generator) -> Array:
    angle, along = rng.uniform((0, 0), (2 * np.pi, 200), (COUNT, 2)).T
    return np.column_stack([60 * np.cos(angle), 60 * np.sin(angle), along])


def box(rng: np.random.Generator) -> Array:
    points = rng.uniform(0, BOX_MM, (COUNT, 3))
    areas = np.repeat(np.prod(BOX_MM) / BOX_MM, 2)
    side = rng.choice(6, COUNT, p=areas / areas.sum())
    points[np.arange(COUNT), side // 2] = (side % 2) * BOX_MM[side // 2]
    return points


def box_normals(points: Array) -> Array:
    away = np.abs(np.stack([points, points - BOX_MM], axis=2)).reshape(len(points), 6)
    side = np.argmin(away, axis=1)
    normals = np.zeros((len(points), 3))
    normals[np.arange(len(points)), side // 2] = 2.0 * (side % 2) - 1.0
    return normals


def unit(ways: Array) -> Array:
    return ways / np.linalg.norm(ways, axis=1, keepdims=True)


SHAPES = {
    "sheet": (sheet, sheet_normals, sheet_area()),
    "torus": (torus, torus_normals, np.pi**2 * TORUS_MM[0] * TORUS_MM[1]),
    "tube": (tube, lambda points: unit(points * [1, 1, 0]), 2 * np.pi * 60 * 200),
    "box": (box, box_normals, 2 * np.sum(np.prod(BOX_MM) / BOX_MM)),
}


def recipe_of(path: str):
    """The library's `part-degrease`, with the path class in question."""
    if path == "surface":
        return load_recipe("part-degrease")
    text = recipe_library()["part-degrease"].read_text("utf-8")
    text = text.replace("path: surface", "path: slices").replace("striping: longest_edge", f"start: {path}")
    return parse_recipe(text.replace("width_mm: auto", "spacing_mm: auto"))


def measure(name: str, path: str, folder: Path) -> None:
    draw, normals_at, area = SHAPES[name]
    rng = np.random.default_rng(3)
    file = folder / f"{name}.xyz"
    np.savetxt(file, draw(rng) + rng.normal(0, NOISE_MM, (COUNT, 3)), fmt="%.4f")
    recipe = recipe_of(path)
    begin, busy = time.perf_counter(), time.process_time()
    part = load_part(str(file))
    poses: list[tuple[float, float]] = []

    def look(stage: str, share: float) -> None:
        no_progress(stage, share)
        if stage == "building the ways around" and not poses:
            poses.append((time.perf_counter() - begin, time.process_time() - busy))

    done = run(recipe, part, look)
    done = time.process_time() - busy
    middles = part.patches.mean(axis=1)
    off = np.degrees(np.arccos(np.clip((part.normals * normals_at(middles)).sum(axis=1), -1, 1)))
    found = sum(face.area_mm2 for face in part.faces)
    covering, (clock, cpu) = done.coverings[0], poses[0]
    print(
        f"{name:6s} {path:8s} poses {clock:5.1f} s ({clock / BAR_S:.2f} of {BAR_S:.0f} s), processor {cpu:5.1f} s, "
        f"program {done:5.1f} s; normals {np.median(off):.2f} deg, area {found / area - 1:+.1%}; "
        f"{covering.stripes} stripes, {covering.share:.1%} of the visible held, {covering.visible.mean():.1%} visible"
    )


def main() -> None:
    options = argparse.ArgumentParser()
    options.add_argument("shapes", nargs="*", default=list(SHAPES))
    options.add_argument("--path", default="surface", choices=("surface", "geodesic", "plane"))
    chosen = options.parse_args()
    # What is compiled and imported once is not counted.
    warm = recipe_of(chosen.path)
    with tempfile.TemporaryDirectory() as folder:
        small = Path(folder) / "warm.xyz"
        np.savetxt(small, tube(np.random.default_rng(1))[::40], fmt="%.3f")
        run(warm, load_part(str(small)))
        for name in chosen.shapes:
            measure(name, chosen.path, Path(folder))


if __name__ == "__main__":
    main()
