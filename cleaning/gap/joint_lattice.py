"""How much of the cells of a gap, and of the ways between them, solder joints take; permeability of arrays of posts.

K is the mean flow, over the whole area, of a gap with posts over that of the same gap without them. A solid share is
the area of posts over all of it. Arrays that are too fine for the cells of a gap become tiles of their permeability.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import PchipInterpolator
from scipy.spatial import KDTree

from boards.undersides.underside import Joint, joint_polygon
from cleaning.errors import require_not_negative, require_positive
from cleaning.gap.hele_shaw import Apertures, Field2
from geometry.arrays import Scalars

LINES = 4
"""Lines across each half cell along which its opening is measured."""
LEAST_OPENING = 1e-3
"""Share of a half cell's width below which it is closed: what is less comes from rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class Outlines:
    """Rectangles and discs in the frame of the underside, m; all (j,)."""

    x: Scalars
    y: Scalars
    half_length: Scalars
    half_width: Scalars
    along: Scalars
    """Cosine of the turn: the x of the direction of the length."""
    across: Scalars
    """Sine of the turn."""
    round: NDArray[np.bool_]

    @property
    def mirrored(self) -> "Outlines":
        """The same with x and y swapped."""
        return Outlines(self.y, self.x, self.half_length, self.half_width, self.across, self.along, self.round)


@dataclass(frozen=True, slots=True)
class Lattice:
    """Where the cells of a rectangle are that has its middle in the origin. m."""

    length_m: float
    width_m: float
    rows: int
    columns: int

    @property
    def shape(self) -> tuple[int, int]:
        """Rows along y, columns along x."""
        return self.rows, self.columns

    @property
    def dx_m(self) -> float:
        """Cell size along x."""
        return self.length_m / self.columns

    @property
    def dy_m(self) -> float:
        """Cell size along y."""
        return self.width_m / self.rows


def quantised(joint: Joint) -> Joint:
    """Round to a nanometre: far below what any file means, it hides the last bits of a board that was turned."""
    x, y, length, width = (round(value, 6) + 0.0 for value in (joint.x_mm, joint.y_mm, joint.length_mm, joint.width_mm))
    return Joint(x, y, length, width, joint.round, round(joint.turn_rad, 9) + 0.0)


def outlines_of(joints: Sequence[Joint], round_skin_m: float = 0.0, straight_skin_m: float = 0.0) -> Outlines:
    """Take the outlines of joints, each moved outwards by the skin of its kind."""
    table = np.array([[j.x_mm, j.y_mm, j.length_mm, j.width_mm] for j in joints]).reshape(-1, 4) * 1e-3
    disc = np.array([joint.round for joint in joints], dtype=np.bool_)
    turn = np.array([joint.turn_rad for joint in joints], dtype=np.float64)
    skin = np.where(disc, round_skin_m, straight_skin_m)
    half_width = np.where(disc, table[:, 2], table[:, 3]) / 2 + skin
    return Outlines(table[:, 0], table[:, 1], table[:, 2] / 2 + skin, half_width, np.cos(turn), np.sin(turn), disc)


def apertures(walls: Outlines, lattice: Lattice) -> Apertures:
    """Measure how far walls close each half cell towards its neighbour.

    Along lines across the way, what is open is exact; behind one another, the lines resist in series. This narrows ways
    between leads much finer than a cell by what the leads take, and lets no liquid through a thin, long wall.
    """
    left, right = _halves(walls.mirrored, lattice.width_m, lattice.length_m, lattice.rows, lattice.columns)
    front, back = _halves(walls, lattice.length_m, lattice.width_m, lattice.columns, lattice.rows)
    return Apertures(left.T, right.T, front, back)


def cover(walls: Outlines, lattice: Lattice) -> Field2:
    """Share of each cell (rows, columns) that walls take; where they overlap it counts once."""
    flat = _along_lines(walls, lattice.length_m, lattice.width_m, lattice.columns, lattice.rows)
    upright = _along_lines(walls.mirrored, lattice.width_m, lattice.length_m, lattice.rows, lattice.columns)
    return 0.5 * (flat.mean(axis=(1, 2)) + upright.mean(axis=(1, 2)).T)


def covered_share(joints: Sequence[Joint], lattice: Lattice) -> float:
    """Share of the whole rectangle that joints take; where they overlap it counts once."""
    across, along = 500.0 * lattice.length_m, 500.0 * lattice.width_m  # halves, mm
    taken = shapely.disjoint_subset_union_all([joint_polygon(joint) for joint in joints])
    return min(taken.intersection(shapely.box(-across, -along, across, along)).area / (4.0 * across * along), 1.0)


