"""Gaps of even cells, and the exact flow in ducts, that solutions of the model are compared with."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cleaning.gap.hele_shaw import Apertures, Grid, narrowed_grid


def plain_grid(mobility: ArrayLike, dx_m: float, dy_m: float) -> Grid:
    """Join cells of the given mobilities (rows, columns), in m3, without walls; 0 where nothing flows."""
    cells = np.atleast_2d(np.asarray(mobility, dtype=np.float64))
    everywhere = np.ones_like(cells)
    return narrowed_grid(cells, dx_m, dy_m, Apertures(everywhere, everywhere, everywhere, everywhere))


def duct_factor(width_over_height: ArrayLike) -> NDArray[np.float64]:
    """Flow in a rectangular duct over that between plates without side walls, for the same width. Exact series."""
    ratio = np.asarray(width_over_height, dtype=np.float64)
    odd = np.arange(1, 400, 2, dtype=np.float64)
    wide = np.maximum(ratio, 1.0 / ratio)
    terms = np.tanh(0.5 * np.pi * odd * wide[..., None]) / odd**5
    # a duct higher than wide is a wide one on its side: its flow per width goes with the square of the ratio
    return np.minimum(ratio, 1.0) ** 2 * (1.0 - 192.0 / np.pi**5 / wide * terms.sum(axis=-1))
