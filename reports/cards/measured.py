"""Measured cleanliness against prediction; a washing bath over many boards, and the rinse tanks behind it."""

from collections.abc import Sequence

from cleaning.uncertainty.bath import Bath, BoardInBath
from cleaning.uncertainty.comparison import Comparison, Confusion, RankCorrelation, Recalibration
from cleaning.undersides.rinse import ionic_ug_cm2
from cleaning.verdicts.results import CleaningReport, report_outcome
from reports.tables.cleaning_tables import caveat, count_words
from reports.tables.table import Block, Card, Cell, FactList, Table, Text, program_title
from reports.tables.wording import amount, name_some, short_number

_MOST_NAMES = 6
_RULE_CHECKS = ("rule", ">fault, right", ">fault, wrong", ">clean, right", ">clean, wrong", "wrong for")
_TOO_FEW = 10
"""Pairs below which a correlation is called weak evidence."""


def measured_card(report: CleaningReport, found: Comparison, commands: Sequence[str]) -> Card:
    """Show hit rate, confusion, correlations, what each rule was worth, and the offers to calibrate.

    Args:
        report: The prediction.
        found: Its comparison with measurements.
        commands: For each of the recalibrations; empty where there is none.
    """
    return Card(
        program_title(report.origin, f". {hit_words(found)}."),
        (Text(source_words(found), "quiet"), Text(caveat(report), "quiet"), *measured_blocks(found, commands)),
    )


