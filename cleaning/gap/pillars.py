"""Permeability of arrays of posts between two plates, such as the balls of a BGA.

K is the mean flow, over the whole area, of a gap with posts over that of the same gap without them. A solid share is
the area of posts over all of it. Arrays that are too fine for the cells of a gap become tiles of their permeability.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import PchipInterpolator
from scipy.spatial import KDTree

from boards.undersides.underside import Joint
from cleaning.errors import require_not_negative, require_positive
from cleaning.gap.hele_shaw import Field2
from cleaning.gap.joint_lattice import Lattice, cover, outlines_of

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
FEWEST = 4
"""Joints of one kind that make an array."""
LONGEST = 1.25
"""Length over width up to which a pad counts as square."""
LEAST_FACTOR = 1e-6
"""Posts that touch let this share through, so that a cell half filled with them is not open by half."""


@dataclass(frozen=True, slots=True)
class Post:
    """A joint and its distance to the nearest one of the same kind."""

    joint: Joint
    pitch_mm: float


@dataclass(frozen=True, slots=True, eq=False)
class Tiles:
    """What the posts do to each cell (rows, columns)."""

    factor: Field2
    """K: mobility with posts over mobility without."""
    solid: Field2
    """Share of the cell that posts take, without any skin."""


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


def post_factor(diameter: ArrayLike, pitch: ArrayLike, height: ArrayLike) -> NDArray[np.float64]:
    """K of a square array of round posts, such as the balls of a BGA, in a gap of any height. All in the same unit.

    The resistance of the plates with the posts as holes, 1 / K0, that of the posts' sides, s / K0, and `COUPLING`
    sqrt(s) / K0 for the layers in which both act. For low gaps this agrees with `ROUND_SKIN`; unlike it, it holds
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


def split_posts(joints: Sequence[Joint], finest_m: float) -> tuple[tuple[Post, ...], tuple[Joint, ...]]:
    """Part joints into posts in arrays whose pitch is less than ``finest_m``, and all others.

    Posts are round or nearly square, and of one kind with others if they have the same shape and size.
    """
    kinds: dict[tuple[bool, float, float], list[int]] = {}
    for index, joint in enumerate(joints):
        sides = sorted((round(joint.length_mm, 6), round(joint.width_mm, 6)))
        if joint.round or sides[1] <= LONGEST * sides[0]:
            kinds.setdefault((joint.round, sides[0], sides[1]), []).append(index)
    pitches = np.full(len(joints), np.inf)
    for members in kinds.values():
        if len(members) >= FEWEST:
            middles = np.array([(joints[index].x_mm, joints[index].y_mm) for index in members])
            pitches[members] = np.round(KDTree(middles).query(middles, k=2)[0][:, 1], 4)  # to 0.1 um
    fine = pitches < finest_m * 1e3 * (1.0 - 1e-9)
    posts = tuple(Post(joint, float(pitch)) for joint, pitch, one in zip(joints, pitches, fine, strict=True) if one)
    return posts, tuple(joint for joint, one in zip(joints, fine, strict=True) if not one)


def tiles_of(posts: Sequence[Post], height_m: float, lattice: Lattice) -> Tiles:
    """Lay a square tile, one pitch wide, around each post and give it the permeability of an endless array."""
    resistance, solid = np.ones(lattice.shape), np.zeros(lattice.shape)
    kinds: dict[tuple[bool, float, float, float], list[Post]] = {}
    for post in posts:
        joint = post.joint
        kinds.setdefault((joint.round, joint.length_mm, joint.width_mm, post.pitch_mm), []).append(post)
    for (is_round, length, width, pitch), members in kinds.items():
        squares = [Joint(post.joint.x_mm, post.joint.y_mm, pitch, pitch) for post in members]
        share = cover(outlines_of(squares), lattice)
        if is_round:
            factor = post_factor(length, pitch, height_m * 1e3)
        else:
            skin = 2.0 * STRAIGHT_SKIN * (height_m * 1e3)
            factor = square_posts((length + skin) * (width + skin) / pitch**2)
        resistance += share * (1.0 / max(float(factor), LEAST_FACTOR) - 1.0)
        solid += share * min((np.pi / 4.0 * length**2 if is_round else length * width) / pitch**2, 1.0)
    return Tiles(1.0 / resistance, np.minimum(solid, 1.0))


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
