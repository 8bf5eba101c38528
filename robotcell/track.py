"""Whether and how a robot carries out a timed program."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from boards.board import Workpiece
from geometry.arrays import Indices, Scalars
from programs.errors import ProgramError
from programs.program import TILT_BAND, Command, TimedProgram
from robotcell.cell.cell import Cell
from robotcell.cell.hold import describe_held, plan_bounds_mm
from robotcell.cell.load import LoadedCell
from robotcell.collision.clearance import Clearance
from robotcell.diagnosis.changes import Remedy
from robotcell.diagnosis.findings import PathInCell, breaks, collisions, nearly_singular, slowness, tilts, unreachable
from robotcell.diagnosis.plausibility import check_cell
from robotcell.diagnosis.refusals import Refusal, find_refusal
from robotcell.diagnosis.remedies import find_remedies, sample_points
from robotcell.motion.cell_queries import CellQueries, build_queries
from robotcell.motion.joint_move import HomeMoves, Lifting, Reconfiguration, find_move
from robotcell.motion.joint_program import AddedTimes, build_robot_program
from robotcell.motion.plan_joints import OutOfReach, plan_motion
from robotcell.motion.retime import retime
from robotcell.motion.sampled_path import Flags, SampledPath, TrackedPath, sample_path
from robotcell.motion.track_attempt import Motion
from robotcell.robot.robot import Joints, Poses, flange_poses, singularity
from specs.finding import Finding, blocking, worst_first
from specs.finding_rules import (
    BOARD_NOT_CHECKED,
    CELL_REMEDY,
    HOME_BLOCKED,
    TOOL_CHANGE_ABOVE_BOARD,
)
from specs.progress import Progress, no_progress, subprogress

_MOST_TILT_DEG = 45.0
_MM = 1e3
_MOST_CHECKED = 2
"""Remedies that are checked as a whole after a search."""
_MOST_AFTER_REFUSAL = 4
"""The same after a cheap refusal, in a program of few samples."""
_SAMPLES_CHECKED = 40_000
"""Samples of the path in all these checks."""


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


@dataclass(frozen=True, slots=True, eq=False)
class CellReport:
    """What a robot does with a program. Where it cannot carry it out, the program is the requested one."""

    cell: Cell
    requested: TimedProgram
    program: TimedProgram
    """As the robot carries it out, from home to home: the same instructions at the same places, its own times, azimuths
    and tilts; more moves where joints do not go straight between the requested ones, and where the tool is changed."""
    clock: Scalars
    """(moves,) s when the requested program would be there; NaN within joint moves that it does not have."""
    corner: Flags
    """(moves,) whether a straight line ends there, of the path or of a joint move."""
    share: Scalars
    """(moves,) of a line along which the turning axes go evenly, whatever the pose does; NaN elsewhere."""
    joints: Joints
    """(moves, dof) one row for each ``MoveTo`` of the program; (0, dof) where the robot cannot carry it out."""
    added: AddedTimes
    """Of the motions that only the robot's program has."""
    singularity: Scalars
    """(moves,) w, the manipulability."""
    condition: Scalars
    """(moves,) inverse condition."""
    clearance: Clearance
    """How near robot and tool come to board and fixtures, at every move that is not part of a joint move."""
    clearance_at: Indices
    """Which moves these are."""
    findings: tuple[Finding, ...]
    remedy: Remedy | None = None
    """The change of the cell that the finding ``cell-remedy`` describes."""
    board: Workpiece | None = None
    """As collisions with it were checked."""
    placements: Mapping[str, Poses] = field(default_factory=lambda: MappingProxyType({}))
    """T_cell_board (4, 4) after ``CALL name``, by that name."""

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
    trial = _try(task, cell, subprogress(progress, 0.0, 0.8))
    report = trial.report
    if trial.wrong is not None and task.terms.remedies:
        causes = ", ".join(dict.fromkeys(each.rule.id for each in report.findings if each.severity == "error"))
        begun = 0.8 if trial.refusal is None else 0.2
        progress(f"{causes}: looking for a remedy", begun)
        found = _remedy(task, cell, trial, subprogress(progress, begun, 1.0))
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


@dataclass(frozen=True, slots=True, eq=False)
class _Trial:
    """A program tried in a cell."""

    report: CellReport
    path: SampledPath
    nodes: Indices
    """Samples at which configurations are chosen."""
    wrong: Indices | None
    """Those that are not reached or not clear; ``None`` where there are none."""
    refusal: Refusal | None = None
    """Set where a cheap rule refused the cell."""


@dataclass(frozen=True, slots=True, eq=False)
class _Searched:
    """A motion that was found, before it is timed."""

    subject: PathInCell
    motion: Motion
    findings: list[Finding]
    """Of collisions and of what is not reached in one go."""
    broken: Indices
    """Samples at which the motion is not one."""


