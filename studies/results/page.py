"""A study as one page of HTML that needs nothing else: fronts by board, how often parts are clean, main effects."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from reports.html.page import header, image, quiet, section, table_html, whole_page
from reports.pictures.sheet import FAINT, FUNCTION_COLOURS, INK, Picture, open_sheet
from reports.tables.table import Table, Text
from reports.tables.wording import amount
from studies.planned_study import PlannedStudy
from studies.results.card import CAVEAT, effects_rows, front_table
from studies.results.summary import CaseSummary, Summary

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
    front, more = sum(map(len, summary.fronts.values())), len(summary.fronts) - len(boards)
    combinations = amount(len(summary.cases), "combination")
    title = (f"{name}: {combinations}, {front} on Pareto fronts", "predicted by the cleaning model, as planned")
    foot = (
        "coloured: Pareto front, no other combination for the board is as good in time, liquid and clean components"
        "\nnumbers: combination, and its clean components as planned; larger dots: more of them"
        + (f"; {more} more boards in the table" if more else "")
    )
    height_mm = _HEAD_MM + rows * _PANEL_MM + _BOTTOM_MM
    with open_sheet(suffix, height_mm, _WIDTH_MM, title=title, foot=foot) as sheet:
        panels = sheet.panels(len(boards), columns, _BOTTOM_MM, (0.2, 0.3))
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
        return sheet.content()


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


_MOST_FRONT, _MOST_SHARES, _MOST_ERRORS = 30, 40, 20
_SHARES = ("component", "case", "as planned", ">clean", ">probability", ">95 % interval")
_ERRORS = ("case", "recipe", "error")
_FRONT_NOTE = (
    "No other combination for the board is as good in time, liquid and clean components, and with tolerances in how "
    "many come out clean on average. All runs are in runs.csv."
)
_SHARES_NOTE = (
    "Of the combinations above, the components that do not come out clean on every board with the stated deviations, "
    "the least often clean first. It covers these deviations and nothing else."
)
_ALL_NOTE = "All components come out clean on every board with the stated deviations."
_EFFECTS_NOTE = "How the mean of all runs at a level differs from the mean of all."


def study_page(planned: PlannedStudy, summary: Summary) -> str:
    """Write the page; the same results give the same text."""
    study = planned.study
    counts = [amount(len(summary.fronts), "board"), amount(len(planned.recipes), "recipe")]
    counts += [amount(len(planned.parameters), "parameter set"), amount(len(planned.points), "point")]
    title = f"{study.study}: {amount(len(summary.cases), 'combination')}"
    head = header(", ".join(counts), title, INK, [study.description, Text(CAVEAT, "quiet")])
    alt = "Liquid over time of all combinations, with the Pareto front of each board"
    more = len(summary.fronts) - MOST_BOARDS
    beyond = quiet(f"and {amount(more, 'more board')}" if more > 0 else "")
    picture = image(Picture(".svg", draw_study(study.study, summary, ".svg"), alt)) + beyond
    boards = [_board(planned, board, front) for board, front in summary.fronts.items()]
    effects = table_html(effects_rows(summary.effects))
    failed = [each.planned for each in summary.cases if each.planned.result.error]
    rows = [(str(each.case.number), each.case.recipe.name, each.result.error) for each in failed[:_MOST_ERRORS]]
    errors = table_html(Table.of(_ERRORS, rows)) + _more(len(failed) - len(rows), "combination")
    return whole_page(
        f"{study.study}: study",
        [
            head,
            section("Time, liquid and clean components", picture),
            *boards,
            section("Main effects", quiet(_EFFECTS_NOTE) + effects if effects else ""),
            section("Combinations that ended in an error", errors),
        ],
    )


def _board(planned: PlannedStudy, board: str, front: Sequence[CaseSummary]) -> str:
    shown = front[:_MOST_FRONT]
    shares = sorted(
        ((share, each.planned.case.number) for each in shown for share in each.shares if share.clean < share.samples),
        key=lambda item: (item[0].share, item[0].component, item[1]),
    )
    rows = [
        (
            share.component,
            str(number),
            share.as_planned,
            f"{share.clean} of {share.samples}",
            f"{share.share:.0%}",
            "{:.0%} to {:.0%}".format(*share.interval),
        )
        for share, number in shares[:_MOST_SHARES]
    ]
    table = table_html(front_table(planned, shown))
    often = table_html(Table.of(_SHARES, rows))
    return section(
        board,
        quiet(_FRONT_NOTE) + table if table else "<p>No combination could be computed.</p>",
        _more(len(front) - len(shown), "combination"),
        quiet(_SHARES_NOTE) + often if often else quiet(_ALL_NOTE if any(each.shares for each in shown) else ""),
        _more(len(shares) - len(rows), "component and combination", "components and combinations"),
    )


def _more(count: int, noun: str, plural: str = "") -> str:
    return quiet(f"and {amount(count, noun, plural)} more") if count > 0 else ""
