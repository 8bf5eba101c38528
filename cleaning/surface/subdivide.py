"""Cutting triangles until none is too long."""

import numpy as np

from geometry.arrays import Indices, Triangles

_ROUND_MM = 1e-6


def split_patches(patches: Triangles, longest_mm: float) -> tuple[Triangles, Indices]:
    """Halve the longest edge of triangles until no edge is longer than asked.

    Args:
        patches: (n, 3, 3) mm.
        longest_mm: More than 0.

    Returns:
        (m, 3, 3) triangles wound as they were, and (m,) from which patch each is. Triangles of a patch follow each
        other in the order of the patches.
    """
    triangles, parent = patches, np.arange(len(patches))
    done: list[Triangles] = []
    parents: list[Indices] = []
    while len(triangles):
        # Lengths are rounded: which of two equal edges is cut must not depend on where the board lies.
        edges = np.round(np.linalg.norm(np.roll(triangles, -1, axis=1) - triangles, axis=2) / _ROUND_MM)
        long = edges.max(axis=1) * _ROUND_MM > longest_mm
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
