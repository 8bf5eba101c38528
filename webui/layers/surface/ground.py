"""The workpiece as coloured triangles, the outline of a component, and the stripes on the faces of a part."""

from collections.abc import Sequence
from functools import lru_cache
from itertools import cycle
from typing import Literal, TypeAlias

import numpy as np

from boards.board import Board, Part, Workpiece
from geometry.arrays import Indices, Points, Triangles
from rulesengine.strokes.classify import Classified
from rulesengine.surface.part_job import Covering
from webui.glb.glb import (
    bars,
    flat_triangles_glb,
    line_width_mm,
    lines_glb,
    ribbons,
    size_mm,
    triangles_glb,
    unlike_segments,
)
from webui.theme.palette import (
    ACCENT,
    BOARD,
    COMPONENT,
    FIXTURE,
    INK,
    SELECTED,
    VERDICT_COLOURS,
    Tint,
    Tints,
    of_names,
    tint_values,
)

ColourBy: TypeAlias = Literal["class", "height", "package", "nothing"]

_OVER_MM = 0.02
_PALER = 0.35
"""Share of white in the colours of components: strokes run in front of them."""
_THICKEST = 0.03
"""Of an outline, as a share of the part's length."""
_REMEMBERED = 8
_SAME_MM = 1e-3
_FIXTURES = (FIXTURE, (146, 153, 160))
"""In turn: a jaw stands out from the table behind it."""


@lru_cache(_REMEMBERED)
def paint_workpiece(workpiece: Workpiece, classified: tuple[Classified, ...], by: ColourBy) -> tuple[bytes, Tints]:
    """A workpiece with the components of a board coloured, and the legend; the last few are cached for all pages.

    Args:
        workpiece: The workpiece.
        classified: Class of each component; used where colours mean classes.
        by: Meaning of the colours.
    """
    tints, legend = tint_components(workpiece, classified, by)
    fixtures = [body.name for body in workpiece.bodies if body.role == "fixture"]
    return ground_glb(workpiece, tints | dict(zip(fixtures, cycle(_FIXTURES), strict=False))), legend


def ground_glb(workpiece: Workpiece, tints: Tints) -> bytes:
    """Every body; components in their tints."""
    bodies = workpiece.bodies
    corners = np.concatenate([body.patches.reshape(-1, 3) for body in bodies])
    plain = {"board": BOARD, "fixture": FIXTURE}
    colour = np.array([tints.get(each.name, plain.get(each.role, COMPONENT)) for each in bodies], dtype=np.uint8)
    return triangles_glb(corners, np.repeat(colour, [3 * len(body.patches) for body in bodies], axis=0))


def chosen_glb(workpiece: Workpiece, name: str, colour: Tint) -> bytes:
    """One component alone and slightly larger, which covers the one on the board; of a face its edges."""
    if any(each.name == name for each in workpiece.faces):
        return _edges_glb(workpiece.require_part("this"), name, colour)
    body = next((each for each in workpiece.bodies if each.name == name), None)
    if body is None or len(body.patches) == 0:
        return b""
    corners: Points = (body.patches + _OVER_MM * body.normals[:, None, :]).reshape(-1, 3)
    return triangles_glb(corners, np.tile(np.array(colour, dtype=np.uint8), (len(corners), 1)))


def _edges_glb(part: Part, name: str, colour: Tint) -> bytes:
    """Edges around a face as bars, so that the colour of the face stays visible."""
    face = next((each for each in part.faces if each.name == name), None)
    if face is None:
        return b""
    patches = part.patches[face.patches]
    sides = np.stack([patches, np.roll(patches, -1, axis=1)], axis=2).reshape(-1, 2, 3)
    _, corner = np.unique(np.round(sides / _SAME_MM).reshape(-1, 3), axis=0, return_inverse=True)
    _, first, count = np.unique(np.sort(corner.reshape(-1, 2), axis=1), axis=0, return_index=True, return_counts=True)
    around = sides[first[count == 1]]
    if not len(around):  # a face that closes in itself, such as a ball
        return b""
    width = 2.0 * line_width_mm(size_mm(part))
    return flat_triangles_glb(*bars(around, colour, width))


def tint_components(board: Workpiece, classified: tuple[Classified, ...], by: ColourBy) -> tuple[Tints, Tints]:
    """Colours of components.

    Returns:
        Colours by component name, and the legend.
    """
    match by:
        case "class":
            kind = {each.component: each.component_class for each in classified}
        case "package":
            kind = {each.name: each.package or "unknown" for each in board.components}
        case "height":
            heights = np.array([each.height_mm for each in board.components])
            marks = (
                {f"{mark:.1f} mm": mark for mark in np.linspace(heights.min(), heights.max(), 5)}
                if len(heights)
                else {}
            )
            found, legend = tint_values(heights, marks)
            return dict(zip((each.name for each in board.components), found, strict=True)), legend
        case "nothing":
            return {}, {}
    named = of_names([kind[each.name] for each in board.components if each.name in kind])
    legend: Tints = {}
    for name, colour in named.items():
        red, green, blue = (int(channel * (1 - _PALER) + 255 * _PALER) for channel in colour)
        legend[name] = red, green, blue
    return {name: legend[value] for name, value in kind.items() if value in legend}, legend


def outline_glb(board: Board, name: str) -> bytes:
    """The edges of the prism around a component as bars; no bytes where there is no such component.

    Args:
        board: The board.
        name: Reference designator of the component.
    """
    component = next((each for each in board.components if each.name == name), None)
    if component is None:
        return b""
    ring = np.asarray(component.outline.exterior.coords, dtype=np.float64)[:, :2]
    surface = board.surface_z_mm(component.side)
    top = surface + component.height_mm * (1.0 if component.side == "top" else -1.0)
    low, high = (np.column_stack([ring, np.full(len(ring), z)]) for z in (surface, top))
    edges = [np.stack([each[:-1], each[1:]], axis=1) for each in (low, high)]
    segments = np.concatenate([*edges, np.stack([low[:-1], high[:-1]], axis=1)])
    width = min(line_width_mm(size_mm(board)), _THICKEST * float(np.ptp(ring, axis=0).max()))
    return flat_triangles_glb(*bars(segments, SELECTED, width))


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
