"""A list that somebody can choose from: a table with one row marked, which rolls, and says how many more there are."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Literal

from webui.cards.boxes import quiet_html
from webui.theme.palette import ACCENT, INK, QUIET, to_hex

MOST_ROWS = 200
_CELL = "padding:1px 8px 1px 0;white-space:nowrap;overflow:hidden;text-overflow:ellipsis"
_FLUSH = {"left": "", "right": "text-align:right;font-variant-numeric:tabular-nums"}


@dataclass(frozen=True, slots=True)
class Column:
    """One column of a list."""

    name: str
    width: str
    """CSS, such as ``"20%"``."""
    side: Literal["left", "right"] = "left"
    """On which its cells are flush."""


@dataclass(frozen=True, slots=True)
class Cell:
    """What stands at one place of a list."""

    text: str
    style: str = ""
    """CSS."""
    mark: str = ""
    """HTML before the text."""


def listing_html(
    columns: Sequence[Column], rows: Sequence[Sequence[Cell]], selected: str, *, height: str, more: str
) -> str:
    """Write a list.

    Args:
        columns: Its columns.
        rows: A cell for each column; the first has the row's name.
        selected: Name of the row that is marked; empty for none.
        height: CSS; a longer list rolls.
        more: What the rows beyond ``MOST_ROWS`` are called, of which only the number is said.
    """
    head = "".join(
        f'<th style="{_CELL};color:{to_hex(QUIET)};text-align:{each.side};font-weight:400;width:{each.width}">'
        f"{each.name}</th>"
        for each in columns
    )
    body = "".join(_row(columns, row, marked=row[0].text == selected) for row in rows[:MOST_ROWS])
    beyond = len(rows) - MOST_ROWS
    return (
        f'<div style="max-height:{height};overflow-y:auto;margin:0 12px">'
        f'<table style="border-collapse:collapse;table-layout:fixed;width:100%;font-size:12px;color:{to_hex(INK)}">'
        f"<tr>{head}</tr>{body}</table></div>" + (quiet_html(f"and {beyond} {more}") if beyond > 0 else "")
    )


def _row(columns: Sequence[Column], row: Sequence[Cell], *, marked: bool) -> str:
    cells = "".join(
        f'<td style="{_CELL};{_FLUSH[column.side]};{cell.style}" title="{escape(cell.text)}">'
        f"{cell.mark}{escape(cell.text)}</td>"
        for column, cell in zip(columns, row, strict=True)
    )
    ground = f' style="background:#fbf1ee;box-shadow:inset 3px 0 0 {to_hex(ACCENT)}"' if marked else ""
    return f"<tr{ground}>{cells}</tr>"
