"""The board and what stands on it, as coloured triangles."""

from typing import Literal, TypeAlias

import numpy as np

from boards.board import Board
from geometry.arrays import Indices, Points
from rulesengine.classify import Classified
from webui.layers.glb import Colours, triangles_glb
from webui.palette import BOARD, COMPONENT, FIXTURE, of_names, of_values

ColourBy: TypeAlias = Literal["class", "height", "package", "nothing"]
Tints: TypeAlias = dict[str, tuple[int, int, int]]


def ground_glb(board: Board, tints: Tints) -> bytes:
    """Draw every body; components in their tints."""
    corners = np.concatenate([body.patches.reshape(-1, 3) for body in board.bodies])
    colour = np.array([_tint(body.role, tints.get(body.name)) for body in board.bodies], dtype=np.uint8)
    return triangles_glb(corners, np.repeat(colour, [3 * len(body.patches) for body in board.bodies], axis=0))


def component_glb(board: Board, name: str, colour: tuple[int, int, int]) -> bytes:
    """Draw one component alone, to lay it over the others."""
    patches = [body.patches.reshape(-1, 3) for body in board.bodies if body.name == name]
    corners: Points = np.concatenate([np.empty((0, 3)), *patches])
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
    legend = of_names([kind[each.name] for each in board.components if each.name in kind])
    return {name: legend[value] for name, value in kind.items() if value in legend}, legend


def body_of_triangle(board: Board) -> Indices:
    """(n,) which body each of the board's triangles belongs to, in the order in which they are drawn."""
    return np.repeat(np.arange(len(board.bodies)), [len(body.patches) for body in board.bodies])


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


def _triple(colour: Colours) -> tuple[int, int, int]:
    red, green, blue = (int(channel) for channel in colour)
    return red, green, blue


def _tint(role: str, tint: tuple[int, int, int] | None) -> tuple[int, int, int]:
    return tint if tint is not None else {"board": BOARD, "fixture": FIXTURE}.get(role, COMPONENT)
