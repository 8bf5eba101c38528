"""A run, a board or a program as a person wants to read it in a terminal."""

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from programs.program import Command, MoveTo, SetNozzle, TimedProgram, Wait
from programs.summary import by_function
from reports.tables.run_report import class_counts, grouped_findings
from specs.finding import Finding, worst_first
from specs.finding_rules import ORDER_GAIN

if TYPE_CHECKING:
    from rulesengine.planning.pipeline import Run

_COLOURS = {"error": "bold red", "warning": "yellow", "info": "dim"}
_NAME = r"[^\s+/]*[^\s+/.,:;]"
_GROUP = re.compile(rf"(?P<first>{_NAME}\+{_NAME})(?P<rest>(?:\+{_NAME}){{2,}})")


def print_run(console: Console, run: "Run") -> None:
    """Time and litres by function, members of each class, what the order saved, findings worst first."""
    print_program(console, run.program)
    counts = ", ".join(f"{name} {count}" for name, count in class_counts(run).items())
    gains = [finding for finding in run.findings if finding.rule == ORDER_GAIN]
    facts = [("classes", counts), *(("order", f"{shorten(gain.made_by)}: {gain.message}") for gain in gains)]
    print_facts(console, facts)
    print_findings(console, [finding for finding in run.findings if finding.rule != ORDER_GAIN])


def print_program(console: Console, program: TimedProgram) -> None:
    """Head line, totals, a table of functions, and what is counted once though it may be repeated."""
    origin, totals = program.origin, program.totals
    console.print(
        f"[bold]{escape(origin.board)}[/bold] with [bold]{escape(origin.recipe)}[/bold]: "
        f"{clock(totals.duration_s)}, {clock(totals.spray_s)} of it spraying; "
        f"{totals.travel_mm / 1000:.2f} m of travel in {amount(totals.moves, 'move')}"
    )
    litres = dict(totals.liquid_l)
    table = _table("function", "nozzle", "solution", ">time", ">spraying", ">sprayed way", ">all the way", ">litres")
    for each in by_function(program):
        # The totals know litres by function: they stand where the function comes first.
        liquid = litres.pop(each.function, None)
        table.add_row(
            escape(each.function),
            escape(each.nozzle),
            escape(each.solution),
            clock(each.duration_s),
            clock(each.spray_s),
            f"{each.spray_mm / 1000:.2f} m",
            f"{each.travel_mm / 1000:.2f} m",
            "" if liquid is None else f"{liquid:.2f}",
        )
    console.print(table)
    repeats = [
        f"{each.made_by} until {' '.join(each.arguments[2:])}, at most {each.arguments[0]} times; counted once here"
        for each in program.instructions
        if isinstance(each, Command) and each.keyword == "REPEAT"
    ]
    print_facts(console, [("repeats", text) for text in repeats])


def print_room(console: Console, program: TimedProgram) -> None:
    """Where the orifice goes, how often the jet opens, and how often it pauses."""
    places = np.array([each.position for each in program.instructions if isinstance(each, MoveTo)]).reshape(-1, 3)
    spans = zip("xyz", places.min(axis=0, initial=np.inf), places.max(axis=0, initial=-np.inf), strict=True)
    room = ", ".join(f"{axis} {low:.1f} to {high:.1f}" for axis, low, high in spans)
    opened = sum(isinstance(each, SetNozzle) and each.spraying for each in program.instructions)
    waits = [each.duration_s for each in program.instructions if isinstance(each, Wait)]
    pauses = f"{amount(len(waits), 'pause')} of {clock(sum(waits))} together" if waits else "no pauses"
    facts = [("orifice", f"{room} mm")] if len(places) else []
    print_facts(console, [*facts, ("jet", f"opens {amount(opened, 'time')}; {pauses}")])


def print_commands(console: Console, program: TimedProgram) -> None:
    """Commands to the cell in order of time; those that one step gives at one moment stand together."""
    table = _table(">at", "commands", "asked for by")
    told: list[tuple[float, str, list[str]]] = []
    for command in program.instructions:
        if isinstance(command, Command):
            if not told or told[-1][:2] != (command.time_s, command.made_by):
                told.append((command.time_s, command.made_by, []))
            told[-1][2].append(" ".join([command.keyword, *command.arguments]))
    for time_s, made_by, words in told:
        table.add_row(clock(time_s), escape(", ".join(words)), escape(shorten(made_by)))
    if told:
        console.print(table)


def print_findings(console: Console, findings: Sequence[Finding]) -> None:
    """One entry for each rule, worst first, with the first place and how many more there are."""
    if not findings:
        console.print("[green]No findings.[/green]")
        return
    counts = Counter(finding.severity for finding in findings)
    tally = ", ".join(f"{counts[severity]} {severity}" for severity in _COLOURS if counts[severity])
    console.print(f"Findings: {tally}{'; worst first' if len(findings) > 1 else ''}.")
    for finding, count in grouped_findings(worst_first(findings)):
        head = Text.assemble((f"{finding.severity} {finding.rule.id}", _COLOURS[finding.severity]))
        if finding.made_by:
            head.append(f"  {shorten(finding.made_by)}", "dim")
        if finding.where is not None:
            head.append("  at " + ", ".join(f"{value:.1f}" for value in finding.where) + " mm", "dim")
        if count > 1:
            head.append(f"  and {count - 1} more", "dim")
        console.print(Padding(head, (0, 0, 0, 2), expand=False))
        console.print(Padding(Text(shorten(finding.message)), (0, 0, 0, 4), expand=False))


def print_facts(console: Console, facts: Iterable[tuple[str, str]]) -> None:
    """Two columns: what it is, and what there is to say; no line is filled with blanks to the length of the longest."""
    told = list(facts)
    width = max((len(name) for name, _ in told), default=0)
    for name, text in told:
        table = Table(box=None, pad_edge=False, show_header=False)
        table.add_column(style="dim", min_width=max(8, width), no_wrap=True)
        table.add_column(overflow="fold")
        table.add_row(name, escape(text))
        console.print(table)


def shorten(text: str) -> str:
    """Name the first two members of a group and count the others: ``U1+C4+37 more``."""
    return _GROUP.sub(lambda found: f"{found['first']}+{found['rest'].count('+')} more", text)


def amount(count: int, noun: str, plural: str = "") -> str:
    """Count things: ``no moves``, ``1 move``, ``44,712 moves``."""
    named = noun if count == 1 else plural or f"{noun}s"
    return f"{count:,} {named}" if count else f"no {named}"


def clock(seconds: float) -> str:
    """Seconds as a person reads them: ``42.3 s`` or ``7 min 11 s``."""
    if round(seconds, 1) < 60:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    return f"{whole // 60} min {whole % 60:02d} s"


def _table(*headings: str) -> Table:
    """An unframed table; a heading that begins with > has its column flush right."""
    table = Table(box=None, pad_edge=False, header_style="dim")
    for heading in headings:
        right = heading.startswith(">")
        table.add_column(heading.removeprefix(">"), justify="right" if right else "left", no_wrap=right)
    return table
