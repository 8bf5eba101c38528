"""Analysing what a program cleans: components and gaps of a board, faces of a part."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from boards.board import Board, Workpiece
from cleaning.analyse import Effort, analyse_on, analyse_with_capability
from cleaning.parameters.load import load_parameters
from cleaning.parameters.model import Parameters
from cleaning.part_faces import FaceVerdict, HeldTimes, judge_faces, times_in_cone, weigh_faces
from cleaning.prepared_board import PreparedBoard, prepare
from cleaning.report import Traceability
from cleaning.verdicts.results import (
    CleaningReport,
    deciding_judgement,
    outcome,
    rests_on_uncalibrated_kinetics,
)
from cleaning.verdicts.rules import Verdict
from cleaning.verify import Verified, check_names, verify
from programs.program import TimedProgram
from recipes.recipe import Recipe
from rulesengine.planning.pipeline import require_fit
from specs.errors import JobError
from specs.finding import worst_first
from specs.input_file import InputFile
from specs.output_file import OutputFile
from specs.progress import Progress, no_progress, subprogress
from specs.rows import Rows
from washboard.inputs import OpenedProgram, find_differences, open_cell
from washboard.planned import Subject

if TYPE_CHECKING:
    from cleaning.uncertainty.comparison import Comparison
    from robotcell.cell.load import LoadedCell
    from rulesengine.surface.part_job import Survey


@dataclass(frozen=True, slots=True)
class ComponentVerdict:
    """The verdict on one component, and what decides it."""

    component: str
    outcome: str
    rule: str
    residue: float | None
    """Worst share that is left under it; ``None`` without a gap."""
    limiting: str
    uncalibrated: bool
    """Whether it rests on kinetics that were not fitted to measurements."""


@dataclass(frozen=True, slots=True, eq=False)
class FaceReport:
    """What a program cleans on the faces of a part."""

    part: Workpiece
    program: TimedProgram
    """Compared by identity."""
    held: tuple[HeldTimes, ...]
    """One for each template of each step."""
    survey: "Survey"
    verdicts: tuple[FaceVerdict, ...]

    @property
    def verdict(self) -> Verdict:
        """Of the part, its faces weighed by their area."""
        return weigh_faces(self.verdicts).verdict


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Cleaned:
    """An analysis: the verdict on every component of a board or face of a part, and the report behind it."""

    report: CleaningReport | FaceReport
    program_bytes: bytes
    """The native program; the report states its fingerprint."""
    effort: Effort = "fast"
    verified: tuple[Verified, ...] = ()
    """Components that were computed exactly."""
    prepared: PreparedBoard | None = None
    """The board made ready for the model, for the next analysis of it."""

    @property
    def verdict(self) -> Verdict:
        """Of the worst component, or of the part."""
        return self.report.verdict

    @property
    def board_report(self) -> CleaningReport:
        """The report on a board.

        Raises:
            JobError: the workpiece is a part.
        """
        if isinstance(self.report, FaceReport):
            raise JobError(f"this is for boards, and {self.report.part.name} is a part.")
        return self.report

    @property
    def verdicts(self) -> Rows[Any]:
        """One row for each component, or for each face and template."""
        if isinstance(self.report, FaceReport):
            return Rows(self.report.verdicts)
        return Rows(
            ComponentVerdict(
                each.component,
                outcome(each),
                deciding_judgement(each).name,
                each.residue,
                each.limiting,
                rests_on_uncalibrated_kinetics(each),
            )
            for each in self.report.parts
        )

    def component(self, name: str) -> Any:
        """All results for one component, or the verdicts on one face.

        Raises:
            JobError: there is none of that name.
        """
        if isinstance(self.report, FaceReport):
            found = [each for each in self.report.verdicts if each.face == name]
        else:
            found = [each for each in self.report.parts if each.component == name]
        if not found:
            raise JobError(f"there is no component or face {name!r}; .verdicts lists them.")
        return Rows(found) if isinstance(self.report, FaceReport) else found[0]

    def html(
        self,
        file: str | Path | None = None,
        trace: Traceability | None = None,
        measured: "tuple[Comparison, list[str]] | None" = None,
    ) -> str:
        """The report as one page, written to a file if one is named.

        Args:
            file: ``.html``
            trace: What an operator states: serial number, detergent and so on.
            measured: Measured cleanliness compared with the prediction, and the commands of recalibrations.
        """
        from reports.html.cleaning_page import cleaning_page, faces_page
        from reports.tables.cleaning_tables import this_producer

        traced = self.traced(trace)
        if isinstance(self.report, FaceReport):
            found = self.report
            page = faces_page(found.part, found.program, found.verdicts, traced)
        else:
            page = cleaning_page(self.report, traced, self.verified, this_producer(self.effort), measured)
        if file is not None:
            OutputFile(Path(file)).write(page)
        return page

    def data(self, trace: Traceability | None = None, measured: "tuple[Comparison, list[str]] | None" = None) -> bytes:
        """The report as JSON."""
        from reports.files.write_run import cleaning_bytes, json_bytes
        from reports.tables.cleaning_tables import this_producer
        from reports.tables.run_report import part_cleaning_report

        if isinstance(self.report, FaceReport):
            found = self.report
            return json_bytes(part_cleaning_report(found.part, found.program, found.verdicts, self.traced(trace)))
        return cleaning_bytes(self.report, this_producer(self.effort), self.traced(trace), self.verified, measured)

    def traced(self, trace: Traceability | None = None) -> Traceability:
        """What an operator states, with the fingerprint of the program."""
        return replace(trace or Traceability(), program_sha256=sha256(self.program_bytes).hexdigest())

    def __repr__(self) -> str:
        return f"<analysis, {self.verdict}>"

    def _repr_html_(self) -> str:
        return f"<p><b>{self.verdict}</b></p>{self.verdicts.html()}"


def analyse(
    subject: Subject,
    parameters: Parameters | str | Path = "default",
    effort: Effort = "fast",
    progress: Progress = no_progress,
    *,
    capability: bool = False,
    verified: Sequence[str] = (),
    before: Cleaned | PreparedBoard | None = None,
    cell: "LoadedCell | str | Path | None" = None,
    dialect: str | None = None,
    log: str | Path | None = None,
) -> Cleaned:
    """Predict what a program cleans, as it was planned, as a controller drives it, or as it ran.

    A board is followed through all stages by the model of cleaning; on a part the time in the cone is judged, face by
    face, which knows no parameters.

    Args:
        subject: A plan, or a program that was opened.
        parameters: Parameter set: one that is open, the name of one of the library, or a file.
        effort: ``fast``: 64 rays a sample; ``full``: 256 rays, and samples twice as dense.
        progress: Receives the stage and the share done.
        capability: Whether how sure the verdicts are is worked out too.
        verified: Components to compute exactly.
        before: An earlier analysis whose board may be the same, or what it prepared.
        cell: Robot cell, for the program as the model of its controller drives it.
        dialect: Language that the controller is given; left out, that of the robot's maker.
        log: Table of what ran (``programs.run_log``), in place of a cell; a log of joints needs the cell too.

    Raises:
        JobError: the program cannot be analysed, or something is requested that a part has no results for.
    """
    from programs import native

    program, workpiece, recipe = _judged(subject, cell, dialect, log), subject.workpiece, subject.recipe
    content = (
        InputFile(subject.file, noun="program").read()
        if isinstance(subject, OpenedProgram)
        else native.render(program).encode("utf-8", "replace")
    )
    require_fit(recipe, workpiece)
    if workpiece.faces:
        _refuse(workpiece, {
            "a parameter set": parameters != "default", "the effort full": effort != "fast",
            "capability": capability, "verifying components": bool(verified),
        })  # fmt: skip
        return Cleaned(judge_part(program, workpiece, recipe, progress), content)
    board = workpiece.require_board("this analysis")
    check_names(board, verified)
    known = parameters if isinstance(parameters, Parameters) else load_parameters(parameters)
    prepared = prepare_again(board, known, before, subprogress(progress, 0.0, 0.2))
    predict = analyse_with_capability if capability else analyse_on
    report = predict(prepared, program, recipe, effort, subprogress(progress, 0.2, 1.0))
    differences = find_differences(program, board, recipe) if isinstance(subject, OpenedProgram) else []
    found = worst_first((*differences, *report.findings))
    origin = replace(report.origin, board=board.name, board_sha256=board.sha256)
    report = replace(report, origin=origin, findings=found)
    if verified:
        progress("verifying", 1.0)
    exact = verify(report, prepared, list(verified))
    from rulesengine.tuning.report import advise

    return Cleaned(advise(report, program, recipe), content, effort, exact, prepared)


def _judged(
    subject: Subject, cell: "LoadedCell | str | Path | None", dialect: str | None, log: str | Path | None
) -> TimedProgram:
    """Give the program that is judged: as planned, as it is driven in a cell, or as it ran.

    Raises:
        JobError: it cannot be driven, the log does not belong to it, or words do not go together.
    """
    if log is not None:
        from programs.run_log import place_joints, program_of_log, read_run_log

        ran = read_run_log(Path(log))
        if dialect is not None or (cell is not None and ran.joints is None):
            raise JobError(
                "a log is what ran, and a cell or dialect what a controller would do: leave out one of them."
            )
        if ran.joints is not None:
            if cell is None:
                raise JobError("the log has joints in place of x_mm, y_mm and z_mm: name the cell of their robot too.")
            from robotcell.cell.installation import installation_of, places_of_tool
            from robotcell.cell.load import hold_board

            held = hold_board(open_cell(cell), subject.workpiece)
            ran = place_joints(ran, subject.program, installation_of(held), places_of_tool(held.cell))
        return program_of_log(ran, subject.program)
    if cell is None:
        if dialect is not None:
            raise JobError("a dialect is driven in a cell: name the cell too.")
        return subject.program
    from washboard.checked import check

    return check(subject, cell).driven(dialect)


def prepare_again(
    board: Board, parameters: Parameters, before: Cleaned | PreparedBoard | None, progress: Progress = no_progress
) -> PreparedBoard:
    """Make a board ready for analyses with some parameters; taken from an earlier analysis where it is the same."""
    known = before.prepared if isinstance(before, Cleaned) else before
    if known is not None and known.board is board and known.parameters == parameters:
        return known
    return prepare(board, parameters, progress)


def judge_part(
    program: TimedProgram,
    workpiece: Workpiece,
    recipe: Recipe,
    progress: Progress = no_progress,
    *,
    before: FaceReport | None = None,
) -> FaceReport:
    """Judge the faces of a part by the time that a program keeps them in the cone.

    Args:
        program: Planned on the part.
        workpiece: The part.
        recipe: The program's.
        progress: Receives the stage and the share done.
        before: Of another program of the same recipe on the part: what can be seen there is the same.

    Raises:
        JobError: the program cannot be judged, or the workpiece is no part.
    """
    from rulesengine.surface.part_job import survey_part

    part = workpiece.require_part("a verdict on faces")
    held = times_in_cone(program, part, recipe, subprogress(progress, 0.0, 0.4))
    survey = survey_part(recipe, part, subprogress(progress, 0.4, 1.0)) if before is None else before.survey
    return FaceReport(part, program, held, survey, judge_faces(part, held, survey.visible, survey.hider))


def _refuse(workpiece: Workpiece, requests: dict[str, bool]) -> None:
    """Refuse what an analysis of a part cannot heed.

    Raises:
        JobError: something is requested.
    """
    for what, is_requested in requests.items():
        if is_requested:
            raise JobError(
                f"{what} is for boards, and {workpiece.name} is a part: its faces are judged by the time in the cone "
                "alone. Leave it out."
            )
