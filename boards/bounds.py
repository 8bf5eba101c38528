"""Bounds of what a board file may state: they hold where a text becomes a number, and again for what was understood.

Geometry libraries hang, fill the memory or end the process on coordinates that no board has.
"""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from boards.board import Body
from boards.errors import BoardError
from geometry.arrays import Points2

FARTHEST_MM = 10_000.0
"""No coordinate and no length of a board is larger."""

MOST_TURN_DEG = 3600.0
"""No angle is larger: ten turns."""

MOST_TRIANGLES = 20_000_000
"""More than a board file of 2 GB holds."""

MOST_BODIES = 50_000
"""Ten times what is measured; each takes some milliseconds."""

MOST_CORNERS = 200_000
"""Of one outline with its holes, arcs as chords."""


_MOST_PAIRS = 500_000
_LEAST = 1e-100
"""Numbers nearer to 0 are 0: GEOS does not come back from simplifying an outline with one below the normal floats."""


def number_within(word: str, bound: float, scale: float = 1.0) -> float:
    """Read a number as text; NaN where it is none, is not finite, or beyond the bound after it was scaled."""
    try:
        value = float(word) * scale
    except ValueError:
        return math.nan
    if not abs(value) <= bound or "_" in word:
        return math.nan
    return value if abs(value) >= _LEAST else 0.0


def beyond(points: ArrayLike, bound: float = FARTHEST_MM) -> bool:
    """Whether a corner is no finite number, or farther from the origin than a board's may be; mm."""
    return not bool((np.abs(np.asarray(points)) <= bound).all())


def check_corners(rings: Sequence[Points2], file: Path | None = None) -> None:
    """Refuse an outline that polygons cannot be computed from, wherever one is made into a body.

    Raises:
        BoardError: It has too many corners, or one that is no finite number or farther away than a board reaches.
    """
    count = sum(map(len, rings))
    if any(map(beyond, rings)):
        message = "an outline or a height is no number or lies more than 10 m away. "
        raise BoardError(f"{message}Correct its place, and check the units.", file=file)
    if count > MOST_CORNERS:
        message = f"the board's outline has {count:,} corners, arcs as chords; at most {MOST_CORNERS:,} are read. "
        raise BoardError(f"{message}Draw it with fewer and smaller pieces.", file=file)


def check_bodies(bodies: Sequence[Body], bound: float = FARTHEST_MM) -> None:
    """Refuse what the libraries of polygons and meshes do not come back from, whichever reader let it through.

    Raises:
        BoardError: There are too many bodies or triangles, a body has none, or a corner is no place on a workpiece.
    """
    if len(bodies) > MOST_BODIES:
        message = f"holds {len(bodies):,} bodies; at most {MOST_BODIES:,} are read. Export each component as one body."
        raise BoardError(message)
    count = sum(len(body.patches) for body in bodies)
    if count > MOST_TRIANGLES:
        raise BoardError(f"holds {count:,} triangles; at most {MOST_TRIANGLES:,} are read. Export it more coarsely.")
    for body in bodies:
        if not len(body.patches):
            raise BoardError(f"{body.name} is empty: it has no triangle. Correct its model or leave it out.")
        if beyond(body.patches, bound):
            problem = f"has a corner that is no number or lies more than {bound / 1000.0:g} m away"
            raise BoardError(f"{body.name} {problem}. Correct its model or its place, and check the units.")


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
