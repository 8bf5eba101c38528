"""The best place of a cell's board for one program: searched by some of its points, confirmed by the whole check.

A place is confirmed as it would be written, tenths of a millimetre and hundredths of a degree.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from boards.board import Board
from geometry.arrays import Indices
from programs.program import TimedProgram
from robotcell.cell.cell import Cell
from robotcell.cell.load import LoadedCell
from robotcell.cell.shape_spec import Place
from robotcell.cell.shapes import place_pose
from robotcell.collision.collision import build_collider
from robotcell.diagnosis.plausibility import corners_of, longest_reach
from robotcell.errors import CellError
from robotcell.motion.sampled_path import Course, course_of
from robotcell.placement.optimise import Placement, Room, Wish, find_placements, judge_placement
from robotcell.placement.reachability import Targets
from robotcell.robot.poses import inverse, roll_pitch_yaw
from robotcell.robot.robot import Poses
from robotcell.track import CellReport, terms_of, track
from specs.errors import EditError
from specs.progress import Progress, no_progress, subprogress
from specs.yaml.edit import set_value

_MOST_TARGETS = 40
_LEVER_M = 0.1
"""By which directions are compared with places when targets are chosen."""
_NEAREST_M = 0.1
_CHECKED = 3
"""Places that are checked, one after the other, until the robot can do the program at one."""
_BETTER = 1e-6
"""A place has to be better by this share."""


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """A place of the board, and what the robot does with the program there."""

    placement: Placement
    report: CellReport

    @property
    def stopped_by(self) -> tuple[str, ...]:
        """Rules of the errors that keep the robot from the program."""
        return tuple(dict.fromkeys(each.rule.id for each in self.report.findings if each.severity == "error"))


@dataclass(frozen=True, slots=True, eq=False)
class Relocation:
    """What came of a search."""

    now: Trial
    """Where the cell holds the board."""
    tried: tuple[Trial, ...]
    """Places that are better by what was asked for, best first; all but the last are refused."""
    looked_at: int
    """Places of the search."""

    @property
    def best(self) -> Trial | None:
        """The place that is better and confirmed; ``None`` if there is none."""
        return self.tried[-1] if self.tried and not self.tried[-1].stopped_by else None


def find_place(
    program: TimedProgram,
    loaded: LoadedCell,
    board: Board | None,
    wish: Wish | None = None,
    progress: Progress = no_progress,
) -> Relocation:
    """Search a better place for the board that ``board`` of the cell's file holds; ``placements`` stay.

    Args:
        program: What is to be done there.
        loaded: The cell.
        board: For collisions, and for room between the fixtures.
        wish: What is looked for; the distance is as far as the robot reaches, whatever it says.
        progress: Receives the stage and the share done.

    Raises:
        CellError: as for ``track``, or the program never moves while the board is held so.
        ProgramError: The program has no move.
    """
    terms, cell = terms_of(loaded), loaded.cell
    targets = targets_of(course_of(program, cell, terms.round_nozzles, terms.placements))
    collider = build_collider(cell, board)
    asked = wish or Wish()
    before = judge_placement(cell, targets, asked, collider)
    far = max(longest_reach(cell), before.distance, 2.0 * _NEAREST_M)
    asked = replace(asked, distance=(min(_NEAREST_M, before.distance), far))
    now = Trial(before, track(program, cell, board, terms=terms, progress=subprogress(progress, 0.0, 0.2)))
    room = None if board is None else room_of(cell, board)
    search = subprogress(progress, 0.2, 0.6)
    found = find_placements(cell, targets, asked, collider, room=room, progress=search)
    better = [each for each in found if _is_better(each, now)]
    tried: list[Trial] = []
    for number, each in enumerate(better[:_CHECKED]):
        share = subprogress(progress, 0.6 + 0.4 * number / _CHECKED, 0.6 + 0.4 * (number + 1) / _CHECKED)
        moved = replace(cell, T_cell_board=place_pose(place_of(each.T_cell_board)))
        judged = replace(
            judge_placement(moved, targets, asked, collider), distance=each.distance, yaw=each.yaw, tried=each.tried
        )
        tried.append(Trial(judged, track(program, moved, board, terms=terms, progress=share)))
        if not tried[-1].stopped_by:
            break
    progress("board placed", 1.0)
    return Relocation(now, tuple(tried), found[0].tried)


def _is_better(placement: Placement, now: Trial) -> bool:
    """Whether every point is reached, and better than now if the robot can do the program now."""
    value = now.placement.value
    return placement.value >= 0.0 and (bool(now.stopped_by) or placement.value > value + _BETTER * abs(value))


def targets_of(course: Course) -> Targets:
    """Choose some points of a course, as far from one another as there are: the outermost are among them.

    Raises:
        CellError: The board is never where the cell's ``board`` says while the robot moves.
    """
    own = np.flatnonzero(course.placement == 0)
    if not len(own):
        raise CellError(
            "the program turns the board over before it moves: the place that `board` tells is never used. "
            "Name a program that washes there.",
            path="board",
        )
    T_board_tcp = inverse(course.T_base_board[0]) @ course.T_base_tcp[own]
    tool = course.tool[own]
    used = np.unique(tool).tolist()
    free = course.free[own]
    azimuth = np.where(free[:, None], 0.0, T_board_tcp[:, :3, 0])
    points = np.hstack((T_board_tcp[:, :3, 3], _LEVER_M * T_board_tcp[:, :3, 2], _LEVER_M * azimuth))
    most = max(_MOST_TARGETS // len(used), 1)
    chosen = [rows[_spread(points[rows], most)] for rows in (np.flatnonzero(tool == each) for each in used)]
    at = np.sort(np.concatenate(chosen))
    return Targets(T_board_tcp[at], tool[at], free[at])


def _spread(points: NDArray[np.float64], most: int) -> Indices:
    """Choose points (n, k) one after the other: the farthest from the middle, then the farthest from all before."""
    apart = np.linalg.norm(points - points.mean(axis=0), axis=1)
    chosen: list[int] = []
    nearest = np.full(len(points), np.inf)
    while len(chosen) < most and nearest.max() > 1e-6:
        # Rounded, so that among equals the first in the program is taken wherever the board lies.
        chosen.append(int(np.argmax(np.round(apart, 7))))
        nearest = np.minimum(nearest, np.linalg.norm(points - points[chosen[-1]], axis=1))
        apart = nearest
    return np.array(chosen, dtype=np.int64)


def room_of(cell: Cell, board: Board) -> Room:
    """Give the question whether the box around a board keeps clear of fixtures and of the robot's base.

    What the box meets where the board is held now is left out: there it was meant so.
    """
    low = 1e-3 * np.min([body.patches.min(axis=(0, 1)) for body in board.bodies], axis=0)
    high = 1e-3 * np.max([body.patches.max(axis=(0, 1)) for body in board.bodies], axis=0)
    around = [corners_of(body) for body in cell.fixtures]
    base = [corners_of(body) for body in cell.robot.bodies[0]]
    around += [corners @ cell.T_cell_base[:3, :3].T + cell.T_cell_base[:3, 3] for corners in base]
    kept = [corners for corners in around if not _meets(corners, low, high, cell.T_cell_board)]
    return lambda T_cell_board: not any(_meets(corners, low, high, T_cell_board) for corners in kept)


def _meets(
    corners: NDArray[np.float64], low: NDArray[np.float64], high: NDArray[np.float64], T_cell_board: Poses
) -> bool:
    T_board_cell = inverse(T_cell_board)
    seen = corners @ T_board_cell[:3, :3].T + T_board_cell[:3, 3]
    return bool(np.all(seen.min(axis=0) < high) and np.all(seen.max(axis=0) > low))


def place_of(T_cell_board: Poses) -> Place:
    """Give a pose as it is written: tenths of a millimetre, hundredths of a degree."""
    x, y, z = (round(1e3 * float(value), 1) + 0.0 for value in T_cell_board[:3, 3])
    roll, pitch, yaw = (round(float(np.degrees(value)), 2) + 0.0 for value in roll_pitch_yaw(T_cell_board))
    return Place(xyz_mm=(x, y, z), rpy_deg=(roll, pitch, yaw))


def spell_place(place: Place) -> str:
    """Write ``board`` with a place as YAML."""
    turned = f", rpy_deg: {_spell(place.rpy_deg)}" if any(place.rpy_deg) else ""
    return f"board:\n  pose: {{xyz_mm: {_spell(place.xyz_mm)}{turned}}}\n"


def _spell(values: Sequence[float]) -> str:
    return f"[{', '.join(str(int(value) if value == int(value) else value) for value in values)}]"


def with_place(text: str, place: Place, file: Path) -> str:
    """Write a place under ``board`` of a cell's text; nothing else changes, comments stay.

    Args:
        text: The cell's file.
        place: Where the board is to be held.
        file: What to call it in errors.

    Raises:
        CellError: ``board`` is shared with another key by an anchor.
    """
    written = {"xyz_mm": list(place.xyz_mm)} | ({"rpy_deg": list(place.rpy_deg)} if any(place.rpy_deg) else {})
    try:
        return set_value(text, ("board",), {"pose": written})
    except EditError as error:
        raise CellError(str(error), file=file) from None
