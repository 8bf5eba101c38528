"""The tables of a cleaning report's page."""

from collections.abc import Iterable, Sequence
from html import escape

from cleaning.assumptions import assumptions_of
from cleaning.report import mean_residue
from cleaning.results import VERDICTS, CleaningReport, Judgement, Number, Part, Verdict
from cleaning.under import GapStage
from rulesengine.cleaning_pictures import VERDICT_COLOURS
from rulesengine.cleaning_words import GRADES, KNOWN_WORDS, RULES
from rulesengine.summary import amount, clock

MOST_TOLD = 40
"""Components of which everything is told; the others that are not clean get a line each."""
MOST_LINES = 400
"""Such lines; the data has all of them."""


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


def verdict_mark(verdict: Verdict) -> str:
    """Write a verdict with its colour; the word alone says it too."""
    return f'<span class="mark" style="background:{VERDICT_COLOURS[verdict]}"></span>{verdict}'


def number_text(number: Number) -> str:
    """Write a number with its unit and its limit."""
    limit = "" if number.limit is None else f" (limit {amount_text(number.limit)})"
    return f"{number.name} {amount_text(number.value)} {number.unit}".rstrip() + limit


def amount_text(value: float) -> str:
    """Write three digits of a number."""
    return f"{value:,.0f}" if 1000 <= abs(value) < 1e9 else f"{value:.3g}"


def parts_table(report: CleaningReport) -> str:
    """List the components that are not clean, the worst first, with what decides and what to do."""
    packages = {component.name: component.package for component in report.board.components}
    found = [part for part in report.worst_first() if part.verdict != "clean"]
    rows = [_part_row(part, packages.get(part.component, "")) for part in found[:MOST_TOLD]]
    lines = [_part_line(part) for part in found[MOST_TOLD : MOST_TOLD + MOST_LINES]]
    clean = [escape(part.component) for part in report.parts if part.verdict == "clean"]
    told = table(("Component", "Verdict", "What decides", "What to do"), rows, "parts") if rows else ""
    if lines:
        told += "<h3>And in short</h3>" + table(("Component", "Verdict", "Rules", ">Residue under it"), lines, "small")
    if len(found) > MOST_TOLD + MOST_LINES:
        left = amount(len(found) - MOST_TOLD - MOST_LINES, "more component")
        told += f"<p>and {left}: the data of this report has all of them.</p>"
    if clean:
        told += f'<p class="names"><b>Predicted clean ({len(clean)}):</b> {", ".join(clean)}.</p>'
    return told


def _part_row(part: Part, package: str) -> tuple[str, str, str, str]:
    shown = [each for each in part.judgements if each.verdict != "clean"] or list(part.judgements[:1])
    makers = ", ".join(f"{made_by} {share:.0%}" for made_by, share in part.makers[:2])
    advice = [f"<div>{escape(text)}</div>" for text in dict.fromkeys(each.advice for each in shown) if text]
    if makers:
        advice.append(f'<div class="q">sprayed by {escape(makers)}</div>')
    return (
        f'<b>{escape(part.component)}</b><div class="q">{escape(package)}</div>',
        f'{verdict_mark(part.verdict)}<div class="q">grade {part.grade}</div>',
        "".join(map(_told, shown)),
        "".join(advice),
    )


def _part_line(part: Part) -> tuple[str, str, str, str]:
    rules = dict.fromkeys(f"{each.rule} {each.name}" for each in part.judgements if each.verdict != "clean")
    residue = "" if part.residue is None else f"{part.residue:.1%}"
    return escape(part.component), verdict_mark(part.verdict), escape(", ".join(rules)), residue


def _told(judgement: Judgement) -> str:
    numbers = "; ".join(map(number_text, judgement.numbers))
    return (
        f"<div><b>{judgement.rule} {escape(judgement.name)}</b>, {judgement.verdict}, {judgement.grade}: "
        f'{escape(judgement.because)}</div><div class="q">{escape(numbers)}</div>'
    )


def process_table(report: CleaningReport) -> str:
    """List what holds for the process as a whole, and for the bare board."""
    named = [("process", each) for each in report.process] + [("bare board", each) for each in report.bare.judgements]
    rows = [(escape(what), verdict_mark(each.verdict), _told(each), escape(each.advice)) for what, each in named]
    return table(("Of the", "Verdict", "What decides", "What to do"), rows, "parts")


def remarks(report: CleaningReport) -> list[str]:
    """Give what was noticed on the way and is no judgement, such as a liquid that the parameter set does not have."""
    rules = {f"{each.name.lower()}-" for each in RULES}
    return [
        f"{finding.made_by}: {finding.message}" if finding.made_by else finding.message
        for finding in report.findings
        if not any(finding.rule.startswith(rule) for rule in rules)
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


def gap_table(report: CleaningReport, part: Part) -> str:
    """Tell the numbers of each case of a gap, stage by stage."""
    rows: list[Sequence[str]] = []
    for gap in part.gaps:
        for stage, result in zip(report.stages, gap.stages, strict=True):
            if result is not None:
                needed = gap.exchanges_needed if stage.use == "wash" else report.parameters.limits.exchanges
                rows.append(
                    (
                        f"{1000 * gap.standoff_mm:.0f}",
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
        f"{left:.1%}",
        clock(result.wet_s),
    )


def rules_table(report: CleaningReport) -> str:
    """List all rules with what each found."""
    judged = [each for part in (report.bare, *report.parts) for each in part.judgements] + list(report.process)
    rows: list[Sequence[str]] = []
    for rule in RULES:
        of_rule = [each.verdict for each in judged if each.rule == rule.name]
        tally = ", ".join(f"{of_rule.count(verdict)} {verdict}" for verdict in VERDICTS if verdict in of_rule)
        rows.append((rule.name, escape(rule.when), rule.grade, tally or '<span class="q">nothing to say</span>'))
    grades = "; ".join(f"{grade}: {escape(words)}" for grade, words in GRADES.items())
    return table(("Rule", "Says that", "Grade", "Found"), rows) + f'<p class="q">Grades. {grades}.</p>'


def assumptions_table(report: CleaningReport) -> str:
    """List every value that the model was told, and where it comes from."""
    rows = [
        (
            f"<code>{escape(each.path)}</code>",
            escape(each.value),
            KNOWN_WORDS[each.known],
            escape(_source(each.provenance.source, each.provenance.date)),
        )
        for each in assumptions_of(report.parameters)
    ]
    return table(("Parameter", "Value", "Known how", "From"), rows, "small")


def _source(source: str, date: str) -> str:
    return f"{source} ({date})" if date else source
