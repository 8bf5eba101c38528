"""Which cells of a surface lie in a cone and are seen from its apex (Sandia 1993, section 2.4)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from geometry.arrays import Directions, Indices, Points, Scalars, Triangles
from geometry.compiled import compiled
from geometry.mesh import areas_and_normals
from geometry.rays import RayScene, are_blocked, split_patches

_BATCH = 400_000
_ALIKE_MM = 2e-3
"""Rounding of coordinates to 0.0001 mm does not decide which of two equal edges is halved."""


@dataclass(frozen=True, slots=True, eq=False)
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


@dataclass(frozen=True, slots=True)
class Cone:
    """What counts as sprayed: inside the cone, seen, and met at no flatter an angle than this."""

    half_angle_rad: float
    incidence_rad: float
    """Least angle between a ray and the surface that it meets."""
    edge_rad: float = 0.0
    """Width inside the half angle over which a cell passes from inside to outside: sums over moments of a motion become
    smooth, and no cell's time hangs on the last digits of its place."""


def cut_cells(patches: Triangles, longest_mm: float) -> Cells:
    """Cut patches, wound outwards, into cells with no edge longer than this."""
    triangles, parent = split_patches(patches, longest_mm, _ALIKE_MM)
    areas, normals = areas_and_normals(triangles.copy())
    solid = areas > 0
    return Cells(triangles[solid], triangles[solid].mean(axis=1), normals[solid], areas[solid], parent[solid])


def cells_in_view(cells: Cells, scene: RayScene, cone: Cone, orifices: Points, axes: Directions) -> csr_array:
    """Which cells are in the cone at which pose, and seen from its apex.

    Args:
        cells: Of the surface.
        scene: What hides.
        cone: Its half angle, and the least angle of incidence.
        orifices: (p, 3) apexes, mm.
        axes: (p, 3) unit vectors along the cone's axis.

    Returns:
        (p, c) matrix of ones, and of shares where the cone has an edge.
    """
    rows: list[Indices] = []
    columns: list[Indices] = []
    shares: list[Scalars] = [np.empty(0)]
    inner, outer = cone.half_angle_rad - cone.edge_rad, cone.half_angle_rad
    step = max(1, _BATCH // max(1, len(cells.points) // 40))
    sine = float(np.sin(cone.incidence_rad))
    for begin in range(0, len(orifices), step):
        some = slice(begin, begin + step)
        pose, cell, share = _in_cone(
            (cells.points, cells.normals),
            (orifices[some], axes[some]),
            (float(np.cos(inner)), float(np.cos(outer))),
            sine,
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


@compiled
def _in_cone(
    surface: tuple[Points, Directions], poses: tuple[Points, Directions], cosines: tuple[float, float], sine: float
) -> tuple[Indices, Indices, Scalars]:
    """Pairs of a pose and a cell in its cone, and the share of each; cosines of the inner and outer half angle."""
    points, normals = surface
    orifices, axes = poses
    counts = np.zeros(len(orifices) + 1, dtype=np.int64)
    pose, cell, share = np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64), np.empty(0)
    inner, outer = cosines
    for turn in range(2):
        if turn == 1:
            counts = np.cumsum(counts)
            pose, cell = np.empty(counts[-1], dtype=np.int64), np.empty(counts[-1], dtype=np.int64)
            share = np.ones(counts[-1])
        for i in range(len(orifices)):
            ox, oy, oz = orifices[i, 0], orifices[i, 1], orifices[i, 2]
            ax, ay, az = axes[i, 0], axes[i, 1], axes[i, 2]
            found = 0
            for j in range(len(points)):
                x, y, z = points[j, 0] - ox, points[j, 1] - oy, points[j, 2] - oz
                along = x * ax + y * ay + z * az
                square = x * x + y * y + z * z
                if along <= 0.0 or along * along < outer * outer * square:
                    continue
                facing = -(x * normals[j, 0] + y * normals[j, 1] + z * normals[j, 2])
                if facing <= 0.0 or facing * facing < sine * sine * square:
                    continue
                if turn == 1:
                    at = counts[i] + found
                    pose[at] = i
                    cell[at] = j
                    share[at] = min(1.0, (along / np.sqrt(square) - outer) / max(inner - outer, 1e-12))
                found += 1
            if turn == 0:
                counts[i + 1] = found
    return pose, cell, share
