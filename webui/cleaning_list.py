"""What the page says of a cleaning report at one glance: the headline, and the parts, worst first."""

from collections.abc import Sequence
from html import escape

from cleaning.cleanliness import count_cleanliness, outcome
from cleaning.results import CleaningReport, Judgement, Part
from rulesengine.cleaning_page import headline, honesty
from rulesengine.summary import clock
from webui.boxes import box_html, quiet_html
from webui.component_card import facts_html
from webui.palette import ACCENT, INK, QUIET, to_hex
from webui.verdict_colours import VERDICT_COLOURS

MOST_ROWS = 200
_CELL = "padding:1px 8px 1px 0;white-space:nowrap;overflow:hidden;text-overflow:ellipsis"
_HEADINGS = (("Part", "left"), ("Verdict", "left"), ("Because", "left"), ("Residue", "right"))
_WIDTHS = ("18%", "28%", "34%", "20%")


def headline_html(report: CleaningReport) -> str:
    """Say what the worst is, how far that can be trusted, and what the process takes."""
    colour = VERDICT_COLOURS[report.verdict]
    facts = {
        "Parts": counts_text(report.parts),
        "Time": clock(report.duration_s),
        "Sprayed": ", ".join(f"{name} {litres:.2f} l" for name, litres in report.litres) or "nothing",
        "Parameters": f"{report.parameters.parameters}, {report.parameters_sha256[:8]}",
    }
    process = "".join(judgement_html(each) for each in report.process if each.verdict != "clean")
    return box_html(
        f'<div style="font-weight:600;font-size:14px;color:{to_hex(colour)}">{headline(report)}</div>'
        f'<div style="color:{to_hex(QUIET)};font-size:11px;margin-bottom:3px">{escape(honesty(report))}</div>'
        f"{facts_html(facts.items())}{process}"
    )


def counts_text(parts: Sequence[Part]) -> str:
    """Count verdicts on cleanliness, such as ``1 dirty, 2 clean``."""
    return ", ".join(f"{count} {verdict}" for verdict, count in count_cleanliness(parts).items()) or "none"


def parts_html(parts: Sequence[Part], selected: str) -> str:
    """Write parts as a table, the selected one marked; a long one says how many more there are."""
    if not parts:
        return quiet_html("The board has no parts.")
    head = "".join(
        f'<th style="{_CELL};color:{to_hex(QUIET)};text-align:{side};font-weight:400;width:{width}">{name}</th>'
        for (name, side), width in zip(_HEADINGS, _WIDTHS, strict=True)
    )
    body = "".join(_row(part, marked=part.component == selected) for part in parts[:MOST_ROWS])
    more = len(parts) - MOST_ROWS
    return (
        '<div style="max-height:26vh;overflow-y:auto;margin:0 12px">'
        f'<table style="border-collapse:collapse;table-layout:fixed;width:100%;font-size:12px;color:{to_hex(INK)}">'
        f"<tr>{head}</tr>{body}</table></div>" + (quiet_html(f"and {more} better ones") if more > 0 else "")
    )


def judgement_html(judgement: Judgement, stage: str = "") -> str:
    """Write what one rule says: the sentence, the numbers with their limits, what to do.

    Args:
        judgement: What to write.
        stage: How the stage is called in which it was seen; empty for all together.
    """
    colour = to_hex(VERDICT_COLOURS[judgement.verdict])
    seen = f", {escape(stage)}" if stage else ""
    numbers = ", ".join(_number(each.name, each.value, each.unit, each.limit) for each in judgement.numbers)
    advice = f'<div style="font-weight:600">{escape(judgement.advice)}</div>' if judgement.advice else ""
    return (
        f'<div style="margin-top:5px;padding-left:7px;border-left:3px solid {colour};overflow-wrap:anywhere">'
        f'<div style="color:{to_hex(QUIET)};font-size:11px">{escape(judgement.rule)} {escape(judgement.name)}: '
        f'<span style="color:{colour}">{judgement.verdict}</span>, grade {judgement.grade}{seen}</div>'
        f"{escape(judgement.because)}{advice}"
        f'<div style="color:{to_hex(QUIET)};font-size:11px">{escape(numbers)}</div></div>'
    )


def _number(name: str, value: float, unit: str, limit: float | None) -> str:
    against = "" if limit is None else f" (limit {limit:.3g})"
    return f"{name} {value:.3g}{' ' if unit else ''}{unit}{against}"


def _row(part: Part, *, marked: bool) -> str:
    residue = "" if part.residue is None else f"{100 * part.residue:.1f} %"
    told = outcome(part)
    texts = (part.component, told, part.judgements[0].name, residue)
    dot = f'<span style="color:{to_hex(VERDICT_COLOURS[told])}">\N{BLACK CIRCLE}</span> '
    lead = ("", dot, "", "")
    styles = ("", "", "", "text-align:right;font-variant-numeric:tabular-nums")
    cells = "".join(
        f'<td style="{_CELL};{style}" title="{escape(text)}">{mark}{escape(text)}</td>'
        for text, style, mark in zip(texts, styles, lead, strict=True)
    )
    ground = f' style="background:#fbf1ee;box-shadow:inset 3px 0 0 {to_hex(ACCENT)}"' if marked else ""
    return f"<tr{ground}>{cells}</tr>"