def _try(task: _Task, cell: Cell, progress: Progress) -> _Trial:
    """Carry out a program in a cell as far as that goes; no remedies."""
    searched = _search(task, cell, progress)
    if isinstance(searched, _Trial):
        return searched
    subject, found, findings = searched.subject, searched.motion, searched.findings
    wrong = np.union1d(found.hits, searched.broken)
    if len(searched.broken):
        report = _without_motion(subject.queries, [*check_cell(cell, task.board), *findings])
    else:
        progress("timing the joints", 0.9)
        report = _with_motion(subject, task.board, found, findings)
        report = replace(report, board=task.board, placements=task.terms.placements)
    return _Trial(report, subject.path, found.nodes.sample, wrong if len(wrong) else None)


def _is_possible(task: _Task, cell: Cell, progress: Progress) -> bool:
    """Whether a robot carries out a whole program without an error; it is not timed, as times make none."""
    searched = _search(task, cell, progress)
    if isinstance(searched, _Trial):
        return not blocking(searched.report.findings, ())
    home = _home_moves(searched.subject.queries, searched.motion.tracked)
    return not blocking([*searched.findings, *_check_home(searched.subject, home)], ())


def _search(task: _Task, cell: Cell, progress: Progress) -> _Searched | _Trial:
    """Search the motion of a program in a cell; a trial without one where a rule or a pose out of reach forbids it."""
    program, board, terms = task.program, task.board, task.terms
    progress("sampling the path", 0.0)
    tilt = max(terms.tilt_band, granted_tilt(program))
    path = sample_path(program, cell, terms.round_nozzles, terms.placements)
    queries = build_queries(program, cell, board, [cell.T_cell_board, *terms.placements.values()])
    refusal = find_refusal(PathInCell(queries, path), tilt)
    if refusal is not None:
        report = _without_motion(queries, [*check_cell(cell, board), *refusal.findings])
        return _Trial(report, path, refusal.nodes, refusal.wrong if len(refusal.wrong) else None, refusal)
    found = plan_motion(queries, path, tilt, subprogress(progress, 0.0, 0.9))
    if isinstance(found, OutOfReach):
        samples = found.nodes.sample[found.empty]
        findings = [*check_cell(cell, board), *unreachable(PathInCell(queries, path), samples)]
        return _Trial(_without_motion(queries, findings), path, found.nodes.sample, samples)
    subject = PathInCell(queries, found.tracked.path)
    findings = [*breaks(subject, found), *collisions(subject, found)]
    broken = np.concatenate((found.nodes.sample[found.discontinuities], found.nodes.sample[found.blocked], found.lost))
    return _Searched(subject, found, findings, broken)


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


def _without_motion(queries: CellQueries, findings: list[Finding]) -> CellReport:
    none = np.zeros(0)
    return CellReport(
        cell=queries.cell,
        requested=queries.program,
        program=queries.program,
        clock=none,
        corner=none > 0.0,
        share=none,
        joints=np.zeros((0, queries.cell.robot.dof)),
        added=AddedTimes(),
        singularity=none,
        condition=none,
        clearance=Clearance(none, ()),
        clearance_at=np.zeros(0, dtype=np.int64),
        findings=worst_first(findings),
    )


def _with_motion(subject: PathInCell, board: Workpiece | None, found: Motion, findings: list[Finding]) -> CellReport:
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
    findings = [*findings, *_check_home(subject, home), *tilts(subject, tracked)]
    findings += _check_tool_changes(subject, board, found.reconfigurations)
    findings += [*nearly_singular(subject, at_sample), *slowness(subject, retiming)]
    if board is None:
        message = (
            f"the board {program.origin.board} was not found: collisions with it were not checked"
            + _assumed(queries.cell)
            + ". Name it with --board."
        )
        findings.append(Finding(BOARD_NOT_CHECKED, message))
    return CellReport(
        cell=queries.cell,
        requested=program,
        program=done.program,
        clock=np.where(done.row_of >= 0, path.times[done.row_of], np.nan),
        corner=done.corner,
        share=done.share,
        joints=done.joints,
        added=done.added,
        singularity=w,
        condition=condition,
        clearance=queries.clearance(done.joints[own], path, done.row_of[own]),
        clearance_at=own,
        findings=worst_first(findings),
    )


def _assumed(cell: Cell) -> str:
    """What is taken for the board's place where the board is not known."""
    if cell.held_by == "origin":
        return ""
    return f", and the origin of its file was taken for the {describe_held(cell.held_by)} that the cell holds it by"


