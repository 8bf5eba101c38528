"""The tables of a cleaning report's page."""

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from math import isinf

from cleaning.parameters.model import Provenance
from cleaning.parameters.provenance import assumptions_of
from cleaning.report import mean_residue
from cleaning.undersides.gap_result import GapStage
from cleaning.undersides.rinse import film_exchanges
from cleaning.verdicts.cleanliness import Outcome, outcome, stays_wet, unclean_parts
from cleaning.verdicts.results import CleaningReport, Number, Part
from cleaning.verdicts.rules import RULES, VERDICTS
from cleaning.verify import Verified
from reports.pictures.cleaning_pictures import VERDICT_COLOURS
from reports.tables.rule_texts import GRADES, KNOWN_WORDS
from reports.tables.similar_components import Group, Told, group_alike, name_some, tell_one, unclean
from reports.tables.summary import amount, clock

MOST_TOLD = 100
"""Groups of components of which everything is told; the others that are not clean are named."""
_MOST_NAMES = 8
"""In the narrow column; more stand in the wide one."""
_MOST_PACKAGES = 3
_LEAST = 1e-3
"""Below it the digits of a number mean nothing."""


def table(heads: Sequence[str], rows: Iterable[Sequence[str]], kind: str = "") -> str:
    """Lay out a table; cells are HTML already. A head that begins with > has its column flush right."""
    right = [head.startswith(">") for head in heads]
    top = "".join(
        f"<th{_RIGHT * flush}>{escape(head.lstrip('>'))}</th>" for head, flush in zip(heads, right, strict=True)
    )
    body = "".join(
        "<tr>" + "".join(f"<td{_RIGHT * flush}>{cell}</td>" for cell, flush in zip(row, right, strict=True)) + "</tr>"
        for row in rows
    )
    return f'<table class="{kind}"><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>'


_RIGHT = ' class="r"'


def verdict_mark(verdict: Outcome) -> str:
    """Write a verdict with its colour; the word alone says it too."""
    return f'<span class="mark" style="background:{VERDICT_COLOURS[verdict]}"></span>{verdict}'


def number_text(number: Number, highest: Number | None = None) -> str:
    """Write a number with its unit and its limit, or the range from it to the highest."""
    last = highest or number
    limit = "" if number.limit is None or last.limit is None else f" (limit {_range(number.limit, last.limit)})"
    return f"{number.name} {_range(number.value, last.value)} {number.unit}".rstrip() + limit


def _range(low: float, high: float) -> str:
    """Write two numbers as a range, or as one if they read the same."""
    first, last = amount_text(low), amount_text(high)
    return first if first == last else f"{first} to {last}"


def amount_text(value: float) -> str:
    """Write three digits of a number; of next to nothing, that it is that."""
    if 0 < value < _LEAST:
        return f"under {_LEAST:g}"
    if isinf(value):
        return "∞"
    return f"{value:,.0f}" if 1000 <= abs(value) < 1e9 else f"{value:.3g}"


def parts_table(report: CleaningReport) -> str:
    """List the components that are not clean, the worst first, with what decides and what to do.

    Components of which the same is said stand together.
    """
    packages = {component.name: component.package for component in report.board.components}
    groups = group_alike(unclean_parts(report), unclean)
    rows = [_group_row(group, packages) for group in groups[:MOST_TOLD]]
    told = table(("Component", "Verdict", "What decides", "What to do"), rows, "parts") if rows else ""
    others = [escape(name) for group in groups[MOST_TOLD:] for name in group.names]
    if others:
        told += f'<p class="names"><b>Neither are these clean ({len(others)}):</b> {", ".join(others)}.</p>'
    clean = [escape(part.component) for part in report.parts if part.verdict == "clean"]
    if clean:
        words = "clean and dry" if any(map(stays_wet, report.parts)) else "clean"
        told += f'<p class="names"><b>Predicted {words} ({len(clean)}):</b> {", ".join(clean)}.</p>'
    return told


