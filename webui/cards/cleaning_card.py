"""The cleaning prediction: the headline, the parts as a table, and the card of one part."""

from collections.abc import Mapping, Sequence
from html import escape

from cleaning.process.stages import Stage
from cleaning.report import to_error
from cleaning.verdicts.cleanliness import count_cleanliness, deciding_judgement, outcome, report_outcome
from cleaning.verdicts.results import CleaningReport, ExposedPart, Judgement, Part
from reports.tables.cleaning_tables import capability_words, caveat, headline, main_cause, sure_words
from reports.tables.table import Column, Table, Text
from reports.tables.wording import clock, shorten
from specs.source import Source
from webui.theme.html import (
    box_html,
    edged_html,
    facts_html,
    grey_html,
    heading_html,
    listing_html,
    more_html,
    quiet_html,
    small_html,
    table_html,
)
from webui.theme.palette import ACCENT, QUIET, TRACK, VERDICT_COLOURS, VERDICT_WORDS, css_colour

_MOST_MAKERS = 6
_HEAD = ("Stage", ">With run-off", ">Front", ">Cone, mean", ">Peak", ">Missed")
_COLUMNS = (
    Column("Part", width="18%"),
    Column("Verdict", width="28%"),
    Column("Because", width="34%"),
    Column("Residue", "right", width="20%"),
)


def stage_names(stages: tuple[Stage, ...]) -> tuple[str, ...]:
    """Names of stages: number and function, such as ``1 clean``."""
    return tuple(f"{number} {stage.function}" for number, stage in enumerate(stages, start=1))


def headline_html(report: CleaningReport, times: str) -> str:
    """The worst verdict, how far it can be relied on, and what the process takes; ``times``: whose they are."""
    colour = css_colour(VERDICT_COLOURS[report_outcome(report)])
    counts = count_cleanliness(report.parts).items()
    facts = {
        "Parts": ", ".join(f"{count} {verdict}" for verdict, count in counts) or "none",
        "Time": f"{clock(report.duration_s)}, {times}",
        "Sprayed": ", ".join(f"{name} {litres:.2f} l" for name, litres in report.litres) or "nothing",
        "Parameters": f"{report.parameters.parameters}, {report.parameters_sha256[:8]}",
    }
    process = "".join(judgement_html(each) for each in report.process if each.verdict != "clean")
    return box_html(
        f'<div style="font-weight:600;font-size:14px;color:{colour}">{headline(report)}</div>'
        f"{small_html(escape(main_cause(report)))}{small_html(escape(caveat(report)))}{facts_html(facts)}{process}"
        f"{small_html(escape(capability_words(report)))}"
    )


def parts_html(parts: Sequence[Part], selected: str) -> str:
    """The parts as a table, the selected one marked."""
    if not parts:
        return quiet_html("The board has no parts.")
    rows = [
        (
            part.component,
            Text(outcome(part), tone=outcome(part)),
            deciding_judgement(part).name,
            "" if part.residue is None else f"{100 * part.residue:.1f} %",
        )
        for part in parts
    ]
    return listing_html(Table(_COLUMNS, tuple(rows)), selected, height="26vh", more="better ones")


def judgement_html(judgement: Judgement, stage: str = "") -> str:
    """One judgement: the sentence, the numbers with their limits, the advice.

    Args:
        judgement: The judgement.
        stage: Name of its stage; empty for one of all stages together.
    """
    colour = css_colour(VERDICT_COLOURS[judgement.verdict])
    numbers = ", ".join(
        f"{each.name} {each.value:.3g}{' ' if each.unit else ''}{each.unit}"
        + ("" if each.limit is None else f" (limit {each.limit:.3g})")
        for each in judgement.numbers
    )
    advice = f'<div style="font-weight:600">{escape(judgement.advice)}</div>' if judgement.advice else ""
    verdict = f'<span style="color:{colour}">{judgement.verdict}</span>, grade {judgement.grade}'
    title = f"{judgement.rule} {escape(judgement.name)}: {verdict}{f', {escape(stage)}' if stage else ''}"
    return edged_html(small_html(title) + escape(judgement.because) + advice + small_html(escape(numbers)), colour)