def _home_moves(queries: CellQueries, tracked: TrackedPath) -> HomeMoves:
    """Find joint moves from home to the beginning, and from the end home: through the safe height."""
    home = Lifting(queries.cell.home[None])
    ways: list[Joints] = []
    for sample in (0, len(tracked.q) - 1):
        tool, placement = int(tracked.path.tool[sample]), int(tracked.path.placement[sample])
        lifting = queries.lifting(tracked, sample, queries.below_safe(tracked.path, sample))
        found = find_move(queries.cell, lifting, home, (tool, tool), queries.blocked_at(placement))
        ways.append(tracked.q[sample : sample + 1] if found is None else found[0])
    return HomeMoves(ways[0][::-1], ways[1])


def _check_home(subject: PathInCell, home: HomeMoves) -> list[Finding]:
    """Report where the way from home to the beginning, or back from the end, is blocked."""
    findings: list[Finding] = []
    ends = ((0, home.out, "from home to the beginning"), (-1, home.back, "from the end back home"))
    for sample, way, text in ends:
        if len(way) < 2:
            message = f"every joint move {text} that was tried collides; choose another home, or move there by hand."
            at = sample % len(subject.path.times)
            findings.append(Finding(HOME_BLOCKED, message, subject.made_by(at), subject.place(at)))
    return findings


def _check_tool_changes(
    subject: PathInCell, board: Workpiece | None, moves: tuple[Reconfiguration, ...]
) -> Iterator[Finding]:
    """Report the first change of a tool whose orifice is above the board, or below it."""
    cell, path = subject.queries.cell, subject.path
    if board is None:
        return
    for move in moves:
        row = move.way[move.change : move.change + 1]
        for sample in (move.begin, move.end) if move.change else ():
            T_base_tcp = flange_poses(cell.robot, row)[0] @ cell.tools[int(path.tool[sample])].T_flange_tcp
            place = np.linalg.inv(path.T_base_board[int(path.placement[sample])]) @ T_base_tcp[:, 3]
            left, front, right, back, _ = plan_bounds_mm(board)
            if left <= _MM * place[0] <= right and front <= _MM * place[1] <= back:
                key = "home_deg_mm" if cell.tool_change is None else "tool_change_deg_mm"
                message = (
                    f"the tool is changed above {board.name}, at {key} of cell {cell.name}: what drips or falls there "
                    "lands on it. State joints beside the board under tool_change_deg_mm."
                )
                yield Finding(TOOL_CHANGE_ABOVE_BOARD, message, subject.made_by(move.end), subject.place(move.end))
                return


def _remedy(task: _Task, cell: Cell, trial: _Trial, progress: Progress) -> tuple[Remedy | None, Finding] | None:
    """Find what would help, and report it: checked as a whole, as a few points do not show the ways between them."""
    if trial.wrong is None:
        return None
    points = sample_points(trial.path, trial.nodes, trial.wrong)
    if not len(points.chosen.tool):
        return None
    through = () if trial.refusal is None else trial.refusal.through_base

    def find(most: int) -> tuple[Remedy, ...]:
        return find_remedies(cell, task.board, points, task.terms.loaded, through_base=through, most=most)

    found = find(1 if trial.refusal is not None else _MOST_CHECKED)
    if not found:
        return None
    return _first_that_passes(task, trial, found, find, progress)


def _first_that_passes(
    task: _Task,
    trial: _Trial,
    found: tuple[Remedy, ...],
    find: Callable[[int], tuple[Remedy, ...]],
    progress: Progress,
) -> tuple[Remedy | None, Finding]:
    """Check remedies as a whole, one after the other; others than those found first only where the first fails."""
    most = _MOST_CHECKED
    if trial.refusal is not None:
        most = min(max(_SAMPLES_CHECKED // len(trial.path.times), 1), _MOST_AFTER_REFUSAL)
    for number in range(most):
        if number == len(found) == 1:
            found = find(most)
        if number >= len(found):
            break
        share = subprogress(progress, number / most, (number + 1) / most)
        if _is_possible(task, found[number].cell, share):
            text = "the robot can do the program, which was checked as a whole"
            return found[number], _remedy_finding(found[number], text)
    return None, _no_remedy(found[:most])


def _no_remedy(tried: Sequence[Remedy]) -> Finding:
    """Report that no change helps, and which were checked."""
    changes = "; ".join(each.text for each in tried)
    text = f"no single change was found with which the robot can do the program; checked as a whole, {changes}"
    return Finding(
        CELL_REMEDY, f"{text}: each leaves an error. Clear the space about robot and board, then check again."
    )


def _remedy_finding(remedy: Remedy, text: str) -> Finding:
    edits = f" Write in the cell: {'; '.join(map(str, remedy.edits))}" if remedy.edits else ""
    return Finding(CELL_REMEDY, f"{remedy.text} {text}.{edits}")
