"""Programs in a cell's robot's own language: exported, read back with the cell, and where their files go."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from boards.board import Workpiece
from programs.errors import ProgramError
from programs.export import AS_PLANNED, Exported, Variant, check_maker, count_steps, export, find_dialect
from programs.foreign import named_cell, rebuild_program
from programs.motion.installation import Installation
from programs.motion.layout import Tracking
from programs.motion.steps import IsClear
from programs.posts.dialect import PAGE_ENDING, Dialect
from programs.program import TimedProgram
from reports.files.commissioning import commissioning_page, page_name
from robotcell.cell.hold import describe_held
from robotcell.cell.installation import exported_joints, flange_of, installation_of
from robotcell.cell.load import LoadedCell, cell_library, hold_board, read_cell
from robotcell.cell.spec import HeldBy
from robotcell.collision.collision import Collider, build_collider, collides_between, with_board_at
from robotcell.robot.robot import is_beyond
from robotcell.track import CellReport, terms_of, track
from specs.finding import Finding, worst_first
from specs.finding_rules import BOARD_PLACE_UNKNOWN
from specs.output_file import OutputError, OutputFile, OutputFolder, OutputPlace, write_outputs
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

    @property
    def page(self) -> str:
        """What an integrator has to do for the program, as Markdown."""
        return commissioning_page(self.report, self.exported, self.findings)

    @property
    def driven(self) -> TimedProgram:
        """The program as the controller drives it, by its model; as the robot does it where the text has all times."""
        return self.exported.drive(self.report.program if self.report.possible else self.report.requested)


def export_in_cell(
    program: TimedProgram,
    loaded: LoadedCell,
    dialect: str,
    board: Workpiece | None,
    progress: Progress = no_progress,
    variant: Variant = AS_PLANNED,
) -> CellExport:
    """Track a program in a cell and write what the robot does; where it cannot do it, write it as planned.

    Args:
        program: As planned.
        loaded: The cell.
        dialect: A name in ``DIALECTS``.
        board: For collisions; ``None`` if it is not at hand.
        progress: Receives the stage and the share done.
        variant: Which of its programs.

    Raises:
        JobError: the robot is of another maker than the language's, the cell lacks something that the program names, or
            the language cannot express it.
    """
    _check_maker(loaded, dialect, variant)
    held = hold_board(loaded, board)
    report = track(program, held.cell, board, terms=terms_of(held), progress=progress)
    return export_tracked(report, held, dialect, variant)


def export_tracked(report: CellReport, loaded: LoadedCell, dialect: str, variant: Variant = AS_PLANNED) -> CellExport:
    """Write what a robot does with a program that was tracked; where it cannot do it, write it as planned.

    Args:
        report: Of the tracked program.
        loaded: The cell, which holds the workpiece.
        dialect: A name in ``DIALECTS``.
        variant: Which of its programs.

    Raises:
        JobError: the robot is of another maker than the language's, or the language cannot express the program.
    """
    _check_maker(loaded, dialect, variant)
    written = write_tracked(report, loaded, dialect, variant)
    return CellExport(report, written, _check_place(report.requested, loaded, report.board))


def _check_maker(loaded: LoadedCell, dialect: str, variant: Variant) -> None:
    if not variant.without_joints:
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


def write_tracked(report: CellReport, loaded: LoadedCell, dialect: str, variant: Variant = AS_PLANNED) -> Exported:
    """Write what a robot does with a program.

    Raises:
        ProgramError: the language needs the joint motion and there is none, with what the check found; or it cannot
            express the program.
    """
    installation, language = installation_of(loaded), find_dialect(dialect)
    if report.board is not None and report.board.faces:
        installation = replace(installation, workpiece="part")
    if not report.possible:
        worst = next((each for each in worst_first(report.findings) if each.severity == "error"), None)
        if language.needs_joints and worst is not None:
            raise ProgramError(
                f"{language.title} is written from the motion of the joints, and the robot has none for this program: "
                f"{f'{worst.made_by}: ' if worst.made_by else ''}{worst.message}"
            )
        return export(report.requested, installation, dialect, variant=variant)
    return export(report.program, installation, dialect, tracking_of(report), variant)


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


def check_output(output: OutputPlace, language: Dialect, program: TimedProgram, installation: Installation) -> None:
    """Refuse a place where a program of this language cannot be, before the long work begins.

    Args:
        output: Where it is to be written.
        language: Its language.
        program: As planned.
        installation: The cell.

    Raises:
        OutputError: it cannot be written there, is no file of this language, or takes several files.
    """
    form = language.form
    if form.several and not form.is_project and isinstance(output, OutputFolder):
        endings = map(re.escape, (*form.several, *form.also, PAGE_ENDING))
        output = replace(output, only=f".*({'|'.join(endings)})")
    output.check()
    if not isinstance(output, OutputFile):
        return
    for each in with_page(output).all_written:
        each.check()
    if form.several:
        reason = f"a program in {language.title} is several files ({', '.join(form.several)})"
        raise OutputError(output.path, reason, "Name a folder, without a suffix.")
    named = {form.suffix.lower(), *form.also}
    if output.path.suffix.lower() not in named:
        reason = f"a program in {language.title} is a {form.suffix} file"
        raise OutputError(output.path, reason, f"Name a {form.suffix} file, or a folder without a suffix.")
    if language.most_steps and count_steps(program, installation, language) > language.most_steps:
        raise _too_long(output.path, language)


def _too_long(output: Path, language: Dialect) -> OutputError:
    reason = f"the program is longer than one file of {language.title} holds: {language.most_steps:,} steps"
    return OutputError(output, reason, "Name a folder, without a suffix.")


def write_program(output: OutputPlace, files: Mapping[str, str], language: Dialect, page: str) -> list[Path]:
    """Write a program's files and its page, whole or not at all; give their paths, the one to start with first.

    A single file joins what is in the folder; several are a set of their own, and replace an earlier one as a whole.

    Args:
        output: A file, or a folder.
        files: Text by file name, the one to start with first; ASCII.
        language: Their language.
        page: What the integrator has to do.

    Raises:
        OutputError: they cannot be written there, or something else is there.
    """
    if isinstance(output, OutputFile):
        if len(files) > 1:
            raise _too_long(output.path, language)
        file, *beside = with_page(output).all_written
        texts = {file: next(iter(files.values())), **dict.fromkeys(beside, page)}
        write_outputs({**texts})
        return [each.path for each in texts]
    every = {**files, page_name(files): page}
    if project := language.folder(files):
        return OutputFolder(output.path / project).write(every)
    for name in files:  # which a list of an earlier, longer program would load, are not to stay
        stem = name.removesuffix(language.form.suffix)
        for left in (output.path / f"{stem}{suffix}" for suffix in language.form.beside):
            if left.name not in files and left.exists():
                reason = f"{left.name} there belongs to a longer program"
                raise OutputError(output.path, reason, "Remove it, or name another folder.")
    folder = OutputFolder(output.path)
    return folder.write(every) if len(files) > 1 else folder.add(every)


def with_page(output: OutputFile) -> OutputFile:
    """Give the file of a program with the page beside it."""
    return replace(output, beside=(PAGE_ENDING,))
