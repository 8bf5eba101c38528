"""The sheet that pictures are drawn on: paper, colours, a board from above, a scale bar.

matplotlib is imported when something is drawn; there is no pyplot and no state that outlives a call.
"""

from __future__ import annotations

import warnings
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from io import BytesIO
from itertools import compress
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon, get_parts

from boards.board import Board, Component, Side
from programs.program import Totals
from reports.tables.wording import clock
from specs.errors import JobError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.colorbar import Colorbar
    from matplotlib.figure import Figure
    from matplotlib.path import Path as Curve

INK = "#22303a"
QUIET = "#7b8790"
FAINT = "#b9c1c7"
BOARD = "#eef1ec"
ACCENT = "#c8442c"
FUNCTION_COLOURS = ("#2b6ca3", "#2f8f7e", "#c08a2e", "#7d5a9b", "#5f7d2f", "#9b5a6e")

SIDES: tuple[Side, Side] = ("top", "bottom")

SHEET_MM = (420.0, 297.0)
"""The widest and highest a sheet becomes: A3."""
LEFT_MM, RIGHT_MM, TOP_MM = 17.0, 10.0, 33.0
"""Margins; the title stands in the upper one."""
_SETTINGS: dict[str, Any] = {
    "svg.hashsalt": "washboard",
    "text.parse_math": False,  # a dollar in a name is a dollar
    "text.color": INK,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": QUIET,
    "axes.linewidth": 0.6,
    "axes.labelsize": 8,
    "font.size": 8,
    **{f"{axis}tick.{key}": value for axis in "xy" for key, value in (("color", QUIET), ("labelsize", 7))},
}
_PANEL_TITLE_MM = 14.0
_LEAST_LETTER_PT = 2.8
_LARGEST_LETTER_PT = 7.0


@dataclass(frozen=True, slots=True)
class Picture:
    """A drawn picture of a page."""

    suffix: str
    """``.png`` or ``.svg``."""
    content: bytes
    alt: str
    """Text for those who cannot see it."""


@dataclass(frozen=True, slots=True)
class View:
    """The part of the plane that a panel shows, mm."""

    low: tuple[float, float]
    high: tuple[float, float]

    @property
    def aspect(self) -> float:
        """Height by width."""
        return (self.high[1] - self.low[1]) / (self.high[0] - self.low[0])

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Left, right, front and back, as images have it."""
        return self.low[0], self.high[0], self.low[1], self.high[1]


def sides_of(board: Board) -> list[Side]:
    """Sides of a board that have components; the top where none has."""
    return [side for side in SIDES if components_of(board, side)] or ["top"]


def view_of(board: Board, points: Sequence[NDArray[np.float64]] = ()) -> View:
    """Look at the whole board, all that stands on it and (n, 2) other points, with a little room around them."""
    outlines = [board.outline, *(body.outline for side in SIDES for body in board.obstacles(side))]
    corners = np.vstack([np.array([outline.bounds for outline in outlines]).reshape(-1, 2), *points])
    low, high = corners.min(axis=0), corners.max(axis=0)
    room = 0.02 * float(np.max(high - low))
    return View((float(low[0]) - room, float(low[1]) - room), (float(high[0]) + room, float(high[1]) + room))


@dataclass(frozen=True, slots=True)
class Layout:
    """Panels in rows and columns, as large as the sheet allows."""

    rows: int
    columns: int
    height_mm: float
    """Of all rows together."""


def arrange(count: int, view: View, width_mm: float, height_mm: float) -> Layout:
    """Find the columns in which so many panels of one view become largest, and no more height than they need."""

    def scale(columns: int) -> float:
        rows = -(-count // columns)
        return min(width_mm / columns, (height_mm / rows - _PANEL_TITLE_MM) / view.aspect)

    columns = max(range(1, count + 1), key=lambda each: (round(scale(each), 6), each))
    rows = -(-count // columns)
    return Layout(rows, columns, rows * (scale(columns) * view.aspect + _PANEL_TITLE_MM))


@dataclass(frozen=True, slots=True, eq=False)
class Sheet:
    """A sheet that is being drawn on, inside the block of ``open_sheet``."""

    figure: Figure
    suffix: str
    """``.png`` or ``.svg``, as which it will be written."""

    @property
    def height_mm(self) -> float:
        """Height of the sheet."""
        return self.figure.get_figheight() * 25.4

    def grid(
        self,
        count: int,
        columns: int,
        box: tuple[float, float, float, float],
        spaces: tuple[float, float],
        widths: Sequence[float] | None = None,
    ) -> list[Axes]:
        """Lay out panels row by row.

        Args:
            count: How many panels.
            columns: How many stand side by side.
            box: Left, bottom, right and top of all of them, as shares of the sheet.
            spaces: Between columns and between rows, as shares of a panel.
            widths: Of the columns, relative to each other; left out, they are alike.
        """
        room = dict(zip(("left", "bottom", "right", "top", "wspace", "hspace"), (*box, *spaces), strict=True))
        grid = self.figure.add_gridspec(-(-count // columns), columns, width_ratios=widths, **room)
        return [self.figure.add_subplot(grid[index // columns, index % columns]) for index in range(count)]

    def panels(
        self, count: int, columns: int, bottom_mm: float, spaces: tuple[float, float], right_mm: float = RIGHT_MM
    ) -> list[Axes]:
        """Lay out panels row by row below the title, with room below them and at their right; see ``grid``."""
        bottom, top = bottom_mm / self.height_mm, 1 - TOP_MM / self.height_mm
        return self.grid(count, columns, (LEFT_MM / SHEET_MM[0], bottom, 1 - right_mm / SHEET_MM[0], top), spaces)

    def write_below(self, height_mm: float, text: str, **style: Any) -> None:
        """Write at the left margin, so far above the lower edge."""
        self.figure.text(LEFT_MM / SHEET_MM[0], height_mm / self.height_mm, text, **style)

    def content(self) -> bytes:
        """Give the file's content; the same drawing gives the same bytes."""
        kind = self.suffix.lower().lstrip(".")
        out = BytesIO()
        metadata = {"Date": None} if kind == "svg" else {"Software": None}
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Glyph .* missing")  # a name in another script becomes boxes
            self.figure.savefig(out, format=kind, metadata=cast("dict[str, Any]", metadata))
        return out.getvalue()

    def picture(self, alt: str) -> Picture:
        """Give the sheet as a picture of a page."""
        return Picture(self.suffix, self.content(), alt)


