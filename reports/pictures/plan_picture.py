"""A picture of a program on its board, for the wall and for the report."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from boards.board import Board, Side
from programs.playback import ToolStates, build_timeline, play
from programs.program import TimedProgram, Wait
from reports.pictures.sheet import (
    ACCENT,
    FAINT,
    FUNCTION_COLOURS,
    INK,
    LEFT_MM,
    QUIET,
    RIGHT_MM,
    SHEET_MM,
    SIDES,
    TOP_MM,
    add_panels,
    arrange,
    check_suffix,
    components_of,
    draw_outlines,
    draw_scale_bar,
    frame_board,
    greys,
    sheet,
    to_bytes,
    view_of,
    write_foot,
    write_names,
    write_title,
)
from reports.tables.wording import clock

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_DOT_PT2_PER_S = 30.0
_STRIP_MM = 82.0
"""Height of what stands below the panels: the heights along the time, and the foot."""


@dataclass(frozen=True, slots=True, eq=False)
class _Motion:
    """A program as n + 1 key states and the n spans between them; within a span nothing switches."""

    key: ToolStates
    span: ToolStates
    """In the middle of each span."""
    upward: NDArray[np.bool_]
    """(n,) the jet points up: the bottom is sprayed."""

    def panel_spans(self, function: int, side: Side) -> NDArray[np.bool_]:
        """(n,) spans of one function on one side."""
        return (self.span.function == function) & (self.upward == (side == "bottom"))


def draw_plan(board: Board, program: TimedProgram, suffix: str) -> bytes:
    """Draw a program on its board: a panel for each function and side, and the height along the time.

    Args:
        board: The board.
        program: What is done to it.
        suffix: ``.png`` or ``.svg``.

    Raises:
        JobError: another suffix.
        ProgramError: the program has no move.
    """
    check_suffix(suffix)
    timeline = build_timeline(program)
    times = np.unique(np.concatenate([timeline.times, timeline.switch_times]))
    span = play(timeline, (times[:-1] + times[1:]) / 2)
    motion = _Motion(play(timeline, times), span, span.approach[:, 2] > 0)
    panels: list[tuple[int, Side]] = [
        (function, side)
        for function in dict.fromkeys(motion.span.function.tolist())
        for side in SIDES
        if (motion.panel_spans(function, side) & motion.span.spraying).any()
    ] or [(0, "top")]
    view = view_of(board, [motion.key.tcp[:, :2]])
    width_mm = SHEET_MM[0] - LEFT_MM - RIGHT_MM
    layout = arrange(len(panels), view, width_mm, SHEET_MM[1] - TOP_MM - _STRIP_MM)
    height_mm = TOP_MM + layout.height_mm + _STRIP_MM
    with sheet(height_mm) as figure:
        totals = program.totals
        litres = "    ".join(f"{name} {amount:.2f} l" for name, amount in totals.liquid_l)
        write_title(
            figure,
            f"{board.name}  ·  {program.origin.recipe}",
            f"{clock(totals.duration_s)} in all    {clock(totals.spray_s)} sprayed    "
            f"{totals.travel_mm / 1000:.2f} m    {totals.moves} moves    {litres}",
        )
        placed = add_panels(figure, len(panels), layout.columns, bottom_mm=_STRIP_MM + 6, spaces=(0.03, 0.20))
        for axes, panel in zip(placed, panels, strict=True):
            frame_board(axes, view)
            _draw_panel(axes, board, program, motion, panel)
        strip = (LEFT_MM / SHEET_MM[0], 22 / height_mm, width_mm / SHEET_MM[0], (_STRIP_MM - 34) / height_mm)
        _draw_heights(figure.add_axes(strip), board, motion)
        _write_legend(figure, height_mm)
        origin = program.origin
        write_foot(figure, f"board sha256 {origin.board_sha256[:16]}    recipe sha256 {origin.recipe_sha256[:16]}")
        return to_bytes(figure, suffix)


def _draw_panel(axes: Axes, board: Board, program: TimedProgram, motion: _Motion, panel: tuple[int, Side]) -> None:
    function, side = panel
    here = motion.panel_spans(function, side)
    wet, dry = here & motion.span.spraying, here & ~motion.span.spraying
    plan = motion.key.tcp[:, :2]
    draw_outlines(axes, board, side)
    components = components_of(board, side)
    write_names(axes, components, ["white" if grey < 0.7 else QUIET for grey, _, _ in greys(components)])
    colour = _colour(function)
    _draw_spans(axes, plan, dry, color=FAINT, linewidth=0.45, zorder=3)
    _draw_spans(axes, plan, wet, color=colour, linewidth=0.75, alpha=0.75, zorder=4)
    waits = np.array([isinstance(item, Wait) for item in program.instructions])
    dwells = np.flatnonzero(wet & waits[motion.span.instruction])
    places, seconds = motion.span.tcp[dwells, :2], np.diff(motion.key.times)[dwells]
    axes.scatter(places[:, 0], places[:, 1], s=_DOT_PT2_PER_S * seconds, c=colour, alpha=0.55, linewidths=0, zorder=5)
    spans = np.flatnonzero(wet)
    if len(spans):
        begin, end = plan[spans[0]], plan[spans[-1] + 1]
        axes.plot(*begin, marker="o", markersize=5, markerfacecolor="white", markeredgecolor=ACCENT, zorder=8)
        axes.plot(*end, marker="s", markersize=4.5, color=ACCENT, zorder=8)
    draw_scale_bar(axes)
    name = motion.span.functions[function] or "program"
    sprayed_s = float(np.diff(motion.key.times)[wet].sum())
    where = "" if side == "top" else "  ·  bottom, as seen from the top"
    axes.set_title(f"{name}{where}", loc="left", fontsize=11, color=colour, fontweight="bold")
    axes.set_title(f"{clock(sprayed_s)} sprayed", loc="right", fontsize=8, color=QUIET)


def _draw_spans(axes: Axes, line: NDArray[np.float64], chosen: NDArray[np.bool_], **style: Any) -> None:
    """Draw the chosen spans of an (n + 1, 2) line as one broken curve."""
    edges = np.diff(np.concatenate([[False], chosen, [False]]).astype(np.int8))
    pieces: list[NDArray[np.float64]] = [np.empty((0, 2))]
    for begin, end in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True):
        pieces += [line[begin : end + 1], np.full((1, 2), np.nan)]
    x, y = np.vstack(pieces)[:-1].T
    axes.plot(x, y, solid_joinstyle="round", solid_capstyle="round", **style)


def _draw_heights(axes: Axes, board: Board, motion: _Motion) -> None:
    """Height of the orifice above the side that is sprayed, along the time."""
    times = motion.key.times
    upward = motion.key.approach[:, 2] > 0
    height = np.where(upward, board.bottom_z_mm - motion.key.tcp[:, 2], motion.key.tcp[:, 2] - board.top_z_mm)
    line = np.column_stack([times, height])
    _draw_spans(axes, line, ~motion.span.spraying, color=FAINT, linewidth=0.6)
    free = -np.inf
    for function in dict.fromkeys(motion.span.function.tolist()):
        chosen = motion.span.function == function
        _draw_spans(axes, line, chosen & motion.span.spraying, color=_colour(function), linewidth=1.0)
        begin = float(times[np.flatnonzero(chosen)[0]])
        if function and begin >= free:
            name = motion.span.functions[function]
            axes.text(begin, 1.02, name, color=_colour(function), fontsize=7, transform=axes.get_xaxis_transform())
            free = begin + 0.04 * float(times[-1] - times[0])  # the next name would run into this one
    tallest = max((part.height_mm for side in SIDES for part in board.obstacles(side)), default=0.0)
    axes.axhline(tallest, color=QUIET, linewidth=0.6, linestyle=(0, (4, 3)))
    axes.text(
        float(times[-1]), tallest, f"tallest body {tallest:.1f} mm ", fontsize=6.5, color=QUIET, ha="right", va="bottom"
    )
    axes.set_xlim(times[0], max(times[-1], times[0] + 1e-3))
    axes.set_ylim(0, 1.08 * max(float(height.max()), tallest, 1.0))
    axes.set_xlabel("time, s")
    axes.set_ylabel("orifice above the surface, mm")
    axes.spines[["top", "right"]].set_visible(False)


def _write_legend(figure: Figure, height_mm: float) -> None:
    from matplotlib.lines import Line2D

    def dot(seconds: float) -> Line2D:
        size = (_DOT_PT2_PER_S * seconds) ** 0.5
        return Line2D([], [], linestyle="", marker="o", markersize=size, color=QUIET, markeredgewidth=0)

    entries = {
        "sprayed": Line2D([], [], color=QUIET, linewidth=1.6),
        "transfer, jet off": Line2D([], [], color=FAINT, linewidth=0.8),
        "pause 0.2 s": dot(0.2),
        "1 s": dot(1.0),
        "jet opens": Line2D([], [], linestyle="", marker="o", markerfacecolor="white", markeredgecolor=ACCENT),
        "jet closes at last": Line2D([], [], linestyle="", marker="s", markersize=4.5, color=ACCENT),
    }
    figure.legend(
        list(entries.values()), list(entries), ncols=6, loc="center right", borderpad=0,
        bbox_to_anchor=(1 - RIGHT_MM / SHEET_MM[0], 1 - 21.5 / height_mm),
        frameon=False, fontsize=8, handletextpad=0.5, columnspacing=1.4,
    )  # fmt: skip


def _colour(function: int) -> str:
    return FUNCTION_COLOURS[(function - 1) % len(FUNCTION_COLOURS)] if function else INK
