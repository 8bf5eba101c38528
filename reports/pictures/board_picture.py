"""Pictures of a board: what was understood of it, and a program on it."""

from __future__ import annotations

from dataclasses import dataclass
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from boards.board import Board, Side
from programs.playback import ToolStates, build_timeline, play
from programs.program import TimedProgram, Wait
from reports.pictures import sheet
from reports.tables.wording import clock
from specs.finding import Finding, worst_first

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

_LISTED_FINDINGS = 9
_SCALE_MM = 36.0
"""Room for the scale of heights at the right."""
_LOWEST, _TALLEST = 0.08, 0.88
"""Part of the scale of colours that heights take."""
_DOT_PT2_PER_S = 30.0
_STRIP_MM = 82.0
"""Height of what stands below the panels of a program: the heights along the time, and the foot."""


def draw_board(board: Board, suffix: str) -> bytes:
    """Draw what was understood of a board: its outline, its components by height, its findings.

    Args:
        board: The board.
        suffix: ``.png`` or ``.svg``.

    Raises:
        JobError: another suffix.
    """
    from matplotlib import colormaps

    sides, view = sheet.sides_of(board), sheet.view_of(board)
    tallest = max((component.height_mm for component in board.components), default=1.0)
    lines, places = _list_findings(board.findings)
    foot_mm = 16.0 + 3.6 * len(lines)
    width_mm, height_mm = sheet.SHEET_MM[0] - sheet.LEFT_MM - _SCALE_MM, sheet.SHEET_MM[1] - sheet.TOP_MM - foot_mm
    layout = sheet.arrange(len(sides), view, width_mm, height_mm)
    x0, y0, x1, y1 = board.outline.bounds
    counts = ", ".join(f"{len(sheet.components_of(board, side))} on the {side}" for side in sides)
    size = f"{x1 - x0:.1f} x {y1 - y0:.1f} mm    {board.top_z_mm - board.bottom_z_mm:.2f} mm thick"
    title = (board.name, f"{size}    {len(board.components)} components: {counts}")
    foot = f"board sha256 {board.sha256[:16]}    both sides as seen from the top"
    with sheet.open_sheet(suffix, sheet.TOP_MM + layout.height_mm + foot_mm, title=title, foot=foot) as page:
        panels = page.panels(len(sides), layout.columns, foot_mm + 6, (0.03, 0.12), _SCALE_MM)
        for axes, side in zip(panels, sides, strict=True):
            components = sheet.components_of(board, side)
            levels = [_LOWEST + 0.80 * component.height_mm / tallest for component in components]
            colours = [colormaps["YlGnBu"](level) for level in levels]
            letters = ["white" if level > 0.55 else sheet.INK for level in levels]
            sheet.draw_side(axes, board, side, view, colours, letters)
            axes.set_title(f"{side}, {len(components)} components", loc="left", fontsize=11, fontweight="bold")
            for number, (x, y, _) in enumerate(places, start=1):
                axes.plot(
                    x, y, marker="o", markersize=11, markerfacecolor="none", markeredgecolor=sheet.ACCENT, zorder=8
                )
                axes.text(x, y, f"   {number}", color=sheet.ACCENT, fontsize=7, va="center", zorder=8, clip_on=True)
        bottom, top = (foot_mm + 6) / page.height_mm, 1 - sheet.TOP_MM / page.height_mm
        box = (1 - 0.7 * _SCALE_MM / sheet.SHEET_MM[0], bottom, 0.010, top - bottom)
        _draw_height_scale(page.figure.add_axes(box), tallest)
        page.write_below(foot_mm, "\n".join(lines), fontsize=7, va="top", linespacing=1.35)
        return page.content()


def _draw_height_scale(axes: Axes, tallest: float) -> None:
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, Normalize

    used = ListedColormap(colormaps["YlGnBu"](np.linspace(_LOWEST, _TALLEST, 256)))
    scale = axes.figure.colorbar(ScalarMappable(Normalize(0, tallest), used), cax=axes)
    scale.set_label("height, mm")
    axes.spines[:].set_visible(False)


