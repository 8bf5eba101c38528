"""Curved pieces of surface as grids of patches: sheets, tubes, and a quarter of a torus."""

from collections.abc import Callable

import numpy as np

from geometry.arrays import Points, Scalars, Triangles

TORUS_MM = (120.0, 40.0)


def grid(place: Callable[[Scalars, Scalars], Points], u: Scalars, v: Scalars) -> Triangles:
    """Patches over a grid of two parameters, wound so that the normal is along d/du x d/dv."""
    every = np.meshgrid(u, v, indexing="ij")
    points = place(every[0].ravel(), every[1].ravel())
    i, j = (each.ravel() for each in np.meshgrid(np.arange(len(u) - 1), np.arange(len(v) - 1), indexing="ij"))
    a, step = i * len(v) + j, len(v)
    corners = np.concatenate([np.stack([a, a + step, a + step + 1], 1), np.stack([a, a + step + 1, a + 1], 1)])
    return points[corners]


def wavy_sheet(step_mm: float = 10.0, size: tuple[float, float] = (400.0, 500.0)) -> Triangles:
    """The sheet z = 10 sin(2 pi x / 400) cos(2 pi y / 500)."""
    x, y = (np.linspace(0, each, round(each / step_mm) + 1) for each in size)
    return grid(lambda u, v: np.column_stack([u, v, wave(u, v)]), x, y)


def wave(x: Scalars, y: Scalars) -> Scalars:
    return 10 * np.sin(2 * np.pi * x / 400) * np.cos(2 * np.pi * y / 500)


def tube(radius: float, length: float, facets: int, rows: int, turn: float = 2 * np.pi) -> Triangles:
    """The wall of a cylinder, without its caps; with less than a full turn, a part of it."""
    angles = np.linspace(0, turn, facets + 1)
    return grid(
        lambda a, z: np.column_stack([radius * np.cos(a), radius * np.sin(a), z]),
        angles,
        np.linspace(0, length, rows + 1),
    )


def on_torus(u: Scalars, v: Scalars) -> Points:
    wide, thin = TORUS_MM
    away = wide + thin * np.cos(v)
    return np.column_stack([away * np.cos(u), away * np.sin(u), thin * np.sin(v)])
