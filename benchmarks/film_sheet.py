"""How even a film on a curved sheet becomes: constant speed against levelled speeds, on a finer, shifted grid.

    python benchmarks/film_sheet.py

The sheet is z = 10 sin(2 pi x / 400) cos(2 pi y / 500) mm, 600 x 400; the gun is that of Jiangsu 2010. Passes run
along x, the nozzle at right angles to the surface, and begin outside the edge. The reference is the same passes at the
constant speed that is best on the flat plate.
"""

import time

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import block_diag, csr_array

from cleaning.exposure.segment_rates import Segments, segment_rates
from cleaning.jet.jet import form_of
from cleaning.parameters.load import load_parameters
from geometry.coverage.dwell import Unknowns, even_film
from recipes.nozzles import Radial

SIZE_MM = (600.0, 400.0)
WAVES_MM = (400.0, 500.0)
DEPTH_MM = 10.0
STANDOFF_MM, OVER_MM, SEGMENT_MM = 100.0, 30.0, 10.0
FILM_UM, FASTEST_MM_S, ACCELERATION_MM_S2 = 40.0, 700.0, 5000.0
PITCH_MM = 3.0
GUN = Radial(radius_mm=40, at_mm=100, flow_lpm=np.pi * 40**4 / 16 * 60e-9)

Array = NDArray[np.float64]


def surface(x: Array, y: Array) -> tuple[Array, Array]:
    """(n, 3) places of the sheet and their (n, 3) normals."""
    u, v = 2.0 * np.pi * x / WAVES_MM[0], 2.0 * np.pi * y / WAVES_MM[1]
    slope_x = DEPTH_MM * 2.0 * np.pi / WAVES_MM[0] * np.cos(u) * np.cos(v)
    slope_y = -DEPTH_MM * 2.0 * np.pi / WAVES_MM[1] * np.sin(u) * np.sin(v)
    normals = np.column_stack([-slope_x, -slope_y, np.ones_like(x)])
    points = np.column_stack([x, y, DEPTH_MM * np.sin(u) * np.cos(v)])
    return points, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def cells(pitch: float, shift: tuple[float, float]) -> tuple[Array, Array]:
    """Places on a grid."""
    x, y = (np.arange(share * pitch, size + 1e-9, pitch) for share, size in zip(shift, SIZE_MM, strict=True))
    return surface(*(grid.ravel() for grid in np.meshgrid(x, y)))


def passes(lines: Array) -> Segments:
    """Segments of passes along x, at places across."""
    count = round((SIZE_MM[0] + 2 * OVER_MM) / SEGMENT_MM)
    x = np.linspace(-OVER_MM, SIZE_MM[0] + OVER_MM, count + 1)
    ends: list[list[Array]] = [[], [], []]
    for line in lines:
        points, normals = surface(x, np.full_like(x, line))
        aside = np.array([0.0, 1.0, 0.0]) - normals * normals[:, 1:2]
        aside /= np.linalg.norm(aside, axis=1, keepdims=True)
        for values, found in zip((points + STANDOFF_MM * normals, -normals, aside), ends, strict=True):
            found.append(np.stack([values[:-1], values[1:]], axis=1))
    return Segments(*(np.concatenate(each) for each in ends))


def knots(segments: int, lines: int) -> tuple[csr_array, NDArray[np.int64]]:
    """Paces of segments from paces at knots two segments apart, and the neighbouring knots."""
    parts = segments // 2
    middle = (np.arange(segments) + 0.5) / segments * parts
    one = np.stack([np.interp(middle, np.arange(parts + 1), column) for column in np.eye(parts + 1)], axis=1)
    first = np.arange(lines * (parts + 1)).reshape(lines, parts + 1)
    pairs = np.stack([first[:, :-1], first[:, 1:]], axis=-1).reshape(-1, 2)
    return csr_array(block_diag([one] * lines)), pairs


def level(spacing: float, count: int, constant: float) -> None:
    """Level one set of passes, and print both films."""
    segments = passes(SIZE_MM[1] / 2 + spacing * (np.arange(count) - (count - 1) / 2))
    form = form_of(GUN, GUN.flow_lpm, load_parameters("default").spray)
    lengths = segments.lengths
    weights, pairs = knots(len(lengths) // count, count)
    seconds = csr_array(weights.multiply(lengths[:, None]))
    begin = time.process_time()
    rates = segment_rates(form, segments, *cells(PITCH_MM, (0.0, 0.0)))
    size = weights.shape[1]
    change = ACCELERATION_MM_S2 * 2 * SEGMENT_MM / (1.5 * constant) ** 3
    both = np.concatenate([pairs, pairs[:, ::-1]])
    unknowns = Unknowns(
        np.asarray(seconds.sum(axis=0)).ravel(), np.full(size, 1 / FASTEST_MM_S), np.full(size, 1 / 20.0), both,
        np.ones(len(both)), np.full(len(both), change),
    )  # fmt: skip
    found = even_film(csr_array(rates @ seconds), np.full(rates.shape[0], FILM_UM), unknowns)
    took = time.process_time() - begin
    finer = segment_rates(form, segments, *cells(0.61 * PITCH_MM, (0.37, 0.43)))
    times = seconds @ found.values
    films = [finer @ (lengths / constant), finer @ times]
    off = [100 * np.abs(film / FILM_UM - 1).max() for film in films]
    speeds = 1.0 / (weights @ found.values)
    before = (lengths / constant).sum()
    print(f"{count} passes at {spacing} mm: constant {constant:g} mm/s ±{off[0]:.1f} %, {before:.1f} s")
    print(
        f"  levelled ±{100 * found.value:.2f} % on {rates.shape[0]:,} cells (bound {100 * found.bound:.2f}, gap "
        f"{found.gap:.0e}), ±{off[1]:.2f} % on {len(films[1]):,} finer ones, {films[1].min():.2f} to "
        f"{films[1].max():.2f} um; {times.sum():.1f} s, {speeds.min():.0f} to {speeds.max():.0f} mm/s; "
        f"{took:.1f} s of processor time"
    )


if __name__ == "__main__":
    level(48.66, 9, 256.604)
    level(29.7, 16, 422.5)
