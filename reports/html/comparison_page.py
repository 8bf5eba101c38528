"""Two recipes or programs on the same board as one page of HTML."""

from collections.abc import Sequence
from html import escape

from cleaning.verdicts.cleanliness import report_outcome
from cleaning.verdicts.results import CleaningReport
from reports.html.cleaning_page import hash_lines, headline, honesty, legend
from reports.html.cleaning_tables import table
from reports.pictures.cleaning_pictures import VERDICT_COLOURS, draw_verdicts
from reports.pictures.html_page import image, section, whole_page
from reports.tables.comparison import Row


def comparison_page(rows: Sequence[Row], reports: tuple[CleaningReport, CleaningReport], names: tuple[str, str]) -> str:
    """Write the page; the same reports give the same text.

    Args:
        rows: What is compared.
        reports: What each cleans, on the same board.
        names: What each is called.
    """
    here, _ = reports
    one, other = names
    verdicts = "".join(_verdict(name, report) for name, report in zip(names, reports, strict=True))
    head = (
        f'<header><p class="q">{escape(here.origin.board)}</p><h1>{escape(one)} and {escape(other)}</h1>'
        f'{verdicts}<p class="honest">{escape(honesty(here))}</p></header>'
    )
    boards = [
        section(f"{name}: the board", legend(), *map(image, draw_verdicts(report)))
        for name, report in zip(names, reports, strict=True)
    ]
    traces = section("Where it comes from", hash_lines(_origins(reports)))
    return whole_page(f"{here.origin.board}: {one} and {other}", [head, *_tables(rows, one, other), *boards, traces])


def _origins(reports: tuple[CleaningReport, CleaningReport]) -> list[tuple[str, str, str]]:
    here, _ = reports
    return [
        ("board", here.origin.board, here.origin.board_sha256),
        *(("recipe", each.origin.recipe, each.origin.recipe_sha256) for each in reports),
        ("parameter set", here.parameters.parameters, here.parameters_sha256),
    ]


def _verdict(name: str, report: CleaningReport) -> str:
    """The verdict on one of them in a line."""
    colour = VERDICT_COLOURS[report_outcome(report)]
    return (
        f'<p><span class="mark" style="background:{colour}"></span><b>{escape(name)}</b> {escape(headline(report))}</p>'
    )


def _tables(rows: Sequence[Row], one: str, other: str) -> list[str]:
    return [
        section(
            group,
            table(
                ("", f">{one}", f">{other}", ">Change"),
                [
                    (escape(row.name), _value(row, row.here), _value(row, row.there), escape(row.change))
                    for row in rows
                    if row.group == group
                ],
                "both",
            ),
        )
        for group in dict.fromkeys(row.group for row in rows)
    ]


def _value(row: Row, text: str) -> str:
    """What does not differ steps back."""
    return escape(text) if row.differs else f'<span class="q">{escape(text)}</span>'
