"""The terminal, or a pipe: tables, facts, findings and the files that a command wrote."""

import os
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TextIO, cast

import rich.table
from rich.console import Console
from rich.padding import Padding
from rich.text import Text

from reports.tables.table import Cell, Emphasis, Facts, Table, Tone, lines_of
from reports.tables.wording import shorten
from specs.errors import printable
from specs.finding import Finding, grouped_findings, worst_first

_ANY_WIDTH = 10_000
"""In a pipe a sentence stays on one line, so that ``grep`` finds it whole."""
STYLES: dict[Tone, str] = {
    "error": "bold red", "warning": "yellow", "info": "dim",
    "dirty": "bold red", "marginal": "yellow", "clean, wet": "cyan", "no verdict": "dim", "clean": "green",
    "avoided": "dim",
}  # fmt: skip
_EMPHASIS: dict[Emphasis, str] = {"strong": "bold", "quiet": "dim"}


def open_console() -> Console:
    """Give the console of stdout: as wide as the terminal or ``COLUMNS``; in a pipe nothing is wrapped or cut."""
    stdout = cast("TextIO | None", sys.stdout)  # a shell may have closed it: washboard >&-
    as_it_is = "COLUMNS" in os.environ or (stdout is not None and stdout.isatty())
    return Console(width=None if as_it_is else _ANY_WIDTH, highlight=False)


def print_line(console: Console, *runs: str | tuple[str, str]) -> None:
    """Print text, and text with its style, as one paragraph; brackets are no markup."""
    console.print(Text.assemble(*runs))


def print_source(console: Console, name: str, description: str, source: str) -> None:
    """Print the name of what is shown, its description, and below it the file that it was read from."""
    print_line(console, (name, "bold"), f"  {description}")
    console.print(Text(printable(source), "dim"), soft_wrap=True)


def print_table(console: Console, *tables: Table) -> None:
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
        if table.title:
            laid.add_row(Text(table.title, "bold"))
        for first, *others in table.rows:
            laid.add_row(Text(indent) + _text(first), *map(_text, others))
    if laid.row_count:
        console.print(laid)


def _text(cell: Cell) -> Text:
    lines = [
        Text.assemble(*((run.text, STYLES[run.tone] if run.tone else _EMPHASIS.get(run.emphasis, "")) for run in line))
        for line in lines_of(cell)
    ]
    return Text("\n").join(lines)


def print_facts(console: Console, facts: Facts) -> None:
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
        print_line(console, ("No findings.", "green"))
        return
    findings = worst_first(findings)
    counts = Counter(finding.severity for finding in findings)
    tally = ", ".join(f"{count} {severity}" for severity, count in counts.items())
    print_line(console, f"Findings: {tally}{'; worst first' if len(findings) > 1 else ''}.")
    for finding, count in grouped_findings(findings):
        head = Text.assemble((f"{finding.severity} {finding.rule.id}", STYLES[finding.severity]))
        if finding.made_by:
            head.append(f"  {shorten(str(finding.made_by))}", "dim")
        if finding.where is not None:
            head.append("  at " + ", ".join(f"{value:.1f}" for value in finding.where) + " mm", "dim")
        if count > 1:
            head.append(f"  and {count - 1} more", "dim")
        console.print(Padding(head, (0, 0, 0, 2), expand=False))
        console.print(Padding(Text(shorten(finding.message)), (0, 0, 0, 4), expand=False))


def print_files(console: Console, *written: Path, **files: Path | None) -> None:
    """Print which files were written, one a line, each with what it is."""
    for name, path in (*(("written", each) for each in written), *files.items()):
        if path is not None:
            console.print(f"{name.capitalize():<8} {printable(str(path))}", markup=False, soft_wrap=True)
