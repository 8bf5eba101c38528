"""Programs in a cell's robot's own language: exported, read back with the cell, and where their files go."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from boards.board import Workpiece
from programs.errors import ProgramError
from programs.export import Exported, check_maker, export, find_dialect
from programs.foreign import named_cell, rebuild_program
from programs.motion.layout import Tracking
from programs.motion.steps import IsClear
from programs.posts.dialect import Dialect
from programs.program import TimedProgram
from reports.files.atomic_write import OutputError, output_errors, write_files, write_text_atomically
from reports.files.write_run import check_apart, check_folder
from robotcell.cell.hold import describe_held
from robotcell.cell.installation import exported_joints, flange_of, installation_of
from robotcell.cell.load import LoadedCell, cell_library, hold_board, read_cell
from robotcell.cell.spec import HeldBy
from robotcell.collision.collision import Collider, build_collider, collides_between, with_board_at
from robotcell.robot.robot import is_beyond
from robotcell.track import CellReport, terms_of, track
from specs.finding import Finding, worst_first
from specs.finding_rules import BOARD_PLACE_UNKNOWN
from specs.progress import Progress, no_progress
from specs.source import Source

_MM = 1e3


@dataclass(frozen=True, slots=True, eq=False)
class CellExport:
    """What a robot does with a program, and how that is written in its language."""

    report: CellReport
    exported: Exported
    placing: tuple[Finding, ...] = ()
    """What is not known of the board's place."""

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Of the board's place, the robot and the language; worst first."""
        return worst_first((*self.placing, *self.report.findings, *self.exported.findings))


