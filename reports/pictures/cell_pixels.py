"""Which cell of a board's surface one sees at each point of a picture: drawn once, then filled with any values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from boards.board import Side
from cleaning.surface.facets import Facets
from geometry.arrays import Indices, Scalars
from reports.pictures.sheet import View

_FLAT = 0.2
"""Facets whose normal rises less than this are walls: from above one would see a line."""


@dataclass(frozen=True, slots=True, eq=False)
class CellPixels:
    """A view of one side from the top, pixel by pixel. Row 0 is at the back (highest y)."""

    view: View
    cell: Indices
    """(rows, columns) index of the cell, -1 where there is none."""

    def filled(self, values: Scalars) -> NDArray[np.float64]:
        """(rows, columns) value of each pixel's cell; NaN where there is none."""
        return np.where(self.cell >= 0, np.append(values, np.nan)[self.cell], np.nan)


def see_cells(facets: Facets, side: Side, view: View, most_pixels: int = 900) -> CellPixels:
    """Draw the exposed facets that face a side, the outermost last, each in a colour that is its cell's number.

    Args:
        facets: The surface.
        side: The side to look at; x and y stay as seen from the top.
        view: The part of the plane.
        most_pixels: Along the longer side of the picture.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure

    outward = 1.0 if side == "top" else -1.0
    seen = np.flatnonzero(facets.exposed & (outward * facets.normals[:, 2] > _FLAT))
    seen = seen[np.argsort(outward * facets.triangles[seen, :, 2].mean(axis=1), kind="stable")]
    size = np.array(view.high) - np.array(view.low)
    columns, rows = np.maximum(np.round(size / size.max() * most_pixels).astype(int), 1).tolist()
    figure = Figure(figsize=(columns / 100, rows / 100), dpi=100, facecolor="black")
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.set_xlim(view.low[0], view.high[0])
    axes.set_ylim(view.low[1], view.high[1])
    colours = _to_colours(facets.cell[seen])
    corners = cast("Sequence[Any]", facets.triangles[seen, :, :2])
    triangles = PolyCollection(corners, facecolors=colours, edgecolors=colours, linewidths=0.4, antialiaseds=False)
    axes.add_collection(triangles, autolim=False)
    canvas.draw()
    return CellPixels(view, _from_colours(np.asarray(canvas.buffer_rgba())))


def _to_colours(cells: Indices) -> NDArray[np.float64]:
    """(n, 3) colours, one unlike all others for each cell; black is left for where there is none."""
    number = cells + 1
    return np.column_stack([number >> 16 & 255, number >> 8 & 255, number & 255]) / 255.0


def _from_colours(pixels: NDArray[np.uint8]) -> Indices:
    red, green, blue = (pixels[:, :, k].astype(np.int64) for k in range(3))
    return (red << 16 | green << 8 | blue) - 1
