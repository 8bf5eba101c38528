"""What a program cleans, as a person wants to read it in a terminal."""

from collections.abc import Sequence

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from cleaning.parameters.provenance import assumptions_of
from cleaning.verdicts.cleanliness import Outcome, count_cleanliness, outcome, report_outcome, unclean_parts
from cleaning.verdicts.results import CleaningReport
from cleaning.verify import Verified
from reports.html.cleaning_page import headline, honesty, wet_count, wet_words
from reports.html.cleaning_tables import amount_text, difference_text, number_text, remarks
from reports.tables.comparison import Row
from reports.tables.report_header import Made
from reports.tables.similar_components import Group, Told, deciding, group_alike, name_some, tell_one
from reports.tables.summary import amount, clock, print_facts, shorten

_MOST_GROUPS = 12
_MOST_NAMES = 12
_STYLES: dict[Outcome, str] = {
    "dirty": "bold red", "marginal": "yellow", "clean, wet": "cyan", "no verdict": "dim", "clean": "green",
}  # fmt: skip


def print_cleaning(console: Console, report: CleaningReport, made: Made) -> None:
    """Headline and what it is worth, the stages, the worst components, what is wrong with the process; by what."""
    origin = report.origin
    console.print(
        f"[bold]{escape(origin.board)}[/bold] with [bold]{escape(origin.recipe)}[/bold]. "
        f"[{_STYLES[report_outcome(report)]}]{escape(headline(report))}[/]"
    )
    console.print(escape(honesty(report)), style="dim")
    console.print(_stages(report))
    groups = group_alike(unclean_parts(report), deciding)
    if groups:
        console.print(_parts(groups[:_MOST_GROUPS]))
    more = sum(len(group.parts) for group in groups[_MOST_GROUPS:])
    if more:
        console.print(f"and {amount(more, 'more component')}; --html and --json have all of them")
    for name, each in [("process", each) for each in report.process] + [
        ("bare board", each) for each in report.bare.judgements
    ]:
        if each.verdict != "clean":
            console.print(f"[{_STYLES[each.verdict]}]{each.verdict}[/]  {name}: {escape(_because(tell_one(each)))}")
    print_facts(console, [*_facts(report), ("analysed", f"by {made}")])


def print_verified(console: Console, verified: Sequence[Verified]) -> None:
    """What rays gave for chosen components, and what the exact sum gives."""
    table = _table("component", "stage", ">rays, mm", ">exact, mm", ">difference", ">worst cell, mm")
    for each in verified:
        table.add_row(
            escape(each.component), escape(each.function), amount_text(each.rays_mm), amount_text(each.exact_mm),
            difference_text(each), amount_text(each.worst_mm),
        )  # fmt: skip
    console.print(table)


def print_comparison(console: Console, rows: Sequence[Row], report: CleaningReport, names: tuple[str, str]) -> None:
    """What it is worth, and one line for each quantity; what does not differ is dim.

    Args:
        console: Where.
        rows: What is compared.
        report: One of the two.
        names: What they are called.
    """
    console.print(f"[bold]{escape(report.origin.board)}[/bold] with [bold]{escape(' and '.join(names))}[/bold].")
    console.print(escape(honesty(report)), style="dim")
    table = _table("", *(f">{name}" for name in names), ">change")
    group = ""
    for row in rows:
        if row.group != group:
            group = row.group
            table.add_row(f"[bold]{escape(group)}[/bold]", "", "", "")
        table.add_row(
            f"  {escape(row.name)}", escape(row.here), escape(row.there), row.change, style="" if row.differs else "dim"
        )
    console.print(table)


def _stages(report: CleaningReport) -> Table:
    litres = dict(report.litres)
    table = _table("function", "solution", "nozzle", ">bar", ">°C", ">time", ">spraying", ">litres", ">lands")
    for stage, exposure in zip(report.stages, report.exposures, strict=True):
        liquid = litres.pop(stage.function, None)  # litres are known by function: they stand where it comes first
        landed = exposure.landed_mm3 / exposure.sprayed_mm3 if exposure.sprayed_mm3 > 0 else 0.0
        table.add_row(
            escape(stage.function), escape(stage.solution), escape(stage.nozzle_name), f"{stage.pressure_pa / 1e5:.3g}",
            f"{stage.temperature_c:.3g}", clock(stage.end_s - stage.begin_s), clock(stage.spray_s),
            "" if liquid is None else f"{liquid:.2f}", f"{landed:.0%}",
        )  # fmt: skip
    return table


def _parts(groups: Sequence[Group]) -> Table:
    table = _table("component", "verdict", "grade", "rule", "because", "what to do")
    for group in groups:
        first, told = group.told[0], outcome(group.parts[0])
        table.add_row(
            escape(name_some(group.names, _MOST_NAMES)), f"[{_STYLES[told]}]{told}[/]", first.grade,
            f"{first.rule} {escape(first.name)}", escape(_because(first)), escape(first.advice),
        )  # fmt: skip
    return table


def _because(told: Told) -> str:
    return told.because or "; ".join(number_text(low, high) for low, high in told.numbers)


def _facts(report: CleaningReport) -> list[tuple[str, str]]:
    assumed = assumptions_of(report.parameters)
    known = {
        word: sum(each.known == word for each in assumed) for word in dict.fromkeys(each.known for each in assumed)
    }
    counts, wet = count_cleanliness(report.parts), wet_count(report)
    litres = f"{sum(value for _, value in report.litres):.2f} l" if report.litres else "no liquid"
    return [
        ("components", ", ".join(f"{count} {verdict}" for verdict, count in counts.items()) or "none"),
        *([("wet", f"{wet} {wet_words(wet)}")] if wet else []),
        ("takes", f"{clock(report.duration_s)}, {litres}"),
        ("assumed", f"{len(assumed)} values of {report.parameters.parameters}: "
                    + ", ".join(f"{count} {word}" for word, count in known.items())),
        *(("noted", shorten(each)) for each in remarks(report)),
    ]  # fmt: skip


def _table(*headings: str) -> Table:
    """An unframed table; a heading that begins with > has its column flush right."""
    table = Table(box=None, pad_edge=False, header_style="dim")
    for heading in headings:
        right = heading.startswith(">")
        table.add_column(
            escape(heading.removeprefix(">")), justify="right" if right else "left", no_wrap=right, overflow="fold"
        )
    return table
