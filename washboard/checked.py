"""Checking whether a robot can carry a program out, and writing it in the robot's language."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import radians
from pathlib import Path
from typing import TYPE_CHECKING

from boards.board import Workpiece
from programs.program import TimedProgram
from specs.finding import Finding, blocking
from specs.output_file import output_place
from specs.progress import Progress, no_progress
from specs.rows import Rows
from washboard.inputs import open_cell
from washboard.planned import Subject

if TYPE_CHECKING:
    from programs.export import Variant
    from reports.files.robot_programs import CellExport
    from robotcell.cell.load import LoadedCell
    from robotcell.robot.robot import Joints
    from robotcell.track import CellReport


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Checked:
    """What a robot does with a program."""

    report: "CellReport"
    cell: "LoadedCell"
    """It holds the workpiece."""

    @property
    def possible(self) -> bool:
        """Whether every place is reached and nothing forbids the motion."""
        return self.report.possible and not blocking(self.report.findings, ())

    @property
    def program(self) -> TimedProgram:
        """As the robot carries it out; as planned where it cannot."""
        return self.report.program

    @property
    def findings(self) -> Rows[Finding]:
        """Obstacles to the program, and deviations from the plan; worst first."""
        return Rows(self.report.findings)

    @property
    def joints(self) -> "Joints":
        """(moves, dof) rad, m: one row for each move; none where the robot cannot carry the program out."""
        return self.report.joints

    def picture(self, suffix: str = ".png") -> bytes:
        """Draw the joints over time.

        Raises:
            JobError: there is no motion, or the suffix is neither ``.png`` nor ``.svg``.
        """
        from reports.pictures.joint_picture import draw_joints

        return draw_joints(self.report, suffix)

    def export(
        self,
        output: str | Path,
        dialect: str | None = None,
        *,
        allowed: Sequence[str] = (),
        without_joints: bool = False,
        first_run: bool = False,
    ) -> list[Path]:
        """Write the program in a robot's language.

        Args:
            output: Folder, or file of a language that has one.
            dialect: Language; left out, that of the robot's maker.
            allowed: Rules whose errors do not forbid the program.
            without_joints: Write poses only.
            first_run: Write its first run: no valve opens, it is slow, and stops before each step.

        Returns:
            The files that were written.

        Raises:
            JobError: a finding forbids it, the language cannot express it, or the place cannot be written.
        """
        from programs.errors import ProgramError
        from programs.export import Variant, find_dialect, own_dialect
        from reports.files.robot_programs import check_output, write_program
        from reports.files.write_run import export_refusal
        from robotcell.cell.installation import installation_of

        installation, place = installation_of(self.cell), output_place(output)
        language = dialect or own_dialect(installation)
        check_output(place, find_dialect(language), self.report.requested, installation)
        done = self.written(language, Variant(without_joints, first_run))
        stops = blocking(done.findings, allowed)
        if stops:
            raise ProgramError(export_refusal(stops), file=place.path)
        return write_program(place, done.exported.files, done.exported.language, done.page)

    def written(self, dialect: str | None = None, variant: "Variant | None" = None) -> "CellExport":
        """Give the program in a robot's language, with what its controller's model predicts; nothing is written.

        Args:
            dialect: Language; left out, that of the robot's maker.
            variant: Which of its programs; left out, that which is driven.

        Raises:
            JobError: the language cannot express it.
        """
        from programs.export import AS_PLANNED, own_dialect
        from reports.files.robot_programs import export_tracked
        from robotcell.cell.installation import installation_of

        language = dialect or own_dialect(installation_of(self.cell))
        return export_tracked(self.report, self.cell, language, variant or AS_PLANNED)

    def driven(self, dialect: str | None = None) -> TimedProgram:
        """Give the program as the controller of a language drives it, by its model.

        Args:
            dialect: Language; left out, that of the robot's maker.

        Raises:
            JobError: the robot cannot carry it out, or the language cannot express it.
        """
        from programs.errors import ProgramError

        if not self.report.possible:
            what = f"{self.report.cell.name} cannot carry the program out, so nothing is driven"
            raise ProgramError(f"{what}: washboard check names what keeps it from that.")
        return self.written(dialect).driven

    def __repr__(self) -> str:
        return f"<check in {self.report.cell.name}, {'possible' if self.possible else 'not possible'}>"

    def _repr_html_(self) -> str:
        words = "can be carried out" if self.possible else "cannot be carried out"
        return f"<p><b>{words} in {self.report.cell.name}</b></p>{self.findings.html()}"


def check(
    subject: Subject,
    cell: "LoadedCell | str | Path",
    progress: Progress = no_progress,
    *,
    tilt_band_deg: float = 0.0,
) -> Checked:
    """Check whether the robot of a cell reaches every point without collision, and at which speed.

    Args:
        subject: A plan, or a program that was opened.
        cell: One that is open, the name of one of the library, or a file.
        progress: Receives the stage and the share done.
        tilt_band_deg: Largest tilt that the robot may add to avoid collisions and limits.

    Raises:
        JobError: the cell cannot be used with this program, or what ``washboard[robot]`` installs is missing.
    """
    return check_in(subject.program, subject.workpiece, open_cell(cell), progress, tilt_band_deg=tilt_band_deg)


def check_in(
    program: TimedProgram,
    workpiece: Workpiece | None,
    cell: "LoadedCell",
    progress: Progress = no_progress,
    *,
    tilt_band_deg: float = 0.0,
) -> Checked:
    """As ``check``, also where the workpiece is not at hand: collisions with it are not looked for then."""
    from robotcell.cell.load import hold_board
    from robotcell.track import terms_of, track

    held = hold_board(cell, workpiece)
    terms = terms_of(held, tilt_band=radians(tilt_band_deg))
    return Checked(track(program, held.cell, workpiece, terms=terms, progress=progress), held)
