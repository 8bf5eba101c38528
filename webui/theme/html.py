"""Building blocks of the page's HTML: boxes, facts, tables, legends, remarks and progress, aligned with the inputs."""

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from itertools import zip_longest

from reports.tables.table import Table, lines_of
from webui.theme.palette import (
    ACCENT,
    CHOSEN_GROUND,
    INK,
    PAPER,
    QUIET,
    SEVERITY_COLOURS,
    TRACK,
    VERDICT_COLOURS,
    Tint,
    css_colour,
    to_hex,
)

LINE = "width:14px;height:4px;border-radius:2px;margin-right:5px"
DIAMOND = "width:8px;height:8px;transform:rotate(45deg);margin:0 7px 0 3px"
SQUARE = "width:12px;height:12px;border-radius:2px;margin-right:7px"
"""CSS of the samples of a legend."""
_TABLE = "border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums"
MOST_ROWS = 200
_CELL = {
    "left": "overflow-wrap:anywhere;vertical-align:top",
    "right": "text-align:right;white-space:nowrap;padding:1px 0 1px 8px;vertical-align:top",
}
_CUT = "padding:1px 8px 1px 0;white-space:nowrap;overflow:hidden;text-overflow:ellipsis"
_FLUSH = {"left": "", "right": "text-align:right;font-variant-numeric:tabular-nums"}


def box_html(inner: str, style: str = "") -> str:
    """HTML in a box; its style is CSS that overrides that of the box."""
    looks = f"margin:2px 12px 4px;font-size:12px;line-height:1.45;color:{css_colour(INK)};{style}"
    return f'<div style="{looks}">{inner}</div>'


def quiet_html(text: str, style: str = "") -> str:
    """Plain text in grey, in a box; nothing for no text."""
    return box_html(escape(text), f"color:{css_colour(QUIET)};{style}") if text else ""


def grey_html(inner: str, style: str = "") -> str:
    """HTML in grey, inside a box; nothing for nothing."""
    return f'<div style="color:{css_colour(QUIET)};{style}">{inner}</div>' if inner else ""


def small_html(inner: str) -> str:
    """HTML in small grey letters, inside a box."""
    return grey_html(inner, "font-size:11px")


def more_html(count: int, what: str = "more") -> str:
    """How many rows are left out of a list, inside a box; nothing where none is."""
    return grey_html(f"and {count} {escape(what)}" if count > 0 else "")


def name_html(text: str) -> str:
    """Name of what a card is about."""
    return f'<div style="font-weight:600;color:{css_colour(ACCENT)};overflow-wrap:anywhere">{escape(text)}</div>'


def heading_html(text: str, rest: str = "") -> str:
    """Heading of a part of a card, with HTML after it."""
    return f'<div style="margin-top:7px;font-weight:600">{escape(text)}{rest}</div>'


def edged_html(inner: str, colour: str, style: str = "") -> str:
    """HTML with a coloured edge on its left."""
    return (
        f'<div style="margin-top:4px;padding-left:7px;border-left:3px solid {colour};overflow-wrap:anywhere;{style}">'
        f"{inner}</div>"
    )


def facts_html(facts: Mapping[str, str]) -> str:
    """Table of names and values, which may have several lines."""
    rows = "".join(
        f'<tr style="vertical-align:top"><td style="color:{css_colour(QUIET)};padding-right:10px;white-space:nowrap">'
        f'{escape(name)}</td><td style="overflow-wrap:anywhere">{_lines_html(value)}</td></tr>'
        for name, value in facts.items()
    )
    return f'<table style="border-collapse:collapse;font-size:12px">{rows}</table>'


def table_html(table: Table, styles: Sequence[str] = ()) -> str:
    """Table of plain cells, as wide as its container.

    Args:
        table: Cells of one line in a column flush left may be wrapped.
        styles: CSS of the rows, where they have any.
    """
    head = "".join(f'<td style="{_CELL[each.align]}">{escape(each.heading)}</td>' for each in table.columns)
    body = f'<tr style="color:{css_colour(QUIET)}">{head}</tr>' if any(each.heading for each in table.columns) else ""
    for row, style in zip_longest(table.rows, styles[: len(table.rows)], fillvalue=""):
        body += f'<tr style="{style}">'
        for column, cell in zip(table.columns, row, strict=True):
            lines = "<br>".join("".join(escape(run.text) for run in line) for line in lines_of(cell))
            body += f'<td style="{_CELL[column.align]}">{lines}</td>'
        body += "</tr>"
    return f'<table style="{_TABLE}">{body}</table>'