def _halves(walls: Outlines, length_m: float, width_m: float, columns: int, rows: int) -> tuple[Field2, Field2]:
    """Openings of the lower and the upper half of each cell, for flow along y: (rows, columns) both."""
    opening = 1.0 - _along_lines(walls, length_m, width_m, columns, rows)
    opening[opening < LEAST_OPENING] = 0.0
    closed = (opening == 0.0).any(axis=2)
    resistance = (1.0 / np.where(opening == 0.0, 1.0, opening)).mean(axis=2)
    open_share = np.where(closed, 0.0, 1.0 / resistance)
    return open_share[:, 0], open_share[:, 1]


def _along_lines(walls: Outlines, length_m: float, width_m: float, columns: int, rows: int) -> NDArray[np.float64]:
    """Share that walls take of each cell's stretch of lines along x: (rows, 2 halves, LINES, columns)."""
    count = rows * 2 * LINES
    lines = ((np.arange(count) + 0.5) / count - 0.5) * width_m
    edges = (np.arange(columns + 1) / columns - 0.5) * length_m
    begin, end = _chords(walls, lines)
    taken = np.zeros((count, columns))
    if begin.shape[1]:
        order = np.argsort(begin, axis=1, kind="stable")
        begin, end = np.take_along_axis(begin, order, axis=1), np.take_along_axis(end, order, axis=1)
        # of overlapping chords, each counts from where all before it have ended
        ended = np.maximum.accumulate(end, axis=1)
        begin[:, 1:] = np.maximum(begin[:, 1:], ended[:, :-1])
        for column in range(columns):
            inside = np.minimum(end, edges[column + 1]) - np.maximum(begin, edges[column])
            taken[:, column] = np.maximum(inside, 0.0).sum(axis=1)
    return np.minimum(taken * (columns / length_m), 1.0).reshape(rows, 2, LINES, columns)


def _chords(walls: Outlines, lines: Scalars) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where each line along x enters and leaves each outline: (lines, j) both; an empty chord ends where it begins."""
    up = lines[:, None] - walls.y
    reach = np.sqrt(np.maximum(walls.half_length**2 - up**2, 0.0))
    begin, end = -reach, reach
    # a rectangle is where two slabs cross; |x along + up across| <= half length, |up along - x across| <= half width
    first = _slab(walls.along, up * walls.across, walls.half_length)
    second = _slab(-walls.across, up * walls.along, walls.half_width)
    begin = np.where(walls.round, begin, np.maximum(first[0], second[0]))
    end = np.where(walls.round, end, np.minimum(first[1], second[1]))
    end = np.maximum(begin, end)
    return begin + walls.x, end + walls.x


def _slab(
    slope: Scalars, offset: NDArray[np.float64], half: Scalars
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Stretch of x in which ``|slope x + offset| <= half``; without slope all or nothing, as a finite stretch."""
    far = 1e3
    flat = np.abs(slope) < 1e-9
    safe = np.where(flat, 1.0, slope)
    one, other = (-half - offset) / safe, (half - offset) / safe
    within = np.abs(offset) < half - 1e-12
    begin = np.where(flat, np.where(within, -far, far), np.minimum(one, other))
    end = np.where(flat, np.where(within, far, far), np.maximum(one, other))
    return begin, end


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


@dataclass(frozen=True, slots=True, eq=False)
class Obstruction:
    """What the joints of a gap do to its cells (rows, columns)."""

    apertures: Apertures
    factor: Field2
    """Mobility with arrays of posts over mobility without."""
    open_share: Field2
    """Share of each cell that no joint takes."""
    coverage: float
    """Share of the whole rectangle that joints take."""


def obstruct(joints: Sequence[Joint], lattice: Lattice, height_m: float, finest_m: float) -> Obstruction:
    """Find how joints narrow a gap: arrays of posts finer than ``finest_m`` by their permeability, others as walls.

    All are thickened by the skin that slows the flow along them; what they cover is counted without it.
    """
    joints = tuple(quantised(joint) for joint in joints)
    posts, walls = split_posts(joints, finest_m)
    thick = outlines_of(walls, ROUND_SKIN * height_m, STRAIGHT_SKIN * height_m)
    tiles = tiles_of(posts, height_m, lattice)
    share = (1.0 - cover(outlines_of(walls), lattice)) * (1.0 - tiles.solid)
    return Obstruction(apertures(thick, lattice), tiles.factor, share, covered_share(joints, lattice))


_SQUARE = PchipInterpolator(np.linspace(0.0, 1.0, len(SQUARE_POSTS)), SQUARE_POSTS)
_TALL_SHARES = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, TOUCHING)
_TALL = PchipInterpolator(_TALL_SHARES, (0.6675, 0.7242, 0.7973, 0.8468, 0.8821, 0.9136, 0.9395, 0.9560, 1.0))
_KELLER = 0.5 * np.pi**1.5
_OFFSET = _KELLER / np.sqrt(TOUCHING - NEARLY) - 1.0 / float(_series(np.asarray(NEARLY)))
