"""Rays against triangles, traced by Embree."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Directions, Indices, Points, Scalars, Triangles
from geometry.mesh import areas_and_normals

_GRAZING = 1e-9
_ROUND_MM = 1e-6
_FAR_MM = 1e30
_SHY = 1.0 - 1e-4
"""A line of sight ends a little before its target, which is a surface itself."""


@dataclass(frozen=True, slots=True, eq=False)
class RayScene:
    """Bodies, cut into triangles that are short enough to locate where a ray landed. Face i is triangle i.

    Millimetres.
    """

    embree: Any
    origin: NDArray[np.float64]
    """(3,) what is zero for embree, whose numbers have seven digits."""
    triangles: Triangles
    """(m, 3, 3) wound so that the normal follows the right-hand rule."""
    areas_mm2: Scalars
    """(m,)"""
    body: Indices
    """(m,) index of the body."""
    planes: NDArray[np.float64]
    """(m, 4) normal and its product with a vertex: where a ray meets the face, in full precision."""

    @property
    def normals(self) -> Directions:
        """(m, 3) outward."""
        return self.planes[:, :3]


def build_ray_scene(patches: Triangles, normals: Directions, body: Indices, longest_mm: float) -> RayScene:
    """Make triangles ready for rays.

    Args:
        patches: (n, 3, 3) mm.
        normals: (n, 3) outward; a patch that is wound the other way is turned around.
        body: (n,) index of the body that each patch belongs to.
        longest_mm: No edge of a triangle stays longer.
    """
    # Imported late: it is compiled code that no other command needs.
    from embreex.mesh_construction import TriangleMesh  # pyright: ignore[reportMissingImports]
    from embreex.rtcore_scene import EmbreeScene  # pyright: ignore[reportMissingImports]

    _, found = areas_and_normals(patches.copy())  # it spoils a lone last patch of what it is given
    contradicts = np.einsum("ij,ij->i", found, normals) < 0
    wound = np.where(contradicts[:, None, None], patches[:, ::-1], patches)
    triangles, parent = split_patches(wound, longest_mm)
    areas, found = areas_and_normals(triangles.copy())
    solid = areas > 0
    triangles, areas, found = triangles[solid], areas[solid], found[solid]
    origin = (triangles.reshape(-1, 3).min(axis=0) + triangles.reshape(-1, 3).max(axis=0)) / 2
    embree: Any = EmbreeScene()
    TriangleMesh(embree, _single(triangles - origin))
    return RayScene(
        embree=embree,
        origin=origin,
        triangles=triangles,
        areas_mm2=areas,
        body=body[parent[solid]],
        planes=np.column_stack([found, np.einsum("ij,ij->i", found, triangles[:, 0])]),
    )


def split_patches(patches: Triangles, longest_mm: float, round_mm: float = _ROUND_MM) -> tuple[Triangles, Indices]:
    """Halve the longest edge of triangles until no edge is too long.

    Args:
        patches: (n, 3, 3) mm.
        longest_mm: More than 0.
        round_mm: Edges whose lengths differ by less are equal, and the first of them is halved.

    Returns:
        (m, 3, 3) triangles wound as they were, and (m,) from which patch each is. Triangles of a patch follow each
        other in the order of the patches.
    """
    triangles, parent = patches, np.arange(len(patches))
    done: list[Triangles] = []
    parents: list[Indices] = []
    while len(triangles):
        # Lengths are rounded: which of two equal edges is cut must not depend on where the board lies.
        ways = triangles[:, (1, 2, 0)] - triangles
        edges = np.round(np.sqrt(ways[..., 0] ** 2 + ways[..., 1] ** 2 + ways[..., 2] ** 2) / round_mm)
        long = edges.max(axis=1) * round_mm > longest_mm
        done.append(triangles[~long])
        parents.append(parent[~long])
        triangles, parent, first = triangles[long], parent[long], np.argmax(edges[long], axis=1)
        rows = np.arange(len(triangles))
        a, b, c = (triangles[rows, (first + corner) % 3] for corner in range(3))
        middle = (a + b) / 2
        halves = np.stack([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)], axis=1)
        triangles, parent = halves.reshape(-1, 3, 3), np.repeat(parent, 2)
    together = np.concatenate(parents) if parents else np.empty(0, dtype=np.int64)
    order = np.argsort(together, kind="stable")
    return (np.concatenate(done)[order] if done else patches), together[order]


def cast_rays(scene: RayScene, origins: NDArray[np.float32], directions: NDArray[np.float32]) -> NDArray[np.int32]:
    """First face that each ray hits, or -1: (n,). Origins are counted from the scene's own."""
    return scene.embree.run(origins, directions)


def cast(scene: RayScene, origins: Points, directions: Directions) -> tuple[Indices, Scalars]:
    """Follow rays until they hit something.

    Args:
        scene: What may be hit.
        origins: (n, 3) board frame, mm.
        directions: (n, 3) unit vectors.

    Returns:
        (n,) face or -1, and (n,) distance in mm, infinite where nothing is hit.
    """
    faces = cast_rays(scene, _single(origins - scene.origin), _single(directions)).astype(np.int64)
    hit = np.flatnonzero(faces >= 0)
    planes = scene.planes[faces[hit]]
    facing = np.einsum("ij,ij->i", planes[:, :3], directions[hit])
    away = planes[:, 3] - np.einsum("ij,ij->i", planes[:, :3], origins[hit])
    distances = np.full(len(origins), np.inf)
    distances[hit] = np.maximum(away / np.where(np.abs(facing) < _GRAZING, np.inf, facing), 0.0)
    return faces, distances


def are_blocked(
    scene: RayScene,
    origins: NDArray[np.float32],
    directions: NDArray[np.float32],
    lengths: NDArray[np.float32] | None = None,
) -> NDArray[np.bool_]:
    """(n,) whether rays hit something, before they are so long; without lengths anywhere.

    Origins are counted from the scene's own.
    """
    ends = np.full(len(origins), _FAR_MM, dtype=np.float32) if lengths is None else lengths * np.float32(_SHY)
    found = scene.embree.run(origins, directions, dists=ends, query="OCCLUDED")
    return np.asarray(found) >= 0


def _single(values: NDArray[np.float64]) -> NDArray[np.float32]:
    return np.ascontiguousarray(values, dtype=np.float32)