@contextmanager
def open_sheet(
    suffix: str, height_mm: float, width_mm: float = SHEET_MM[0], *, title: tuple[str, str] = ("", ""), foot: str = ""
) -> Generator[Sheet]:
    """Give a sheet, as wide as A3 by default, drawn with matplotlib's own settings whatever the user's are.

    Args:
        suffix: ``.png`` or ``.svg``.
        height_mm: Of the sheet.
        width_mm: Likewise.
        title: What the sheet shows, and a quiet line below it.
        foot: What proves where the sheet comes from.

    Raises:
        JobError: another suffix.
    """
    check_suffix(suffix)
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    settings = {key: value for key, value in matplotlib.rcParamsDefault.items() if not key.startswith("backend")}
    with matplotlib.rc_context(cast("dict[Any, Any]", settings | _SETTINGS)):
        figure = Figure(figsize=(width_mm / 25.4, height_mm / 25.4), dpi=150, facecolor="white")
        FigureCanvasAgg(figure)
        drawn = Sheet(figure, suffix)
        if title[0]:
            drawn.write_below(drawn.height_mm - 13, title[0], fontsize=18, fontweight="bold", va="center")
            drawn.write_below(drawn.height_mm - 21.5, title[1], fontsize=9, color=QUIET, va="center")
        if foot:
            drawn.write_below(6, foot, fontsize=6.5, color=QUIET, va="center")
        yield drawn
    figure.clear()  # its parts refer to each other: else they wait for a collection of garbage


def check_suffix(suffix: str) -> None:
    """Refuse what a sheet cannot be written as, before anything is drawn.

    Raises:
        JobError: the suffix is neither ``.png`` nor ``.svg``.
    """
    if suffix.lower() not in (".png", ".svg"):
        raise JobError(
            f"a picture is written as .png or .svg, not as {suffix or 'a file without suffix'!r}; rename it."
        )


def totals_line(totals: Totals, way: str = "") -> str:
    """Times, way and litres of a program in a line."""
    litres = [f"{name} {amount:.2f} l" for name, amount in totals.liquid_l]
    times = [f"{clock(totals.duration_s)} in all", f"{clock(totals.spray_s)} sprayed"]
    return "    ".join([*times, *([way] if way else []), "    ".join(litres)])


def frame_board(axes: Axes, view: View) -> None:
    """Show a part of the plane at one scale for both axes; no ticks."""
    axes.set_xlim(view.low[0], view.high[0])
    axes.set_ylim(view.low[1], view.high[1])
    axes.set_aspect("equal", anchor="NW")
    axes.set_axis_off()


def draw_outlines(axes: Axes, board: Board, side: Side, colours: Sequence[Any] | None = None) -> None:
    """Draw the board's edge with its holes, and the components of a side that lie in the view, tall ones darker.

    Args:
        axes: Where ``frame_board`` was called.
        board: The board.
        side: The side whose components are filled; coordinates stay as seen from the top.
        colours: One for each component of that side, in the order of the board, in place of the greys.
    """
    from matplotlib.collections import PathCollection
    from matplotlib.patches import PathPatch

    # As an artist: a patch would look for the limits of the view, which are set, and that takes long.
    axes.add_artist(PathPatch(curve_of(board.outline), facecolor=BOARD, edgecolor=INK, linewidth=0.9, zorder=1))
    fixtures = {body.name for body in board.bodies if body.role == "fixture"}
    for obstacle in board.obstacles(side):
        if obstacle.name in fixtures:
            patch = PathPatch(
                curve_of(obstacle.outline), facecolor="none", edgecolor=QUIET, hatch="////", linewidth=0.5
            )
            axes.add_artist(patch)
    components = components_of(board, side)
    faces = greys(components) if colours is None else colours
    shown = [_is_in_view(axes, component) for component in components]
    curves, fills = list(compress(_curves_of(board, side), shown)), list(compress(faces, shown))
    axes.add_collection(
        PathCollection(curves, facecolors=fills, edgecolors="#8d979e", linewidths=0.35, zorder=2), autolim=False
    )