def _group_row(group: Group, packages: Mapping[str, str]) -> tuple[str, str, str, str]:
    first = group.parts[0]
    advice = [f"<div>{escape(text)}</div>" for text in dict.fromkeys(each.advice for each in group.told) if text]
    makers = ", ".join(f"{made_by} {share:.0%}" for made_by, share in first.makers[:2])
    if makers and len(group.parts) == 1:
        advice.append(f'<div class="q">sprayed by {escape(makers)}</div>')
    kinds = list(dict.fromkeys(packages[name] for name in group.names if packages.get(name)))
    names, many = escape(", ".join(group.names)), len(group.parts) > _MOST_NAMES
    return (
        f"<b>{amount(len(group.parts), 'component') if many else names}</b>"
        f'<div class="q">{escape(name_some(kinds, _MOST_PACKAGES))}</div>',
        f'{verdict_mark(outcome(first))}<div class="q">grade {group.told[0].grade}</div>',
        "".join(map(_told, group.told)) + (f'<div class="names">{names}</div>' if many else ""),
        "".join(advice),
    )


def _told(told: Told) -> str:
    numbers = "; ".join(number_text(low, high) for low, high in told.numbers)
    return (
        f"<div><b>{told.rule} {escape(told.name)}</b>, {told.verdict}, {told.grade}: "
        f'{escape(told.because)}</div><div class="q">{escape(numbers)}</div>'
    )


def process_table(report: CleaningReport) -> str:
    """List what holds for the process as a whole, and for the bare board."""
    named = [("process", each) for each in report.process] + [("bare board", each) for each in report.bare.judgements]
    rows = [
        (escape(what), verdict_mark(each.verdict), _told(tell_one(each)), escape(each.advice)) for what, each in named
    ]
    return table(("Of the", "Verdict", "What decides", "What to do"), rows, "parts")


def remarks(report: CleaningReport) -> list[str]:
    """Give what was noticed on the way and is no judgement, such as a liquid that the parameter set does not have."""
    return [
        f"{finding.made_by}: {finding.message}" if finding.made_by else finding.message
        for finding in report.findings
        if not finding.rule.verdict
    ]


def stages_table(report: CleaningReport) -> str:
    """List the stages in order, with what they take."""
    litres = dict(report.litres)
    rows: list[Sequence[str]] = []
    for stage, exposure, bare in zip(report.stages, report.exposures, report.bare.exposed, strict=True):
        landed = exposure.landed_mm3 / exposure.sprayed_mm3 if exposure.sprayed_mm3 > 0 else 0.0
        liquid = litres.pop(stage.function, None)  # litres are known by function: they stand where it comes first
        gets = "" if bare is None or stage.use == "dry" else " / ".join(amount_text(each) for each in bare.volume_mm)
        rows.append((
            escape(stage.function), escape(stage.solution), escape(stage.nozzle_name), f"{stage.pressure_pa / 1e5:.3g}",
            f"{stage.temperature_c:.3g}", clock(stage.end_s - stage.begin_s), clock(stage.spray_s),
            "" if liquid is None else f"{liquid:.2f}", f"{landed:.0%}", gets,
        ))  # fmt: skip
    heads = ("Function", "Solution", "Nozzle", ">bar", ">°C", ">Time", ">Spraying", ">Litres", ">Lands on the board",
             ">Bare board, mm: least / p5 / mean")  # fmt: skip
    return table(heads, rows)


def renewals(report: CleaningReport) -> list[str]:
    """Say of each rinse how often it renews the film on the bare board."""
    told: list[str] = []
    for stage, bare in zip(report.stages, report.bare.exposed, strict=True):
        if stage.use == "rinse" and bare is not None:
            low, mean = (film_exchanges(report.parameters.rinse, volume) for volume in bare.volume_mm[1:])
            told.append(
                f"{stage.made_by}: {stage.function} renews the film on the bare board {amount_text(mean)} times on "
                f"average, in the least wetted twentieth at most {amount_text(low)} times."
            )
    return told


