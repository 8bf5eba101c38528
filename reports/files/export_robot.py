"""A program in a cell's robot's own language."""

from dataclasses import dataclass

import numpy as np

from boards.board import Board
from programs.export import Exported, check_maker, export, find_dialect
from programs.program import TimedProgram
from robotcell.cell.installation import installation_of
from robotcell.cell.load import LoadedCell
from robotcell.robot.robot import Joints, Robot
from robotcell.track import CellReport, terms_of, track
from specs.finding import Finding, worst_first
from specs.progress import Progress, no_progress

_MM = 1e3


@dataclass(frozen=True, slots=True, eq=False)
class CellExport:
    """What a robot does with a program, and how that is written in its language."""

    report: CellReport
    exported: Exported

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Of the robot and of the language; worst first."""
        return worst_first((*self.report.findings, *self.exported.findings))


def export_in_cell(
    program: TimedProgram,
    loaded: LoadedCell,
    dialect: str,
    board: Board | None,
    progress: Progress = no_progress,
    *,
    without_joints: bool = False,
) -> CellExport:
    """Track a program in a cell and write what the robot does; where it cannot do it, write it as planned.

    Args:
        program: As planned.
        loaded: The cell.
        dialect: A name in ``DIALECTS``.
        board: For collisions; ``None`` if it is not at hand.
        progress: Receives the stage and the share done.
        without_joints: Write poses only, also for the controller of another maker than the robot's.

    Raises:
        JobError: the robot is of another maker than the language's, the cell lacks something that the program names, or
            the language cannot express it.
    """
    if not without_joints:
        check_maker(find_dialect(dialect), installation_of(loaded))
    report = track(program, loaded.cell, board, terms=terms_of(loaded), progress=progress)
    return CellExport(report, write_tracked(report, loaded, dialect, without_joints=without_joints))


def write_tracked(report: CellReport, loaded: LoadedCell, dialect: str, *, without_joints: bool = False) -> Exported:
    """Write what a robot does with a program.

    Raises:
        ProgramError: the language needs the joint motion and there is none, or it cannot express the program.
    """
    installation = installation_of(loaded)
    if not report.possible:
        return export(report.requested, installation, dialect, without_joints=without_joints)
    joints = exported_joints(loaded.cell.robot, report.joints)
    return export(report.program, installation, dialect, joints, without_joints=without_joints)


def exported_joints(robot: Robot, joints: Joints) -> Joints:
    """Joints in the units of programs: radians, and millimetres where they are prismatic."""
    return joints * np.array([_MM if joint.kind == "prismatic" else 1.0 for joint in robot.joints])