@lru_cache(maxsize=2)
def _curves_of(board: Board, side: Side) -> list[Curve]:
    """Give the outlines of the components of a side: a report draws them a dozen times."""
    return [curve_of(component.outline) for component in components_of(board, side)]


def _is_in_view(axes: Axes, component: Component) -> bool:
    """Whether any of a component may be seen: of a large board a close view has few."""
    (left, right), (low, high) = sorted(axes.get_xlim()), sorted(axes.get_ylim())
    x0, y0, x1, y1 = component.outline.bounds
    return x1 >= left and x0 <= right and y1 >= low and y0 <= high


def components_of(board: Board, side: Side) -> list[Component]:
    """Return the components of a side in the order of the board."""
    return [component for component in board.components if component.side == side]


def greys(components: Sequence[Component]) -> list[tuple[float, float, float]]:
    """Give a grey for each component: light at the board, darker the taller it is."""
    tallest = max((component.height_mm for component in components), default=1.0)
    return [(level, level, level) for level in (0.90 - 0.32 * part.height_mm / tallest for part in components)]


def write_names(axes: Axes, components: Sequence[Component], colours: Sequence[str]) -> None:
    """Write each name into its component where that is in view and it fits; along the longer side."""
    axes.apply_aspect()
    x0, x1 = axes.get_xlim()
    points_per_mm = 72.0 * axes.get_window_extent().width / axes.figure.dpi / (x1 - x0)
    for component, colour in zip(components, colours, strict=True):
        if not _is_in_view(axes, component):
            continue
        x0, y0, x1, y1 = component.outline.bounds
        upright = y1 - y0 > 1.3 * (x1 - x0)
        along, across = ((y1 - y0), (x1 - x0)) if upright else ((x1 - x0), (y1 - y0))
        letter_mm = min(along * 0.9 / (0.62 * len(component.name)), across * 0.7)
        size = min(letter_mm * points_per_mm, _LARGEST_LETTER_PT)
        if size >= _LEAST_LETTER_PT:
            turn = 90 if upright else 0
            place = ((x0 + x1) / 2, (y0 + y1) / 2)
            name = axes.text(*place, component.name, fontsize=size, rotation=turn, color=colour, clip_on=True, zorder=6)
            name.set(horizontalalignment="center", verticalalignment="center")


def draw_side(
    axes: Axes, board: Board, side: Side, view: View, colours: Sequence[Any] | None, letters: Sequence[str]
) -> None:
    """Draw a side of a board in its view: outlines, names in the colours of the letters, and a scale bar."""
    frame_board(axes, view)
    draw_outlines(axes, board, side, colours)
    write_names(axes, components_of(board, side), letters)
    draw_scale_bar(axes)


def draw_image(
    axes: Axes, values: NDArray[np.float64], extent: tuple[float, ...], scale: Any, bar: Mapping[str, Any], **style: Any
) -> Colorbar:
    """Draw values as an image, nothing where there is none, with a scale of its colours.

    Args:
        axes: Where.
        values: (rows, columns); NaN for none.
        extent: Left, right, front and back.
        scale: Scale of colours, or its name.
        bar: Where the scale is drawn.
        style: Limits of the scale, origin, order.
    """
    left, right, front, back = extent
    shown = np.ma.masked_invalid(values)
    drawn = axes.imshow(shown, extent=(left, right, front, back), cmap=scale, interpolation="nearest", **style)
    return add_scale(axes, drawn, **bar)


def add_scale(axes: Axes, drawn: ScalarMappable, **place: Any) -> Colorbar:
    """Draw the scale of colours of what is drawn beside it, without a frame."""
    bar = axes.figure.colorbar(drawn, ax=axes, **place)
    bar.outline.set_visible(False)
    return bar


def draw_scale_bar(axes: Axes) -> None:
    """Draw a bar of a round length under the board."""
    x0, x1 = axes.get_xlim()
    y0, y1 = axes.get_ylim()
    length = max(step for step in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000) if step <= max(1.0, 0.25 * (x1 - x0)))
    below = y0 - 0.025 * (y1 - y0)
    axes.plot([x0, x0 + length], [below, below], color=INK, linewidth=1.6, solid_capstyle="butt", clip_on=False)
    axes.text(x0 + length, below, f"  {length} mm", fontsize=7, color=QUIET, va="center", clip_on=False)
    axes.set_xlim(x0, x1)
    axes.set_ylim(y0, y1)


def curve_of(shape: Polygon | MultiPolygon) -> Curve:
    """Give the edges of a shape and of its holes as one path."""
    from matplotlib.path import Path as Curve

    rings = [ring for polygon in get_parts(shape) for ring in (polygon.exterior, *polygon.interiors)]
    return Curve.make_compound_path(*(Curve(np.asarray(ring.coords)[:, :2], closed=True) for ring in rings))
