"""The terminal, or a pipe: cards, tables, facts, findings and the files that a command wrote."""

import os
import sys
from collections import Counter
from collections.abc import Sequence
from itertools import groupby
from os import PathLike
from typing import TextIO, cast

import rich.table
from rich.console import Console
from rich.padding import Padding
from rich.text import Text

from reports.tables import table as model
from specs.errors import printable
from specs.finding import Finding, grouped_findings, worst_first

_ANY_WIDTH = 10_000
"""In a pipe a sentence stays on one line, so that ``grep`` finds it whole."""
STYLES: dict[model.Tone, str] = {
    "error": "bold red", "warning": "yellow", "info": "dim",
    "dirty": "bold red", "marginal": "yellow", "clean, wet": "cyan", "no verdict": "dim", "clean": "green",
    "avoided": "dim",
}  # fmt: skip
_EMPHASIS: dict[model.Emphasis, str] = {"strong": "bold", "quiet": "dim", "small": "dim"}
_CHANGED = {"+": "green", "-": "red", "@": "dim"}
_BAR = 10
"""Characters of the longest bar."""


def open_console() -> Console:
    """Give the console of stdout: as wide as the terminal or ``COLUMNS``; in a pipe nothing is wrapped or cut."""
    stdout = cast("TextIO | None", sys.stdout)  # a shell may have closed it: washboard >&-
    as_it_is = "COLUMNS" in os.environ or (stdout is not None and stdout.isatty())
    return Console(width=None if as_it_is else _ANY_WIDTH, highlight=False)


def print_card(console: Console, card: model.Card) -> None:
    """Print title and blocks of a card; tables of the same columns that follow each other are laid out as one."""
    if card.title:
        print_line(console, card.title)
    for columns, blocks in groupby(
        card.blocks, lambda block: block.columns if isinstance(block, model.Table) else None
    ):
        if columns is not None:
            print_table(console, *(block for block in blocks if isinstance(block, model.Table)))
            continue
        for block in blocks:
            _print_block(console, block)


def _print_block(console: Console, block: model.Block) -> None:
    match block:
        case model.Table():
            print_table(console, block)
        case model.FactList():
            print_facts(console, block.facts)
        case model.FindingList():
            print_findings(console, block.findings)
        case model.Note():
            print_line(console, block.head)
            for line in block.below:
                console.print(Padding(_text(line), (0, 0, 0, 4), expand=False))
        case model.Verbatim():
            for line in block.text.splitlines():
                changed = _CHANGED.get(line[:1], "") if block.emphasis == "changed" else ""
                console.print(Text(printable(line), changed or _EMPHASIS.get(block.emphasis, "")), soft_wrap=True)
        case _:
            print_line(console, block)


def print_line(console: Console, line: model.Line) -> None:
    """Print a paragraph; brackets are no markup."""
    console.print(_text(line))


def print_note(console: Console, text: str) -> None:
    """Print a remark in grey."""
    print_line(console, model.Text(text, "quiet"))


def print_table(console: Console, *tables: model.Table) -> None:
    """Print tables of the same columns as one; the title of each heads its rows."""
    laid = rich.table.Table(box=None, pad_edge=False, header_style="dim")
    for column in tables[0].columns:
        laid.add_column(
            Text(column.heading), justify=column.align, style=_EMPHASIS.get(column.emphasis, ""),
            no_wrap=column.align == "right", overflow="ellipsis" if column.at_most else "fold",
            min_width=column.at_least or None, max_width=column.at_most or None,
        )  # fmt: skip
    for table in tables:
        indent = "  " if table.title else ""
        if table.title and table.rows:
            laid.add_row(Text(table.title, "bold"))
        for first, *others in table.rows:
            laid.add_row(Text(indent) + _text(first), *map(_text, others))
    if laid.row_count:
        console.print(laid)


def _text(cell: model.Cell) -> Text:
    bar = f"{'█' * round(_BAR * cell.share):<{_BAR}} " if isinstance(cell, model.Bar) else ""
    lines: list[Text] = []
    for line in model.lines_of(cell):
        styles = [STYLES[run.tone] if run.tone else _EMPHASIS.get(run.emphasis, "") for run in line]
        lines.append(Text.assemble(bar, *((run.text, style) for run, style in zip(line, styles, strict=True))))
    return Text("\n").join(lines)


def print_facts(console: Console, facts: model.Facts) -> None:
    """Print two columns; each fact by itself, so that no line is filled with blanks to the length of the longest."""
    width = max((len(name) for name, _ in facts), default=0)
    for name, text in facts:
        table = rich.table.Table(box=None, pad_edge=False, show_header=False)
        table.add_column(style="dim", min_width=max(8, width), no_wrap=True)
        table.add_column(overflow="fold")
        table.add_row(name, Text(text))
        console.print(table)


def print_findings(console: Console, findings: Sequence[Finding]) -> None:
    """Print one entry for each rule, worst first, with the first place and how many more there are."""
    if not findings:
        print_line(console, model.Text("No findings.", tone="clean"))
        return
    findings = worst_first(findings)
    counts = Counter(finding.severity for finding in findings)
    tally = ", ".join(f"{count} {severity}" for severity, count in counts.items())
    print_line(console, f"Findings: {tally}{'; worst first' if len(findings) > 1 else ''}.")
    for finding, count in grouped_findings(findings):
        note = model.finding_note(finding)
        head = _text(note.head)
        if count > 1:
            head.append(f"  and {count - 1} more", "dim")
        console.print(Padding(head, (0, 0, 0, 2), expand=False))
        for line in note.below:
            console.print(Padding(_text(line), (0, 0, 0, 4), expand=False))


def print_files(console: Console, *written: PathLike[str], **files: PathLike[str] | None) -> None:
    """Print which files were written, one a line, each with what it is."""
    for name, path in (*(("written", each) for each in written), *files.items()):
        if path is not None:
            console.print(f"{name.capitalize():<8} {printable(str(path))}", markup=False, soft_wrap=True)
