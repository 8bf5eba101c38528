"""A check of a program in a robot cell."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from programs.program import TimedProgram
from robotcell.cell.load import LoadedCell
from rulesengine.planning.pipeline import Run
from specs.finding import Finding
from specs.progress import Progress
from webui.layers.robot.robot import JointMotion, joint_motion

if TYPE_CHECKING:
    from robotcell.track import CellReport


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
        run: Its program, and the board for collisions.
        cell: The cell.
        progress: Receives the stage and the share done.
        lean: Largest tilt that the robot may add to avoid collisions or limits, rad.

    Raises:
        JobError: the cell cannot be used with this program, or what ``washboard[robot]`` installs is missing.
    """
    from robotcell.track import terms_of, track

    report = track(run.program, cell.cell, run.board, terms=terms_of(cell, lean), progress=progress)
    return Checked(run, cell, report, joint_motion(report.program, report.joints) if report.possible else None)
