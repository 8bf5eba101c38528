"""Picture of a study: for each board its combinations by time, liquid and clean components, with the Pareto front."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.pictures.sheet import FAINT, FUNCTION_COLOURS, INK, add_panels, sheet, to_bytes, write_foot, write_title
from reports.tables.wording import amount

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from studies.results.summary import CaseSummary, Summary

_WIDTH_MM, _PANEL_MM, _BOTTOM_MM, _HEAD_MM = 260.0, 82.0, 22.0, 30.0
_COLUMNS = 3
MOST_BOARDS = 12
"""Boards that are drawn; the table has all of them."""
_MINUTE_S = 60.0
_LEAST_POINTS, _MOST_POINTS = 3.0, 8.0
_ROOM = 0.08


def draw_study(name: str, summary: Summary, suffix: str) -> bytes:
    """Draw litres over minutes for each board; a dot is larger the more components are clean.

    The same results give the same bytes.
    """
    boards = list(summary.fronts)[:MOST_BOARDS]
    columns = min(_COLUMNS, len(boards))
    rows = -(-len(boards) // columns)
    with sheet(_HEAD_MM + rows * _PANEL_MM + _BOTTOM_MM, _WIDTH_MM) as figure:
        panels = add_panels(figure, len(boards), columns, bottom_mm=_BOTTOM_MM, spaces=(0.2, 0.3))
        for panel, board in zip(panels, boards, strict=True):
            cases = [
                each
                for each in summary.cases
                if each.planned.case.board.name == board and not each.planned.result.error
            ]
            _draw(panel, cases, summary.fronts[board])
            most = max((each.planned.clean for each in cases), default=0)
            total = max((each.planned.components for each in cases), default=0)
            panel.set_title(f"{board}: liquid, l; at most {most} of {total} clean", fontsize=9, loc="left")
        front = sum(map(len, summary.fronts.values()))
        write_title(
            figure,
            f"{name}: {amount(len(summary.cases), 'combination')}, {front} on Pareto fronts",
            "predicted by the cleaning model, as planned",
        )
        more = len(summary.fronts) - len(boards)
        write_foot(
            figure,
            "coloured: Pareto front, no other combination for the board is as good in time, liquid and clean components"
            "\nnumbers: combination, and its clean components as planned; larger dots: more of them"
            + (f"; {more} more boards in the table" if more else ""),
        )
        return to_bytes(figure, suffix)


def _draw(axes: Axes, cases: Sequence[CaseSummary], front: Sequence[CaseSummary]) -> None:
    on_front = {each.planned.case.number for each in front}
    for each in cases:
        place = each.planned.result.seconds / _MINUTE_S, each.planned.result.litres
        share = each.planned.clean / max(1, each.planned.components)
        size = _LEAST_POINTS + (_MOST_POINTS - _LEAST_POINTS) * share
        best = each.planned.case.number in on_front
        axes.plot(*place, "o", color=FUNCTION_COLOURS[0] if best else FAINT, markersize=size, zorder=2 if best else 1)
        if best:
            text = f"{each.planned.case.number}: {each.planned.clean}"
            axes.annotate(text, place, (4, 4), textcoords="offset points", fontsize=7, color=INK, zorder=3)
    axes.set_xlabel("program, min")
    axes.grid(visible=True, color=FAINT, linewidth=0.3, alpha=0.6)
    axes.tick_params(length=2)
    axes.margins(_ROOM)
