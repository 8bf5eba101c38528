"""The card of one part: its judgements, what reaches it in each stage, what limits it, who sprays it."""

from collections.abc import Mapping
from html import escape

from cleaning.process.stages import Stage
from cleaning.verdicts.cleanliness import deciding_judgement, outcome
from cleaning.verdicts.results import CleaningReport, ExposedPart, Part
from reports.tables.wording import shorten
from webui.cards.boxes import box_html
from webui.cards.cleaning_list import judgement_html
from webui.theme.palette import ACCENT, QUIET, to_hex
from webui.theme.verdict_colours import VERDICT_COLOURS, VERDICT_WORDS

_MOST_MAKERS = 6
_HEAD = ("Stage", "Volume", "Front", "Cone", "Peak", "Missed")
_FACTORS = {
    "time": "Time",
    "temperature": "Temperature",
    "chemistry": "Chemistry",
    "pressure": "Pressure",
    "standoff": "Standoff",
}


def stage_names(stages: tuple[Stage, ...]) -> tuple[str, ...]:
    """Name stages by number and function, such as ``1 clean``."""
    return tuple(f"{number} {stage.function}" for number, stage in enumerate(stages, start=1))


def part_html(report: CleaningReport, part: Part) -> str:
    """Say all that was found of one part."""
    names = dict(zip((stage.made_by for stage in report.stages), stage_names(report.stages), strict=True))
    colour, first = to_hex(VERDICT_COLOURS[outcome(part)]), deciding_judgement(part)
    judgements = sorted(part.judgements, key=lambda each: each is not first)
    said = "".join(judgement_html(each, names.get(each.stage, "")) for each in judgements)
    return box_html(
        f'<div style="font-weight:600"><span style="color:{to_hex(ACCENT)}">{escape(part.component)}</span> '
        f'<span style="color:{colour}">{VERDICT_WORDS[outcome(part)]}</span> '
        f'<span style="font-weight:400;color:{to_hex(QUIET)}">grade {first.grade}</span></div>'
        f"{said}{exposed_html(part.exposed, stage_names(report.stages))}{factors_html(part.elasticity, part.limiting)}"
        f"{makers_html(part.makers)}"
    )


def exposed_html(exposed: tuple[ExposedPart | None, ...], names: tuple[str, ...]) -> str:
    """Write what reaches the surface in each stage: 5th percentiles by area, peak pressure, share missed."""
    rows = [_cells(_HEAD, f"color:{to_hex(QUIET)}")]
    for name, part in zip(names, exposed, strict=True):
        rows.append(_cells((name, "other side", "", "", "", "") if part is None else _numbers(name, part), ""))
    return (
        f'{_title("Surface, the least-served 5 %")}<table style="border-collapse:collapse;font-size:11px;width:100%;'
        f'font-variant-numeric:tabular-nums">{"".join(rows)}</table>'
    )


def factors_html(elasticity: Mapping[str, float], limiting: str) -> str:
    """Draw how much less residue is left where a factor is raised by one percent: bars, the longest limits most."""
    if not elasticity:
        return ""
    longest = max(max(abs(value) for value in elasticity.values()), 1e-9)
    bars = "".join(
        _bar(_FACTORS.get(name, name), value, abs(value) / longest, marked=name == limiting)
        for name, value in sorted(elasticity.items(), key=lambda item: -abs(item[1]))
    )
    hint = f'<span style="color:{to_hex(QUIET)};font-weight:400"> residue for 1 % more of it</span>'
    return f"{_title('What limits it', hint)}{bars}"


def makers_html(makers: tuple[tuple[str, float], ...]) -> str:
    """Say who sprays a part, and which share of the volume on it each gives."""
    if not makers:
        return f'{_title("Sprayed by")}<div style="color:{to_hex(QUIET)}">nobody</div>'
    rows = "".join(
        f'<div style="display:flex;justify-content:space-between;gap:8px"><span style="overflow:hidden;'
        f'text-overflow:ellipsis;white-space:nowrap">{escape(shorten(maker))}</span>'
        f"<span>{100 * share:.0f} %</span></div>"
        for maker, share in makers[:_MOST_MAKERS]
    )
    more = len(makers) - _MOST_MAKERS
    rest = f'<div style="color:{to_hex(QUIET)}">and {more} more</div>' if more > 0 else ""
    return f"{_title('Sprayed by')}{rows}{rest}"


def _numbers(name: str, part: ExposedPart) -> tuple[str, ...]:
    return (
        name,
        f"{part.volume_mm[1]:.2f} mm",
        f"{part.front_s[1]:.2f} s",
        f"{part.cone_s[1]:.2f} s",
        f"{part.peak_pa:.0f} Pa",
        f"{100 * part.missed_share:.0f} %",
    )


def _cells(texts: tuple[str, ...], style: str) -> str:
    cells = "".join(
        f'<td style="padding:0 6px 0 0;white-space:nowrap;text-align:{"left" if at == 0 else "right"};{style}">'
        f"{escape(text)}</td>"
        for at, text in enumerate(texts)
    )
    return f"<tr>{cells}</tr>"


def _bar(name: str, value: float, share: float, *, marked: bool) -> str:
    colour = to_hex(ACCENT) if marked else "#b8c2c9"
    weight = "600" if marked else "400"
    return (
        f'<div style="display:flex;align-items:center;gap:6px;font-weight:{weight}">'
        f'<span style="width:86px">{escape(name)}</span>'
        f'<span style="flex:1"><span style="display:block;height:7px;border-radius:2px;background:{colour};'
        f'width:{100 * share:.0f}%"></span></span>'
        f'<span style="width:56px;white-space:nowrap;text-align:right;font-variant-numeric:tabular-nums">'
        f"{value:+.2f} %</span></div>"
    )


def _title(text: str, rest: str = "") -> str:
    return f'<div style="margin-top:7px;font-weight:600">{text}{rest}</div>'
