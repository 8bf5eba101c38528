"""A frame that moves with a shape, with a grid in it: what is decided there is decided the same in every pose."""

from dataclasses import dataclass

import numpy as np
import shapely
from shapely import Polygon

from geometry.arrays import Indices, Points2, Triangles
from geometry.polygons import GRID_MM, to_grid


@dataclass(frozen=True, slots=True)
class GridFrame:
    """Where a shape lies: an origin and a direction that are taken from the shape itself. Millimetres.

    Coordinates in this frame are rounded to a grid. The rounding swallows the last bits that a rotation changes, so
    that union, offset and simplification see the same numbers wherever the shape lies.
    """

    origin: tuple[float, float]
    axis: tuple[float, float]
    """Unit vector of the frame's x."""

    def to_frame(self, points: Points2) -> Points2:
        """Move (n, 2) points into the frame and round them to the grid."""
        x, y = points[:, 0] - self.origin[0], points[:, 1] - self.origin[1]
        cosine, sine = self.axis
        return to_grid(np.column_stack((cosine * x + sine * y, cosine * y - sine * x)))

    def from_frame(self, points: Points2) -> Points2:
        """Move (n, 2) points of the frame to where the shape lies."""
        cosine, sine = self.axis
        x, y = points[:, 0], points[:, 1]
        return np.column_stack((cosine * x - sine * y, sine * x + cosine * y)) + np.array(self.origin)

    def triangles_to_frame(self, patches: Triangles) -> Triangles:
        """Move x and y of (n, 3, 3) triangles into the frame, z stays."""
        moved = np.empty(patches.shape)
        moved[:, :, :2] = self.to_frame(patches[:, :, :2].reshape(-1, 2)).reshape(-1, 3, 2)
        moved[:, :, 2] = patches[:, :, 2]
        return moved

    def polygons_from_frame(self, polygons: list[Polygon], inside: Points2, outside: Points2) -> list[Polygon]:
        """Move polygons to where the shape lies; a corner that is a vertex of the mesh becomes exactly that vertex.

        Args:
            polygons: Polygons in the frame.
            inside: (n, 2) vertices of the mesh in the frame.
            outside: (n, 2) the same vertices where the shape lies.
        """
        keys = _keys(inside)
        order = np.argsort(keys, kind="stable")
        ordered = keys[order]

        def move(points: Points2) -> Points2:
            moved = self.from_frame(points)
            found = _keys(points)
            place = np.minimum(np.searchsorted(ordered, found), len(ordered) - 1)
            known = ordered[place] == found
            moved[known] = outside[order[place[known]]]
            return moved

        moved = shapely.transform(np.array(polygons, dtype=object), move)
        return [polygon for polygon in moved.tolist() if isinstance(polygon, Polygon)]


def _keys(points: Points2) -> Indices:
    """One integer for each point of the grid."""
    steps = np.round(points / GRID_MM).astype(np.int64)
    return (steps[:, 0] << 32) + steps[:, 1]


def find_grid_frame(patches: Triangles) -> GridFrame:
    """Take the frame of flat patches from their edge: its first longest piece in file order.

    Args:
        patches: (n, 3, 3) triangles of one flat face, mm.
    """
    corners = patches[:, :, :2].reshape(-1, 2)
    begins = corners
    ends = patches[:, (1, 2, 0), :2].reshape(-1, 2)
    lengths = np.round(np.hypot(*(ends - begins).T) / (128.0 * GRID_MM))
    # Sides that belong to two triangles are not on the edge.
    names = np.unique(np.vstack((begins, ends)), axis=0, return_inverse=True)[1].reshape(2, -1)
    pairs = np.sort(names, axis=0)
    _, side, counts = np.unique(pairs[0] * (names.max() + 1) + pairs[1], return_inverse=True, return_counts=True)
    lengths[counts[side] != 1] = -1.0
    first = int(np.argmax(lengths))
    vector = ends[first] - begins[first]
    length = float(np.hypot(*vector))
    axis = (float(vector[0] / length), float(vector[1] / length)) if length > 0.0 else (1.0, 0.0)
    return GridFrame((float(begins[first, 0]), float(begins[first, 1])), axis)
