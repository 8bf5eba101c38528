"""Programs in robots' languages, read from the project folder or an upload, and rebuilt to be drawn and played."""

import io
import zipfile
import zlib
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path, PurePosixPath

import numpy as np

from boards.board import Workpiece
from boards.load import board_library, load_board
from programs.errors import ProgramError
from programs.foreign import is_foreign, named_cell, read_files
from programs.plan import Jet, Origin, Plan, SprayPass, Transfer
from programs.playback import Timeline, build_timeline, play
from programs.posts.dialects import DIALECTS
from programs.program import TimedProgram
from reports.files.robot_programs import find_cell, rebuild_in_cell
from rulesengine.planning.pipeline import Run
from specs.confinement import admit
from specs.progress import Progress, subprogress
from specs.source import NO_SOURCE
from specs.temporary import temporary_folder, write_temporary
from washboard.inputs import find_workpiece
from webui.page.project import Project, check_name
from webui.page.session import ReadBack, Session

_LARGEST_ZIP = 50_000_000
"""Bytes of an upload, packed and unpacked."""
_MOST_FILES = 500
_ADVICE = "choose its cell in the tab Robot first."
_JET = Jet("jet", "", "", 0.0, liquid=True)
_UNPACKING = (zipfile.BadZipFile, zlib.error, RuntimeError, NotImplementedError, EOFError, OSError, ValueError)
"""What the standard library raises for zips that are damaged, encrypted or packed otherwise."""


def read_project_program(project: Project, name: str, session: Session, progress: Progress) -> ReadBack:
    """Read a program of the project folder, as ``washboard show`` does.

    Args:
        project: The folder.
        name: A file, or a folder with ``/`` at its end, as the browser sent it.
        session: What is open while it is read.
        progress: Receives the stage and the share done.

    Raises:
        JobError: it is outside the folder, is not understood, or its cell or board is not known.
    """
    path = project.locate_entry(name)
    progress("reading the program", 0.0)
    dialect, files = read_files(path)
    return _rebuild(dialect, files, path, session.resumed(), subprogress(progress, 0.2, 1.0))


def read_uploaded_program(
    project: Project, name: str, content: bytes, session: Session, progress: Progress
) -> ReadBack:
    """Read an uploaded program, one file or a zip of several; it is not stored.

    Raises:
        JobError: it is none, is not understood, or its cell or board is not known.
    """
    check_name(name)
    packed = name.lower().endswith(".zip")
    files = unpack(name, content) if packed else {name: content}
    if not packed and not is_foreign(Path(name)):
        raise ProgramError("this is no program in a robot's language, nor a zip of its files.", file=Path(name))
    progress("reading the program", 0.0)
    with temporary_folder() as folder, ExitStack() as stack:
        for each, data in files.items():
            write_temporary(folder, each, data)
        stack.enter_context(admit(*(folder / each for each in files)))
        try:
            dialect, texts = read_files(folder if packed else folder / name)
        except ProgramError as error:  # the file as the browser names it
            raise ProgramError(str(error).replace(f"{folder}/", "").replace(str(folder), name)) from None
    return _rebuild(dialect, texts, project.folder / name, session.resumed(), subprogress(progress, 0.2, 1.0))


def unpack(name: str, content: bytes) -> Mapping[str, bytes]:
    """Unpack a zip in memory: its files by their names, without folders; those of other kinds are left out.

    Raises:
        ProgramError: it is damaged, has too many files, unpacks to too much, or has two files of one name.
    """
    place, files, left = Path(name), dict[str, bytes](), _LARGEST_ZIP
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            entries = [each for each in archive.infolist() if not each.is_dir()]
            if len(entries) > _MOST_FILES:
                raise ProgramError(f"{len(entries):,} files are too many for one program.", file=place)
            for entry in entries:
                plain = PurePosixPath(entry.filename.replace("\\", "/")).name
                if not is_foreign(Path(plain)):
                    continue
                check_name(plain)
                if plain in files:
                    raise ProgramError(f"it has several files {plain}; pack one program alone.", file=place)
                with archive.open(entry) as packed:
                    files[plain] = packed.read(left + 1)
                left -= len(files[plain])
                if left < 0:
                    raise ProgramError(f"it unpacks to more than {_LARGEST_ZIP:,} bytes.", file=place)
    except _UNPACKING as error:
        raise ProgramError(f"this zip cannot be unpacked: {error}; pack it again.", file=place) from None
    if not files:
        raise ProgramError("there is no program in a robot's language in this zip.", file=place)
    return files


