"""A proposal of tuning, or a single change: shown as HTML, and accepted as one edit or as a new file."""

import base64
from dataclasses import dataclass, replace
from html import escape

from reports.pictures.charts import picture_of_tuning
from reports.tables.cleaning_tables import UNCALIBRATED
from reports.tables.table import Lines, Table
from reports.tables.wording import amount, clock
from rulesengine.tuning.report import describe_end, explain, is_unfinished
from rulesengine.tuning.trial.outcome import Figures
from rulesengine.tuning.trial.request import AcceptedChange, TuningResult, cleanliness, pareto_front
from rulesengine.tuning.variables import recipe_diff
from webui.page.document import Document
from webui.page.evaluations import Proposal, TuningError
from webui.page.project import Project
from webui.page.session import Change, Session
from webui.theme.html import box_html, edged_html, heading_html, more_html, quiet_html, small_html, table_html
from webui.theme.palette import ACCENT, ADDED, ADDED_INK, GROUND, LINE_COLOUR, QUIET, REMOVED, REMOVED_INK, css_colour


@dataclass(frozen=True, slots=True)
class Fix:
    """One change of a recipe, with its predicted effect."""

    component: str
    """Part that it is suggested for."""
    what: str
    """Such as ``"templates.sweep.speed_mm_s: 60 -> 40"``."""
    document: Document
    """The recipe before it."""
    text: str
    """The recipe with it."""
    before: Figures
    after: Figures
    resolved: bool
    """Whether the part is clean then."""


def apply_fix(fix: Fix) -> Change:
    """Apply one change: one edit, which can be undone."""

    def change(session: Session) -> Session:
        if session.document.file != fix.document.file or session.document.text != fix.document.text:
            raise TuningError("The recipe was edited since this was suggested. Undo that, or suggest again.")
        return session.edited(fix.text)

    return change


def apply_proposal(session: Session) -> Session:
    """Apply the proposed recipe: one edit, which can be undone.

    Raises:
        TuningError: it was edited meanwhile, and these edits would be lost.
    """
    proposal = session.proposal
    if proposal is None:
        return session
    if not proposal.fits(session.document):
        raise TuningError(
            "The text is not the one that was tuned any more. Undo the edits since, save the tuned one as a new "
            "recipe, or discard it and tune again."
        )
    return replace(session.edited(proposal.text), proposal=None)


def save_proposal(project: Project, name: str) -> Change:
    """Write the proposed recipe to a new file of the project, and open that."""

    def change(session: Session) -> Session:
        proposal = session.proposal
        if proposal is None:
            return session
        document = proposal.document.edited(proposal.text).save_as(project.recipe_file(name))
        return replace(session.with_document(document), proposal=None)

    return change


_MOST_REASONS = 40
_ARROW = "\N{RIGHTWARDS ARROW}"


def headline_of(tuned: TuningResult) -> str:
    """Result of tuning in one sentence."""
    if not tuned.within_limits:
        return "The limits cannot be kept with what may be changed."
    if tuned.last.clean:
        saved = tuned.first.clean and tuned.changes
        return "Predicted clean, and shorter than before." if saved else "Predicted clean."
    if not tuned.changes:
        return "Nothing was found that is better."
    return "Better, and not clean yet."


def totals_html(proposal: Proposal) -> str:
    """Totals of the recipe before and after, and why tuning ended."""
    tuned = proposal.tuned
    chosen = next((each for each in tuned.trials if each.text == proposal.chosen), None)
    before, after = tuned.first.figures, tuned.last.figures if chosen is None else chosen.figures
    rows = (
        (
            "Clean parts",
            f"{before.clean_components} of {tuned.first.total}",
            f"{after.clean_components} of {tuned.last.total}",
        ),
        ("Open requirements", f"{before.open_requirements}", f"{after.open_requirements}"),
        ("Most residue", _percent(before.worst_residue), _percent(after.worst_residue)),
        ("Time", clock(before.seconds), clock(after.seconds)),
        ("Sprayed", f"{before.litres:.2f} l", f"{after.litres:.2f} l"),
    )
    caveat = (
        f"A prediction of the cleaning model after {_analyses(tuned.used)}; it is no proof of cleanliness. "
        "Time and liquid of loops are those of once."
    ) + f" {UNCALIBRATED}" * (not tuned.calibrated)
    if tuned.robot is not None:
        caveat += f" Times are those of {escape(tuned.robot.name)} in {escape(tuned.robot.cell)}."
    headline = headline_of(tuned)
    if proposal.interrupted:
        headline, ended = f"Cancelled; the best until then, found by {_analyses(tuned.used)}.", ""
    elif chosen is not None:
        headline, ended = "Chosen of the Pareto front.", describe_end(tuned)
    else:
        ended = describe_end(tuned)
    return box_html(
        f'<div style="font-weight:600;font-size:14px">{headline}</div>'
        + small_html(escape(ended))
        + small_html(caveat)
        + table_html(Table.of(("", ">before", ">after"), rows))
    )


