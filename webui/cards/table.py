"""A list to choose from: a table with one row marked, which scrolls, and states how many more rows there are."""

from html import escape

from reports.tables.table import Cell, Column, Table, lines_of
from webui.cards.boxes import quiet_html
from webui.theme.palette import ACCENT, INK, QUIET, to_hex
from webui.theme.verdict_colours import SEVERITY_COLOURS, VERDICT_COLOURS

MOST_ROWS = 200
_CELL = "padding:1px 8px 1px 0;white-space:nowrap;overflow:hidden;text-overflow:ellipsis"
_FLUSH = {"left": "", "right": "text-align:right;font-variant-numeric:tabular-nums"}


def listing_html(table: Table, selected: str, *, height: str, more: str) -> str:
    """Write a list.

    Args:
        table: Columns with their widths, and rows; the first cell has the row's name.
        selected: Name of the row that is marked; empty for none.
        height: CSS; a longer list scrolls.
        more: Name of the rows beyond ``MOST_ROWS``, of which only the number is given.
    """
    head = "".join(
        f'<th style="{_CELL};color:{to_hex(QUIET)};text-align:{each.align};font-weight:400;width:{each.width}">'
        f"{each.heading}</th>"
        for each in table.columns
    )
    body = "".join(_row_html(table.columns, row, selected) for row in table.rows[:MOST_ROWS])
    beyond = len(table.rows) - MOST_ROWS
    return (
        f'<div style="max-height:{height};overflow-y:auto;margin:0 12px">'
        f'<table style="border-collapse:collapse;table-layout:fixed;width:100%;font-size:12px;color:{to_hex(INK)}">'
        f"<tr>{head}</tr>{body}</table></div>" + (quiet_html(f"and {beyond} {more}") if beyond > 0 else "")
    )


def _row_html(columns: tuple[Column, ...], row: tuple[Cell, ...], selected: str) -> str:
    cells = ""
    for column, cell in zip(columns, row, strict=True):
        (run,) = lines_of(cell)[0]
        style, mark = "", ""
        if run.tone in SEVERITY_COLOURS:
            style = f"font-weight:600;color:{SEVERITY_COLOURS[run.tone]}"
        elif run.tone in VERDICT_COLOURS:
            mark = f'<span style="color:{to_hex(VERDICT_COLOURS[run.tone])}">\N{BLACK CIRCLE}</span> '
        text = escape(run.text)
        cells += f'<td style="{_CELL};{_FLUSH[column.align]};{style}" title="{text}">{mark}{text}</td>'
    marked = lines_of(row[0])[0][0].text == selected
    ground = f' style="background:#fbf1ee;box-shadow:inset 3px 0 0 {to_hex(ACCENT)}"' if marked else ""
    return f"<tr{ground}>{cells}</tr>"
