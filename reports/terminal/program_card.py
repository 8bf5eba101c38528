"""A run, or a program, on the terminal."""

from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console

from programs.program import Command, MoveTo, SetNozzle, TimedProgram, Wait
from programs.summary import by_function
from reports.tables.run_report import class_counts, fitted_words, landed_words
from reports.tables.table import Facts, Table
from reports.tables.wording import amount, clock, shorten
from reports.terminal.console import print_facts, print_findings, print_line, print_table
from specs.finding_rules import ORDER_GAIN
from specs.source import Source

if TYPE_CHECKING:
    from rulesengine.planning.pipeline import Run


def print_run(console: Console, run: "Run") -> None:
    """Print time and litres by function, members of each class, what was fitted, what lands, and findings."""
    print_program(console, run.program)
    counts = ", ".join(f"{name} {count}" for name, count in class_counts(run).items())
    gains = [finding for finding in run.findings if finding.rule == ORDER_GAIN]
    facts = [
        *_robot(run),
        ("classes", counts),
        *(("fitted", words) for words in [fitted_words(run)] if words),
        *(("lands", f"{words} of the spray on the board") for words in [landed_words(run)] if words),
        *(("order", f"{shorten(str(gain.made_by))}: {gain.message}") for gain in gains),
    ]
    print_facts(console, facts)
    print_findings(console, [finding for finding in run.findings if finding.rule != ORDER_GAIN])


def _robot(run: "Run") -> Facts:
    """What the limits of a cell's robot cost, where the program is timed for one."""
    timing = run.robot
    if timing is None:
        return []
    price = ", ".join(f"{clock(seconds)} {kind}" for kind, seconds in timing.price_s if seconds >= 0.05)
    longer = f"{clock(timing.planned_s - timing.free_s)} longer than the recipe's limits allow"
    ratio, added = timing.robot_s / timing.planned_s, clock(timing.added_s)
    return [
        ("cell", f"{timing.cell} ({timing.robot}): {longer}" + (f"; {price}" if price else "")),
        ("", f"its robot takes {ratio:.3f} times the planned time, and {added} for home and changes of the tool"),
    ]


def print_program(console: Console, program: TimedProgram) -> None:
    """Print head line, totals, a table of functions, and what is counted once though it may be repeated."""
    origin, totals = program.origin, program.totals
    print_line(
        console, (origin.board, "bold"), " with ", (origin.recipe, "bold"),
        f": {clock(totals.duration_s)}, {clock(totals.spray_s)} of it spraying; "
        f"{totals.travel_mm / 1000:.2f} m of travel in {amount(totals.moves, 'move')}",
    )  # fmt: skip
    litres = dict(totals.liquid_l)
    rows: list[tuple[str, ...]] = []
    for each in by_function(program):
        liquid = litres.pop(each.function, None)  # litres are known by function: they stand where it comes first
        rows.append((
            each.function, each.nozzle, each.solution, clock(each.duration_s), clock(each.spray_s),
            f"{each.spray_mm / 1000:.2f} m", f"{each.travel_mm / 1000:.2f} m",
            "" if liquid is None else f"{liquid:.2f}",
        ))  # fmt: skip
    headings = ("function", "nozzle", "solution", ">time", ">spraying", ">sprayed way", ">all the way", ">litres")
    print_table(console, Table.of(headings, rows))
    repeats = [
        f"{each.made_by} until {' '.join(each.arguments[2:])}, at most {each.arguments[0]} times; counted once here"
        for each in program.instructions
        if isinstance(each, Command) and each.keyword == "REPEAT"
    ]
    print_facts(console, [("repeats", text) for text in repeats])


def print_extent(console: Console, program: TimedProgram) -> None:
    """Print where the orifice goes, how often the jet opens, and how often it pauses."""
    places = np.array([each.position for each in program.instructions if isinstance(each, MoveTo)]).reshape(-1, 3)
    spans = zip("xyz", places.min(axis=0, initial=np.inf), places.max(axis=0, initial=-np.inf), strict=True)
    extent = ", ".join(f"{axis} {low:.1f} to {high:.1f}" for axis, low, high in spans)
    opened = sum(isinstance(each, SetNozzle) and each.spraying for each in program.instructions)
    waits = [each.duration_s for each in program.instructions if isinstance(each, Wait)]
    pauses = f"{amount(len(waits), 'pause')} of {clock(sum(waits))} together" if waits else "no pauses"
    facts = [("orifice", f"{extent} mm")] if len(places) else []
    print_facts(console, [*facts, ("jet", f"opens {amount(opened, 'time')}; {pauses}")])


def print_commands(console: Console, program: TimedProgram) -> None:
    """Print commands to the cell in order of time; those that one step gives at one moment stand together."""
    grouped: list[tuple[float, Source, list[str]]] = []
    for command in program.instructions:
        if isinstance(command, Command):
            if not grouped or grouped[-1][:2] != (command.time_s, command.made_by):
                grouped.append((command.time_s, command.made_by, []))
            grouped[-1][2].append(" ".join([command.keyword, *command.arguments]))
    rows = [(clock(time_s), ", ".join(words), shorten(str(made_by))) for time_s, made_by, words in grouped]
    print_table(console, Table.of((">at", "commands", "recipe entry"), rows))
