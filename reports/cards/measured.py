"""Measured cleanliness against prediction."""

from collections.abc import Sequence

from cleaning.uncertainty.comparison import Comparison, Confusion, RankCorrelation, Recalibration
from cleaning.verdicts.results import CleaningReport
from reports.tables.cleaning_tables import caveat
from reports.tables.table import Block, Card, Table, Text
from reports.tables.wording import amount, name_some, short_number

_MOST_NAMES = 6
_TOO_FEW = 10
"""Pairs below which a correlation is called weak evidence."""


def measured_card(report: CleaningReport, found: Comparison, commands: Sequence[str]) -> Card:
    """Show hit rate, confusion, correlations, what each rule was worth, and the offers to calibrate.

    Args:
        report: The prediction.
        found: Its comparison with measurements.
        commands: For each of the recalibrations; empty where there is none.
    """
    origin = report.origin
    return Card(
        (Text(origin.board, "strong"), " with ", Text(origin.recipe, "strong"), f". {hit_words(found)}."),
        (Text(source_words(found), "quiet"), Text(caveat(report), "quiet"), *measured_blocks(found, commands)),
    )


def measured_blocks(found: Comparison, commands: Sequence[str]) -> tuple[Block, ...]:
    """Give confusion, correlations, what each rule was worth, and the offers to calibrate."""
    return (
        _confusion(found),
        *map(_correlation_words, found.correlations),
        _escapes(found),
        _rule_checks(found),
        *(_recalibration_words(*each) for each in zip(found.recalibrations, commands, strict=True)),
    )


def hit_words(found: Comparison) -> str:
    """One sentence: how many components were predicted as they were measured."""
    confusion = found.confusion
    if confusion.hit_rate is None:
        return "No component has both a verdict and a measurement"
    return (
        f"{confusion.right} of {amount(confusion.count, 'measured component')} predicted as measured "
        f"({100 * confusion.hit_rate:.0f} %)"
    )


def source_words(found: Comparison) -> str:
    """Where the measurements come from, and what of them is not compared."""
    table = found.table
    words = f"{table.file}, sha256 {table.sha256[:16]}: {amount(len(table.rows), 'row')}"
    if found.without_verdict:
        words += f"; without a verdict: {', '.join(found.without_verdict)}"
    words += f"; {amount(found.not_measured, 'component')} not measured"
    return words + ("; SYNTHETIC: made up, it proves nothing about a line" if table.synthetic else "")


def _confusion(found: Comparison) -> Table:
    """Count what was predicted against what was measured, by all methods together and by each."""
    rows = [("all methods", *_counts(found.confusion))]
    rows += [(f"{method.name}: {method.meaning}", *_counts(each)) for method, each in found.by_method]
    headings = (">clean, passed", ">clean, failed", ">not clean, passed", ">not clean, failed", ">hit rate")
    return Table.of(("measured by", *headings), rows)


def _escapes(found: Comparison) -> Table:
    """Name the components that were predicted otherwise than they were measured."""
    rows = [
        (what, ", ".join(names))
        for what, names in (
            ("predicted clean, measured not clean", found.confusion.clean_beyond),
            ("predicted not clean, measured clean", found.confusion.unclean_within),
        )
        if names
    ]
    return Table.of(("wrong", "components"), rows)


def _correlation_words(found: RankCorrelation) -> str:
    """Rank correlation of one method in words."""
    name = f"predicted residue and {found.method.name}"
    if found.rho is None or found.p_value is None:
        return f"{name}: no rank correlation from {amount(found.pairs, 'pair')}, or figures that never change"
    few = ", which is little evidence" if found.pairs < _TOO_FEW else ""
    return (
        f"{name}: Spearman {found.rho:+.2f} over {amount(found.pairs, 'component')}, "
        f"p {short_number(found.p_value)}{few}"
    )


def _rule_checks(found: Comparison) -> Table:
    """List rules with how often each was right, and the components of which it was wrong."""
    rows = [
        (
            f"{each.rule.id} {each.rule.title}",
            f"{len(each.faults_right)}",
            f"{len(each.faults_wrong)}",
            f"{len(each.clean_right)}",
            f"{len(each.clean_wrong)}",
            name_some((*each.faults_wrong, *each.clean_wrong), _MOST_NAMES),
        )
        for each in found.rules
    ]
    headings = ("rule", ">fault, right", ">fault, wrong", ">clean, right", ">clean, wrong", "wrong for")
    return Table.of(headings, rows)


def _recalibration_words(offer: Recalibration, command: str) -> str:
    """What the errors of a rule point to, and the command that fits it."""
    errors = f"{amount(offer.too_strict, 'false alarm')} and {amount(offer.too_lenient, 'escape')}"
    kind = "strict" if offer.too_strict > offer.too_lenient else "lenient"
    words = f"{offer.rule.id} {offer.rule.title} is too {kind} ({errors})"
    if offer.values:
        words += f": {' or '.join(offer.values)} is too {'low' if offer.raise_values else 'high'}"
    if command:
        return f"{words}. With measurements of your own: {command}"
    return f"{words}. No calibration fits it: measure it, and state it in a parameter set"


def _counts(confusion: Confusion) -> tuple[str, ...]:
    each = (confusion.clean_within, confusion.clean_beyond, confusion.unclean_within, confusion.unclean_beyond)
    rate = "" if confusion.hit_rate is None else f"{100 * confusion.hit_rate:.0f} %"
    return (*(f"{len(names)}" for names in each), rate)
