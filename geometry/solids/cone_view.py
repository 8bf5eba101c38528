"""Which cells of a surface lie in a cone and are seen from its apex (Sandia 1993, section 2.4)."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from geometry.arrays import Directions, Indices, Points, Scalars, Triangles
from geometry.compiled import compiled, inner
from geometry.mesh import areas_and_normals
from geometry.rays import RayScene, are_blocked, split_patches

Vector: TypeAlias = Any  # three numbers
_BATCH = 400_000
_GROUP = 32
"""Points in a group at most."""
_SLACK_MM = 1e-6
_ALIKE_MM = 2e-3
"""Rounding of coordinates to 0.0001 mm does not decide which of two equal edges is halved."""


@dataclass(frozen=True, eq=False)  # without slots, for what is cached
class Cells:
    """A surface cut into triangles so small that the middle of each stands for it. Millimetres."""

    triangles: Triangles
    """(c, 3, 3)"""
    points: Points
    """(c, 3) their middles."""
    normals: Directions
    """(c, 3) outward."""
    areas_mm2: Scalars
    """(c,)"""
    patch: Indices
    """(c,) patch that each was cut from."""

    @cached_property
    def groups(self) -> "Groups":
        """Neighbouring cells in groups, so that cones pass over most of them at once."""
        return group_points(self.points)


@dataclass(frozen=True, slots=True, eq=False)
class Groups:
    """Points in balls."""

    order: Indices
    """(c,) points, group after group."""
    begin: Indices
    """(g + 1,) where each begins in ``order``, and the end of the last."""
    middles: Points
    """(g, 3)"""
    radii: Scalars
    """(g,) of balls that have all points of a group in them."""


def group_points(points: Points) -> Groups:
    """Group points (c, 3) by halving at the median of the longer side, until a group has at most ``_GROUP``."""
    order = np.arange(len(points))
    todo, done = [(0, len(points))], list[int]()
    while todo:
        first, last = todo.pop()
        if last - first <= _GROUP:
            done.append(first)
            continue
        own = points[order[first:last]]
        axis = int(np.argmax(np.ptp(own, axis=0)))
        order[first:last] = order[first:last][np.argsort(own[:, axis], kind="stable")]
        middle = (first + last) // 2
        todo += [(middle, last), (first, middle)]
    begin = np.array([*done, len(points)], dtype=np.int64)
    counts = np.diff(begin)
    owner = np.repeat(np.arange(len(counts)), counts)
    sums = np.column_stack([np.bincount(owner, points[order, axis], len(counts)) for axis in range(3)])
    middles = sums / np.maximum(counts, 1)[:, None]
    radii = np.zeros(len(counts))
    np.maximum.at(radii, owner, np.linalg.norm(points[order] - middles[owner], axis=1))
    return Groups(order, begin, middles, radii + _SLACK_MM)


@dataclass(frozen=True, slots=True)
class Cone:
    """What counts as sprayed: inside the cone, seen, and met at no flatter an angle than this."""

    half_angle_rad: float
    incidence_rad: float
    """Least angle between a ray and the surface that it meets."""
    edge_rad: float = 0.0
    """Width inside the half angle over which a cell passes from inside to outside of a cone at rest: no cell's time
    hangs on the last digits of its place. The edge of a moving cone is sharp, in the middle of that width."""
    range_mm: float = np.inf
    """From the apex; farther cells do not count."""
    edge_mm: float = 0.0
    """Width inside the range, as ``edge_rad``."""


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """How cones move while they are looked at: half of it before their poses, half of it after."""

    ways: Points
    """(p, 3) of the apexes, mm."""
    turns: Directions
    """(p, 3) rotation vectors, small."""


def turns_between(axes: Directions) -> Directions:
    """(n - 1, 3) rotation vectors from each of (n, 3) unit vectors to the next."""
    cross = np.cross(axes[:-1], axes[1:])
    sine = np.linalg.norm(cross, axis=1)
    angle = np.arctan2(sine, np.einsum("ij,ij->i", axes[:-1], axes[1:]))
    return cross * (angle / np.maximum(sine, 1e-12))[:, None]


def cut_cells(patches: Triangles, longest_mm: float) -> Cells:
    """Cut patches, wound outwards, into cells with no edge longer than this."""
    triangles, parent = split_patches(patches, longest_mm, _ALIKE_MM)
    areas, normals = areas_and_normals(triangles.copy())
    solid = areas > 0
    return Cells(triangles[solid], triangles[solid].mean(axis=1), normals[solid], areas[solid], parent[solid])


def cells_in_view(
    cells: Cells, scene: RayScene, cone: Cone, orifices: Points, axes: Directions, stretch: Stretch | None = None
) -> csr_array:
    """Which cells are in the cone at which pose, or for which share of a stretch, and seen from its apex.

    Args:
        cells: Of the surface.
        scene: What hides.
        cone: Its half angle, and the least angle of incidence.
        orifices: (p, 3) apexes, mm.
        axes: (p, 3) unit vectors along the cone's axis.
        stretch: Motions around the poses; without it, and where it is 0, cones are at rest.

    Returns:
        (p, c) matrix of ones, and of shares where the cone has an edge or moves.
    """
    stretch = stretch or Stretch(np.zeros_like(orifices), np.zeros_like(axes))
    rows: list[Indices] = []
    columns: list[Indices] = []
    shares: list[Scalars] = [np.empty(0)]
    angles = np.cos(cone.half_angle_rad - cone.edge_rad * np.array([1.0, 0.5, 0.0]))
    cosines = float(angles[0]), float(angles[1]), float(angles[2])
    reach = float(cone.range_mm), float(cone.edge_mm)
    step = max(1, _BATCH // max(1, len(cells.points) // 40))
    sine = float(np.sin(cone.incidence_rad))
    groups = cells.groups
    for begin in range(0, len(orifices), step):
        some = slice(begin, begin + step)
        pose, cell, share = _in_cone(
            (cells.points[groups.order], cells.normals[groups.order]),
            (groups.order, groups.begin, groups.middles, groups.radii),
            (orifices[some], axes[some], stretch.ways[some], stretch.turns[some]),
            cosines,
            sine,
            reach,
        )
        seen = are_seen(scene, orifices[some][pose], cells.points[cell])
        rows.append(pose[seen] + begin)
        columns.append(cell[seen])
        shares.append(share[seen])
    row, column = np.concatenate([np.empty(0, np.int64), *rows]), np.concatenate([np.empty(0, np.int64), *columns])
    shape = (len(orifices), len(cells.points))
    return csr_array((np.concatenate(shares), (row, column)), shape=shape)


def are_seen(scene: RayScene, orifices: Points, targets: Points) -> NDArray[np.bool_]:
    """(n,) whether nothing stands between each orifice and its target, both (n, 3), mm."""
    if not len(orifices):
        return np.empty(0, dtype=np.bool_)
    ways = targets - orifices
    lengths = np.linalg.norm(ways, axis=1)
    directions = ways / np.maximum(lengths, 1e-9)[:, None]
    return ~are_blocked(
        scene,
        np.ascontiguousarray(orifices - scene.origin, dtype=np.float32),
        np.ascontiguousarray(directions, dtype=np.float32),
        np.ascontiguousarray(lengths, dtype=np.float32),
    )


@inner
def _is_beside(middle: Vector, axis: Vector, turn: Any, radius: Any) -> Any:
    """Whether a ball lies outside a cone from 0: its middle is farther than its radius from the plane along its side.

    ``turn`` are cosine and sine of the half angle.
    """
    along = middle[0] * axis[0] + middle[1] * axis[1] + middle[2] * axis[2]
    square = middle[0] * middle[0] + middle[1] * middle[1] + middle[2] * middle[2]
    return np.sqrt(max(square - along * along, 0.0)) * turn[0] - along * turn[1] > radius


@inner
def _cosine_inside(way: Vector, axis: Vector, normal: Vector, outer: Any, sine: Any) -> Any:
    """Cosine between a ray and the axis where it is in the cone and meets a surface steeply enough, else -2."""
    along = way[0] * axis[0] + way[1] * axis[1] + way[2] * axis[2]
    square = way[0] * way[0] + way[1] * way[1] + way[2] * way[2]
    if along <= 0.0 or along < outer * np.sqrt(square):
        return -2.0
    facing = -(way[0] * normal[0] + way[1] * normal[1] + way[2] * normal[2])
    if facing <= 0.0 or facing * facing < sine * sine * square:
        return -2.0
    return along / np.sqrt(square)


@inner
def _half_moved(way: Vector, motion: tuple[Vector, Vector], radius: Any) -> Any:
    """Half of how far points within a radius around a way from the apex move at most, seen from the cone."""
    (vx, vy, vz), (rx, ry, rz) = motion
    far = np.sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]) + radius
    return (np.sqrt(vx * vx + vy * vy + vz * vz) + np.sqrt(rx * rx + ry * ry + rz * rz) * far) / 2.0


@inner
def _share_seen(
    way: Vector, motion: tuple[Vector, Vector], axis: Vector, normal: Vector, cosines: tuple[Any, Any, Any], sine: Any
) -> Any:
    """Share in the cone of what is met steeply enough: over its edge at rest, of the stretch in motion; else -1."""
    (vx, vy, vz), (rx, ry, rz) = motion
    inner, sharp, outer = cosines
    moves = vx != 0.0 or vy != 0.0 or vz != 0.0 or rx != 0.0 or ry != 0.0 or rz != 0.0
    cosine = _cosine_inside(way, axis, normal, -1.0 if moves else outer, sine)
    if cosine < -1.0:
        return -1.0
    if not moves:
        return min(1.0, (cosine - outer) / max(inner - outer, 1e-12))
    onward = vx + ry * way[2] - rz * way[1], vy + rz * way[0] - rx * way[2], vz + rx * way[1] - ry * way[0]
    share = _share_inside(way, onward, axis, sharp * sharp)
    return share if share > 0.0 else -1.0


@inner
def _share_near(way: Vector, motion: tuple[Vector, Vector], reach: tuple[Any, Any]) -> Any:
    """Share within a range of the apex: over its edge at rest, of the stretch in motion, in which a way is straight."""
    far = np.sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2])
    (vx, vy, vz), _ = motion
    moved = abs(way[0] * vx + way[1] * vy + way[2] * vz) / max(far, 1e-12)
    if vx != 0.0 or vy != 0.0 or vz != 0.0:
        return min(1.0, max(0.0, 0.5 + (reach[0] - reach[1] / 2.0 - far) / max(moved, 1e-9)))
    return min(1.0, max(0.0, (reach[0] - far) / max(reach[1], 1e-9)))


@inner
def _share_inside(way: Vector, change: Vector, axis: Vector, square: Any) -> Any:
    """Share of s from -1/2 to 1/2 for which way - s change is inside a cone about an axis; square of its cosine.

    Inside is where the quadratic (axis . x)² - square x² is positive; it opens downwards but for ways along the cone.
    """
    along = way[0] * axis[0] + way[1] * axis[1] + way[2] * axis[2]
    onward = change[0] * axis[0] + change[1] * axis[1] + change[2] * axis[2]
    ways = way[0] * way[0] + way[1] * way[1] + way[2] * way[2]
    both = way[0] * change[0] + way[1] * change[1] + way[2] * change[2]
    changes = change[0] * change[0] + change[1] * change[1] + change[2] * change[2]
    a, b, c = onward * onward - square * changes, along * onward - square * both, along * along - square * ways
    begin, end = a / 4.0 + b + c, a / 4.0 - b + c
    if begin >= 0.0 and end >= 0.0:
        return 1.0
    if a >= 0.0:
        if begin < 0.0 and end < 0.0:
            return 0.0
        return max(begin, end) / abs(begin - end)
    root = b * b - a * c
    if root <= 0.0:
        return 0.0
    return max(0.0, min(0.5, (b - np.sqrt(root)) / a) - max(-0.5, (b + np.sqrt(root)) / a))


@compiled
def _in_cone(
    surface: tuple[Points, Directions],
    groups: tuple[Indices, Indices, Points, Scalars],
    poses: tuple[Points, Directions, Points, Directions],
    cosines: tuple[float, float, float],
    sine: float,
    reach: tuple[float, float],
) -> tuple[Indices, Indices, Scalars]:
    """Pairs of a pose and a cell in its cone, and the share of each; cosines of inner, middle and outer half angle.

    Points and normals of the surface are in the order of the groups.
    """
    points, normals = surface
    order, first, middles, radii = groups
    orifices, axes, ways, turns = poses
    most, found = 1024, 0
    pose, cell, share = np.empty(most, dtype=np.int64), np.empty(most, dtype=np.int64), np.empty(most)
    outer = cosines[2]
    outer_sine = np.sqrt(1.0 - outer * outer)
    for i in range(len(orifices)):
        ox, oy, oz = orifices[i, 0], orifices[i, 1], orifices[i, 2]
        ax, ay, az = axes[i, 0], axes[i, 1], axes[i, 2]
        motion = (ways[i, 0], ways[i, 1], ways[i, 2]), (turns[i, 0], turns[i, 1], turns[i, 2])
        for group in range(len(radii)):
            x, y, z = middles[group, 0] - ox, middles[group, 1] - oy, middles[group, 2] - oz
            wide = radii[group] + _half_moved((x, y, z), motion, radii[group])
            far = reach[0] + wide
            if x * x + y * y + z * z > far * far or _is_beside((x, y, z), (ax, ay, az), (outer, outer_sine), wide):
                continue
            for j in range(first[group], first[group + 1]):
                way = points[j, 0] - ox, points[j, 1] - oy, points[j, 2] - oz
                normal = normals[j, 0], normals[j, 1], normals[j, 2]
                near = _share_near(way, motion, reach)
                if near <= 0.0:
                    continue
                part = near * _share_seen(way, motion, (ax, ay, az), normal, cosines, sine)
                if part < 0.0:
                    continue
                if found == most:
                    most *= 2
                    pose = np.concatenate((pose, np.empty_like(pose)))
                    cell = np.concatenate((cell, np.empty_like(cell)))
                    share = np.concatenate((share, np.empty_like(share)))
                pose[found], cell[found], share[found] = i, order[j], part
                found += 1
    return pose[:found], cell[:found], share[:found]
