"""Bounds of what a board file may state: they hold where a text becomes a number, and again for what was understood.

Geometry libraries hang, fill the memory or end the process on coordinates that no board has.
"""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from boards.errors import BoardError
from geometry.arrays import Points2, Triangles

FARTHEST_MM = 10_000.0
"""No coordinate and no length of a board is larger."""

MOST_TURN_DEG = 3600.0
"""No angle is larger: ten turns."""

MOST_TRIANGLES = 20_000_000
"""More than a board file of 2 GB holds."""

MOST_CORNERS = 200_000
"""Of one outline with its holes, arcs as chords."""


_MOST_PAIRS = 500_000


def number_within(word: str, bound: float, scale: float = 1.0) -> float:
    """Read a number as text; NaN where it is none, is not finite, or beyond the bound after it was scaled."""
    try:
        value = float(word) * scale
    except ValueError:
        return math.nan
    return value if abs(value) <= bound and "_" not in word else math.nan


def beyond(patches: Triangles, bound: float = FARTHEST_MM) -> bool:
    """Whether a corner is no finite number, or farther from the origin than a board's may be; mm."""
    return not bool((np.abs(patches) <= bound).all())


def check_corners(rings: Sequence[Points2], file: Path | None = None) -> None:
    """Refuse an outline of more corners than polygons can be computed from.

    Raises:
        BoardError: There are too many.
    """
    count = sum(map(len, rings))
    if count > MOST_CORNERS:
        message = f"the board's outline has {count:,} corners, arcs as chords; at most {MOST_CORNERS:,} are read. "
        raise BoardError(f"{message}Draw it with fewer and smaller pieces.", file=file)


def check_crowds(places: ArrayLike, file: Path | None = None) -> None:
    """Refuse parts that lie upon each other by the thousands: each would be compared with every other in its place.

    Args:
        places: (n, k) numbers that are alike for parts at the same place, such as their origins, mm.
        file: For the message.

    Raises:
        BoardError: So many lie upon each other that it cannot be a board.
    """
    rows = np.round(np.asarray(places, dtype=np.float64), 3)
    counts = np.unique(rows, axis=0, return_counts=True)[1] if len(rows) else np.zeros(0)
    if int(np.square(counts).sum()) > _MOST_PAIRS:
        message = "thousands of its parts lie upon each other. Export the board once, without copies of parts."
        raise BoardError(message, file=file)
