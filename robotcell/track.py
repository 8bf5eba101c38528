"""Whether and how a robot carries out a timed program."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from types import MappingProxyType

import numpy as np

from boards.board import Workpiece
from geometry.arrays import Indices, Scalars
from programs.errors import ProgramError
from programs.program import TILT_BAND, Command, TimedProgram
from robotcell.cell.cell import Cell
from robotcell.cell.load import LoadedCell
from robotcell.collision.clearance import Clearance
from robotcell.diagnosis.changes import Remedy
from robotcell.diagnosis.reasons import Diagnosis, PathInCell, diagnose
from robotcell.diagnosis.refusals import find_refusal
from robotcell.diagnosis.remedies import find_remedy
from robotcell.motion.cell_queries import CellQueries, HomeMoves, Lifting, build_queries, find_move
from robotcell.motion.joint_program import AddedTimes, build_robot_program
from robotcell.motion.plan_joints import OutOfReach, plan_motion
from robotcell.motion.retime import retime
from robotcell.motion.sampled_path import Flags, TrackedPath, sample_path
from robotcell.motion.track_attempt import Motion
from robotcell.robot.robot import Joints, Poses, singularity
from specs.finding import Finding, blocking, worst_first
from specs.progress import Progress, no_progress, subprogress

_MOST_TILT_DEG = 45.0


@dataclass(frozen=True, slots=True)
class Terms:
    """What the robot may do beyond the program."""

    round_nozzles: frozenset[str] = frozenset()
    """Names of nozzles whose jet is the same all around: the robot may turn it about its axis while it sprays."""
    placements: Mapping[str, Poses] = field(default_factory=lambda: MappingProxyType({}))
    """T_cell_board (4, 4) after ``CALL name``, by that name."""
    tilt_band: float = 0.0
    """rad that the robot may tilt the jet while it sprays where nothing else is clear, if the program grants less."""
    loaded: LoadedCell | None = None
    """The cell's file, whose edits are offered as remedies."""
    remedies: bool = True
    """Whether changes of the cell that would help are looked for."""


class Nearness:
    """How near robot and tool come to board and fixtures: measured when first needed, since an export never does."""

    def __init__(self, measure: Callable[[], Clearance]) -> None:
        """Keep what measures it until then."""
        self._measure: Callable[[], Clearance] | None = measure
        self._found = Clearance(np.zeros(0), ())

    def find(self) -> Clearance:
        """Measure, once."""
        if self._measure is not None:
            self._found, self._measure = self._measure(), None
        return self._found


def _none() -> Scalars:
    return np.zeros(0)


@dataclass(frozen=True, slots=True, eq=False)
class CellReport:
    """What a robot does with a program. Where it cannot carry it out, the program is the requested one."""

    cell: Cell
    requested: TimedProgram
    program: TimedProgram
    """As the robot carries it out, from home to home: the same instructions at the same places, its own times, azimuths
    and tilts; more moves where joints do not go straight between the requested ones, and where the tool is changed."""
    findings: tuple[Finding, ...]
    clock: Scalars = field(default_factory=_none)
    """(moves,) s when the requested program would be there; NaN within joint moves that it does not have."""
    corner: Flags = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    """(moves,) whether a straight line ends there, of the path or of a joint move."""
    share: Scalars = field(default_factory=_none)
    """(moves,) of a line along which the turning axes go evenly, whatever the pose does; NaN elsewhere."""
    joints: Joints = field(default_factory=lambda: np.zeros((0, 0)))
    """(moves, dof) one row for each ``MoveTo`` of the program; none where the robot cannot carry it out."""
    added: AddedTimes = field(default_factory=AddedTimes)
    """Of the motions that only the robot's program has."""
    singularity: Scalars = field(default_factory=_none)
    """(moves,) w, the manipulability."""
    condition: Scalars = field(default_factory=_none)
    """(moves,) inverse condition."""
    nearness: Nearness = field(default_factory=lambda: Nearness(lambda: Clearance(_none(), ())))
    """What ``clearance`` measures by."""
    clearance_at: Indices = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """The moves at which the clearance is measured."""
    remedy: Remedy | None = None
    """The change of the cell that the finding ``cell-remedy`` describes."""
    board: Workpiece | None = None
    """As collisions with it were checked."""
    placements: Mapping[str, Poses] = field(default_factory=lambda: MappingProxyType({}))
    """T_cell_board (4, 4) after ``CALL name``, by that name."""

    @property
    def clearance(self) -> Clearance:
        """How near robot and tool come to board and fixtures, at every move that is not part of a joint move."""
        return self.nearness.find()

    @property
    def possible(self) -> bool:
        """Whether there is a motion to show: every place is reached, if not clear of everything."""
        return len(self.joints) > 0


def terms_of(loaded: LoadedCell, tilt_band: float = 0.0) -> Terms:
    """Give the terms of a cell's file, with a tilt band in radians."""
    return Terms(loaded.round_nozzles, loaded.placements, tilt_band, loaded)


