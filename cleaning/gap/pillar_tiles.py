"""Arrays of posts that are too fine for the cells of a gap: each post becomes a tile of its permeability."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from boards.undersides.underside import Joint
from cleaning.gap.grid import Field2
from cleaning.gap.joint_lattice import Lattice, cover, outlines_of
from cleaning.gap.pillar_drag import STRAIGHT_SKIN, post_factor, square_posts

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
            pitches[members] = _pitches([joints[index] for index in members])
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
        factor = max(_factor(is_round, (length, width), pitch, height_m * 1e3), LEAST_FACTOR)
        resistance += share * (1.0 / factor - 1.0)
        solid += share * min((np.pi / 4.0 * length**2 if is_round else length * width) / pitch**2, 1.0)
    return Tiles(1.0 / resistance, np.minimum(solid, 1.0))


def _factor(is_round: bool, size: tuple[float, float], pitch: float, height: float) -> float:
    if is_round:
        return float(post_factor(size[0], pitch, height))
    skin = 2.0 * STRAIGHT_SKIN * height
    return float(square_posts((size[0] + skin) * (size[1] + skin) / pitch**2))


def _pitches(joints: Sequence[Joint]) -> NDArray[np.float64]:
    """Distance of each joint to its nearest neighbour, to a tenth of a micrometre, mm."""
    middles = np.array([(joint.x_mm, joint.y_mm) for joint in joints])
    distances, _ = KDTree(middles).query(middles, k=2)
    return np.round(distances[:, 1], 4)
