"""How much posts and walls between two plates take from the flow: permeability of arrays, width of ducts.

K is the mean flow of a gap with posts over that of the same gap without them, h^2 / 12.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import PchipInterpolator

from cleaning.errors import CleaningError

ROUND_SKIN = 0.28
"""Round posts act as if their outline lay this many gap heights further out; from 3-D Stokes flow around cylinders, for
solid shares of 0.1 to 0.4 and heights of 0.1 to 0.5 pitches."""
STRAIGHT_SKIN = 0.315
"""The same of straight walls; from the exact flow in ducts at least three times as wide as high: half of 0.6302..."""
TOUCHING = np.pi / 4.0
"""Solid share of round posts that touch one another in a square array."""
NEARLY = 0.70
"""Above this solid share the series for round posts loses accuracy, and the narrow gaps between posts decide."""
SQUARE_POSTS = (1.0, 0.978354, 0.916182, 0.821193, 0.704347, 0.577350, 0.449840, 0.327424, 0.211836, 0.102874, 0.0)
"""K of square posts whose side is 0, 0.1, ... 1 pitch: own solution, extrapolated from grids of 40 to 320 cells
per pitch. Half a pitch has the exact value 1 / sqrt(3)."""


def round_posts(solid: ArrayLike) -> NDArray[np.float64]:
    """K of a square array of high, round posts that take the given share of the area; 0 from where they touch.

    Rayleigh (1892) as carried on by Perrins and others (1979); above `NEARLY` Keller's (1963) law for narrow gaps, made
    to meet it. Pressure in a gap and voltage in a sheet with holes obey the same equation.
    """
    share = np.asarray(solid, dtype=np.float64)
    wide = np.minimum(share, NEARLY)
    narrow = np.sqrt(np.maximum(TOUCHING - np.maximum(share, NEARLY), 0.0))
    resistance = np.divide(_KELLER, narrow, out=np.full_like(narrow, np.inf), where=narrow > 0) - _OFFSET
    return np.where(share <= NEARLY, _series(wide), 1.0 / resistance)


def square_posts(solid: ArrayLike) -> NDArray[np.float64]:
    """K of a square array of high, square posts that take the given share of the area; 0 where they touch."""
    side = np.sqrt(np.clip(np.asarray(solid, dtype=np.float64), 0.0, 1.0))
    return np.asarray(_SQUARE(side), dtype=np.float64)


def inflated_share(diameter: ArrayLike, pitch: ArrayLike, height: ArrayLike) -> NDArray[np.float64]:
    """Solid share of round posts in a square array with the skin that a gap of finite height puts around them.

    All three in the same unit.
    """
    radius = 0.5 * np.asarray(diameter, dtype=np.float64) + ROUND_SKIN * np.asarray(height, dtype=np.float64)
    return np.pi * (radius / np.asarray(pitch, dtype=np.float64)) ** 2


def post_factor(diameter: ArrayLike, pitch: ArrayLike, height: ArrayLike) -> NDArray[np.float64]:
    """K of a square array of round posts, such as the balls of a BGA, in a gap of any height. All in the same unit."""
    return round_posts(inflated_share(diameter, pitch, height))


def duct_factor(width_over_height: ArrayLike) -> NDArray[np.float64]:
    """Flow in a rectangular duct over that between plates without side walls, for the same width. Exact series."""
    ratio = np.asarray(width_over_height, dtype=np.float64)
    if not (ratio > 0).all():
        raise CleaningError("a duct needs a positive width over its height")
    odd = np.arange(1, 400, 2, dtype=np.float64)
    terms = np.tanh(0.5 * np.pi * odd * ratio[..., None]) / odd**5
    return 1.0 - 192.0 / np.pi**5 / ratio * terms.sum(axis=-1)


def duct_with_skin(width_over_height: ArrayLike) -> NDArray[np.float64]:
    """The same from walls that are moved inwards by the skin: good from a width of two heights on."""
    ratio = np.asarray(width_over_height, dtype=np.float64)
    return np.maximum(1.0 - 2.0 * STRAIGHT_SKIN / ratio, 0.0)


def _series(solid: NDArray[np.float64]) -> NDArray[np.float64]:
    fourth = solid**4
    eighth = fourth**2
    below = 1.0 + solid - 0.305827 * fourth / (1.0 - 1.402958 * eighth) - 0.013362 * eighth
    return 1.0 - 2.0 * solid / below


_SQUARE = PchipInterpolator(np.linspace(0.0, 1.0, len(SQUARE_POSTS)), SQUARE_POSTS)
_KELLER = 0.5 * np.pi**1.5
_OFFSET = _KELLER / np.sqrt(TOUCHING - NEARLY) - 1.0 / float(_series(np.asarray(NEARLY)))
