"""Stripes on the faces of a part: where the jet meets them, their order, the lance along them, and what is clean."""

from collections.abc import Sequence

import numpy as np

from geometry.arrays import Indices, Points, Triangles
from rulesengine.surface.part_job import Covering
from webui.glb.glb import flat_triangles_glb, lines_glb, ribbons, unlike_segments
from webui.theme.palette import ACCENT, INK, VERDICT_COLOURS, Tints

_LIFT_MM = 0.8
_NUMBER_MM = 4.0
"""How far above the face a stripe's number stands."""
_MOST_NUMBERS = 150
"""More would hide the part, and each is an element of its own in the browser."""
_LANCE_MM = 60.0
_LANCES_MM = 12.0
"""Way of the jet over the face from one lance that is drawn to the next."""
CLEANNESS: Tints = {
    "Held for the required time": VERDICT_COLOURS["clean"],
    "Held for less": VERDICT_COLOURS["marginal"],
    "Seen by no free pose": VERDICT_COLOURS["no verdict"],
}
"""Colours of cells, and the legend."""


def stripes_glb(coverings: Sequence[Covering], width_mm: float) -> bytes:
    """Draw the way of the jet's axis over the faces; no bytes where there is none."""
    segments = [np.empty((0, 2, 3))]
    for piece in (piece for covering in coverings for piece in covering.pieces):
        way = _lifted(piece.targets, piece.approach, _LIFT_MM)
        segments.append(np.stack([way[:-1], way[1:]], axis=1))
    drawn = np.concatenate(segments)
    drawn = drawn[unlike_segments(drawn)]
    if not len(drawn):
        return b""
    return flat_triangles_glb(*ribbons(drawn, INK, width_mm))


def stripe_starts(coverings: Sequence[Covering]) -> list[tuple[int, Points]]:
    """Number of each stripe in the order of spraying, from 1, and the point (3,) at which it begins, mm.

    Pauses at one pose have a number and no stripe; they are left out.
    """
    pieces = [piece for covering in coverings for piece in covering.pieces]
    return [
        (number, _lifted(piece.targets[:1], piece.approach[:1], _NUMBER_MM)[0])
        for number, piece in enumerate(pieces, start=1)
        if len(piece.targets) > 1
    ][:_MOST_NUMBERS]


def lances_glb(coverings: Sequence[Covering]) -> bytes:
    """Draw the end of the lance, from the orifice away from the jet, at equal distances along the stripes."""
    ends = [np.empty((0, 2, 3))]
    for piece in (piece for covering in coverings for piece in covering.pieces):
        way = np.concatenate([[0.0], np.linalg.norm(np.diff(piece.targets, axis=0), axis=1).cumsum()])
        at = np.unique(np.searchsorted(way, np.arange(0.0, way[-1] + 1e-9, _LANCES_MM)))
        ends.append(np.stack([piece.tcp[at], piece.tcp[at] - _LANCE_MM * piece.approach[at]], axis=1))
    segments = np.concatenate(ends)
    if not len(segments):
        return b""
    return lines_glb(segments.reshape(-1, 3), np.tile(np.array(ACCENT, dtype=np.uint8), (2 * len(segments), 1)))


def cells_glb(triangles: Triangles, states: Indices) -> bytes:
    """Draw the cells of the sprayed faces in the colour of what is held.

    Args:
        triangles: (c, 3, 3) the cells.
        states: (c,) index into ``CLEANNESS`` of each.
    """
    colours = np.array(list(CLEANNESS.values()), dtype=np.uint8)[states]
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    corners = (triangles + _LIFT_MM / 2 * normals[:, None, :]).reshape(-1, 3)
    return flat_triangles_glb(corners, np.repeat(colours, 3, axis=0))


def _lifted(targets: Points, approach: Points, by_mm: float) -> Points:
    """Points moved off the surface, against the jet, so that they are not hidden in it."""
    return targets - by_mm * approach
