"""A run, a board or a program as a person wants to read it in a terminal."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from boards.board import Board
from geometry.finding import Finding
from programs.program import TimedProgram
from programs.summary import by_function
from rulesengine.report import board_facts, class_counts, grouped_findings

if TYPE_CHECKING:
    from rulesengine.pipeline import Run

_COLOURS = {"error": "bold red", "warning": "yellow", "info": "dim"}
_MOST_ROWS = 40


def print_run(console: Console, run: "Run") -> None:
    """Time and litres by function, members of each class, what the order saved, findings worst first."""
    print_program(console, run.program)
    counts = class_counts(run)
    console.print("Classes: " + ", ".join(f"{escape(name)} {count}" for name, count in counts.items()))
    for finding in run.findings:
        if finding.rule == "order-gain":
            console.print(f"[dim]{escape(finding.made_by)}:[/dim] {escape(finding.message)}", highlight=False)
    print_findings(console, [finding for finding in run.findings if finding.rule != "order-gain"])


def print_program(console: Console, program: TimedProgram) -> None:
    """Head line, totals and a table of functions."""
    origin, totals = program.origin, program.totals
    console.print(
        f"[bold]{escape(origin.board)}[/bold] with [bold]{escape(origin.recipe)}[/bold]: "
        f"{clock(totals.duration_s)}, {clock(totals.spray_s)} of it spraying; "
        f"{totals.travel_mm / 1000:.2f} m of travel in {totals.moves} moves",
        highlight=False,
    )
    litres = dict(totals.liquid_l)
    table = Table(box=None, pad_edge=False, header_style="dim")
    for heading in ("function", "nozzle", "solution"):
        table.add_column(heading)
    for heading in ("time", "spraying", "sprayed way", "all the way", "litres"):
        table.add_column(heading, justify="right")
    counted: set[str] = set()
    for each in by_function(program):
        amount = f"{litres[each.function]:.2f}" if each.function in litres and each.function not in counted else ""
        counted.add(each.function)
        table.add_row(
            escape(each.function),
            escape(each.nozzle),
            escape(each.solution),
            clock(each.duration_s),
            clock(each.spray_s),
            f"{each.spray_mm / 1000:.2f} m",
            f"{each.travel_mm / 1000:.2f} m",
            amount,
        )
    console.print(table)


def print_findings(console: Console, findings: Sequence[Finding]) -> None:
    """One line for each rule, worst first, with the first place and how many more there are."""
    if not findings:
        console.print("[green]No findings.[/green]")
        return
    console.print(f"Findings ({len(findings)}), worst first:")
    for finding, count in grouped_findings(findings):
        more = f" [dim](and {count - 1} more)[/dim]" if count > 1 else ""
        by = f" [dim]{escape(finding.made_by)}[/dim]" if finding.made_by else ""
        colour = _COLOURS[finding.severity]
        console.print(
            f"  [{colour}]{finding.severity} {finding.rule}[/{colour}]{by}{more}\n    {escape(finding.message)}",
            highlight=False,
        )


def print_board(console: Console, board: Board, rows: int = _MOST_ROWS) -> None:
    """The board's card: what was understood, its components, its findings."""
    console.print(f"[bold]{escape(board.name)}[/bold]")
    facts = Table(box=None, pad_edge=False, show_header=False)
    facts.add_column(style="dim")
    facts.add_column()
    for name, value in board_facts(board).items():
        facts.add_row(name, escape(value))
    console.print(facts)
    table = Table(box=None, pad_edge=False, header_style="dim")
    for heading in ("component", "package", "side"):
        table.add_column(heading)
    for heading in ("pins", "area mm2", "height mm", "standoff mm", "neighbour mm"):
        table.add_column(heading, justify="right")
    for component in board.components[:rows]:
        standoff = "unknown" if component.standoff_mm is None else f"{component.standoff_mm:.3f}"
        assumed = "" if component.standoff_source in ("stated", "unknown") else " *"
        neighbour = f"{component.neighbour_mm:.2f} {component.neighbours[0][0]}" if component.neighbours else ""
        table.add_row(
            escape(component.name),
            escape(component.package),
            component.side,
            str(component.pins),
            f"{component.area_mm2:.2f}",
            f"{component.height_mm:.2f}",
            standoff + assumed,
            escape(neighbour),
        )
    console.print(table)
    if len(board.components) > rows:
        console.print(f"[dim]and {len(board.components) - rows} more; --all lists them[/dim]")
    if any(component.standoff_source not in ("stated", "unknown") for component in board.components):
        console.print("[dim]* assumed from the package family; state standoff in the board file or a parts table[/dim]")
    print_findings(console, board.findings)


def clock(seconds: float) -> str:
    """Seconds as a person reads them: ``42.3 s`` or ``7 min 11 s``."""
    if seconds < 60:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    return f"{whole // 60} min {whole % 60:02d} s"
