"""What a program cleans as it was planned, beside what it cleans as the controller of a robot drives it."""

from collections import defaultdict
from collections.abc import Mapping, Set
from dataclasses import dataclass
from functools import partial
from html import escape
from typing import TYPE_CHECKING, TypeAlias

from cleaning.analyse import analyse_on
from cleaning.parameters.load import load_parameters
from cleaning.parameters.model import Parameters
from cleaning.prepared_board import PreparedBoard
from cleaning.verdicts.results import CleaningReport, outcome, rank_parts, report_outcome
from cleaning.verdicts.rules import OUTCOMES, Outcome
from programs.posts.proving.findings import LEAST_DOSE, MOST_DOSE, REMEDIES, strokes_off
from programs.summary import jet_seconds
from reports.tables.cleaning_tables import kinetics_words
from reports.tables.table import Card, FactList, FindingList, Text
from reports.tables.wording import name_some
from rulesengine.planning.pipeline import require_fit
from specs.finding import Finding, finding_data
from specs.finding_rules import VERDICT_DIFFERS
from specs.json import Json
from specs.progress import Progress, no_progress, subprogress
from specs.rows import Rows
from specs.source import NO_SOURCE, Source
from washboard.cleaned import Cleaned, FaceReport, judge_part, prepare_again
from washboard.planned import Subject

if TYPE_CHECKING:
    from reports.files.robot_programs import CellExport