def _rebuild(dialect: str, files: Mapping[str, str], path: Path, session: Session, progress: Progress) -> ReadBack:
    name = named_cell(files)
    own = session.cell is not None and name in ("", session.cell.cell.name)
    loaded = session.cell if own and session.cell is not None else find_cell(files, path, _ADVICE)
    program = rebuild_in_cell(dialect, files, loaded)
    timeline = build_timeline(program)
    progress("looking for its board", 0.5)
    workpiece_name, workpiece, note = _workpiece_of(program, path, session, subprogress(progress, 0.5, 1.0))
    run = Run(session.recipe, session.recipe, workpiece, paths_of(program, timeline), program)
    return ReadBack(path.name, DIALECTS[dialect].title, loaded.cell.name, workpiece_name, note, run)


def _workpiece_of(
    program: TimedProgram, path: Path, session: Session, progress: Progress
) -> tuple[str, Workpiece, str]:
    """Name, board or part, and note: what is open if it is the program's, else a sample, or one beside the program.

    Raises:
        JobError: there is none.
    """
    origin = program.origin
    if session.workpiece.sha256 == origin.board_sha256:
        return session.workpiece_name, session.workpiece, ""
    if origin.board_sha256 == _UNNAMED.board_sha256:
        return session.workpiece_name, session.workpiece, "The text does not name its board."
    found = find_workpiece(program, path, None, progress)
    if found is not None:
        return origin.board, found, ""
    note = f"The board has changed since: the text names sha256 {origin.board_sha256[:16]}."
    if origin.board == session.workpiece.name:
        return session.workpiece_name, session.workpiece, note
    if origin.board in board_library():
        return origin.board, load_board(board_library()[origin.board], None, progress), note
    message = f"made for {origin.board}, which is no sample; choose its board in the tab Board first."
    raise ProgramError(message, file=path)


_UNNAMED = Origin("", "0", "", "0")


def paths_of(program: TimedProgram, timeline: Timeline) -> Plan:
    """Divide the way of a program where the jet is switched: passes that spray, and transfers."""
    within = (timeline.switch_times > timeline.times[0]) & (timeline.switch_times < timeline.times[-1])
    times = np.unique(np.concatenate((timeline.times, timeline.switch_times[within])))
    if len(times) < 2:
        return Plan(program.origin, (), ())
    states, between = play(timeline, times), play(timeline, (times[:-1] + times[1:]) / 2.0)
    on = between.spraying
    begins = np.flatnonzero(np.concatenate(([True], on[1:] != on[:-1])))
    ends = np.append(begins[1:], len(on))
    items: list[SprayPass | Transfer] = []
    for begin, end in zip(begins.tolist(), ends.tolist(), strict=True):
        rows = slice(begin, end + 1)
        tcp, approach = states.tcp[rows], states.approach[rows]
        way = float(np.linalg.norm(np.diff(tcp, axis=0), axis=1).sum())
        speed = way / float(times[end] - times[begin])
        if on[begin]:
            speeds = np.full(len(tcp) - 1, speed)
            items.append(SprayPass(tcp, approach, np.zeros_like(approach), speeds, _JET, NO_SOURCE))
        else:
            items.append(Transfer(tcp, approach, np.zeros_like(approach), speed, NO_SOURCE))
    return Plan(program.origin, tuple(items), ())
