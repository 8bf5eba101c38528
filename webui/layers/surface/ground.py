"""The board and what stands on it, as coloured triangles."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, TypeAlias

import numpy as np

from boards.board import Board
from geometry.arrays import Points, Scalars
from rulesengine.strokes.classify import Classified
from webui.glb.glb import Colours, triangles_glb
from webui.theme.palette import BOARD, COMPONENT, FIXTURE, of_names, of_values

ColourBy: TypeAlias = Literal["class", "height", "package", "nothing"]
Tints: TypeAlias = dict[str, tuple[int, int, int]]

_OVER_MM = 0.02
_PALER = 0.35
_REMEMBERED = 8


@dataclass(frozen=True, slots=True, eq=False)
class Painted:
    """A board in its colours."""

    glb: bytes
    legend: Tints


@lru_cache(_REMEMBERED)
def paint_board(board: Board, classified: tuple[Classified, ...], by: ColourBy) -> Painted:
    """Draw a board with its components coloured; the last few are remembered, whichever page asks.

    Args:
        board: The board.
        classified: Class of each component; looked at where colours mean classes.
        by: What the colours tell apart.
    """
    tints, legend = tint_components(board, classified, by)
    return Painted(ground_glb(board, tints), legend)


def ground_glb(board: Board, tints: Tints) -> bytes:
    """Draw every body; components in their tints."""
    corners = np.concatenate([body.patches.reshape(-1, 3) for body in board.bodies])
    colour = np.array([_tint(body.role, tints.get(body.name)) for body in board.bodies], dtype=np.uint8)
    return triangles_glb(corners, np.repeat(colour, [3 * len(body.patches) for body in board.bodies], axis=0))


def component_glb(board: Board, name: str, colour: tuple[int, int, int]) -> bytes:
    """Draw one component alone and a hair larger, to lay it over the one that is there."""
    body = next((each for each in board.bodies if each.name == name), None)
    if body is None or len(body.patches) == 0:
        return b""
    corners: Points = (body.patches + _OVER_MM * body.normals[:, None, :]).reshape(-1, 3)
    return triangles_glb(corners, np.tile(np.array(colour, dtype=np.uint8), (len(corners), 1)))


def tint_components(board: Board, classified: tuple[Classified, ...], by: ColourBy) -> tuple[Tints, Tints]:
    """Colour components.

    Returns:
        Component name to colour, and the legend: what a colour means to the colour.
    """
    match by:
        case "class":
            kind = {each.component: each.component_class for each in classified}
        case "package":
            kind = {each.name: each.package or "unknown" for each in board.components}
        case "height":
            return _by_height(board)
        case "nothing":
            return {}, {}
    legend = _softened([kind[each.name] for each in board.components if each.name in kind])
    return {name: legend[value] for name, value in kind.items() if value in legend}, legend


def _by_height(board: Board) -> tuple[Tints, Tints]:
    heights = np.array([each.height_mm for each in board.components])
    if len(heights) == 0:
        return {}, {}
    low, high = float(heights.min()), float(heights.max())
    colours: Colours = of_values(heights, low, high)
    tints = {each.name: _triple(colour) for each, colour in zip(board.components, colours, strict=True)}
    steps = np.linspace(low, high, 5)
    legend = {
        f"{step:.1f} mm": _triple(colour) for step, colour in zip(steps, of_values(steps, low, high), strict=True)
    }
    return tints, legend


def _softened(names: list[str]) -> Tints:
    """Give each name a colour, paler than those of strokes, which run in front of it."""
    return {name: _triple(np.array(colour) * (1 - _PALER) + 255 * _PALER) for name, colour in of_names(names).items()}


def _triple(colour: Colours | Scalars) -> tuple[int, int, int]:
    red, green, blue = (int(channel) for channel in colour)
    return red, green, blue


def _tint(role: str, tint: tuple[int, int, int] | None) -> tuple[int, int, int]:
    return tint if tint is not None else {"board": BOARD, "fixture": FIXTURE}.get(role, COMPONENT)
