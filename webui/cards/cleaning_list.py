"""What the page says of a cleaning report at one glance: the headline, and the parts, worst first."""

from collections.abc import Sequence
from html import escape

from cleaning.verdicts.cleanliness import count_cleanliness, deciding_judgement, outcome, report_outcome
from cleaning.verdicts.results import CleaningReport, Judgement, Part
from reports.tables.cleaning_tables import caveat, headline
from reports.tables.table import Column, Table, Text
from reports.tables.wording import clock
from webui.cards.boxes import box_html, quiet_html
from webui.cards.component_card import facts_html
from webui.cards.table import listing_html
from webui.theme.palette import QUIET, to_hex
from webui.theme.verdict_colours import VERDICT_COLOURS

_COLUMNS = (
    Column("Part", width="18%"),
    Column("Verdict", width="28%"),
    Column("Because", width="34%"),
    Column("Residue", "right", width="20%"),
)


def headline_html(report: CleaningReport) -> str:
    """Say what the worst is, how far that can be trusted, and what the process takes."""
    colour = VERDICT_COLOURS[report_outcome(report)]
    facts = {
        "Parts": counts_text(report.parts),
        "Time": clock(report.duration_s),
        "Sprayed": ", ".join(f"{name} {litres:.2f} l" for name, litres in report.litres) or "nothing",
        "Parameters": f"{report.parameters.parameters}, {report.parameters_sha256[:8]}",
    }
    process = "".join(judgement_html(each) for each in report.process if each.verdict != "clean")
    return box_html(
        f'<div style="font-weight:600;font-size:14px;color:{to_hex(colour)}">{headline(report)}</div>'
        f'<div style="color:{to_hex(QUIET)};font-size:11px;margin-bottom:3px">{escape(caveat(report))}</div>'
        f"{facts_html(facts.items())}{process}"
    )


def counts_text(parts: Sequence[Part]) -> str:
    """Count verdicts on cleanliness, such as ``1 dirty, 2 clean``."""
    return ", ".join(f"{count} {verdict}" for verdict, count in count_cleanliness(parts).items()) or "none"


def parts_html(parts: Sequence[Part], selected: str) -> str:
    """Write parts as a table, the selected one marked; a long one says how many more there are."""
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
        f'<div style="color:{to_hex(QUIET)};font-size:11px">{judgement.rule} {escape(judgement.name)}: '
        f'<span style="color:{colour}">{judgement.verdict}</span>, grade {judgement.grade}{seen}</div>'
        f"{escape(judgement.because)}{advice}"
        f'<div style="color:{to_hex(QUIET)};font-size:11px">{escape(numbers)}</div></div>'
    )


def _number(name: str, value: float, unit: str, limit: float | None) -> str:
    against = "" if limit is None else f" (limit {limit:.3g})"
    return f"{name} {value:.3g}{' ' if unit else ''}{unit}{against}"
