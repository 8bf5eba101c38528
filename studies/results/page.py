"""A study as one page of HTML that needs nothing else: fronts by board, how often parts are clean, main effects."""

from collections.abc import Sequence
from html import escape

from reports.html.page import image, section, table_html, whole_page
from reports.pictures.sheet import INK, Picture
from reports.tables.table import Table
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
    head = (
        f'<header><p class="q">{escape(", ".join(counts))}</p><h1 style="border-color:{INK}">{escape(study.study)}: '
        f"{amount(len(summary.cases), 'combination')}</h1><p>{escape(study.description)}</p>"
        f'<p class="q">{escape(CAVEAT)}</p></header>'
    )
    alt = "Liquid over time of all combinations, with the Pareto front of each board"
    more = len(summary.fronts) - MOST_BOARDS
    beyond = f'<p class="q">and {amount(more, "more board")}</p>' if more > 0 else ""
    picture = image(Picture(".svg", draw_study(study.study, summary, ".svg"), alt)) + beyond
    boards = [_board(planned, board, front) for board, front in summary.fronts.items()]
    effects = table_html(effects_rows(summary.effects))
    failed = [each.planned for each in summary.cases if each.planned.result.error]
    errors = [(str(each.case.number), each.case.recipe.name, each.result.error) for each in failed[:_MOST_ERRORS]]
    table = table_html(Table.of(_ERRORS, errors)) + _more(len(failed) - len(errors), "combination")
    return whole_page(
        f"{study.study}: study",
        [
            head,
            section("Time, liquid and clean components", picture),
            *boards,
            section("Main effects", _note(_EFFECTS_NOTE) + effects if effects else ""),
            section("Combinations that ended in an error", table),
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
        _note(_FRONT_NOTE) + table if table else "<p>No combination could be computed.</p>",
        _more(len(front) - len(shown), "combination"),
        _note(_SHARES_NOTE) + often if often else _note(_ALL_NOTE if any(each.shares for each in shown) else ""),
        _more(len(shares) - len(rows), "component and combination", "components and combinations"),
    )


def _note(text: str) -> str:
    return f'<p class="q">{escape(text)}</p>' if text else ""


def _more(count: int, noun: str, plural: str = "") -> str:
    return _note(f"and {amount(count, noun, plural)} more") if count > 0 else ""