def measured_blocks(found: Comparison, commands: Sequence[str]) -> tuple[Block, ...]:
    """Give confusion, correlations, what each rule was worth, and the offers to calibrate."""
    counted = [("all methods", found.confusion)]
    counted += [(f"{method.name}: {method.meaning}", each) for method, each in found.by_method]
    outcomes = (">clean, passed", ">clean, failed", ">not clean, passed", ">not clean, failed", ">hit rate")
    checks: list[tuple[str, ...]] = []
    for each in found.rules:
        lists = (each.faults_right, each.faults_wrong, each.clean_right, each.clean_wrong)
        mistaken = name_some((*each.faults_wrong, *each.clean_wrong), _MOST_NAMES)
        checks.append((f"{each.rule.id} {each.rule.title}", *(f"{len(names)}" for names in lists), mistaken))
    wrong = {
        "predicted clean, measured not clean": found.confusion.clean_beyond,
        "predicted not clean, measured clean": found.confusion.unclean_within,
    }
    return (
        Table.of(("measured by", *outcomes), [(name, *_counts(each)) for name, each in counted]),
        *map(_correlation_words, found.correlations),
        Table.of(("wrong", "components"), [(what, ", ".join(names)) for what, names in wrong.items() if names]),
        Table.of(_RULE_CHECKS, checks),
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


def _correlation_words(found: RankCorrelation) -> str:
    """Rank correlation of one method in words."""
    name = f"predicted residue and {found.method.name}"
    if found.rho is None or found.p_value is None:
        return f"{name}: no rank correlation from {amount(found.pairs, 'pair')}, or figures that never change"
    few = ", which is little evidence" if found.pairs < _TOO_FEW else ""
    return (
        f"{name}: Spearman {found.rho:+z.2f} over {amount(found.pairs, 'component')}, "
        f"p {short_number(found.p_value)}{few}"
    )


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


_HEAD = (">board", ">residue in the bath", ">refractometer reads", "verdict", "components", ">worst residue")


def bath_card(bath: Bath, liquid: str, limit_pct: float, boards: Sequence[BoardInBath]) -> Card:
    """Show what a board brings and takes along, when the bath is spent, and the boards that were analysed."""
    report = boards[0].report
    water = report.rinse_water
    brought, taken = short_number(1e3 * bath.flux_g), short_number(bath.drag_out_ml)
    balance = f"brings {brought} mg of flux, takes {taken} ml of the bath along, which fresh solution makes up"
    begins = "" if bath.begin_pct is None else f"begins with {bath.begin_pct:g} % residue; "
    facts = [("each board", balance), ("bath", begins + change_words(bath, limit_pct))]
    if water is not None:
        least, last = report.parameters.limits.rinse_warn_mohm, water.cascade.solutions[-1]
        after = water.cascade.boards_until(least, *bath.carried_g_m3)
        falls = "never falls" if after is None else "falls"
        when = "" if after is None else f" after {amount(after, 'board')}"
        facts.append(("rinse", f"{last} {falls} below {least:g} MΩ·cm{when}"))
    concentration = report.parameters.liquids[liquid].concentration_pct
    tanks = [] if water is None else [f">{solution}, MΩ·cm" for solution in water.cascade.solutions]
    return Card(
        program_title(report.origin, f" in a bath of {bath.volume_l:g} l of {liquid}"),
        (
            Text(caveat(report), "quiet"),
            FactList(facts),
            Table.of((*_HEAD, *tanks), [_row(each, concentration) for each in boards]),
        ),
    )


def change_words(bath: Bath, limit_pct: float) -> str:
    """When the bath is to be changed, and by which limit."""
    limit = f"{limit_pct:g} % non-volatile residue"
    boards = bath.boards_until(limit_pct)
    if boards is None:
        return f"never reaches {limit}: it settles at {bath.settles_pct:.2g} %"
    return f"change it after {amount(boards, 'board')}, for {limit}"


def _row(washed: BoardInBath, concentration_pct: float) -> tuple[Cell, ...]:
    report, water = washed.report, washed.report.rinse_water
    outcome = report_outcome(report)
    worst = max((part.residue for part in report.parts if part.residue is not None), default=None)
    return (
        f"{washed.number:,}",
        f"{washed.residue_pct:.2f} %",
        f"{concentration_pct + washed.residue_pct:.1f} %",  # it takes what is dissolved for agent
        Text(outcome, tone=outcome),
        count_words(report.parts),
        "" if worst is None else f"{100.0 * worst:.2g} %",
        *(short_number(tank.resistivity_mohm_cm) for tank in ([] if water is None else water.tanks)),
    )


_TANKS = ("rinse tank", ">litres", ">salt in its water, g/m³", ">MΩ·cm", ">exchanged on a board",
          ">left by its film, µg/cm²")  # fmt: skip


def rinse_words(report: CleaningReport) -> list[str]:
    """What boards carry from tank to tank, in a sentence; none where there are no tanks."""
    water = report.rinse_water
    if water is None:
        return []
    cascade = water.cascade
    feed = "overflows from the last tank to the first" if cascade.counter_current else "enters each tank"
    tanks = ", ".join(
        f"{tank.solution} has {short_number(tank.resistivity_mohm_cm)} MΩ·cm ({short_number(tank.content_g_m3)} g/m³)"
        for tank in water.tanks
    )
    return [
        f"Rinse tanks: {tanks}. Each board carries {short_number(1e6 * cascade.carried_m3)} ml from the bath into the "
        f"first and on from tank to tank; {short_number(1e3 * cascade.fresh_m3)} l of fresh water for it {feed}."
    ]


def rinse_table(report: CleaningReport) -> Table:
    """Tanks in the order in which boards pass them; without rows where there are none."""
    film_um = report.parameters.rinse.final_film_um
    rows: list[tuple[str, ...]] = []
    for tank in [] if report.rinse_water is None else report.rinse_water.tanks:
        left = ionic_ug_cm2(tank.on_board_g_m3, film_um)
        numbers = (1e3 * tank.volume_m3, tank.content_g_m3, tank.resistivity_mohm_cm)
        exchanged = f"{100.0 * (1.0 - tank.kept):.3g} %"
        rows.append((tank.solution, *map(short_number, numbers), exchanged, short_number(left)))
    return Table.of(_TANKS, rows)
