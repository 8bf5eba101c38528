"""Rays against everything that a board carries."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from boards.board import Board
from cleaning.surface.subdivide import split_patches
from geometry.arrays import Directions, Indices, Points, Scalars, Triangles
from geometry.mesh import areas_and_normals

_GRAZING = 1e-9
_SHY = 1.0 - 1e-4
"""A line of sight ends a little before its target, which is a surface itself."""


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """All bodies of a board, cut into triangles that are short enough to say where on them a ray landed.

    Board frame, mm. Face i of the scene is triangle i, and facet i of ``Facets``.
    """

    embree: Any
    origin: NDArray[np.float64]
    """(3,) what is zero for embree, whose numbers have seven digits."""
    triangles: Triangles
    """(m, 3, 3) wound so that the normal follows the right-hand rule."""
    normals: Directions
    """(m, 3) outward."""
    areas_mm2: Scalars
    """(m,)"""
    body: Indices
    """(m,) index into the board's bodies."""
    planes: NDArray[np.float64]
    """(m, 4) normal and its product with a vertex: where a ray meets the face, in full precision."""


def build_scene(board: Board, longest_mm: float = 2.0) -> Scene:
    """Make a board ready for rays.

    Args:
        board: Any board.
        longest_mm: No edge of a triangle stays longer.
    """
    body = np.repeat(np.arange(len(board.bodies)), [len(each.patches) for each in board.bodies])
    patches = np.concatenate([each.patches for each in board.bodies])
    stated = np.concatenate([each.normals for each in board.bodies])
    triangles, parent = split_patches(_wound(patches, stated), longest_mm)
    areas, normals = areas_and_normals(triangles.copy())
    solid = areas > 0
    triangles, areas, normals, body = triangles[solid], areas[solid], normals[solid], body[parent[solid]]
    origin = (triangles.reshape(-1, 3).min(axis=0) + triangles.reshape(-1, 3).max(axis=0)) / 2
    return Scene(
        embree=_embree(triangles - origin),
        origin=origin,
        triangles=triangles,
        normals=normals,
        areas_mm2=areas,
        body=body,
        planes=np.column_stack([normals, np.einsum("ij,ij->i", normals, triangles[:, 0])]),
    )


def cast_rays(scene: Scene, origins: NDArray[np.float32], directions: NDArray[np.float32]) -> NDArray[np.int32]:
    """First face that each ray hits, or -1: (n,). Origins are counted from the scene's own."""
    return scene.embree.run(origins, directions)


def cast(scene: Scene, origins: Points, directions: Directions) -> tuple[Indices, Scalars]:
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
    scene: Scene, origins: NDArray[np.float32], directions: NDArray[np.float32], lengths: NDArray[np.float32]
) -> NDArray[np.bool_]:
    """(n,) whether rays hit something before they are so long. Origins are counted from the scene's own."""
    found = scene.embree.run(origins, directions, dists=lengths * np.float32(_SHY), query="OCCLUDED")
    return np.asarray(found) >= 0


def _single(values: NDArray[np.float64]) -> NDArray[np.float32]:
    return np.ascontiguousarray(values, dtype=np.float32)


def _wound(patches: Triangles, stated: Directions) -> Triangles:
    """Turn patches over whose winding contradicts the stated normal."""
    _, normals = areas_and_normals(patches.copy())  # it spoils a lone last patch of what it is given
    wrong = np.einsum("ij,ij->i", normals, stated) < 0
    return np.where(wrong[:, None, None], patches[:, ::-1], patches)


def _embree(triangles: Triangles) -> Any:
    # Imported late: it is compiled code that no other command needs.
    from embreex.mesh_construction import TriangleMesh  # pyright: ignore[reportMissingImports]
    from embreex.rtcore_scene import EmbreeScene  # pyright: ignore[reportMissingImports]

    embree: Any = EmbreeScene()
    TriangleMesh(embree, _single(triangles))
    return embree