def part_html(report: CleaningReport, part: Part) -> str:
    """Card of one part: judgements, exposure by stage, limiting factors, strokes that spray it."""
    names = dict(zip((stage.made_by for stage in report.stages), stage_names(report.stages), strict=True))
    colour, first = css_colour(VERDICT_COLOURS[outcome(part)]), deciding_judgement(part)
    judgements = sorted(part.judgements, key=lambda each: each is not first)
    found = "".join(judgement_html(each, names.get(each.stage, "")) for each in judgements)
    sampled = () if report.capability is None else report.capability.parts
    sure = [sure_words(each) for each in sampled if each.component == part.component]
    found += "".join(small_html(escape(f"{words[:1].upper()}{words[1:]}.")) for words in sure)
    return box_html(
        f'<div style="font-weight:600"><span style="color:{css_colour(ACCENT)}">{escape(part.component)}</span> '
        f'<span style="color:{colour}">{VERDICT_WORDS[outcome(part)]}</span> '
        f'<span style="font-weight:400;color:{css_colour(QUIET)}">grade {first.grade}</span></div>'
        f"{found}{exposed_html(part.exposed, stage_names(report.stages))}{factors_html(part.elasticity, part.limiting)}"
        f"{makers_html(part.makers)}"
    )


def exposed_html(exposed: tuple[ExposedPart | None, ...], names: tuple[str, ...]) -> str:
    """Exposure of the surface by stage: its least served places, peak pressure, share missed."""
    rows = [
        (name, "other side", "", "", "", "")
        if part is None
        else (
            name,
            f"{part.supply_mm[1]:.2f} mm",
            f"{part.front_s[1]:.2f} s",
            f"{to_error(part.cone_s[2], part.cone_error_s):g} ± {to_error(part.cone_error_s, part.cone_error_s):g} s",
            f"{part.peak_pa:.0f} Pa",
            f"{100 * part.missed_share:.0f} %",
        )
        for name, part in zip(names, exposed, strict=True)
    ]
    inner = table_html(Table.of(_HEAD, rows))  # wider than the panel: it scrolls by itself, also by the keyboard
    table = f'<div tabindex="0" style="font-size:11px;white-space:nowrap;overflow-x:auto">{inner}</div>'
    return heading_html("Surface, the least-served places") + table


def factors_html(elasticity: Mapping[str, float], limiting: str) -> str:
    """Bars of the change of residue for one percent more of each factor; the longest limits most."""
    if not elasticity:
        return ""
    longest = max(max(abs(value) for value in elasticity.values()), 1e-9)
    bars = "".join(
        _bar(name.capitalize(), value, abs(value) / longest, marked=name == limiting)
        for name, value in sorted(elasticity.items(), key=lambda item: -abs(item[1]))
    )
    hint = f'<span style="color:{css_colour(QUIET)};font-weight:400"> residue for 1 % more of it</span>'
    return heading_html("What limits it", hint) + bars


def makers_html(makers: tuple[tuple[Source, float], ...]) -> str:
    """Strokes that spray a part, each with its share of the volume on it."""
    rows = "".join(
        f'<div style="display:flex;justify-content:space-between;gap:8px"><span style="overflow:hidden;'
        f'text-overflow:ellipsis;white-space:nowrap">{escape(shorten(str(maker)))}</span>'
        f"<span>{100 * share:.0f} %</span></div>"
        for maker, share in makers[:_MOST_MAKERS]
    )
    return heading_html("Sprayed by") + (rows or grey_html("nothing")) + more_html(len(makers) - _MOST_MAKERS)


def _bar(name: str, value: float, share: float, *, marked: bool) -> str:
    colour, weight = (css_colour(ACCENT), "600") if marked else (TRACK, "400")
    return (
        f'<div style="display:flex;align-items:center;gap:6px;font-weight:{weight}">'
        f'<span style="width:86px">{escape(name)}</span>'
        f'<span style="flex:1"><span style="display:block;height:7px;border-radius:2px;background:{colour};'
        f'width:{100 * share:.0f}%"></span></span>'
        f'<span style="width:56px;white-space:nowrap;text-align:right;font-variant-numeric:tabular-nums">'
        f"{value:+.2f} %</span></div>"
    )