def listing_html(table: Table, selected: str, *, height: str, more: str) -> str:
    """Scrolling table with one row marked, cut off after ``MOST_ROWS``; a click on a row chooses it in its stepper.

    Args:
        table: Columns with their widths, and rows; the first cell has the row's name.
        selected: Name of the row that is marked; empty for none.
        height: CSS; a longer table scrolls.
        more: Name of the rows beyond, of which only the number is given.
    """
    head = "".join(
        f'<th style="{_CUT};color:{css_colour(QUIET)};text-align:{each.align};font-weight:400;width:{each.width}">'
        f"{each.heading}</th>"
        for each in table.columns
    )
    body = f"<tr>{head}</tr>"
    for row in table.rows[:MOST_ROWS]:
        runs = [lines_of(cell)[0][0] for cell in row]
        ground = f' style="background:{css_colour(CHOSEN_GROUND)};box-shadow:inset 3px 0 0 {css_colour(ACCENT)}"'
        body += f'<tr data-row="{escape(runs[0].text)}"{ground if runs[0].text == selected else ""}>'
        for column, run in zip(table.columns, runs, strict=True):
            style, mark, text = "", "", escape(run.text)
            if run.tone in SEVERITY_COLOURS:
                style = f"font-weight:600;color:{css_colour(SEVERITY_COLOURS[run.tone])}"
            elif run.tone in VERDICT_COLOURS:
                mark = f'<span style="color:{css_colour(VERDICT_COLOURS[run.tone])}">\N{BLACK CIRCLE}</span> '
            body += f'<td style="{_CUT};{_FLUSH[column.align]};{style}" title="{text}">{mark}{text}</td>'
        body += "</tr>"
    beyond = len(table.rows) - MOST_ROWS
    return (
        f'<div tabindex="0" style="max-height:{height};overflow-y:auto;margin:0 12px">'
        f'<table style="border-collapse:collapse;table-layout:fixed;width:100%;font-size:12px;color:{css_colour(INK)}">'
        f"{body}</table></div>" + (quiet_html(f"and {beyond} {more}") if beyond > 0 else "")
    )


def legend_html(items: Iterable[tuple[str, Tint]], sample: str = LINE) -> str:
    """Names with samples of their colours, side by side; those with squares one below the other."""
    display = "flex" if sample == SQUARE else "inline-flex"
    return box_html(
        "".join(
            f'<span style="display:{display};align-items:center;margin:0 12px 2px 0">'
            f'<span style="{sample};background:{to_hex(tint)}"></span>{escape(name)}</span>'
            for name, tint in items
        ),
        "line-height:1.6",
    )


def remark_html(reason: str) -> str:
    """Why something was refused; nothing for no reason."""
    colour = css_colour(SEVERITY_COLOURS["error"])
    style = f"margin:-2px 10px 8px;padding:4px 8px;line-height:1.4;font-size:12px;color:{colour}"
    lines = _lines_html(reason)
    return (
        f'<div role="alert" style="{style};border-left:3px solid {colour};overflow-wrap:anywhere">{lines}</div>'
        if reason
        else ""
    )


def sticky_html(text: str) -> str:
    """A note that stays in sight below many inputs."""
    return (
        f"<style>div:has(> .washboard-note) {{ position: sticky; bottom: 0; z-index: 3; background: {PAPER}; }}</style>"
        '<div class="washboard-note" style="margin:0 10px;padding:4px 0 6px;font-size:12px;line-height:1.4;'
        f'color:{css_colour(INK)}">{escape(text)}</div>'
    )


def progress_html(what: str, done: float) -> str:
    """What is being done and which share of it is done."""
    return box_html(grey_html(f"{escape(what.capitalize())}\N{HORIZONTAL ELLIPSIS} {done:.0%}") + bar_html(done))


def bar_html(share: float | None) -> str:
    """A thin progress bar; without a share its room is left empty."""
    ground, width = ("transparent", 0.0) if share is None else (TRACK, 100 * min(max(share, 0.03), 1.0))
    return (
        f'<div style="height:3px;border-radius:2px;margin-top:4px;background:{ground}">'
        f'<div style="height:3px;border-radius:2px;width:{width:.0f}%;background:{css_colour(ACCENT)}"></div></div>'
    )


def _lines_html(text: str) -> str:
    return "<br>".join(map(escape, text.splitlines()))
