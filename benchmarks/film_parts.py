"""How even a film on four free-form parts becomes, beside Table 1 of Jiangsu 2010.

    OMP_NUM_THREADS=1 python benchmarks/film_parts.py [PART ...]

Sheet z = 10 sin(2 pi x / 400) cos(2 pi y / 500) mm, basin a paraboloid of radius 800 mm, saddle of the same curvatures,
blade twisted by 30 degrees over its length; all 600 x 400 mm in patches of 5 mm. The gun is that of Jiangsu 2010 at
100 mm, 40 um. Films are those of timed programs, on cells finer than those of the linear program and off them.
"""

import sys
import time
from collections.abc import Callable

import numpy as np

from boards.board import Body, Part, Surface
from boards.part.understand import FaceChoice, understand_part
from geometry.arrays import Points, Scalars, Triangles
from geometry.mesh import areas_and_normals
from recipes.load import parse_recipe
from rulesengine.levelling.film_run import lay_films, level_run

RECIPE = """recipe: film
functions: {coat: {solution: paint, pressure_bar: 3, max_speed_mm_s: 700}}
nozzles: {gun: {pattern: radial, radius_mm: 40, at_mm: 100, flow_lpm: 0.0301593, at_bar: 3}}
classes: {}
templates: {passes: {path: slices, standoff_mm: 100, along: [1, 0, 0], film: {thickness_um: 40, tolerance_um: 2}}}
limits: {acceleration_mm_s2: 5000, rotation_acceleration_deg_s2: 5000}
sequence: [{function: coat, nozzle: gun, paths: [passes]}]
"""
PAPER_UM = ((21.88, 57.34), (33.41, 46.68))
"""Table 1: least and greatest thickness before and after its optimisation."""
LENGTH_MM, WIDTH_MM, PATCH_MM = 600.0, 400.0, 5.0


def sheet(x: Scalars, y: Scalars) -> Points:
    return np.column_stack([x, y, 10.0 * np.sin(2 * np.pi * x / 400.0) * np.cos(2 * np.pi * y / 500.0)])


def basin(x: Scalars, y: Scalars) -> Points:
    return np.column_stack([x, y, ((x - 300.0) ** 2 + (y - 200.0) ** 2) / 1600.0])


def saddle(x: Scalars, y: Scalars) -> Points:
    return np.column_stack([x, y, ((x - 300.0) ** 2 - (y - 200.0) ** 2) / 1600.0])


def blade(x: Scalars, y: Scalars) -> Points:
    turn, aside = np.radians(30.0) * (x / LENGTH_MM - 0.5), y - 200.0
    return np.column_stack([x, 200.0 + aside * np.cos(turn), aside * np.sin(turn)])


PARTS: dict[str, Callable[[Scalars, Scalars], Points]] = {
    "sheet": sheet, "basin": basin, "saddle": saddle, "blade": blade,
}  # fmt: skip


def patches_of(place: Callable[[Scalars, Scalars], Points]) -> Triangles:
    """Two patches for each cell of a grid, wound upwards."""
    x, y = (np.linspace(0.0, size, round(size / PATCH_MM) + 1) for size in (LENGTH_MM, WIDTH_MM))
    corners = place(*(each.ravel() for each in np.meshgrid(x, y, indexing="ij"))).reshape(len(x), len(y), 3)
    a, b, c, d = corners[:-1, :-1], corners[1:, :-1], corners[1:, 1:], corners[:-1, 1:]
    return np.concatenate(
        [np.stack([a, b, c], axis=2).reshape(-1, 3, 3), np.stack([a, c, d], axis=2).reshape(-1, 3, 3)]
    )


def part_of(name: str) -> Part:
    """One of the four parts."""
    patches = patches_of(PARTS[name])
    body = Body(name, "part", patches, areas_and_normals(patches.copy())[1], (Surface("s", len(patches)),))
    return understand_part([body], name, FaceChoice(20, ()))


def main(names: list[str]) -> None:
    """Print the table."""
    print("part               spacing  one speed  levelled  timed                   film  spraying  processor")
    for name, (least, most) in zip(("paper, before", "paper, after"), PAPER_UM, strict=True):
        off = (most - least) / (most + least)
        print(f"{name:16}                                ±{100 * off:5.2f} %  {least:6.2f} to {most:5.2f} µm")
    for name in names:
        begin = time.process_time()
        laid = lay_films(parse_recipe(RECIPE), part_of(name))
        _, report = level_run(laid)
        took = time.process_time() - begin
        (step,) = report.steps
        spacing = laid.fitted.templates["passes"].spacing_mm
        before, after, timed = (100.0 * each.finer.deviation for each in (step.before, step.after, step.timed))
        film = step.timed.finer
        print(
            f"{name:16} {spacing:6.2f} mm  ±{before:5.2f} %  ±{after:4.2f} %  ±{timed:4.2f} %  {film.least:6.2f} to "
            f"{film.most:5.2f} µm  {step.spray_after_s:6.1f} s  {took:7.1f} s",
            flush=True,
        )


if __name__ == "__main__":
    main(sys.argv[1:] or list(PARTS))
