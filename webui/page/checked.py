"""What came of trying a program in a robot cell, as one frozen value."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from geometry.arrays import Scalars
from programs.program import TimedProgram
from reports.pictures.joint_picture import Quantity, joint_curves
from reports.tables.wording import clock
from robotcell.cell.load import LoadedCell
from robotcell.motion.retime import rates_of
from rulesengine.planning.pipeline import Run
from specs.finding import Finding
from specs.progress import Progress
from webui.layers.robot.proximity import Near, nearest_of
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
    """``None`` where the robot cannot do it."""

    @property
    def program(self) -> TimedProgram:
        """As the robot does it; as planned where it cannot."""
        return self.report.program

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What keeps the robot from it, and what it does otherwise than planned; worst first."""
        return self.report.findings


def check_program(run: Run, cell: LoadedCell, progress: Progress, lean: float = 0.0) -> Checked:
    """Try a program in a cell, as the command line does.

    Args:
        run: Its program, and the board for collisions.
        cell: The cell.
        progress: Receives the stage and the share done.
        lean: rad that the jet may lean while it sprays, where nothing else is clear.

    Raises:
        JobError: the cell cannot be used with this program, or what ``washboard[robot]`` installs is missing.
    """
    from robotcell.track import terms_of, track

    report = track(run.program, cell.cell, run.board, terms=terms_of(cell, lean), progress=progress)
    return Checked(run, cell, report, joint_motion(report.program, report.joints) if report.possible else None)


def facts_of(checked: Checked) -> dict[str, str]:
    """Say what to know of a check at one glance: a name and a text each; nothing where nothing moves."""
    report, motion = checked.report, checked.motion
    if motion is None:
        return {}
    return {
        "Time": _time(report.requested.totals.duration_s, report.program.totals.duration_s),
        "Speed": _hardest(report, "speed"),
        "Acceleration": _hardest(report, "acceleration"),
        "Nearest": _nearest(nearest_of(report, motion)),
        "Manipulability": _least(report.singularity, "at the least"),
        "Condition": _least(report.condition, "inverse, at the least"),
    }


def _time(asked_s: float, taken_s: float) -> str:
    if abs(taken_s - asked_s) < 0.05:
        return f"{clock(taken_s)}, as planned"
    return f"{clock(taken_s)}, planned {clock(asked_s)}"


def _hardest(report: "CellReport", quantity: Quantity) -> str:
    """Name the joint that comes nearest to its limit."""
    curves = joint_curves(report.cell.robot.joints, rates_of(report.program, report.joints), quantity)
    hardest = max(curves, key=lambda curve: curve.use)
    return f"{hardest.name} at {hardest.use:.0%} of its limit"


def _nearest(near: Near | None) -> str:
    from robotcell.collision.collision import FARTHEST

    if near is None:
        return f"nothing within {1000 * FARTHEST:g} mm"
    return f"{near.body} to {near.other}, {near.distance_mm:.1f} mm"


def _least(values: Scalars, words: str) -> str:
    return f"{float(values.min()):.3g} {words}"