def gap_table(report: CleaningReport, part: Part) -> str:
    """Tell the numbers of each case of a gap, stage by stage."""
    rows: list[Sequence[str]] = []
    for gap in part.gaps:
        for stage, result in zip(report.stages, gap.stages, strict=True):
            if result is not None:
                needed = gap.exchanges_needed if stage.use == "wash" else report.parameters.limits.exchanges
                rows.append(
                    (
                        f"{1000 * gap.gap_height_mm:.0f}",
                        escape(stage.function),
                        *_gap_cells(result, needed, mean_residue(result, gap.field)),
                    )
                )
    heads = (">Gap, µm", "Stage", "Entered", ">Margin, Pa", ">Renewals", ">needed", ">Weak area", ">Residue left",
             ">Wet for")  # fmt: skip
    return table(heads, rows)


def _gap_cells(result: GapStage, needed: float, left: float) -> tuple[str, ...]:
    return (
        "yes" if result.entered else "no",
        amount_text(result.margin_pa),
        amount_text(result.exchanges),
        amount_text(needed),
        f"{result.weak_share:.0%}",
        f"{amount_text(100 * left)}%",
        clock(result.wet_s),
    )


def verified_table(verified: Sequence[Verified]) -> str:
    """Compare what rays gave for chosen components with the exact sum; nothing where none was chosen."""
    rows = [
        (
            escape(each.component), escape(each.function), amount_text(each.rays_mm), amount_text(each.exact_mm),
            difference_text(each), amount_text(each.worst_mm),
        )
        for each in verified
    ]  # fmt: skip
    heads = ("Component", "Stage", ">Rays, mm", ">Exact, mm", ">Difference", ">Worst cell, mm")
    return table(heads, rows) if rows else ""


def difference_text(verified: Verified) -> str:
    """Write by how much rays are off from the exact sum."""
    off = (verified.rays_mm - verified.exact_mm) / verified.exact_mm if verified.exact_mm > 0 else 0.0
    return f"{off:+.1%}"


def rules_table(report: CleaningReport) -> str:
    """List all rules with what each found."""
    judged = [each for part in (report.bare, *report.parts) for each in part.judgements] + list(report.process)
    rows: list[Sequence[str]] = []
    for rule in RULES:
        of_rule = [each.verdict for each in judged if each.rule == rule]
        tally = ", ".join(f"{of_rule.count(verdict)} {verdict}" for verdict in VERDICTS if verdict in of_rule)
        rows.append((rule.id, escape(rule.meaning), rule.grade, tally or '<span class="q">nothing to say</span>'))
    grades = "; ".join(f"{grade}: {escape(words)}" for grade, words in GRADES.items())
    return table(("Rule", "Says that", "Grade", "Found"), rows) + f'<p class="q">Grades. {grades}.</p>'


def assumptions_table(report: CleaningReport) -> str:
    """List every value that the model was told, and where it comes from."""
    rows = [
        (
            f"<code>{escape(each.path)}</code>",
            escape(each.value),
            KNOWN_WORDS[each.known],
            escape(_source(each.provenance)),
        )
        for each in assumptions_of(report.parameters)
    ]
    return table(("Parameter", "Value", "Known how", "From"), rows, "small")


def _source(entry: Provenance) -> str:
    """Write where a value comes from; of what was fitted also how well."""
    told = f"{entry.source} ({entry.date})" if entry.date else entry.source
    if entry.samples is not None:
        told += f"; {amount(entry.samples, 'sample')}"
    if entry.rms is not None:
        told += f", rms {entry.rms:.3g}"
    return told if entry.interval is None else f"{told}, 95 % {entry.interval[0]:.4g} to {entry.interval[1]:.4g}"
