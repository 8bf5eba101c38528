"""Measured cleanliness against prediction, on the terminal."""

from collections.abc import Sequence

from rich.console import Console

from cleaning.uncertainty.comparison import Comparison
from cleaning.verdicts.results import CleaningReport
from reports.tables.cleaning_tables import caveat
from reports.tables.measured_tables import (
    confusion_table,
    correlation_words,
    escapes_table,
    hit_words,
    recalibration_words,
    rule_checks_table,
    source_words,
)
from reports.terminal.console import print_line, print_table


def print_measured(console: Console, report: CleaningReport, found: Comparison, commands: Sequence[str]) -> None:
    """Print hit rate, confusion, correlations, what each rule was worth, and the offers to calibrate.

    Args:
        console: Where.
        report: The prediction.
        found: Its comparison with measurements.
        commands: For each of the recalibrations; empty where there is none.
    """
    origin = report.origin
    print_line(console, (origin.board, "bold"), " with ", (origin.recipe, "bold"), f". {hit_words(found)}.")
    print_line(console, (source_words(found), "dim"))
    print_line(console, (caveat(report), "dim"))
    print_table(console, confusion_table(found))
    for each in found.correlations:
        print_line(console, correlation_words(each))
    print_table(console, escapes_table(found))
    print_table(console, rule_checks_table(found))
    for offer, command in zip(found.recalibrations, commands, strict=True):
        print_line(console, recalibration_words(offer, command))
