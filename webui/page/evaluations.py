"""Evaluations of a program: its analysis by the cleaning model, and its check in a robot cell."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cleaning.parameters.model import Parameters
from cleaning.part_faces import FaceVerdict, HeldTimes, judge_faces, times_in_cone
from cleaning.verdicts.results import CleaningReport, Part
from programs.program import TimedProgram
from robotcell.cell.load import LoadedCell
from rulesengine.planning.pipeline import Run
from rulesengine.surface.part_job import survey_part
from specs.finding import Finding
from specs.progress import Progress, subprogress
from specs.source import Source
from webui.layers.robot.robot import JointMotion, joint_motion

if TYPE_CHECKING:
    from boards.board import Board
    from cleaning.analyse import Effort
    from cleaning.prepared_board import PreparedBoard
    from robotcell.track import CellReport

_LEAST_SHARE = 0.1
"""Share of the volume on a part: strokes with less are left out."""


@dataclass(frozen=True, slots=True, eq=False)
class Analysed:
    """A program and its cleaning report."""

    program: TimedProgram
    """Compared by identity."""
    parameters_name: str
    """Name in the project's list."""
    report: CleaningReport
    prepared: "PreparedBoard | None" = None
    """The prepared board, reused for the next program on it."""
    effort: "Effort" = "fast"

    def part(self, component: str) -> Part | None:
        """The report's part of a component, if there is one."""
        return next((each for each in self.report.parts if each.component == component), None)

    def makers_of(self, component: str) -> frozenset[Source]:
        """Strokes with a considerable share of the volume on a component."""
        part = self.part(component)
        return frozenset() if part is None else frozenset(name for name, share in part.makers if share >= _LEAST_SHARE)


@dataclass(frozen=True, slots=True)
class AnalysisSettings:
    """Parameters and effort of an analysis."""

    parameters_name: str
    """Name in the project's list."""
    parameters: Parameters
    effort: "Effort"
    capability: bool = False
    """Whether how sure the verdicts are is worked out too, which takes longer."""


def analyse_run(run: Run, settings: AnalysisSettings, before: Analysed | None, progress: Progress) -> Analysed:
    """Analyse a program, as the command line does.

    Args:
        run: Its program, board and recipe.
        settings: Parameters and effort.
        before: An analysis that may be of the same board.
        progress: Receives the stage and the share done.

    Raises:
        JobError: the program cannot be analysed with these parameters.
    """
    from cleaning.analyse import analyse_on, analyse_with_capability
    from rulesengine.tuning.suggest import advise

    prepared = prepare_board(run.board, settings.parameters, before, subprogress(progress, 0.0, 0.2))
    predict = analyse_with_capability if settings.capability else analyse_on
    report = predict(prepared, run.program, run.recipe, settings.effort, subprogress(progress, 0.2, 1.0))
    report = advise(report, run.program, run.recipe)
    return Analysed(run.program, settings.parameters_name, report, prepared, settings.effort)


def prepare_board(
    board: "Board", parameters: Parameters, before: Analysed | None, progress: Progress
) -> "PreparedBoard":
    """A board prepared for analyses with some parameters, taken from an earlier analysis where possible."""
    from cleaning.prepared_board import prepare

    known = None if before is None else before.prepared
    if known is not None and known.board is board and known.parameters == parameters:
        return known
    return prepare(board, parameters, progress)


@dataclass(frozen=True, slots=True, eq=False)
class AnalysedFaces:
    """A program over a part, and the verdicts on its faces."""

    program: TimedProgram
    """Compared by identity."""
    held: tuple[HeldTimes, ...]
    """One for each template of each step."""
    visible: NDArray[np.bool_]
    """(c,) cells that some free pose sees."""
    verdicts: tuple[FaceVerdict, ...]


def analyse_part(run: Run, progress: Progress) -> AnalysedFaces:
    """Judge the faces of a part under a program, as the command line does.

    Args:
        run: Its program, part and recipe.
        progress: Receives the stage and the share done.

    Raises:
        JobError: the program cannot be analysed.
    """
    part, recipe, program = run.workpiece.require_part("a verdict on faces"), run.recipe, run.program
    held = times_in_cone(program, part, recipe, subprogress(progress, 0.0, 0.4))
    survey = survey_part(recipe, part, subprogress(progress, 0.4, 1.0))
    return AnalysedFaces(program, held, survey.visible, judge_faces(part, held, survey.visible, survey.hider))


@dataclass(frozen=True, slots=True, eq=False)
class Checked:
    """A run in a cell."""

    run: Run
    cell: LoadedCell
    report: "CellReport"
    motion: JointMotion | None
    """``None`` where the robot cannot execute the program."""

    @property
    def program(self) -> TimedProgram:
        """As the robot executes it; as planned where it cannot."""
        return self.report.program

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Obstacles to the program, and deviations from the plan; worst first."""
        return self.report.findings


def check_program(run: Run, cell: LoadedCell, progress: Progress, lean: float = 0.0) -> Checked:
    """Check a program in a cell, as the command line does.

    Args:
        run: Its program, and the workpiece for collisions.
        cell: The cell.
        progress: Receives the stage and the share done.
        lean: Largest tilt that the robot may add to avoid collisions or limits, rad.

    Raises:
        JobError: the cell cannot be used with this program, or what ``washboard[robot]`` installs is missing.
    """
    from robotcell.track import terms_of, track

    report = track(run.program, cell.cell, run.workpiece, terms=terms_of(cell, lean), progress=progress)
    return Checked(run, cell, report, joint_motion(report.program, report.joints) if report.possible else None)


def plan_at_pace(run: Run, cell: LoadedCell, progress: Progress) -> Run:
    """Time a program for the robot of a cell, as ``washboard plan --cell`` does.

    Args:
        run: Its plan, board and recipe.
        cell: The cell, which holds the board.
        progress: Receives the stage and the share done.

    Raises:
        JobError: the cell cannot be used with this program, or what ``washboard[robot]`` installs is missing.
    """
    from rulesengine.planning.cell_plan import plan_for_cell

    return plan_for_cell(run, cell, progress)
