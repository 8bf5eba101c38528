"""What the page says about findings: which are shown, their names, their list."""

from collections import Counter
from collections.abc import Sequence
from html import escape

from boards.board import Board
from recipes.load import LoadedRecipe
from reports.tables.comparison import SEVERITY_WORDS
from reports.tables.wording import shorten
from specs.finding import Finding, Severity, worst_first
from webui.cards.recipe_location import recipe_line
from webui.page.session import Session
from webui.theme.palette import ACCENT, INK, QUIET, to_hex
from webui.theme.verdict_colours import SEVERITY_COLOURS

ALL: str = "All"
PLANNING, CLEANING = "Planning", "Cleaning"
"""Who found it."""
_MOST_SHOWN = 60


def findings_of(session: Session, source: str = ALL) -> tuple[Finding, ...]:
    """Give what planning found, and what the analysis of this very program did; worst first."""
    found: list[Finding] = []
    if session.run is not None and source != CLEANING:
        found += session.run.findings
    if session.analysis is not None and source != PLANNING:
        found += session.analysis.report.findings
    return worst_first(found)


def choose_findings(findings: Sequence[Finding], severity: str, rule: str) -> list[Finding]:
    """Keep the findings of a severity (as in ``"Errors"``) and a rule; ``"All"`` keeps all. Their order stays."""
    return [
        finding
        for finding in findings
        if severity in (ALL, SEVERITY_WORDS[finding.severity]) and rule in (ALL, finding.rule.id)
    ]


def name_findings(findings: Sequence[Finding]) -> dict[str, Finding]:
    """Give each finding a short name of its own, to choose it by: its number in the list, its rule, who made it."""
    names: dict[str, Finding] = {}
    for number, finding in enumerate(findings, start=1):
        _, _, made_by = finding.made_by.rpartition("]/")
        place = judged_of(finding) or shorten(made_by)
        names[f"{number} {finding.rule.id}{f' {place}' if place else ''}"] = finding
    return names


def judged_of(finding: Finding) -> str:
    """Name what a judgement of the cleaning model is about, which its message begins with; nothing for others."""
    return finding.message.partition(": ")[0] if finding.rule.verdict else ""


def component_of(finding: Finding, board: Board) -> str:
    """Name the component that a finding is about, where it is about one; else nothing."""
    parts = finding.made_by.split("/")
    named = judged_of(finding) or (parts[2] if len(parts) > 2 else "")
    return named if any(component.name == named for component in board.components) else ""


def tally(findings: Sequence[Finding]) -> str:
    """Count findings by severity, such as ``2 warnings, 15 notes``."""
    counts = Counter(finding.severity for finding in findings)
    words = [
        f"{counts[severity]} {word.lower() if counts[severity] != 1 else word.lower().removesuffix('s')}"
        for severity, word in SEVERITY_WORDS.items()
        if counts[severity]
    ]
    return ", ".join(words) or "no findings"


def findings_html(findings: Sequence[Finding], loaded: LoadedRecipe, chosen: Finding | None) -> str:
    """List findings as they come, the chosen one marked; long lists say how many more there are."""
    items = "".join(
        _item(number, finding, loaded, marked=finding is chosen)
        for number, finding in enumerate(findings[:_MOST_SHOWN], start=1)
    )
    more = len(findings) - _MOST_SHOWN
    rest = f'<div style="color:{to_hex(QUIET)}">and {more} more; choose a rule to see them</div>' if more > 0 else ""
    nothing = "" if findings else f'<div style="color:{to_hex(QUIET)}">Nothing to look at.</div>'
    return (
        f'<div style="margin:4px 12px;font-size:12px;line-height:1.45;color:{to_hex(INK)}">{items}{rest}{nothing}</div>'
    )


def kinds_html(findings: Sequence[Finding], loaded: LoadedRecipe, chosen: Finding | None) -> str:
    """List the first finding of each rule, how many more there are of it, and the chosen one, marked."""
    counts = Counter((finding.severity, finding.rule.id) for finding in findings)
    firsts: dict[tuple[Severity, str], int] = {}
    for index, finding in enumerate(findings):
        firsts.setdefault((finding.severity, finding.rule.id), index)
    shown = [index for index, each in enumerate(findings) if each is chosen or index in firsts.values()]
    items = "".join(_item(at + 1, findings[at], loaded, marked=findings[at] is chosen) for at in shown)
    more = [f"{count - 1} more {rule}" for (_, rule), count in counts.items() if count > 1]
    rest = f'<div style="color:{to_hex(QUIET)}">and {escape(", ".join(more))}</div>' if more else ""
    return f'<div style="margin:4px 12px;font-size:12px;line-height:1.45;color:{to_hex(INK)}">{items}{rest}</div>'


def _item(number: int, finding: Finding, loaded: LoadedRecipe, *, marked: bool) -> str:
    colour = SEVERITY_COLOURS[finding.severity]
    edge = to_hex(ACCENT) if marked else colour
    ground = "#fbf1ee" if marked else "transparent"
    places = [shorten(finding.made_by), recipe_line(loaded, finding.made_by)]
    if finding.where is not None:
        places.append(", ".join(f"{value:.1f}" for value in finding.where) + " mm")
    place = " \N{MIDDLE DOT} ".join(escape(text) for text in places if text)
    return (
        f'<div style="border-left:3px solid {edge};background:{ground};padding:2px 0 3px 8px;margin-bottom:8px;'
        'overflow-wrap:anywhere">'
        f'<span style="color:{colour};font-weight:600">{number} {escape(finding.rule.id)}</span>'
        f"<div>{escape(shorten(finding.message))}</div>"
        f'<div style="color:{to_hex(QUIET)};font-size:11px">{place}</div></div>'
    )
