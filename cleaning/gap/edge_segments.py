"""The eight edge segments of every underside: where the spray presses liquid in or sucks it out."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray

from boards.board import Board, Component
from boards.undersides.underside import Underside
from geometry.arrays import Directions, Indices, Points, Points2, Scalars

SEGMENTS = 8
"""Halves of the four edges of an underside, anticlockwise in its own frame (x along its length), beginning at the left
half of the front edge (-y): front left, front right, right front, right back, back right, back left, left back,
left front."""

Cast: TypeAlias = Callable[[Points, Directions], tuple[Indices, Scalars]]
"""Rays into the board: origins and unit directions (n, 3) to faces (n,), -1 if free, and distances (n,) in mm."""

_MIDDLES = np.array([[-1, -2], [1, -2], [2, -1], [2, 1], [1, 2], [-1, 2], [-2, 1], [-2, -1]]) / 4.0
_OUTWARD = np.array([[0, -1], [0, -1], [1, 0], [1, 0], [0, 1], [0, 1], [-1, 0], [-1, 0]], dtype=np.float64)
_CLEAR_MM = 0.1  # an outline is true within half of this


@dataclass(frozen=True, slots=True, eq=False)
class Edges:
    """Edge segments of c components, each with eight. Board frame, mm."""

    component: Indices
    """(c,) index into the board's components."""
    middles: NDArray[np.float64]
    """(c, 8, 3) middle of each segment, at the board's surface."""
    outward: NDArray[np.float64]
    """(c, 8, 3) unit vectors in the plane of the board."""
    heights_mm: Scalars
    """(c,) of each component."""
    sheltered: NDArray[np.float64]
    """(c, 8) from each segment, along its outward normal at half height, to the next body; infinite if free."""
    facing: Scalars
    """(c,) 1 on the top side, -1 on the bottom side: z of what points out of the board."""

    def only(self, row: int) -> "Edges":
        """The edges of one component."""
        return Edges(*(getattr(self, each.name)[[row]] for each in fields(self)))


@dataclass(frozen=True, slots=True, eq=False)
class EdgePressure:
    """Pressure on the eight edge segments of one component while the jet is near, in one stage."""

    sample: Indices
    """(k,) ascending indices into the stage's samples: all that are near enough to matter."""
    pressure_pa: NDArray[np.float64]
    """(k, 8)"""


def build_edges(undersides: Sequence[Underside], board: Board, cast: Cast) -> Edges:
    """Lay eight segments around each underside and look how far each is from the next body.

    The rays begin just outside the part's own outline, so that its leads do not shelter it from itself.

    Args:
        undersides: Of components of this board; those of one component may differ in their cases only.
        board: Has the components by their names.
        cast: Casts rays at all bodies of the board.
    """
    index = {part.name: at for at, part in enumerate(board.components)}
    component = np.array([index[each.component] for each in undersides], dtype=np.int64)
    parts = [board.components[at] for at in component]
    turned = np.array([each.turn_rad for each in undersides], dtype=np.float64)
    size = np.array([[each.length_mm, each.width_mm] for each in undersides], dtype=np.float64).reshape(-1, 1, 2)
    place = np.array([[each.x_mm, each.y_mm] for each in undersides], dtype=np.float64).reshape(-1, 1, 2)
    middles, outward = np.zeros((len(parts), SEGMENTS, 3)), np.zeros((len(parts), SEGMENTS, 3))
    middles[..., :2] = place + _turn(_MIDDLES * size, turned)
    middles[..., 2] = np.array([board.surface_z_mm(part.side) for part in parts], dtype=np.float64)[:, None]
    outward[..., :2] = _turn(np.broadcast_to(_OUTWARD, (len(parts), SEGMENTS, 2)), turned)
    heights = np.array([part.height_mm for part in parts], dtype=np.float64)
    facing = np.array([1.0 if part.side == "top" else -1.0 for part in parts])
    start = _way_out(parts, middles[..., :2], outward[..., :2]) + _CLEAR_MM
    origins = middles + start[..., None] * outward
    origins[..., 2] += (0.5 * facing * heights)[:, None]
    face, distance = cast(origins.reshape(-1, 3), outward.reshape(-1, 3))
    free = np.where(face < 0, np.inf, distance).reshape(start.shape)
    return Edges(component, middles, outward, heights, start + free, facing)


def _turn(local: Points2, turned: Scalars) -> Points2:
    """(c, 8, 2) vectors of each underside's frame in the board's."""
    c, s = np.cos(turned)[:, None], np.sin(turned)[:, None]
    x, y = local[..., 0], local[..., 1]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def _way_out(parts: Sequence[Component], middles: Points2, outward: Points2) -> Scalars:
    """(c, 8) from each segment to where its outward normal leaves the part's own outline for good, mm; 0 if it has."""
    outlines = np.array([part.outline for part in parts], dtype=object)
    x0, y0, x1, y1 = shapely.bounds(outlines).reshape(-1, 4).T
    beyond = np.hypot(x1 - x0, y1 - y0)[:, None, None]
    lines = shapely.linestrings(np.stack([middles, middles + beyond * outward], axis=2))
    inside = shapely.intersection(lines, outlines[:, None])
    corners, of = shapely.get_coordinates(inside.ravel(), return_index=True)
    along = np.sum((corners - middles.reshape(-1, 2)[of]) * outward.reshape(-1, 2)[of], axis=1)
    way = np.zeros(middles.shape[0] * SEGMENTS)
    np.maximum.at(way, of, along)
    return way.reshape(-1, SEGMENTS)
