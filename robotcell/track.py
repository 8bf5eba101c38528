"""Whether and how a robot carries out a timed program."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from boards.board import Board
from geometry.arrays import Indices, Scalars
from programs.errors import ProgramError
from programs.program import TILT_BAND, Command, TimedProgram
from robotcell.cell.cell import Cell
from robotcell.cell.load import LoadedCell
from robotcell.collision.clearance import Clearance
from robotcell.diagnosis.findings import Scene, breaks, collisions, leaning, nearly_singular, slowness, unreachable
from robotcell.diagnosis.plausibility import check_cell
from robotcell.diagnosis.remedies import find_remedy, places_of, share_reached
from robotcell.motion.attempt import Motion
from robotcell.motion.cell_queries import Questions, ask_of
from robotcell.motion.joint_move import find_move
from robotcell.motion.joint_program import retell
from robotcell.motion.plan_joints import OutOfReach, find_motion
from robotcell.motion.retime import pace
from robotcell.motion.sampled_path import Course, Flags, course_of
from robotcell.motion.track_branch import Followed
from robotcell.robot.conditioning import singularity
from robotcell.robot.robot import Joints, Poses
from specs.finding import Finding, worst_first
from specs.finding_rules import BOARD_NOT_CHECKED, CELL_REMEDY, HOME_BLOCKED
from specs.progress import Progress, no_progress, subprogress

_MOST_LEAN_DEG = 45.0


@dataclass(frozen=True, slots=True)
class Terms:
    """What the robot may do that the program does not ask for."""

    round_nozzles: frozenset[str] = frozenset()
    """Names of nozzles whose jet is the same all around: the robot may turn it about its axis while it sprays."""
    placements: Mapping[str, Poses] = field(default_factory=lambda: MappingProxyType({}))
    """T_cell_board (4, 4) after ``CALL name``, by that name."""
    lean: float = 0.0
    """rad that the jet may lean while it sprays where nothing else is clear, if the program itself grants less."""


@dataclass(frozen=True, slots=True, eq=False)
class CellReport:
    """What a robot does with a program. Where it cannot do it, the program is the one that was asked for."""

    cell: Cell
    asked: TimedProgram
    program: TimedProgram
    """As the robot does it: the same instructions at the same places, its own times, azimuths and leans; more moves
    where joints do not go straight between the asked ones."""
    joints: Joints
    """(moves, dof) one row for each ``MoveTo`` of the program; (0, dof) where the robot cannot do it."""
    singularity: Scalars
    """(moves,) w, the manipulability."""
    condition: Scalars
    """(moves,) inverse condition."""
    clearance: Clearance
    """How near robot and tool come to board and fixtures, at every move that is not part of a joint move."""
    clearance_at: Indices
    """Which moves these are."""
    findings: tuple[Finding, ...]

    @property
    def possible(self) -> bool:
        """Whether there is a motion to show: every place is reached, if not clear of everything."""
        return len(self.joints) > 0


def terms_of(loaded: LoadedCell, lean: float = 0.0) -> Terms:
    """Give the terms that a cell's file states, and a tilt band in radians."""
    return Terms(loaded.round_nozzles, loaded.placements, lean)


def track(
    program: TimedProgram,
    cell: Cell,
    board: Board | None,
    *,
    terms: Terms | None = None,
    progress: Progress = no_progress,
) -> CellReport:
    """Find the joint motion for a whole program, or say what keeps the robot from it.

    The same input gives the same result.

    Args:
        program: What is to be done; its own findings stay with it.
        cell: The cell.
        board: For collisions; without it only the cell itself is looked at, and a finding says so.
        terms: What the robot may do beyond the program.
        progress: Receives the stage and the share done.

    Raises:
        CellError: The cell lacks a tool or a placement that the program names, the robot has no closed form, or the
            libraries of ``washboard[robot]`` are missing.
        ProgramError: The program has no move.
    """
    allowed = terms or Terms()
    progress("laying out the course", 0.0)
    lean = max(allowed.lean, granted_lean(program))
    course = course_of(program, cell, allowed.round_nozzles, allowed.placements)
    ask = ask_of(program, cell, board, [cell.T_cell_board, *allowed.placements.values()])
    found = find_motion(ask, course, lean, subprogress(progress, 0.0, 0.9))
    if isinstance(found, OutOfReach):
        report = _impossible(ask, course, board, found)
    elif len(found.torn) or len(found.blocked) or len(found.lost):
        report = _refused(ask, board, found)
    else:
        progress("timing the joints", 0.9)
        report = _told(ask, board, found)
    progress("robot checked", 1.0)
    return report


