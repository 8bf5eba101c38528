"""A page of HTML that needs nothing else, to look at, print and keep: sections, cards, tables, pictures."""

from base64 import b64encode
from collections.abc import Iterable
from html import escape

from cleaning.verdicts.rules import Outcome
from reports.pictures.cleaning_pictures import VERDICT_COLOURS
from reports.pictures.sheet import FAINT, INK, QUIET, Picture
from reports.tables import table as model
from specs.finding import worst_first

_CLASSES = {"quiet": "q", "small": "names"}


def whole_page(title: str, sections: Iterable[str]) -> str:
    """Write the page around its sections."""
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f'<meta name="viewport" content="width=device-width"><style>{_STYLE}</style></head>'
        f"<body><main>{''.join(sections)}</main></body></html>\n"
    )


def section(title: str, *content: str) -> str:
    """Put content under a heading; nothing at all where there is none."""
    body = "".join(content)
    return f"<section><h2>{escape(title)}</h2>{body}</section>" if body else ""


def image(picture: Picture) -> str:
    """Put a picture into the page itself."""
    kind = {".png": "image/png", ".svg": "image/svg+xml"}[picture.suffix]
    data = b64encode(picture.content).decode("ascii")
    return f'<img alt="{escape(picture.alt)}" src="data:{kind};base64,{data}">'


def blocks_html(blocks: Iterable[model.Block]) -> str:
    """Write blocks of a card one below the other."""
    return "".join(map(_block_html, blocks))


def _block_html(block: model.Block) -> str:
    match block:
        case model.Table():
            return table_html(block)
        case model.FactList():
            facts = "".join(
                f"<dt>{escape(model.capital(name))}</dt><dd>{escape(text)}</dd>" for name, text in block.facts
            )
            return f"<dl>{facts}</dl>"
        case model.FindingList():
            return blocks_html(map(model.finding_note, worst_first(block.findings))) or "<p>No findings.</p>"
        case model.Note():
            return "".join(f"<p>{_line_html(line)}</p>" for line in (block.head, *block.below))
        case model.Verbatim():
            return f"<pre><code>{escape(block.text)}</code></pre>"
        case model.Text("", _, _) | "":
            return ""
        case model.Text(text, "quiet" | "small", None):
            return f'<p class="q">{escape(text)}</p>'
        case _:
            return f"<p>{_line_html(block)}</p>"


def quiet(text: str) -> str:
    """Write a remark in grey; nothing for no text."""
    return _block_html(model.Text(text, "quiet"))


def header(above: str, title: str, colour: str, blocks: Iterable[model.Block] = (), inner: str = "") -> str:
    """Begin a page: what it is about, what came out in a colour, and what that is worth."""
    head = f'{quiet(above)}<h1 style="border-color:{colour}">{escape(title)}</h1>'
    return f"<header>{head}{blocks_html(blocks)}{inner}</header>"


def table_html(table: model.Table, kind: str = "") -> str:
    """Lay out a table of a class of the page's style; nothing where it has no rows."""
    if not table.rows:
        return ""
    flush = [' class="r"' * (column.align == "right") for column in table.columns]
    columns = zip(table.columns, flush, strict=True)
    head = "".join(f"<th{each}>{escape(model.heading_of(column))}</th>" for column, each in columns)
    body = "".join(
        "<tr>" + "".join(f"<td{each}>{_cell_html(cell)}</td>" for cell, each in zip(row, flush, strict=True)) + "</tr>"
        for row in table.rows
    )
    title = f"<caption>{escape(table.title)}</caption>" if table.title else ""
    return f'<table class="{kind}">{title}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'


def verdict_mark(verdict: Outcome) -> str:
    """Write a verdict with its colour; the word alone is enough to read it."""
    return f'<span class="mark" style="background:{VERDICT_COLOURS[verdict]}"></span>{verdict}'


def _cell_html(cell: model.Cell) -> str:
    first, *below = model.lines_of(cell)
    html = "".join(map(_run_html, first))
    if isinstance(cell, model.Bar):
        html += f'<div class="bar" style="width:{100 * cell.share:.0f}%"></div>'
    for line in below:
        if len(line) == 1 and line[0].emphasis in _CLASSES:
            html += f'<div class="{_CLASSES[line[0].emphasis]}">{escape(line[0].text)}</div>'
        else:
            html += f"<div>{''.join(map(_run_html, line))}</div>"
    return html


def _line_html(line: model.Line) -> str:
    return "".join(map(_run_html, model.lines_of(line)[0]))


