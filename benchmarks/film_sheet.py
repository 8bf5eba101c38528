"""How even a film on a curved sheet becomes: constant speed, levelled speeds, and levelled standoffs.

    python benchmarks/film_sheet.py

The sheet is z = 10 sin(2 pi x / 400) cos(2 pi y / 500) mm, the basin a paraboloid of radius 800 mm; both 600 x 400.
The gun is that of Jiangsu 2010. Passes run along x, the nozzle at right angles to the surface, and begin outside the
edge by more than the pattern's radius and a ramp. Films are compared on a finer, shifted grid, and after timing.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from film_standoffs import fit_standoffs, moved
from numpy.typing import NDArray
from scipy.sparse import csr_array

from cleaning.exposure.segment_rates import Segments, segment_rates
from cleaning.jet.jet import form_of
from cleaning.parameters.load import load_parameters
from geometry.coverage.dwell import Unknowns, even_film
from programs.plan import Jet, Origin, Plan, SprayPass, Transfer
from recipes.nozzles import Radial
from recipes.recipe import Limits
from rulesengine.levelling.segments import joined, knots_of, sprayed_moves
from rulesengine.timing.time_plan import time_plan
from specs.source import Source

SIZE_MM = (600.0, 400.0)
STANDOFF_MM, SEGMENT_MM = 100.0, 5.0
FILM_UM, FASTEST_MM_S, ACCELERATION_MM_S2 = 40.0, 700.0, 5000.0
CELL_MM, FINER_MM, JOINED_MM = (2.5, 0.8), 1.83, 2.0
KNOTS = 8
"""Segments from knot to knot: a radius of the pattern."""
CORRECTIONS = 8
"""Linear programs after timing; the timed film that deviates least is taken."""
STEPS = 4
"""Of the programmed speed in a segment."""
POSE = ("tcp", "approach", "reference")
GUN = Radial(radius_mm=40, at_mm=100, flow_lpm=np.pi * 40**4 / 16 * 60e-9)
FORM = form_of(GUN, GUN.flow_lpm, load_parameters("default").spray)

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Surface:
    """A height over the plane, mm, with its slopes."""

    name: str
    section_mm: float
    """The x of the section on which the spacing of passes is measured."""
    height: Callable[[Array, Array], Array]
    slopes: Callable[[Array, Array], tuple[Array, Array]]

    def places(self, x: Array, y: Array) -> tuple[Array, Array]:
        """(n, 3) places and (n, 3) normals."""
        slope_x, slope_y = self.slopes(x, y)
        normals = np.column_stack([-slope_x, -slope_y, np.ones_like(x)])
        return np.column_stack([x, y, self.height(x, y)]), normals / np.linalg.norm(normals, axis=1, keepdims=True)

    def cells(self, pitches: tuple[float, float], shift: tuple[float, float]) -> tuple[Array, Array]:
        """Places on a grid, and their normals."""
        axes = zip(pitches, shift, SIZE_MM, strict=True)
        x, y = (np.arange(share * pitch, size + 1e-9, pitch) for pitch, share, size in axes)
        return self.places(*(grid.ravel() for grid in np.meshgrid(x, y)))

    def lines(self, spacing: float, count: int) -> Array:
        """The y of passes, equally far apart on the surface about the middle of the section."""
        y = np.linspace(-100.0, SIZE_MM[1] + 100.0, 12_001)
        height = self.height(np.full_like(y, self.section_mm), y)
        way = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(y), np.diff(height)))])
        middle = np.interp(SIZE_MM[1] / 2, y, way)
        return np.interp(middle + spacing * (np.arange(count) - (count - 1) / 2), way, y)

    def passes(self, lines: Array, over_mm: float) -> tuple[Segments, int]:
        """Segments of passes along x that begin and end outside the edge, and how many a pass has."""
        count = round((SIZE_MM[0] + 2 * over_mm) / SEGMENT_MM)
        x = np.linspace(-over_mm, SIZE_MM[0] + over_mm, count + 1)
        ends: list[list[Array]] = [[], [], []]
        for line in lines:
            points, normals = self.places(x, np.full_like(x, line))
            aside = np.array([0.0, 1.0, 0.0]) - normals * normals[:, 1:2]
            aside /= np.linalg.norm(aside, axis=1, keepdims=True)
            for values, found in zip((points + STANDOFF_MM * normals, -normals, aside), ends, strict=True):
                found.append(np.stack([values[:-1], values[1:]], axis=1))
        tcp, approach, reference = (np.concatenate(each) for each in ends)
        return Segments(tcp, approach, reference), count


def sheet_slopes(x: Array, y: Array) -> tuple[Array, Array]:
    u, v = 2.0 * np.pi * x / 400.0, 2.0 * np.pi * y / 500.0
    return np.pi / 20.0 * (np.cos(u) * np.cos(v)), -np.pi / 25.0 * (np.sin(u) * np.sin(v))


SHEET = Surface(
    "sheet", 200.0, lambda x, y: 10.0 * np.sin(2.0 * np.pi * x / 400.0) * np.cos(2.0 * np.pi * y / 500.0), sheet_slopes
)
BASIN = Surface(
    "basin", 300.0, lambda x, y: ((x - 300.0) ** 2 + (y - 200.0) ** 2) / 1600.0,
    lambda x, y: ((x - 300.0) / 800.0, (y - 200.0) / 800.0),
)  # fmt: skip


def timed(segments: Segments, passes: int, seconds: Array) -> tuple[Segments, Array]:
    """Moves with the jet on of the timed program of passes with (segments,) times, and their seconds."""
    jet, made_by = Jet("coat", "gun", "paint", GUN.flow_lpm, liquid=True), Source(0, "passes")
    count = len(seconds) // passes
    steps = np.arange(STEPS * count + 1) / STEPS
    speeds = segments.lengths / seconds
    items: list[SprayPass | Transfer] = []
    for number in range(passes):
        mine = slice(number * count, (number + 1) * count)
        tcp, approach, reference = (
            along(steps, np.concatenate([each[mine, 0], each[mine][-1:, 1]]))
            for each in (segments.tcp, segments.approach, segments.reference)
        )
        approach /= np.linalg.norm(approach, axis=1, keepdims=True)
        reference -= approach * np.sum(approach * reference, axis=1, keepdims=True)
        reference /= np.linalg.norm(reference, axis=1, keepdims=True)
        paces = along((steps[1:] + steps[:-1] - 1) / 2, 1.0 / speeds[mine, None])[:, 0]
        here = SprayPass(tcp, approach, reference, np.minimum(1.0 / paces, FASTEST_MM_S), jet, made_by)
        if items:
            ends = [np.stack([getattr(items[-1], each)[-1], getattr(here, each)[0]]) for each in POSE]
            items.append(Transfer(ends[0], ends[1], ends[2], 250.0, made_by))
        items.append(here)
    limits = Limits(acceleration_mm_s2=ACCELERATION_MM_S2)
    program = time_plan(Plan(Origin("sheet", "", "coat", ""), tuple(items), ()), limits)
    return joined(*sprayed_moves(program, lambda source: True), JOINED_MM)


def along(places: Array, values: Array) -> Array:
    """Interpolate (n, k) values that are 1 apart."""
    return np.stack([np.interp(places, np.arange(len(values)), column) for column in values.T], axis=1)


def level(surface: Surface, spacing: float, count: int, constant: float, band_mm: float) -> None:
    """Level one set of passes, and print the films."""
    fastest = min(1.5 * constant, FASTEST_MM_S)
    over = GUN.radius_mm + fastest**2 / (2 * ACCELERATION_MM_S2)
    segments, each = surface.passes(surface.lines(spacing, count), 10 * np.ceil(over / 10))
    lengths = segments.lengths
    weights, pairs = knots_of([each] * count, KNOTS)
    seconds = csr_array(weights.multiply(lengths[:, None]))
    size = weights.shape[1]
    change = ACCELERATION_MM_S2 * KNOTS * SEGMENT_MM / fastest**3
    both = np.concatenate([pairs, pairs[:, ::-1]])
    unknowns = Unknowns(
        np.asarray(seconds.sum(axis=0)).ravel(), np.full(size, 1 / fastest), np.full(size, 1 / 20.0), both,
        np.ones(len(both)), np.full(len(both), change),
    )  # fmt: skip
    cells, finer = surface.cells(CELL_MM, (0.0, 0.0)), surface.cells((FINER_MM, FINER_MM), (0.37, 0.43))
    film = np.full(len(cells[0]), FILM_UM)
    begin = time.process_time()
    shifts = np.zeros((len(lengths), 2))
    if band_mm:
        fit = fit_standoffs(
            lambda trial: segment_rates(FORM, trial, *cells),
            (segments, [each] * count, STANDOFF_MM), (seconds, unknowns), film, band_mm,
        )  # fmt: skip
        shifts = fit.shifts_mm
    way = moved(segments, shifts)
    rates = segment_rates(FORM, way, *cells)
    found = even_film(csr_array(rates @ seconds), film, unknowns)
    planned = times = seconds @ found.values
    first, gap = found.value, found.gap
    there, moves, spent = np.inf, way, times
    for _ in range(CORRECTIONS + 1):
        trial = timed(way, count, times)
        laid = segment_rates(FORM, trial[0], *cells) @ trial[1]
        off = float(np.abs(laid / FILM_UM - 1).max())
        if off < there:
            there, (moves, spent) = off, trial
        # What the motion lays on each cell for what the program lays there.
        shares = laid / (rates @ times)
        found = even_film(csr_array(csr_array(rates * shares[:, None]) @ seconds), film, unknowns)
        times = seconds @ found.values
    took = time.process_time() - begin
    films = {
        "constant": segment_rates(FORM, segments, *finer) @ (lengths / constant),
        "levelled": segment_rates(FORM, way, *finer) @ planned,
        "timed": segment_rates(FORM, moves, *finer) @ spent,
    }
    worst = {name: 100 * np.abs(film / FILM_UM - 1).max() for name, film in films.items()}
    speeds, after = way.lengths / planned, films["timed"]
    print(f"{surface.name}, {count} passes at {spacing} mm, standoff {STANDOFF_MM:g} mm, band {band_mm:g} mm")
    print(f"  constant {constant:g} mm/s   ±{worst['constant']:.2f} % on finer cells, {lengths.sum() / constant:.1f} s")
    print(
        f"  levelled            ±{100 * first:.2f} % on {len(film):,} cells (gap {gap:.0e}), "
        f"±{worst['levelled']:.2f} % on {len(after):,} finer ones; {planned.sum():.1f} s, {speeds.min():.0f} to "
        f"{speeds.max():.0f} mm/s, standoffs {STANDOFF_MM + shifts.min():.1f} to {STANDOFF_MM + shifts.max():.1f} mm"
    )
    print(
        f"  levelled and timed  ±{100 * there:.2f} % on the cells, ±{worst['timed']:.2f} % on the finer ones, "
        f"{after.min():.2f} to {after.max():.2f} um, {spent.sum():.1f} s; {took:.1f} s of processor time",
        flush=True,
    )


if __name__ == "__main__":
    for surface in (SHEET, BASIN):
        level(surface, 48.66, 9, 256.604, 0.0)
        level(surface, 48.66, 9, 256.604, 8.0)
        level(surface, 29.7, 16, 422.5, 0.0)