def track(
    program: TimedProgram,
    cell: Cell,
    board: Workpiece | None,
    *,
    terms: Terms | None = None,
    progress: Progress = no_progress,
) -> CellReport:
    """Find the joint motion for a whole program, or report what keeps the robot from it, and what would help.

    Cheap rules come first (``robotcell.diagnosis.refusals``): where one refuses the cell, no motion is searched in it.
    The same input gives the same result.

    Args:
        program: The program; its own findings stay with it.
        cell: The cell.
        board: For collisions; without it only the cell itself is checked, and a finding reports that.
        terms: What the robot may do beyond the program.
        progress: Receives the stage and the share done.

    Raises:
        CellError: The cell lacks a tool or a placement that the program names, the robot has no closed form, or the
            libraries of ``washboard[robot]`` are missing.
        ProgramError: The program has no move.
    """
    task = _Task(program, board, terms or Terms())
    subject, outcome = _search(task, cell, subprogress(progress, 0.0, 0.8))
    if isinstance(outcome, Motion) and not len(outcome.broken):
        progress("timing the joints", 0.72)
        diagnosis, report = _carry_out(task, subject, outcome)
    else:
        diagnosis = diagnose(subject, board, outcome)
        report = CellReport(cell, program, program, diagnosis.findings, board=board)
    if len(diagnosis.wrong) and task.terms.remedies:
        causes = ", ".join(dict.fromkeys(each.rule.id for each in report.findings if each.severity == "error"))
        begun = 0.2 if diagnosis.is_refusal else 0.8
        progress(f"{causes}: looking for a remedy", begun)
        found = find_remedy(
            subject,
            board,
            diagnosis,
            task.terms.loaded,
            lambda changed, share: _is_possible(task, changed, share),
            subprogress(progress, begun, 1.0),
        )
        if found is not None:
            remedy, finding = found
            report = replace(report, findings=worst_first([*report.findings, finding]), remedy=remedy)
    progress("robot checked", 1.0)
    return report


@dataclass(frozen=True, slots=True, eq=False)
class _Task:
    """What is to be carried out, in this cell or another."""

    program: TimedProgram
    board: Workpiece | None
    terms: Terms


def _is_possible(task: _Task, cell: Cell, progress: Progress) -> bool:
    """Whether a robot carries out a whole program without an error; it is not timed, as times make none."""
    subject, outcome = _search(task, cell, progress)
    home = _home_moves(subject.queries, outcome.tracked) if isinstance(outcome, Motion) else None
    return not blocking(diagnose(subject, task.board, outcome, home).findings, ())


def _search(task: _Task, cell: Cell, progress: Progress) -> tuple[PathInCell, Diagnosis | OutOfReach | Motion]:
    """Search the motion of a program in a cell, unless a cheap rule forbids any; give also the path, as tracked."""
    program, terms = task.program, task.terms
    progress("sampling the path", 0.0)
    tilt = max(terms.tilt_band, granted_tilt(program))
    path = sample_path(program, cell, terms.round_nozzles, terms.placements)
    queries = build_queries(program, cell, task.board, [cell.T_cell_board, *terms.placements.values()])
    subject = PathInCell(queries, path)
    outcome = find_refusal(subject, tilt) or plan_motion(queries, path, tilt, subprogress(progress, 0.0, 0.9))
    return (PathInCell(queries, outcome.tracked.path) if isinstance(outcome, Motion) else subject), outcome


def granted_tilt(program: TimedProgram) -> float:
    """Give the tilt band that a program's recipe grants, rad; the least where it states several, 0 where none.

    Raises:
        ProgramError: the value is no angle from 0 to 45 degrees.
    """
    stated = [
        item.arguments[1]
        for item in program.instructions
        if isinstance(item, Command) and item.keyword == "SET" and item.arguments[0] == TILT_BAND
    ]
    try:
        degrees = [float(text) for text in stated]
    except ValueError:
        degrees = [np.nan]
    if not all(0.0 <= each <= _MOST_TILT_DEG for each in degrees):
        raise ProgramError(f"SET {TILT_BAND} needs a number from 0 to {_MOST_TILT_DEG:g}; found {', '.join(stated)}.")
    return float(np.radians(min(degrees, default=0.0)))


def _carry_out(task: _Task, subject: PathInCell, found: Motion) -> tuple[Diagnosis, CellReport]:
    """Time a motion, and report on it."""
    queries, path, tracked = subject.queries, subject.path, found.tracked
    robot, program = queries.cell.robot, queries.program
    cuts = np.diff(tracked.piece) != 0
    for move in found.reconfigurations:
        cuts[move.begin : move.end] = True
    retiming = retime(robot, path.times, tracked.q, cuts)
    home = _home_moves(queries, tracked)
    done = build_robot_program(program, queries.cell, tracked, retiming.lasting, found.reconfigurations, home)
    w, condition = singularity(robot, done.joints)
    own = np.flatnonzero(done.row_of >= 0)
    at_sample = np.ones(len(tracked.q))
    at_sample[done.row_of[own]] = condition[own]
    carried = path.tool[done.row_of[own]], path.placement[done.row_of[own]]
    diagnosis = diagnose(subject, task.board, found, home, (retiming, at_sample))
    return diagnosis, CellReport(
        cell=queries.cell,
        requested=program,
        program=done.program,
        findings=diagnosis.findings,
        clock=np.where(done.row_of >= 0, path.times[done.row_of], np.nan),
        corner=done.corner,
        share=done.share,
        joints=done.joints,
        added=done.added,
        singularity=w,
        condition=condition,
        nearness=Nearness(partial(queries.clearance, done.joints[own], *carried)),
        clearance_at=own,
        board=task.board,
        placements=task.terms.placements,
    )


def _home_moves(queries: CellQueries, tracked: TrackedPath) -> HomeMoves:
    """Find joint moves from home to the beginning, and from the end home: through the safe height."""
    home = Lifting(queries.cell.home[None])
    ways: list[Joints] = []
    for sample in (0, len(tracked.q) - 1):
        carried = int(tracked.path.tool[sample]), int(tracked.path.placement[sample])
        lifting = queries.lifting(tracked, sample, queries.below_safe(tracked.path, sample))
        found = find_move(queries, lifting, home, carried, carried)
        ways.append(tracked.q[sample : sample + 1] if found is None else found[0])
    return HomeMoves(ways[0][::-1], ways[1])