def _run_html(run: model.Text) -> str:
    if run.tone in VERDICT_COLOURS and run.text == run.tone:
        return verdict_mark(run.tone)
    text = escape(run.text)
    match run.emphasis:
        case "strong":
            return f"<b>{text}</b>"
        case "code":
            return f"<code>{text}</code>"
        case "quiet" | "small":
            return f'<span class="{_CLASSES[run.emphasis]}">{text}</span>'
        case _:
            return text


_STYLE = f"""
@page {{ size: A4; margin: 14mm 15mm }}
* {{ box-sizing: border-box }}
body {{ margin: 0; background: #fff; color: {INK}; font: 13px/1.5 system-ui, "DejaVu Sans", sans-serif;
  font-variant-numeric: tabular-nums; print-color-adjust: exact; -webkit-print-color-adjust: exact }}
main {{ max-width: 190mm; margin: 0 auto; padding: 8mm 5mm }}
h1 {{ font-size: 24px; line-height: 1.25; margin: 4px 0 10px; padding-left: 12px; border-left: 8px solid }}
h2 {{ font-size: 16px; margin: 30px 0 8px; padding-top: 8px; border-top: 1px solid {FAINT}; break-after: avoid }}
h3 {{ font-size: 13px; margin: 14px 0 2px; break-after: avoid }}
p {{ margin: 4px 0 8px }}
img {{ display: block; width: 100%; margin: 6px 0; break-inside: avoid }}
article, .facts, .blanks {{ break-inside: avoid }}
.q {{ color: #5d6a73; font-size: 11.5px; break-inside: avoid }}
.legend, h2 + .q {{ break-after: avoid }}
.caveat {{ padding-left: 20px; max-width: 150mm }}
.facts {{ display: flex; flex-wrap: wrap; gap: 8px 28px; margin-top: 14px }}
.facts b {{ display: block; font-size: 18px; font-weight: 600 }}
.facts span {{ color: #5d6a73; font-size: 11.5px }}
.mark {{ display: inline-block; width: 9px; height: 9px; margin: 0 5px 0 0; border-radius: 2px }}
.legend {{ word-spacing: 0 }} .legend .mark {{ margin-left: 12px }} .legend .mark:first-child {{ margin-left: 0 }}
table {{ width: 100%; border-collapse: collapse; margin: 6px 0 }}
th {{ text-align: left; font-weight: 600; font-size: 11.5px; color: #5d6a73; border-bottom: 1px solid {QUIET} }}
th, td {{ padding: 3px 8px 3px 0; vertical-align: top }}
td {{ border-bottom: 1px solid #e6e9eb }}
tr {{ break-inside: avoid }}
.r {{ text-align: right }} td.r {{ white-space: nowrap }}
.parts td:nth-child(1) {{ width: 19% }} .parts td:nth-child(2) {{ width: 13% }} .parts td:nth-child(4) {{ width: 28% }}
.parts td {{ overflow-wrap: anywhere }}
.sure td:nth-child(1) {{ width: 50%; font-size: 12px }} .sure td:nth-child(2) {{ width: 12% }}
.small td:nth-child(1) {{ width: 34% }} .small td:nth-child(2) {{ width: 14% }}
.both {{ table-layout: fixed }} .both th:first-child {{ width: 40% }}
.small {{ font-size: 11px }} .names {{ font-size: 12px }}
code {{ font: 11px "DejaVu Sans Mono", monospace; overflow-wrap: anywhere }}
.blanks {{ display: grid; grid-template-columns: 1fr 1fr; gap: 14px 24px; margin: 10px 0 16px }}
.blanks div {{ border-bottom: 1px solid {INK} }} .blanks span {{ color: #5d6a73; font-size: 11.5px; margin-right: 8px }}
@media print {{ main {{ padding: 0 }} }}
@media screen and (min-width: 1250px) {{ main {{ max-width: 310mm }} .caveat, p {{ max-width: 200mm }}
  article {{ display: inline-block; width: 49%; margin-right: .9%; vertical-align: top }} }}
@media screen and (max-width: 700px) {{ table {{ display: block; overflow-x: auto }} }}
dl {{ display: grid; grid-template-columns: max-content 1fr; gap: 0 12px; margin: 4px 0 8px }} dd {{ margin: 0 }}
dt {{ color: #5d6a73 }} caption {{ text-align: left; font-weight: 600 }} .bar {{ height: 6px; background: {QUIET} }}
.hashes {{ font-size: 11.5px }} li {{ margin-bottom: 4px }}
"""