def export_in_cell(
    program: TimedProgram,
    loaded: LoadedCell,
    dialect: str,
    board: Workpiece | None,
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
    _check_maker(loaded, dialect, without_joints=without_joints)
    held = hold_board(loaded, board)
    report = track(program, held.cell, board, terms=terms_of(held), progress=progress)
    return export_tracked(report, held, dialect, without_joints=without_joints)


def export_tracked(report: CellReport, loaded: LoadedCell, dialect: str, *, without_joints: bool = False) -> CellExport:
    """Write what a robot does with a program that was tracked; where it cannot do it, write it as planned.

    Args:
        report: Of the tracked program.
        loaded: The cell, which holds the workpiece.
        dialect: A name in ``DIALECTS``.
        without_joints: Write poses only, also for the controller of another maker than the robot's.

    Raises:
        JobError: the robot is of another maker than the language's, or the language cannot express the program.
    """
    _check_maker(loaded, dialect, without_joints=without_joints)
    written = write_tracked(report, loaded, dialect, without_joints=without_joints)
    return CellExport(report, written, _check_place(report.requested, loaded, report.board))


def _check_maker(loaded: LoadedCell, dialect: str, *, without_joints: bool) -> None:
    if not without_joints:
        check_maker(find_dialect(dialect), installation_of(loaded))


def _check_place(program: TimedProgram, loaded: LoadedCell, board: Workpiece | None) -> tuple[Finding, ...]:
    """Report where the place of the board's frame depends on a board that is not at hand."""
    every: list[HeldBy] = [hold.held_by for hold in (loaded.spec.board, *loaded.spec.placements.values())]
    holds: list[HeldBy] = [held_by for held_by in every if held_by != "origin"]
    if board is not None or not holds:
        return ()
    message = (
        f"cell {loaded.cell.name} holds the board by its {describe_held(holds[0])}, and the board "
        f"{program.origin.board} was not found: where its own frame is, is not known. Name the board with --board, or "
        "write `hold: origin` under `board` of the cell if its file's origin is there."
    )
    return (Finding(BOARD_PLACE_UNKNOWN, message, Source(entry="board")),)


def write_tracked(report: CellReport, loaded: LoadedCell, dialect: str, *, without_joints: bool = False) -> Exported:
    """Write what a robot does with a program.

    Raises:
        ProgramError: the language needs the joint motion and there is none, or it cannot express the program.
    """
    installation = installation_of(loaded)
    if not report.possible:
        return export(report.requested, installation, dialect, without_joints=without_joints)
    return export(report.program, installation, dialect, tracking_of(report), without_joints=without_joints)


def tracking_of(report: CellReport) -> Tracking:
    """Give how a robot carries out a program, in the units of programs."""
    joints = exported_joints(report.cell.robot, report.joints)
    return Tracking(joints, report.clock, report.corner, report.share, _check_of(report))


def _check_of(report: CellReport) -> IsClear:
    """Give the check whether joints, in the units of programs, go from row to row in their travel and hit nothing."""
    units = exported_joints(report.cell.robot, np.ones(report.cell.robot.dof))

    @cache
    def collider(placement: str) -> Collider:
        if placement in report.placements:
            return with_board_at(collider(""), report.placements[placement])
        return build_collider(report.cell, report.board)

    @cache
    def is_clear(rows: tuple[tuple[float, ...], ...], tool: int, placement: str) -> bool:
        joints = np.array(rows) / units
        if is_beyond(report.cell.robot, joints).any():
            return False
        return not collides_between(collider(placement), joints[:-1], joints[1:], tool).any()

    return is_clear


def find_cell(files: Mapping[str, str], place: Path, advice: str) -> LoadedCell:
    """Read the library cell that the header of a program names.

    Args:
        files: Text by file name.
        place: Of the program, for the error.
        advice: How the cell is named otherwise, for the error.

    Raises:
        ProgramError: none is named, or it is not in the library.
    """
    name = named_cell(files)
    if name not in cell_library():
        named = f"made for cell {name}, which is not in the library" if name else "no cell is named in its header"
        raise ProgramError(f"{named}; {advice}", file=place)
    return read_cell(name)


def rebuild_in_cell(dialect: str, files: Mapping[str, str], loaded: LoadedCell) -> TimedProgram:
    """Execute the text of a program with the tools, valves and kinematics of a cell.

    Raises:
        ProgramError: it is not understood, or was made for another robot.
    """
    return rebuild_program(dialect, files, installation_of(loaded), flange_of(loaded.cell))


def check_output(output: Path, language: Dialect, read: Sequence[str | Path | None]) -> None:
    """Refuse a place where a program of this language cannot be, before the long work begins.

    A place with a suffix that is not a folder by now is a file, any other a folder.

    Args:
        output: Where the program is to be written.
        language: Its language.
        read: What the command reads.

    Raises:
        OutputError: it cannot be written there, is no file of this language, or the language has several files.
    """
    if not _is_file(output):
        check_folder(output)
        return
    check_apart(read, [output])
    form = language.form
    if form.several:
        reason = f"a program in {language.title} is several files ({', '.join(form.several)})"
        raise OutputError(output, reason, "Name a folder, without a suffix.")
    named = {form.suffix.lower(), *form.also}
    if output.suffix.lower() not in named:
        reason = f"a program in {language.title} is a {form.suffix} file"
        raise OutputError(output, reason, f"Name a {form.suffix} file, or a folder without a suffix.")


def write_program(output: Path, files: Mapping[str, str], language: Dialect) -> list[Path]:
    """Write a program's files whole or not at all; give their paths, the one to start with first.

    Args:
        output: A file, or a folder: as ``check_output`` reads it.
        files: Text by file name, the one to start with first; ASCII.
        language: Their language.

    Raises:
        OutputError: they cannot be written there, or something else is there.
    """
    if _is_file(output):
        if len(files) > 1:
            reason = f"the program is longer than one file of {language.title} holds, and has {len(files)}"
            raise OutputError(output, reason, "Name a folder, without a suffix.")
        write_text_atomically(output, next(iter(files.values())))
        return [output]
    if project := language.folder(files):
        with output_errors(output):
            output.mkdir(exist_ok=True)
        return write_files(output / project, files)
    for name in files:  # which a list of an earlier, longer program would load, are not to stay
        stem = name.removesuffix(language.form.suffix)
        for left in (output / f"{stem}{suffix}" for suffix in language.form.beside):
            if left.name not in files and left.exists():
                reason = f"{left.name} there belongs to a longer program"
                raise OutputError(output, reason, "Remove it, or name another folder.")
    return write_files(output, files)


def _is_file(output: Path) -> bool:
    return bool(output.suffix) and not output.is_dir()
