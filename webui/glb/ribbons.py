"""Lines with a width, as triangles: browsers draw bare lines one pixel wide."""

import numpy as np
from numpy.typing import NDArray

from boards.board import Workpiece
from geometry.arrays import Points, Scalars
from webui.glb.glb import Colours

_SAME_MM = 0.001


def unlike_segments(segments: NDArray[np.float64]) -> NDArray[np.intp]:
    """Indices of distinct segments among (n, 2, 3), in order: the first of those that coincide, in either direction.

    Segments of no length are left out.
    """
    rounded = np.round(segments / _SAME_MM).astype(np.int64)
    forwards, backwards = rounded.reshape(-1, 6), rounded[:, ::-1].reshape(-1, 6)
    differs = forwards != backwards
    first = np.argmax(differs, axis=1)
    rows = np.arange(len(forwards))
    turned = np.where((forwards[rows, first] > backwards[rows, first])[:, None], backwards, forwards)
    _, index = np.unique(turned, axis=0, return_index=True)
    kept = np.sort(index)
    return kept[differs[kept].any(axis=1)]


def ribbons(segments: NDArray[np.float64], colours: Colours, width_mm: float) -> tuple[Points, Colours]:
    """Two crossed strips for every segment, one lying and one on edge, so that it is seen from all sides.

    Args:
        segments: (n, 2, 3) begin and end.
        colours: (n, 3) of each segment.
        width_mm: Of the strips.

    Returns:
        (12 n, 3) corners of triangles and their colours.
    """
    aside, upward = _across(segments)
    half = width_mm / 2
    strips = [_strip(segments, aside * half), _strip(segments, upward * half)]
    return np.concatenate(strips, axis=1).reshape(-1, 3), np.repeat(colours, 12, axis=0)


def bars(segments: NDArray[np.float64], colours: Colours, width_mm: float) -> tuple[Points, Colours]:
    """Four sides for every segment, which hide narrower ribbons inside.

    Args:
        segments: (n, 2, 3) begin and end.
        colours: (n, 3) of each segment.
        width_mm: Of the sides.

    Returns:
        (24 n, 3) corners of triangles and their colours.
    """
    aside, upward = (direction * width_mm / 2 for direction in _across(segments))
    sides = ((upward, aside), (-upward, aside), (aside, upward), (-aside, upward))
    strips = [_strip(segments + shift[:, None], half) for shift, half in sides]
    return np.concatenate(strips, axis=1).reshape(-1, 3), np.repeat(colours, 24, axis=0)


def size_mm(workpiece: Workpiece) -> float:
    """Diagonal of the box around a workpiece."""
    low, high = workpiece.box
    return float(np.linalg.norm(high - low))


def line_width_mm(size_mm: float) -> float:
    """Line width that is about two pixels where a workpiece of this diagonal fills half of a page."""
    return size_mm / 260


def lengths_of(segments: NDArray[np.float64]) -> Scalars:
    """(n,) lengths of (n, 2, 3) segments."""
    return np.asarray(np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1), dtype=np.float64)


def _across(segments: NDArray[np.float64]) -> tuple[Points, Points]:
    """(n, 3) directions normal to (n, 2, 3) segments: a horizontal one, and the one normal to both."""
    along = segments[:, 1] - segments[:, 0]
    unit = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    aside = np.cross(unit, [0.0, 0.0, 1.0])
    lengths = np.linalg.norm(aside, axis=1, keepdims=True)
    aside = np.where(lengths > 1e-6, aside / np.maximum(lengths, 1e-12), [1.0, 0.0, 0.0])
    return aside, np.cross(aside, unit)


def _strip(segments: NDArray[np.float64], half: Points) -> NDArray[np.float64]:
    """(n, 6, 3) two triangles for each segment."""
    begin, end = segments[:, 0], segments[:, 1]
    left, right = (begin + half, end + half), (begin - half, end - half)
    return np.stack([right[0], right[1], left[1], right[0], left[1], left[0]], axis=1)
