"""Upright prisms: the bodies of formats that state an outline and two heights."""

import manifold3d
import numpy as np
import shapely
from shapely import LinearRing, MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from boards.board import Surface
from boards.bounds import check_corners
from boards.errors import BoardError
from geometry.arrays import Directions, Triangles
from geometry.polygons import signed_area

_MOST_DRAWN, _MOST_RING_CORNERS = 30_000, 10_000
"""Corners of a ring as it is drawn, and as it is triangulated: the time grows with the square of their number."""
_FLAT_MM = 0.001
"""Points of an outline that stand off its course by less are dropped: they would make patches without area."""


def prism(
    outline: Polygon | MultiPolygon, low_mm: float, high_mm: float
) -> tuple[Triangles, Directions, tuple[Surface, ...]]:
    """Extrude an outline with its holes between two heights.

    Args:
        outline: Plan outline, mm; several pieces give several prisms in one body.
        low_mm: Height of the lower face.
        high_mm: Height of the upper face, above the lower one.

    Returns:
        Patches ``(n, 3, 3)``, outward normals ``(n, 3)`` and the surfaces ``top``, ``bottom``, ``sides`` in that order.
        Each piece is a closed mesh.

    Raises:
        BoardError: A corner or a height is no place on a board, or there are too many corners.
    """
    check_corners([shapely.get_coordinates(outline), np.array([[low_mm, high_mm]])])
    _check_rings(outline, _MOST_DRAWN)
    thinned = shapely.remove_repeated_points(outline, _FLAT_MM).simplify(_FLAT_MM)
    if not thinned.area > 0.0:  # nothing of it is broader than that: the box around it stands for it
        thinned = shapely.box(*outline.buffer(_FLAT_MM).bounds)
    _check_rings(thinned, _MOST_RING_CORNERS)
    # Shells counter-clockwise, holes clockwise, open, each from the vertex with which it was drawn first.
    drawn = [(shapely.get_coordinates(ring), outer) for ring, outer in _rings(thinned)]
    rings = [points[:-1] if (signed_area(points[:-1]) >= 0.0) == outer else points[:0:-1] for points, outer in drawn]
    points = np.concatenate(rings)
    corners = points[np.asarray(manifold3d.triangulate(rings), dtype=np.int64)]
    top = np.dstack([corners, np.full(corners.shape[:2], high_mm)])
    bottom = np.dstack([corners[:, ::-1], np.full(corners.shape[:2], low_mm)])
    walls: list[Triangles] = []
    outward: list[Directions] = []
    for ring in rings:  # two patches an edge, outward to the right of travel
        after = np.concatenate((ring[1:], ring[:1]))
        wall = np.empty((len(ring), 2, 3, 3))
        wall[:, :, 0, :2] = ring[:, None]
        wall[:, 0, 1, :2] = wall[:, 0, 2, :2] = wall[:, 1, 1, :2] = after
        wall[:, 1, 2, :2] = ring
        wall[..., 2] = (low_mm, low_mm, high_mm), (low_mm, high_mm, high_mm)
        walls.append(wall.reshape(-1, 3, 3))
        along = after - ring
        along /= np.sqrt(along[:, 0] ** 2 + along[:, 1] ** 2)[:, None]
        outward.append(np.repeat(np.column_stack([along[:, 1], -along[:, 0], np.zeros(len(ring))]), 2, axis=0))
    sides = np.concatenate(walls)
    up = np.tile([0.0, 0.0, 1.0], (len(top), 1))
    surfaces = (Surface("top", len(top)), Surface("bottom", len(bottom)), Surface("sides", len(sides)))
    return np.concatenate([top, bottom, sides]), np.concatenate([up, -up, *outward]), surfaces


def _check_rings(outline: BaseGeometry, most: int) -> None:
    count = max((len(ring.coords) for ring, _ in _rings(outline)), default=0)
    if count > most:
        raise BoardError(f"one line of an outline has {count:,} corners; at most {most:,} are read. Draw it coarser.")


def _rings(outline: BaseGeometry) -> list[tuple[LinearRing, bool]]:
    """Rings of an outline, and whether each is a shell."""
    pieces = [piece for piece in shapely.get_parts(outline).tolist() if isinstance(piece, Polygon)]
    return [(ring, place == 0) for piece in pieces for place, ring in enumerate((piece.exterior, *piece.interiors))]
