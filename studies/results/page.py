"""A study as one page of HTML that needs nothing else: fronts by board, how often parts are clean, main effects."""

from collections.abc import Sequence

from reports.html.page import header, image, quiet, section, table_html, whole_page
from reports.pictures.sheet import INK, Picture
from reports.tables.table import Table, Text
from reports.tables.wording import amount
from studies.planned_study import PlannedStudy
from studies.results.card import CAVEAT, effects_rows, front_table
from studies.results.picture import MOST_BOARDS, draw_study
from studies.results.summary import CaseSummary, Summary

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