def _list_findings(findings: Sequence[Finding]) -> tuple[list[str], list[tuple[float, float, float]]]:
    """Lines that list the findings, worst first, those with a place numbered; and these places."""
    lines: list[str] = []
    places: list[tuple[float, float, float]] = []
    for finding in worst_first(findings)[:_LISTED_FINDINGS]:
        number = ""
        if finding.where is not None:
            places.append(finding.where)
            number = f"({len(places)}) "
        lines += wrap(f"{number}{finding.severity}: {finding.message}", 230, subsequent_indent="      ")
    if len(findings) > _LISTED_FINDINGS:
        lines.append(f"and {len(findings) - _LISTED_FINDINGS} more")
    return lines, places


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
    timeline = build_timeline(program)
    times = np.unique(np.concatenate([timeline.times, timeline.switch_times]))
    span = play(timeline, (times[:-1] + times[1:]) / 2)
    motion = _Motion(play(timeline, times), span, span.approach[:, 2] > 0)
    panels: list[tuple[int, Side]] = [
        (function, side)
        for function in dict.fromkeys(motion.span.function.tolist())
        for side in sheet.SIDES
        if (motion.panel_spans(function, side) & motion.span.spraying).any()
    ] or [(0, "top")]
    view = sheet.view_of(board, [motion.key.tcp[:, :2]])
    width_mm = sheet.SHEET_MM[0] - sheet.LEFT_MM - sheet.RIGHT_MM
    layout = sheet.arrange(len(panels), view, width_mm, sheet.SHEET_MM[1] - sheet.TOP_MM - _STRIP_MM)
    origin, totals = program.origin, program.totals
    way = f"{totals.travel_mm / 1000:.2f} m    {totals.moves} moves"
    title = (f"{board.name}  ·  {origin.recipe}", sheet.totals_line(totals, way))
    foot = f"board sha256 {origin.board_sha256[:16]}    recipe sha256 {origin.recipe_sha256[:16]}"
    with sheet.open_sheet(suffix, sheet.TOP_MM + layout.height_mm + _STRIP_MM, title=title, foot=foot) as page:
        placed = page.panels(len(panels), layout.columns, _STRIP_MM + 6, (0.03, 0.20))
        for axes, panel in zip(placed, panels, strict=True):
            sheet.frame_board(axes, view)
            _draw_panel(axes, board, program, motion, panel)
        height_mm = page.height_mm
        left, width = sheet.LEFT_MM / sheet.SHEET_MM[0], width_mm / sheet.SHEET_MM[0]
        strip = (left, 22 / height_mm, width, (_STRIP_MM - 34) / height_mm)
        _draw_heights(page.figure.add_axes(strip), board, motion)
        _write_legend(page.figure, height_mm)
        return page.content()


