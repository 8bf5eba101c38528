"""Findings: filtered, named and listed."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from html import escape
from pathlib import Path

from boards.board import Workpiece
from recipes.load import LoadedRecipe
from reports.tables.wording import SEVERITY_WORDS, shorten
from specs.finding import Finding, Severity, worst_first
from specs.source import Source
from webui.page.session import Session
from webui.theme.html import box_html, edged_html, grey_html, more_html, small_html
from webui.theme.palette import ACCENT, CHOSEN_GROUND, SEVERITY_COLOURS, css_colour

ALL: str = "All"
PLANNING, ROBOT, CLEANING = "Planning", "Robot", "Cleaning"
"""Sources of findings."""
_MOST_SHOWN = 60


def findings_of(session: Session, source: str = ALL) -> tuple[Finding, ...]:
    """Findings of planning, and of the check and the analysis of this very program; worst first."""
    found: list[Finding] = []
    if session.run is not None and source in (ALL, PLANNING):
        found += session.run.findings
    if session.check is not None and source in (ALL, ROBOT):
        found += session.check.findings
    if session.analysis is not None and source in (ALL, CLEANING):
        found += session.analysis.report.findings
    return worst_first(found)


def choose_findings(findings: Sequence[Finding], severity: str, rule: str) -> list[Finding]:
    """Findings of a severity (as in ``"Errors"``) and a rule, in their order; ``"All"`` keeps all."""
    return [
        finding
        for finding in findings
        if severity in (ALL, SEVERITY_WORDS[finding.severity]) and rule in (ALL, finding.rule.id)
    ]


def name_findings(findings: Sequence[Finding]) -> dict[str, Finding]:
    """Findings by a short unique name: number in the list, rule, and what caused it."""
    names: dict[str, Finding] = {}
    for number, finding in enumerate(findings, start=1):
        place = judged_of(finding) or shorten(str(replace(finding.made_by, step=None)))
        names[f"{number} {finding.rule.id}{f' {place}' if place else ''}"] = finding
    return names


def judged_of(finding: Finding) -> str:
    """Subject of a judgement of the cleaning model, with which its message begins; empty for other findings."""
    return finding.message.partition(": ")[0] if finding.rule.verdict else ""


def place_of(finding: Finding, workpiece: Workpiece) -> str:
    """Name of the one component or face that a finding is about; empty where there is none, or more."""
    names = [judged_of(finding)] if judged_of(finding) else finding.made_by.components
    return names[0] if len(names) == 1 and names[0] in workpiece.place_names else ""


def findings_html(findings: Sequence[Finding], loaded: LoadedRecipe, chosen: Finding | None) -> str:
    """List of findings in their order, the chosen one marked, cut off after so many."""
    names = tuple(name_findings(findings))
    items = "".join(
        _item(name, finding, loaded, marked=finding is chosen)
        for name, finding in zip(names[:_MOST_SHOWN], findings, strict=False)
    )
    rest = more_html(len(findings) - _MOST_SHOWN, "more; choose a rule to see them")
    return box_html(items + rest if findings else grey_html("Nothing to look at."))


def kinds_html(findings: Sequence[Finding], loaded: LoadedRecipe, chosen: Finding | None) -> str:
    """List of the first finding of each rule, the number of others of it, and the chosen one, marked."""
    counts = Counter((finding.severity, finding.rule.id) for finding in findings)
    firsts: dict[tuple[Severity, str], int] = {}
    for index, finding in enumerate(findings):
        firsts.setdefault((finding.severity, finding.rule.id), index)
    shown = [index for index, each in enumerate(findings) if each is chosen or index in firsts.values()]
    names = tuple(name_findings(findings))
    items = "".join(_item(names[at], findings[at], loaded, marked=findings[at] is chosen) for at in shown)
    more = [f"{count - 1} more {rule}" for (_, rule), count in counts.items() if count > 1]
    return box_html(items + grey_html(f"and {escape(', '.join(more))}" if more else ""))


def mistakes_html(findings: Sequence[Finding]) -> str:
    """List of probable mistakes in a cell or a program, worst first; nothing where there are none."""
    items = [
        _finding_html(each, each.rule.id, each.message, escape(str(each.made_by))) for each in worst_first(findings)
    ]
    return box_html("".join(items)) if items else ""


def _item(name: str, finding: Finding, loaded: LoadedRecipe, *, marked: bool) -> str:
    """One finding; a click on it chooses it by its name in the stepper."""
    number = name.partition(" ")[0]
    places = [source_words(finding.made_by), recipe_line(loaded, finding.made_by)]
    if finding.where is not None:
        places.append(", ".join(f"{value:.1f}" for value in finding.where) + " mm")
    place = " \N{MIDDLE DOT} ".join(escape(text) for text in places if text)
    title = f"{number} {finding.rule.id}"
    html = _finding_html(finding, title, shorten(finding.message), place, marked=marked)
    return f'<div data-row="{escape(name)}">{html}</div>'


def _finding_html(finding: Finding, title: str, message: str, place: str, *, marked: bool = False) -> str:
    colour = css_colour(SEVERITY_COLOURS[finding.severity])
    return edged_html(
        f'<span style="color:{colour};font-weight:600">{escape(title)}</span><div>{escape(message)}</div>'
        f"{small_html(place)}",
        css_colour(ACCENT) if marked else colour,
        f"background:{css_colour(CHOSEN_GROUND) if marked else 'transparent'};padding:2px 0 3px 8px;margin-bottom:8px",
    )


def source_words(made_by: Source) -> str:
    """Name a source by its step's number in the job: ``step 4, around, U12``; other entries as the recipe has them."""
    if made_by.step is None:
        return made_by.entry
    names = [f"step {made_by.step + 1}", made_by.template, "+".join(made_by.components), made_by.motion]
    return shorten(", ".join(filter(None, names)))


def recipe_line(loaded: LoadedRecipe, made_by: Source) -> str:
    """File and line of the entry of a source, such as ``smt-aqueous.yaml, line 104``; empty where there is none."""
    node = loaded.root
    for key in made_by.recipe_path:
        inner = node.get(key)
        if inner is None:
            break
        node = inner
    return "" if node is loaded.root else f"{Path(node.mark.file).name}, line {node.mark.line}"
