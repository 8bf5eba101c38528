"""What a program cleans, on the terminal."""

from collections.abc import Iterable, Sequence

from rich.console import Console

from cleaning.parameters.provenance import assumptions_of
from cleaning.verdicts.cleanliness import (
    count_cleanliness,
    outcome,
    parts_by_instance,
    report_outcome,
    unclean_parts,
)
from cleaning.verdicts.results import CleaningReport, Part
from cleaning.verify import Verified
from reports.tables.cleaning_tables import (
    Producer,
    board_judgements,
    capability_table,
    capability_words,
    caveat,
    headline,
    main_cause,
    remarks,
    stage_rows,
    verified_rows,
    wet_count,
    wet_words,
)
from reports.tables.comparison import Row, comparison_tables
from reports.tables.rinse_tables import rinse_words
from reports.tables.similar_components import Description, deciding, describe, group_alike
from reports.tables.table import Cell, Facts, Table, Text
from reports.tables.wording import amount, clock, name_some, number_text, shorten
from reports.terminal.console import STYLES, print_facts, print_line, print_table

_MOST_GROUPS = 12
_MOST_NAMES = 12
_MOST_WORST = 3
_STAGES = ("function", "solution", "nozzle", ">bar", ">°C", ">time", ">spraying", ">litres", ">lands")
_VERIFIED = ("component", "stage", ">rays, mm", ">exact, mm", ">difference", ">worst cell, mm", ">cone, s", ">exact, s")
_SURE = ("component", ">clean, of 100", "else fails by", "depends most on")
_PARTS = ("component", "verdict", "grade", "rule", "because", "what to do")


def print_cleaning(console: Console, report: CleaningReport, producer: Producer) -> None:
    """Print headline and caveat, the stages, the worst components, what is wrong with the process, the producer."""
    origin = report.origin
    words = (headline(report), STYLES[report_outcome(report)])
    print_line(console, (origin.board, "bold"), " with ", (origin.recipe, "bold"), ". ", words)
    print_line(console, (caveat(report), "dim"))
    print_cause(console, report)
    print_table(console, Table.of(_STAGES, [row[: len(_STAGES)] for row in stage_rows(report)]))
    groups = group_alike(unclean_parts(report), deciding)
    rows: list[tuple[Cell, ...]] = []
    for group in groups[:_MOST_GROUPS]:
        first, verdict = group.descriptions[0], Text(outcome(group.parts[0]), tone=outcome(group.parts[0]))
        names, rule = name_some(group.names, _MOST_NAMES), f"{first.rule} {first.name}"
        rows.append((names, verdict, first.grade, rule, _because(first), first.advice))
    print_table(console, Table.of(_PARTS, rows))
    more = sum(len(group.parts) for group in groups[_MOST_GROUPS:])
    if more:
        console.print(f"and {amount(more, 'more component')}; --html and --json have all of them")
    for name, each in board_judgements(report):
        if each.verdict != "clean":
            print_line(console, (each.verdict, STYLES[each.verdict]), f"  {name}: {_because(describe(each))}")
    print_facts(console, [*_facts(report), ("analysed", f"by {producer}")])
    if words := capability_words(report):
        print_line(console, f"{words}.")
        print_table(console, Table.of(_SURE, capability_table(report, _MOST_NAMES).rows))


def print_cause(console: Console, report: CleaningReport) -> None:
    """Print what most components that are not clean fail by, and what helps; nothing where all are clean."""
    if cause := main_cause(report):
        print_line(console, cause)


def print_worst(console: Console, report: CleaningReport, seconds: float) -> None:
    """Print headline and caveat, verdicts counted, the worst few with the reason, and how long the analysis took."""
    print_line(console, (report.origin.board, "bold"), f", what comes out clean. {headline(report)}")
    print_line(console, (caveat(report), "dim"))
    print_cause(console, report)
    worst = group_alike(unclean_parts(report), deciding)[:_MOST_WORST]
    facts = [
        ("verdicts", _verdicts(report.parts)),
        *((name_some(each.names, 1), f"{outcome(each.parts[0])}: {each.descriptions[0].because}") for each in worst),
        ("analysed", f"in {clock(seconds)}"),
    ]
    print_facts(console, facts)


def print_verified(console: Console, verified: Sequence[Verified]) -> None:
    """Print what rays gave for chosen components, and what the exact sum gives."""
    print_table(console, Table.of(_VERIFIED, verified_rows(verified)))


def print_comparison(console: Console, rows: Sequence[Row], report: CleaningReport, names: tuple[str, str]) -> None:
    """Print the caveat, and one line for each quantity; what does not differ is dim.

    Args:
        console: Where.
        rows: What is compared.
        report: One of the two.
        names: Name of each.
    """
    print_line(console, (report.origin.board, "bold"), " with ", (" and ".join(names), "bold"), ".")
    print_line(console, (caveat(report), "dim"))
    print_table(console, *comparison_tables(rows, names, "change"))


def _because(description: Description) -> str:
    return description.because or "; ".join(number_text(low, high) for low, high in description.numbers)


def _verdicts(parts: Iterable[Part]) -> str:
    return ", ".join(f"{count} {verdict}" for verdict, count in count_cleanliness(parts).items()) or "none"


def _facts(report: CleaningReport) -> Facts:
    assumed = assumptions_of(report.parameters)
    known = {
        word: sum(each.known == word for each in assumed) for word in dict.fromkeys(each.known for each in assumed)
    }
    counts, wet = ", ".join(f"{count} {word}" for word, count in known.items()), wet_count(report)
    litres = f"{sum(value for _, value in report.litres):.2f} l" if report.litres else "no liquid"
    return [
        ("components", _verdicts(report.parts)),
        *((f"board {name}", _verdicts(parts)) for name, parts in parts_by_instance(report).items()),
        *([("wet", f"{wet} {wet_words(wet)}")] if wet else []),
        ("takes", f"{clock(report.duration_s)}, {litres}"),
        ("assumed", f"{len(assumed)} values of {report.parameters.parameters}: {counts}"),
        *(("rinsed", each) for each in rinse_words(report)),
        *(("noted", shorten(each)) for each in remarks(report)),
    ]