def _draw_panel(axes: Axes, board: Board, program: TimedProgram, motion: _Motion, panel: tuple[int, Side]) -> None:
    function, side = panel
    here = motion.panel_spans(function, side)
    wet, dry = here & motion.span.spraying, here & ~motion.span.spraying
    plan = motion.key.tcp[:, :2]
    sheet.draw_outlines(axes, board, side)
    components = sheet.components_of(board, side)
    letters = ["white" if grey < 0.7 else sheet.QUIET for grey, _, _ in sheet.greys(components)]
    sheet.write_names(axes, components, letters)
    colour = _colour(function)
    _draw_spans(axes, plan, dry, color=sheet.FAINT, linewidth=0.45, zorder=3)
    _draw_spans(axes, plan, wet, color=colour, linewidth=0.75, alpha=0.75, zorder=4)
    waits = np.array([isinstance(item, Wait) for item in program.instructions])
    dwells = np.flatnonzero(wet & waits[motion.span.instruction])
    places, seconds = motion.span.tcp[dwells, :2], np.diff(motion.key.times)[dwells]
    axes.scatter(places[:, 0], places[:, 1], s=_DOT_PT2_PER_S * seconds, c=colour, alpha=0.55, linewidths=0, zorder=5)
    spans = np.flatnonzero(wet)
    if len(spans):
        begin, end = plan[spans[0]], plan[spans[-1] + 1]
        axes.plot(*begin, marker="o", markersize=5, markerfacecolor="white", markeredgecolor=sheet.ACCENT, zorder=8)
        axes.plot(*end, marker="s", markersize=4.5, color=sheet.ACCENT, zorder=8)
    sheet.draw_scale_bar(axes)
    name = motion.span.functions[function] or "program"
    sprayed_s = float(np.diff(motion.key.times)[wet].sum())
    where = "" if side == "top" else "  ·  bottom, as seen from the top"
    axes.set_title(f"{name}{where}", loc="left", fontsize=11, color=colour, fontweight="bold")
    axes.set_title(f"{clock(sprayed_s)} sprayed", loc="right", fontsize=8, color=sheet.QUIET)


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
    _draw_spans(axes, line, ~motion.span.spraying, color=sheet.FAINT, linewidth=0.6)
    free = -np.inf
    for function in dict.fromkeys(motion.span.function.tolist()):
        chosen = motion.span.function == function
        _draw_spans(axes, line, chosen & motion.span.spraying, color=_colour(function), linewidth=1.0)
        begin = float(times[np.flatnonzero(chosen)[0]])
        if function and begin >= free:
            name = motion.span.functions[function]
            axes.text(begin, 1.02, name, color=_colour(function), fontsize=7, transform=axes.get_xaxis_transform())
            free = begin + 0.04 * float(times[-1] - times[0])  # the next name would run into this one
    tallest = max((part.height_mm for side in sheet.SIDES for part in board.obstacles(side)), default=0.0)
    axes.axhline(tallest, color=sheet.QUIET, linewidth=0.6, linestyle=(0, (4, 3)))
    style: dict[str, Any] = {"fontsize": 6.5, "color": sheet.QUIET, "ha": "right", "va": "bottom"}
    axes.text(float(times[-1]), tallest, f"tallest body {tallest:.1f} mm ", **style)
    axes.set_xlim(times[0], max(times[-1], times[0] + 1e-3))
    axes.set_ylim(0, 1.08 * max(float(height.max()), tallest, 1.0))
    axes.set_xlabel("time, s")
    axes.set_ylabel("orifice above the surface, mm")
    axes.spines[["top", "right"]].set_visible(False)


def _write_legend(figure: Figure, height_mm: float) -> None:
    from matplotlib.lines import Line2D

    def dot(seconds: float) -> Line2D:
        size = (_DOT_PT2_PER_S * seconds) ** 0.5
        return Line2D([], [], linestyle="", marker="o", markersize=size, color=sheet.QUIET, markeredgewidth=0)

    entries = {
        "sprayed": Line2D([], [], color=sheet.QUIET, linewidth=1.6),
        "transfer, jet off": Line2D([], [], color=sheet.FAINT, linewidth=0.8),
        "pause 0.2 s": dot(0.2),
        "1 s": dot(1.0),
        "jet opens": Line2D([], [], linestyle="", marker="o", markerfacecolor="white", markeredgecolor=sheet.ACCENT),
        "jet closes at last": Line2D([], [], linestyle="", marker="s", markersize=4.5, color=sheet.ACCENT),
    }
    figure.legend(
        list(entries.values()), list(entries), ncols=6, loc="center right", borderpad=0,
        bbox_to_anchor=(1 - sheet.RIGHT_MM / sheet.SHEET_MM[0], 1 - 21.5 / height_mm),
        frameon=False, fontsize=8, handletextpad=0.5, columnspacing=1.4,
    )  # fmt: skip


def _colour(function: int) -> str:
    return sheet.FUNCTION_COLOURS[(function - 1) % len(sheet.FUNCTION_COLOURS)] if function else sheet.INK