def granted_lean(program: TimedProgram) -> float:
    """Give the tilt band that a program's recipe grants, rad; the least where it states several, 0 where none.

    Raises:
        ProgramError: what the program says is no angle from 0 to 45 degrees.
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
    if not all(0.0 <= each <= _MOST_LEAN_DEG for each in degrees):
        raise ProgramError(f"SET {TILT_BAND} needs a number from 0 to {_MOST_LEAN_DEG:g}; found {', '.join(stated)}.")
    return float(np.radians(min(degrees, default=0.0)))


def _impossible(ask: Questions, course: Course, board: Board | None, found: OutOfReach) -> CellReport:
    samples = found.nodes.sample[found.empty]
    findings = unreachable(Scene(ask, course), samples)
    findings += _remedy(ask.cell, board, course, found.nodes.sample, samples)
    return _without_motion(ask, [*check_cell(ask.cell, board), *findings])


def _refused(ask: Questions, board: Board | None, found: Motion) -> CellReport:
    scene = Scene(ask, found.done.course)
    findings = [*breaks(scene, found), *collisions(scene, found)]
    if len(found.hits):
        findings += _remedy(ask.cell, board, found.done.course, found.nodes.sample, found.hits)
    return _without_motion(ask, [*check_cell(ask.cell, board), *findings])


def _without_motion(ask: Questions, findings: list[Finding]) -> CellReport:
    none = np.zeros(0)
    return CellReport(
        cell=ask.cell,
        asked=ask.program,
        program=ask.program,
        joints=np.zeros((0, ask.cell.robot.dof)),
        singularity=none,
        condition=none,
        clearance=Clearance(none, ()),
        clearance_at=np.zeros(0, dtype=np.int64),
        findings=worst_first(findings),
    )


def _told(ask: Questions, board: Board | None, found: Motion) -> CellReport:
    done = found.done
    scene = Scene(ask, done.course)
    timing = pace(ask.cell.robot, done.course.times, done.q, _cuts(found))
    told = retell(ask.program, ask.cell, done, timing.lasting, list(found.leaps))
    w, condition = singularity(ask.cell.robot, told.joints)
    own = told.row_of >= 0
    at_sample = np.ones(len(done.q))
    at_sample[told.row_of[own]] = condition[own]
    findings = [*breaks(scene, found), *collisions(scene, found)]
    if len(found.hits):
        findings += _remedy(ask.cell, board, done.course, found.nodes.sample, found.hits)
    findings += [*_home(ask, done), *leaning(scene, done), *nearly_singular(scene, at_sample), *slowness(scene, timing)]
    findings += [] if board is not None else [_without_board(ask.program)]
    looked_at = np.flatnonzero(own)
    return CellReport(
        cell=ask.cell,
        asked=ask.program,
        program=told.program,
        joints=told.joints,
        singularity=w,
        condition=condition,
        clearance=ask.nearest(told.joints[looked_at], done.course, told.row_of[looked_at]),
        clearance_at=looked_at,
        findings=worst_first(findings),
    )


def _cuts(found: Motion) -> Flags:
    """(n - 1,) intervals that joint moves stand for."""
    cuts = np.diff(found.done.piece) != 0
    for leap in found.leaps:
        cuts[leap.begin : leap.end] = True
    return cuts


def _home(ask: Questions, done: Followed) -> list[Finding]:
    """Say where the way from home to the beginning, or back from the end, is blocked."""
    findings: list[Finding] = []
    for sample, text in ((0, "from home to the beginning"), (len(done.q) - 1, "from the end back home")):
        tool, placement = int(done.course.tool[sample]), int(done.course.placement[sample])
        ends = ask.cell.home[None], ask.raised(done.q[sample], done.T_base_tcp[sample], tool)
        move = find_move(ask.cell, *ends, (tool, tool), ask.blocked(placement))
        if move is None:
            message = f"the straight joint move {text} collides; choose another home, or go there by hand."
            scene = Scene(ask, done.course)
            findings.append(Finding(HOME_BLOCKED, message, scene.made_by(sample), scene.place(sample)))
    return findings


def _without_board(program: TimedProgram) -> Finding:
    text = (
        f"the board {program.origin.board} was not at hand: no collision with it was looked for. Name it with --board."
    )
    return Finding(BOARD_NOT_CHECKED, text)


def _remedy(cell: Cell, board: Board | None, course: Course, nodes: Indices, wrong: Indices) -> list[Finding]:
    """Say what would help, if anything that was tried does."""
    places = places_of(course, nodes, wrong)
    text = find_remedy(cell, board, places)
    if text is None:
        return []
    share = share_reached(cell, places)
    message = f"{text}; as it stands {share:.0%} of the {len(places.tool)} points that were tried are reached at all."
    return [Finding(CELL_REMEDY, message)]
