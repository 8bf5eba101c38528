"""Evaluations of a program: its analysis by the cleaning model, and its check in a robot cell."""

from dataclasses import dataclass
from math import degrees
from typing import TYPE_CHECKING

from cleaning.parameters.model import Parameters
from cleaning.verdicts.results import CleaningReport, Part
from programs.program import TimedProgram
from robotcell.cell.load import LoadedCell
from rulesengine.planning.pipeline import Run
from specs.finding import Finding
from specs.progress import Progress
from specs.source import Source
from webui.layers.robot.robot import JointMotion, joint_motion

if TYPE_CHECKING:
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
    from washboard.cleaned import analyse

    known = None if before is None else before.prepared
    done = analyse(run, settings.parameters, settings.effort, progress, capability=settings.capability, before=known)
    return Analysed(run.program, settings.parameters_name, done.board_report, done.prepared, settings.effort)


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
    from washboard.checked import check_in

    report = check_in(run.program, run.workpiece, cell, progress, tilt_band_deg=degrees(lean)).report
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
