"""The page's HTML: cards, and their building blocks, boxes, facts, tables, legends, aligned with the inputs."""

from collections.abc import Iterable, Mapping, Sequence
from html import escape

from reports.tables.table import (
    Bar,
    Block,
    Card,
    Cell,
    FactList,
    FindingList,
    Line,
    Note,
    Table,
    Text,
    Tone,
    Verbatim,
    capital,
    heading_of,
    lines_of,
)
from reports.tables.wording import shorten, tally
from specs.finding import Finding, worst_first
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
_MOST_FINDINGS = 5
_FEW = 3
"""Columns that a panel has room for."""
TONE_COLOURS: dict[Tone, Tint] = {**SEVERITY_COLOURS, **VERDICT_COLOURS}
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
    return f'<div style="overflow-wrap:anywhere">{_line_html(Text(text, "strong"), ACCENT)}</div>'


def heading_html(text: str) -> str:
    """Heading of a part of a card."""
    return f'<div style="margin-top:7px;font-weight:600">{escape(text)}</div>'


def edged_html(inner: str, colour: str, style: str = "") -> str:
    """HTML with a coloured edge on its left."""
    return (
        f'<div style="margin-top:4px;padding-left:7px;border-left:3px solid {colour};overflow-wrap:anywhere;{style}">'
        f"{inner}</div>"
    )


def card_html(card: Card) -> str:
    """A card in a box: its title, and its blocks one below the other."""
    title = f'<div style="overflow-wrap:anywhere">{_line_html(card.title, ACCENT)}</div>' if card.title else ""
    return box_html(title + blocks_html(card.blocks))


def blocks_html(blocks: Iterable[Block]) -> str:
    """Blocks of a card one below the other, inside a box."""
    return "".join(map(_block_html, blocks))


def _block_html(block: Block) -> str:
    match block:
        case Table(rows=()):
            return ""
        case Table():  # one that is wider than the panel scrolls by itself, also by the keyboard
            style = "font-size:11px;overflow-x:auto;white-space:nowrap" if len(block.columns) > _FEW else ""
            heading = heading_html(block.title) if block.title else ""
            return f'{heading}<div tabindex="0" style="{style}">{table_html(block)}</div>'
        case FactList():
            return facts_html({capital(name): text for name, text in block.facts})
        case FindingList():
            found = worst_first(block.findings)
            return facts_html({"Findings": tally(found)}) + messages_html(found, _MOST_FINDINGS)
        case Note():
            below = "".join(f"<div>{_line_html(line)}</div>" for line in block.below)
            return edged_html(small_html(_line_html(block.head)) + below, css_colour(TONE_COLOURS[block.tone]))
        case Verbatim():
            return f'<pre style="margin:4px 0;white-space:pre-wrap;overflow-wrap:anywhere">{escape(block.text)}</pre>'
        case _:
            return f'<div style="overflow-wrap:anywhere">{_line_html(block)}</div>'


def messages_html(findings: Sequence[Finding], most: int) -> str:
    """Messages of the first findings, and the number of others."""
    shown = [
        edged_html(escape(shorten(each.message)), css_colour(TONE_COLOURS[each.severity])) for each in findings[:most]
    ]
    return "".join(shown) + more_html(len(findings) - most)


def _line_html(line: Line, strong: Tint | None = None) -> str:
    """Runs of a line; those that are strong in a colour, if one is given."""
    return "".join(_run_html(run, strong) for run in lines_of(line)[0])


def _run_html(run: Text, strong: Tint | None = None) -> str:
    tint = strong if run.emphasis == "strong" else QUIET if run.emphasis in ("quiet", "small") else None
    tint = TONE_COLOURS[run.tone] if run.tone else tint
    style = {
        "font-weight": "600" if run.tone or run.emphasis == "strong" else "",
        "color": "" if tint is None else css_colour(tint),
        "font-size": "11px" if run.emphasis == "small" else "",
    }
    css = ";".join(f"{name}:{value}" for name, value in style.items() if value)
    return f'<span style="{css}">{escape(run.text)}</span>' if css else escape(run.text)


def facts_html(facts: Mapping[str, str]) -> str:
    """Table of names and values, which may have several lines."""
    rows = "".join(
        f'<tr style="vertical-align:top"><td style="color:{css_colour(QUIET)};padding-right:10px;white-space:nowrap">'
        f'{escape(name)}</td><td style="overflow-wrap:anywhere">{_lines_html(value)}</td></tr>'
        for name, value in facts.items()
    )
    return f'<table style="border-collapse:collapse;font-size:12px">{rows}</table>'


def table_html(table: Table) -> str:
    """Table as wide as its container; text in a column flush left may be wrapped."""
    head = "".join(f'<td style="{_CELL[each.align]}">{escape(heading_of(each))}</td>' for each in table.columns)
    body = f'<tr style="color:{css_colour(QUIET)}">{head}</tr>' if any(each.heading for each in table.columns) else ""
    for row in table.rows:
        cells = zip(table.columns, row, strict=True)
        inner = (f'<td style="{_CELL[column.align]}">{_cell_html(cell)}</td>' for column, cell in cells)
        body += f"<tr>{''.join(inner)}</tr>"
    return f'<table style="{_TABLE}">{body}</table>'


def _cell_html(cell: Cell) -> str:
    if not isinstance(cell, Bar):
        return "<br>".join("".join(_run_html(run, ACCENT) for run in line) for line in lines_of(cell))
    colour, weight = (css_colour(ACCENT), 600) if cell.marked else (css_colour(QUIET), 400)
    return (
        '<div style="display:flex;align-items:center;gap:6px"><span style="flex:1;min-width:40px;'
        f'background:{TRACK};border-radius:2px"><span style="display:block;height:7px;border-radius:2px;'
        f'background:{colour};width:{100 * cell.share:.0f}%"></span></span>'
        f'<span style="flex:none;white-space:nowrap;font-weight:{weight}">{escape(cell.text)}</span></div>'
    )


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
        f"{heading_of(each)}</th>"
        for each in table.columns
    )
    body = f"<tr>{head}</tr>"
    ground = f' style="background:{css_colour(CHOSEN_GROUND)};box-shadow:inset 3px 0 0 {css_colour(ACCENT)}"'
    for row in table.rows[:MOST_ROWS]:
        runs = [lines_of(cell)[0][0] for cell in row]
        body += f'<tr data-row="{escape(runs[0].text)}"{ground if runs[0].text == selected else ""}>'
        for column, run in zip(table.columns, runs, strict=True):
            mark = ""
            if run.tone in VERDICT_COLOURS:
                mark = f'<span style="color:{css_colour(VERDICT_COLOURS[run.tone])}">\N{BLACK CIRCLE}</span> '
                run = Text(run.text)
            style, text = f"{_CUT};{_FLUSH[column.align]}", escape(run.text)
            body += f'<td style="{style}" title="{text}">{mark}{_run_html(run)}</td>'
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
