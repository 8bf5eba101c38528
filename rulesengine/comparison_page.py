"""Two recipes on the same board as one page of HTML."""

from collections.abc import Sequence
from html import escape

from cleaning.results import CleaningReport
from rulesengine.cleaning_page import headline, honesty
from rulesengine.cleaning_pictures import VERDICT_COLOURS, draw_verdicts
from rulesengine.cleaning_tables import table
from rulesengine.comparison import Row
from rulesengine.page import image, section, whole_page


def comparison_page(rows: Sequence[Row], here: CleaningReport, there: CleaningReport) -> str:
    """Write the page; the same runs give the same text.

    Args:
        rows: What is compared.
        here: What the first recipe cleans.
        there: What the second does, on the same board.
    """
    one, other = here.origin.recipe, there.origin.recipe
    head = (
        f'<header><p class="q">{escape(here.origin.board)}</p><h1>{escape(one)} and {escape(other)}</h1>'
        f"{_verdict(here)}{_verdict(there)}"
        f'<p class="honest">{escape(honesty(here))}</p></header>'
    )
    boards = [
        section(f"{report.origin.recipe}: the board", *map(image, draw_verdicts(report))) for report in (here, there)
    ]
    return whole_page(f"{here.origin.board}: {one} and {other}", [head, *_tables(rows, one, other), *boards])


def _verdict(report: CleaningReport) -> str:
    """One recipe's verdict in a line."""
    colour = VERDICT_COLOURS[report.verdict]
    return (
        f'<p><span class="mark" style="background:{colour}"></span><b>{escape(report.origin.recipe)}</b> '
        f"{escape(headline(report))}</p>"
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