_MOST_NAMES = 8
_Outcomes: TypeAlias = Mapping[str, tuple[Outcome, frozenset[Source]]]
"""Of each component, face or rule of the process: what comes of it, and the strokes that it depends on."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class DrivenVerdict:
    """What a program cleans as planned, and as the controller of a language drives it by its model."""

    language: str
    """Title."""
    planned: CleaningReport | FaceReport
    driven: CleaningReport | FaceReport
    finding: Finding | None
    """What differs and why; ``None`` where nothing does."""

    def card(self) -> Card:
        """Show both verdicts, and what differs."""
        facts = [("as planned", describe(self.planned)), ("as driven", describe(self.driven))]
        found = () if self.finding is None else (FindingList((self.finding,)),)
        rests = "" if isinstance(self.driven, FaceReport) else kinetics_words(self.driven)
        worth = (Text(rests, "quiet"),) if rests else ()
        return Card(f"Predicted cleanliness, driven by {self.language}:", (FactList(facts), *worth, *found))

    def data(self) -> dict[str, Json]:
        """Give it as plain data for a report."""
        finding = None if self.finding is None else finding_data(self.finding)
        return {
            "language": self.language,
            "planned": _whole(self.planned),
            "driven": _whole(self.driven),
            "finding": finding,
        }

    def __repr__(self) -> str:
        return f"<{describe(self.planned)} as planned, {describe(self.driven)} as {self.language} drives it>"

    def _repr_html_(self) -> str:
        return (
            f"<p><b>{escape(repr(self)[1:-1])}</b></p>" + Rows(() if self.finding is None else (self.finding,)).html()
        )


def judge_driven(
    subject: Subject,
    done: "CellExport",
    parameters: Parameters | str = "default",
    progress: Progress = no_progress,
    *,
    planned: Cleaned | PreparedBoard | None = None,
) -> DrivenVerdict:
    """Judge a program as it was planned and as a controller drives it.

    Args:
        subject: A plan, or a program that was opened.
        done: What the robot does with it, and how that is written.
        parameters: Parameter set of the model for boards: one that is open, the name of one of the library, or a file.
        progress: Receives the stage and the share done.
        planned: Its analysis as planned, where that is at hand, whose parameters and effort count; or its board made
            ready for the model.

    Raises:
        JobError: it cannot be analysed.
    """
    program, workpiece, recipe = subject.program, subject.workpiece, subject.recipe
    require_fit(recipe, workpiece)
    first, second = subprogress(progress, 0.0, 0.5), subprogress(progress, 0.5, 1.0)
    known = planned if isinstance(planned, Cleaned) else None
    if workpiece.faces:
        faces = None if known is None else known.report
        here = faces if isinstance(faces, FaceReport) else judge_part(program, workpiece, recipe, first)
        there = judge_part(done.driven, workpiece, recipe, second, before=here)
    else:
        if known is not None and known.prepared is not None:
            parameters = known.prepared.parameters
        read = parameters if isinstance(parameters, Parameters) else load_parameters(parameters)
        prepared = prepare_again(workpiece.require_board("this analysis"), read, planned, first)
        judge = partial(analyse_on, prepared, recipe=recipe, effort="fast" if known is None else known.effort)
        here = judge(program, progress=first, sensitivity=False) if known is None else known.board_report
        there = judge(done.driven, progress=second, sensitivity=False)
    return DrivenVerdict(done.exported.language.title, here, there, find_difference(here, there, done))


def _whole(report: CleaningReport | FaceReport) -> Outcome:
    return report.verdict if isinstance(report, FaceReport) else report_outcome(report)


def describe(report: CleaningReport | FaceReport) -> str:
    """State the worst verdict, and how many components or faces are clean."""
    outcomes = (
        [each.verdict for each in report.verdicts] if isinstance(report, FaceReport) else [*map(outcome, report.parts)]
    )
    noun = "faces" if isinstance(report, FaceReport) else "components"
    films = (
        [each.film.deviation for each in report.verdicts if each.film is not None]
        if isinstance(report, FaceReport)
        else []
    )
    film = f"; film ±{max(films):.2%}" if films else ""
    return f"{_whole(report)}, {outcomes.count('clean')} of {len(outcomes)} {noun} clean{film}"


def _outcomes(report: CleaningReport | FaceReport) -> _Outcomes:
    """Give what comes of each component, or of each face by each template, the worst first."""
    if isinstance(report, FaceReport):
        several = len({each.made_by for each in report.verdicts}) > 1
        faces: dict[str, tuple[Outcome, frozenset[Source]]] = {
            f"{each.face}{f' by {each.made_by}' if several else ''}": (each.verdict, frozenset({each.made_by}))
            for each in report.verdicts
        }
        return dict(sorted(faces.items(), key=lambda each: OUTCOMES.index(each[1][0])))
    sides = {each.name: f" ({each.side})" for each in report.board.components}
    parts = [*rank_parts(report), report.bare]
    found: dict[str, tuple[Outcome, frozenset[Source]]] = {
        f"{part.component}{sides.get(part.component, '')}": (
            outcome(part),
            frozenset(maker for maker, _ in part.makers),
        )
        for part in parts
    }
    process: list[Outcome] = ["clean", *(each.verdict for each in report.process)]
    found["process"] = min(process, key=OUTCOMES.index), frozenset()
    return found


def find_difference(
    here: CleaningReport | FaceReport, there: CleaningReport | FaceReport, done: "CellExport"
) -> Finding | None:
    """Report which components, faces or rules have another verdict as driven, with the seconds and why."""
    planned, driven = _outcomes(here), _outcomes(there)
    changes = defaultdict[tuple[Outcome, Outcome], list[str]](list)
    strokes: set[Source] = set()
    for name, (then, makers) in driven.items():
        before, others = planned[name]
        if then != before:
            changes[before, then].append(name)
            strokes |= makers | others
    if not changes:
        return None
    noun = "faces " if isinstance(there, FaceReport) else ""
    listed = "; ".join(
        f"planned {before}, driven {then}: {noun}{name_some(names, _MOST_NAMES)}"
        for (before, then), names in changes.items()
    )
    is_worse = any(OUTCOMES.index(then) < OUTCOMES.index(before) for before, then in changes)
    why, made_by = _cause(done, strokes, is_worse=is_worse)
    message = f"{listed}, as {done.exported.language.title} is predicted to drive it. {why}"
    return Finding(VERDICT_DIFFERS, message, made_by, override=None if is_worse else "info")


def _cause(done: "CellExport", strokes: Set[Source], *, is_worse: bool) -> tuple[str, Source]:
    """State the seconds of the jets, the stroke of some whose time is farthest from the plan, why, and what helps."""
    planned, driven = jet_seconds(done.report.requested), jet_seconds(done.driven)
    whole = f"The jets are on for {sum(driven.values()):.2f} s, planned {sum(planned.values()):.2f} s"
    own = [each for each in planned if any(each.belongs_to(stroke) for stroke in strokes)] or list(planned)
    worst = max(own, key=lambda each: abs(driven.get(each, 0.0) - planned[each]), default=NO_SOURCE)
    due_s, takes_s = planned.get(worst, 0.0), driven.get(worst, 0.0)
    there = f"farthest off {worst or 'the program'}, {takes_s:.2f} s for {due_s:.2f} s"
    if not is_worse:
        return f"{whole}; {there}.", worst
    if LEAST_DOSE * due_s <= takes_s <= MOST_DOSE * due_s:
        only_just = "the plan only just has its verdict. Remedy: plan with more time there: less speed, or another pass"
        return f"{whole}; {there}: {only_just}.", worst
    forecast = done.exported.forecast
    off = [] if forecast is None else strokes_off(forecast)
    moves = [each.longest for each in off if each.longest.made_by == worst]
    if not moves:  # as the robot's program has it already
        return f"{whole}; {there}, at the limits of the robot. Remedy: plan with the cell (plan --cell).", worst
    cause = REMEDIES[max(moves, key=lambda move: abs(move.jet_s - move.jet_planned_s)).cause]
    return f"{whole}; {there}, {cause.what}. Remedy: {cause.remedy}.", worst