def front_html(proposal: Proposal) -> str:
    """Picture of all recipes that were analysed, with the Pareto front and the recipe that is proposed."""
    picture = picture_of_tuning(proposal.tuned, proposal.chosen)
    data = base64.b64encode(picture.content).decode()
    source = f"data:image/svg+xml;base64,{data}"
    return box_html(f'<img alt="{escape(picture.alt)}" data-front style="width:100%" src="{source}">')


def front_labels(tuned: TuningResult) -> dict[str, str]:
    """Recipes of the Pareto front by a line that describes each, the cleanest first; texts of recipes."""
    numbered = sorted(enumerate(pareto_front(tuned.trials), 1), key=lambda pair: cleanliness(pair[1]), reverse=True)
    return {
        f"{number}: {each.figures.clean_components} of {tuned.last.total} clean, "
        + (f"margin {each.margin:.2f}, " if each.margin else "")
        + f"{clock(each.figures.seconds)}, {each.figures.litres:.2f} l": each.text
        for number, each in numbered
    }


def changes_html(changes: tuple[AcceptedChange, ...]) -> str:
    """Changes in their order, each with its own effect and cost."""
    if not changes:
        return ""
    head = ("Change", ">open", ">clean parts", ">residue", ">time", ">liquid")
    rows = [
        (Lines(each.what[0], each.what[1:]), *_effects(each.before, each.after), *_cost(each.before, each.after))
        for each in changes
    ]
    return _section_html("Changes, one after the other", table_html(Table.of(head, rows)), "12vh")


def fix_html(fix: Fix) -> str:
    """Predicted effect of one change on its part, and its cost."""
    unmet, clean, residue = _effects(fix.before, fix.after)
    rows = (
        (fix.component, "clean" if fix.resolved else "not clean yet"),
        ("Open requirements", unmet),
        ("Clean parts", clean),
        ("Most residue", residue),
        ("Cost", ", ".join(_cost(fix.before, fix.after))),
    )
    return box_html(heading_html(fix.what) + table_html(Table.of(("", ">"), rows)))


def diff_html(before: str, after: str) -> str:
    """Lines that change with those around them: removed ones in red, added ones in green."""
    lines = recipe_diff(before, after, "before", "after").splitlines()[2:]
    if not lines:
        return ""
    body = ""
    for line in lines:
        ground, ink = {"+": (ADDED, ADDED_INK), "-": (REMOVED, REMOVED_INK)}.get(line[:1], ("transparent", "inherit"))
        if line.startswith("@@"):
            ground, ink = GROUND, css_colour(QUIET)
            line = f"line {line.split('+')[1].split(',')[0].split(' ')[0]}"
        body += f'<div style="background:{ground};color:{ink};padding:0 8px">{escape(line)}</div>'
    style = f"border:1px solid {LINE_COLOUR};border-radius:4px;font-family:ui-monospace,monospace;font-size:11.5px"
    lines_html = f'<div data-diff style="{style};white-space:pre;tab-size:2;min-width:max-content">{body}</div>'
    return _section_html("Recipe", lines_html, "18vh")


def reasons_html(tuned: TuningResult) -> str:
    """Open requirement of each part that is not clean yet, and why the recipe cannot be tuned further for it."""
    reasons = explain(tuned)
    if not reasons:
        return ""
    grey = f'<span style="color:{css_colour(QUIET)}">'
    rows = "".join(
        edged_html(
            f'<span style="color:{css_colour(ACCENT)};font-weight:600">{escape(each.component)}</span> '
            f"{grey}{each.rule} {escape(each.name)}</span> {escape(each.because)} {grey}{escape(each.why)}</span>",
            css_colour(ACCENT),
        )
        for each in reasons[:_MOST_REASONS]
    )
    hint = "With a higher limit under Analyses at most, tuning may find more." if is_unfinished(tuned) else ""
    more = more_html(len(reasons) - _MOST_REASONS)
    return _section_html("Not met yet, and why", rows + more, "11vh") + quiet_html(hint)


def _effects(before: Figures, after: Figures) -> tuple[str, str, str]:
    """Open requirements, clean parts and residue, before and after."""
    return (
        f"{before.open_requirements} {_ARROW} {after.open_requirements}",
        f"{before.clean_components} {_ARROW} {after.clean_components}",
        f"{_percent(before.worst_residue)} {_ARROW} {_percent(after.worst_residue)}",
    )


def _cost(before: Figures, after: Figures) -> tuple[str, str]:
    """Additional time and liquid."""
    return f"{after.seconds - before.seconds:+z.1f} s", f"{after.litres - before.litres:+z.2f} l"


def _section_html(title: str, inner: str, height: str) -> str:
    """A heading, and content that scrolls beyond a height."""
    return box_html(heading_html(title) + f'<div tabindex="0" style="max-height:{height};overflow:auto">{inner}</div>')


def _analyses(count: int) -> str:
    return amount(count, "analysis", "analyses")


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %"
