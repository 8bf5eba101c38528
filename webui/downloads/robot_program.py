"""The program of a robot as a page gives it away: checked, written in the robot's language, packed."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from programs.errors import ProgramError
from robotcell.cell.installation import installation_of
from robotcell.robot.robot import Joints, Robot
from rulesengine.planning.pipeline import Run
from specs.finding import Finding, blocking, worst_first
from specs.progress import Progress, subprogress
from webui.downloads.downloads import Download, plain_name, refuse_errors
from webui.downloads.program_text import Written, write_program, zip_bytes
from webui.page.checked import Checked, check_program
from webui.page.session import Session

_CHECKING = 0.8
"""Share of the work that the check is."""


@dataclass(frozen=True, slots=True, eq=False)
class Made:
    """A robot's program and the check that it comes from."""

    checked: Checked
    written: Written

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Of the plan, of the check and of the writing, worst first."""
        return worst_first((*self.checked.run.findings, *self.checked.findings, *self.written.findings))


def make_program(session: Session, dialect: str, progress: Progress) -> Made:
    """Write the program of a session for the robot of its cell; it is checked first if it was not.

    Raises:
        JobError: there is no such program yet, or it cannot be written.
    """
    run, cell = session.run, session.cell
    if cell is None:
        raise ProgramError("no cell is chosen; choose one in the tab Robot.")
    if run is None or not session.planned:
        raise ProgramError("the recipe as it is now is not planned yet; wait until it is, or mend what stops it.")
    checked = session.check or check_program(run, cell, subprogress(progress, 0.0, _CHECKING))
    joints = None if checked.motion is None else exported_joints(cell.cell.robot, checked.motion.joints)
    progress("writing", _CHECKING)
    return Made(checked, write_program(checked.program, installation_of(cell), dialect, joints))


def exported_joints(robot: Robot, joints: Joints) -> Joints:
    """Give joints as programs hold them: radians, and millimetres where they slide."""
    return joints * np.array([1000.0 if joint.kind == "prismatic" else 1.0 for joint in robot.joints])


def download_program(made: Made, allowed: Collection[str]) -> Download:
    """Pack a program for the browser: one file as it is, several as a zip; the same program gives the same bytes.

    Args:
        made: The program.
        allowed: Rules whose errors do not forbid it.

    Raises:
        ProgramError: a finding forbids it.
    """
    refuse_errors(made.findings, allowed)
    content = made.written.content
    if len(content) == 1:
        name, text = next(iter(content.items()))
        return Download(name, text.encode("ascii"))
    return Download(f"{_name_of(made.checked.run)}-{made.written.dialect}.zip", zip_bytes(content))


def forbidding(made: Made) -> tuple[str, ...]:
    """Rules whose errors forbid a program, each once."""
    return tuple(dict.fromkeys(finding.rule.id for finding in blocking(made.findings, ())))


def _name_of(run: Run) -> str:
    return f"{plain_name(run.board.name)}-{plain_name(run.recipe.recipe)}"
