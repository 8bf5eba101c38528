"""How much posts and walls between two plates take from the flow: permeability of arrays, width of ducts.

K is the mean flow, over the whole area, of a gap with posts over that of the same gap without them. A solid share is
the area of posts over all of it.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import PchipInterpolator

from cleaning.errors import CleaningError
from cleaning.require import require_not_negative, require_positive

ROUND_SKIN = 0.28
"""A round post acts as if its outline lay this many gap heights further out, as long as there is room between such
outlines: fitted to 3-D Stokes flow around cylinders of solid shares of 0.1 to 0.4."""
STRAIGHT_SKIN = 0.315
"""The same of straight walls; from the exact flow in ducts at least three times as wide as high: half of 0.6302..."""
COUPLING = 0.35
"""How much plates and the sides of posts resist together beyond the sum; fitted to 3-D Stokes flow."""
TOUCHING = np.pi / 4.0
"""Solid share of round posts that touch one another in a square array."""
NEARLY = 0.70
"""Above this solid share the series for round posts loses accuracy, and the narrow gaps between posts decide."""
SQUARE_POSTS = (1.0, 0.978354, 0.916182, 0.821193, 0.704347, 0.577350, 0.449840, 0.327424, 0.211836, 0.102874, 0.0)
"""K of square posts whose side is 0, 0.1, ... 1 pitch: own solution, extrapolated from grids of 40 to 320 cells
per pitch. Half a pitch has the exact value 1 / sqrt(3)."""


def round_posts(solid: ArrayLike) -> NDArray[np.float64]:
    """K of a square array of round posts, wide against the height of the gap; 0 from where they touch.

    Rayleigh (1892) as carried on by Perrins and others (1979); above `NEARLY` Keller's (1963) law for narrow gaps, made
    to meet it. Pressure in a gap and voltage in a sheet with holes obey the same equation.
    """
    require_not_negative(solid=solid)
    share = np.asarray(solid, dtype=np.float64)
    wide = np.minimum(share, NEARLY)
    narrow = np.sqrt(np.maximum(TOUCHING - np.maximum(share, NEARLY), 0.0))
    resistance = np.divide(_KELLER, narrow, out=np.full_like(narrow, np.inf), where=narrow > 0) - _OFFSET
    return np.where(share <= NEARLY, _series(wide), 1.0 / resistance)


def square_posts(solid: ArrayLike) -> NDArray[np.float64]:
    """K of a square array of square posts, wide against the height of the gap; 0 where they touch."""
    require_not_negative(solid=solid)
    side = np.sqrt(np.clip(np.asarray(solid, dtype=np.float64), 0.0, 1.0))
    return np.clip(np.asarray(_SQUARE(side), dtype=np.float64), 0.0, 1.0)


def tall_posts(solid: ArrayLike) -> NDArray[np.float64]:
    """Permeability, in squares of the pitch, of a square array of round posts so long that plates do not matter.

    Up to a solid share of 0.05 the drag of Sangani and Acrivos (1982), above it Gebart's (1992) law for narrow gaps
    times a table that comes from Brinkman's equation; 0 where posts touch.
    """
    require_not_negative(solid=solid)
    share = np.asarray(solid, dtype=np.float64)
    thin = np.clip(share, 1e-12, _TALL_SHARES[0])
    dilute = (-0.5 * np.log(thin) - 0.738 + thin - 0.887 * thin**2 + 2.038 * thin**3) / (4.0 * np.pi)
    dense = np.clip(share, _TALL_SHARES[0], TOUCHING)
    narrow = 16.0 / (9.0 * np.pi * np.sqrt(2.0)) * (np.sqrt(TOUCHING / dense) - 1.0) ** 2.5 * dense / np.pi
    return np.where(share < _TALL_SHARES[0], dilute, narrow * _TALL(dense))


def inflated_share(diameter: ArrayLike, pitch: ArrayLike, height: ArrayLike) -> NDArray[np.float64]:
    """Solid share of round posts in a square array, with the skin that a gap of finite height puts around them.

    All three in the same unit.
    """
    require_not_negative(diameter=diameter, height=height)
    require_positive(pitch=pitch)
    radius = 0.5 * np.asarray(diameter, dtype=np.float64) + ROUND_SKIN * np.asarray(height, dtype=np.float64)
    return np.pi * (radius / np.asarray(pitch, dtype=np.float64)) ** 2


def post_factor(diameter: ArrayLike, pitch: ArrayLike, height: ArrayLike) -> NDArray[np.float64]:
    """K of a square array of round posts, such as the balls of a BGA, in a gap of any height. All in the same unit.

    The resistance of the plates with the posts as holes, 1 / K0, that of the posts' sides, s / K0, and `COUPLING`
    sqrt(s) / K0 for the layers in which both act. For low gaps this is what `ROUND_SKIN` says; unlike it, it holds
    where layers fill the space between posts. Within 4 % of 3-D Stokes flow for solid shares of 0.05 to 0.6 and
    heights of 0.1 to 2 pitches.
    """
    require_not_negative(diameter=diameter, height=height)
    require_positive(pitch=pitch)
    pitches = np.asarray(pitch, dtype=np.float64)
    solid = np.pi * (0.5 * np.asarray(diameter, dtype=np.float64) / pitches) ** 2
    low, tall = round_posts(solid), tall_posts(solid)
    squared = (np.asarray(height, dtype=np.float64) / pitches) ** 2
    with_room = tall > 0
    sides = np.where(solid > 0, squared * low / (12.0 * np.where(with_room, tall, 1.0)), 0.0)
    return np.where(with_room, low / (1.0 + sides + COUPLING * np.sqrt(sides)), 0.0)


def duct_factor(width_over_height: ArrayLike) -> NDArray[np.float64]:
    """Flow in a rectangular duct over that between plates without side walls, for the same width. Exact series."""
    ratio = np.asarray(width_over_height, dtype=np.float64)
    if not (ratio > 0).all():
        raise CleaningError("a duct needs a positive width over its height")
    odd = np.arange(1, 400, 2, dtype=np.float64)
    wide = np.maximum(ratio, 1.0 / ratio)
    terms = np.tanh(0.5 * np.pi * odd * wide[..., None]) / odd**5
    # a duct higher than wide is a wide one on its side: its flow per width goes with the square of the ratio
    return np.minimum(ratio, 1.0) ** 2 * (1.0 - 192.0 / np.pi**5 / wide * terms.sum(axis=-1))


def duct_with_skin(width_over_height: ArrayLike) -> NDArray[np.float64]:
    """The same from walls that are moved inwards by the skin: good from a width of two heights on."""
    require_positive(width_over_height=width_over_height)
    ratio = np.asarray(width_over_height, dtype=np.float64)
    return np.maximum(1.0 - 2.0 * STRAIGHT_SKIN / ratio, 0.0)


def _series(solid: NDArray[np.float64]) -> NDArray[np.float64]:
    fourth = solid**4
    eighth = fourth**2
    below = 1.0 + solid - 0.305827 * fourth / (1.0 - 1.402958 * eighth) - 0.013362 * eighth
    return 1.0 - 2.0 * solid / below


_SQUARE = PchipInterpolator(np.linspace(0.0, 1.0, len(SQUARE_POSTS)), SQUARE_POSTS)
_TALL_SHARES = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, TOUCHING)
_TALL = PchipInterpolator(_TALL_SHARES, (0.6675, 0.7242, 0.7973, 0.8468, 0.8821, 0.9136, 0.9395, 0.9560, 1.0))
_KELLER = 0.5 * np.pi**1.5
_OFFSET = _KELLER / np.sqrt(TOUCHING - NEARLY) - 1.0 / float(_series(np.asarray(NEARLY)))
