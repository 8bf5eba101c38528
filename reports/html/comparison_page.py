"""Two recipes or programs on the same board as one page of HTML."""

from collections.abc import Sequence
from html import escape

from cleaning.verdicts.cleanliness import report_outcome
from cleaning.verdicts.results import CleaningReport
from reports.html.cleaning_page import hash_lines, legend
from reports.html.page import image, section, table_html, whole_page
from reports.pictures.cleaning_pictures import VERDICT_COLOURS, draw_verdicts
from reports.tables.cleaning_tables import caveat, headline
from reports.tables.comparison import Row, comparison_tables


def comparison_page(rows: Sequence[Row], reports: tuple[CleaningReport, CleaningReport], names: tuple[str, str]) -> str:
    """Write the page; the same reports give the same text.

    Args:
        rows: What is compared.
        reports: What each cleans, on the same board.
        names: Name of each.
    """
    here, _ = reports
    one, other = names
    title = f"{one} and {other}"
    verdicts = "".join(
        f'<p><span class="mark" style="background:{VERDICT_COLOURS[report_outcome(report)]}"></span>'
        f"<b>{escape(name)}</b> {escape(headline(report))}</p>"
        for name, report in zip(names, reports, strict=True)
    )
    head = (
        f'<header><p class="q">{escape(here.origin.board)}</p><h1>{escape(title)}</h1>'
        f'{verdicts}<p class="caveat">{escape(caveat(here))}</p></header>'
    )
    tables = [section(table.title, table_html(table, "both")) for table in comparison_tables(rows, names, "Change")]
    boards = [
        section(f"{name}: the board", legend(), *map(image, draw_verdicts(report)))
        for name, report in zip(names, reports, strict=True)
    ]
    origins = [
        ("board", here.origin.board, here.origin.board_sha256),
        *(("recipe", each.origin.recipe, each.origin.recipe_sha256) for each in reports),
        ("parameter set", here.parameters.parameters, here.parameters_sha256),
    ]
    traces = section("Where it comes from", hash_lines(origins))
    return whole_page(f"{here.origin.board}: {title}", [head, *tables, *boards, traces])
