"""Measures of triangle soups: patches that need not be closed, connected or wound the same way."""

import numpy as np

from geometry.arrays import Directions, Points, Scalars, Triangles

_CHUNK = 8192


def cross_products(patches: Triangles) -> Points:
    """(n, 3) vector of each patch along the normal of its winding, as long as twice its area."""
    crosses = np.empty((len(patches), 3))
    for begin in range(0, len(patches), _CHUNK):  # what fits the cache is several times faster
        some = slice(begin, begin + _CHUNK)
        a, b, c = (patches[some, corner].T.copy() for corner in range(3))
        b -= a
        c -= a
        crosses[some, 0] = b[1] * c[2] - b[2] * c[1]
        crosses[some, 1] = b[2] * c[0] - b[0] * c[2]
        crosses[some, 2] = b[0] * c[1] - b[1] * c[0]
    return crosses


def middles_of(triangles: Triangles) -> Points:
    """Means of the corners of (n, 3, 3) triangles, (n, 3): a mean along an axis of three takes four times as long."""
    return (triangles[:, 0] + triangles[:, 1] + triangles[:, 2]) / 3.0


def boxes_of(triangles: Triangles) -> tuple[Points, Points]:
    """Lowest and highest coordinates of (n, 3, 3) triangles, (n, 3) each: as fast as ``middles_of``."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    return np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)


def areas_and_normals(patches: Triangles) -> tuple[Scalars, Directions]:
    """Area and unit normal of each patch by its winding.

    Args:
        patches: (n, 3, 3) triangles, mm.

    Returns:
        (n,) areas in mm², and (n, 3) unit normals, zero where a triangle has no area.
    """
    crosses = cross_products(patches)
    doubled = np.sqrt(np.einsum("ij,ij->i", crosses, crosses))
    np.divide(crosses, doubled[:, None], out=crosses, where=doubled[:, None] > 0.0)
    return doubled / 2.0, crosses
