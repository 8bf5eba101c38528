"""Search for the best placement of a cell's workpiece: for a program, confirmed by the whole check, or for a surface.

A place is confirmed as it would be written, tenths of a millimetre and hundredths of a degree.
"""

from dataclasses import dataclass, replace

import numpy as np

from boards.board import Workpiece
from geometry.rays import build_ray_scene, cast
from programs.program import TimedProgram
from robotcell.cell.cell import Cell, HasRoom, all_rooms, longest_reach, place_pose, room_of, room_on_table
from robotcell.cell.cell_edits import place_of
from robotcell.cell.load import LoadedCell, hold_board
from robotcell.cell.spec import Place
from robotcell.collision.collision import build_collider
from robotcell.errors import CellError
from robotcell.motion.sampled_path import SampledPath, sample_path
from robotcell.placement.configurations import PlacementDetails, Struck, describe_placement
from robotcell.placement.evaluate import PlacementGoal, PlacementTask
from robotcell.placement.optimise import Placement, find_placements, judge_placement
from robotcell.placement.placement_map import MapGrid, PlacementMap, map_placements, refine_map
from robotcell.placement.reachability import Targets
from robotcell.placement.search_space import SearchSpace
from robotcell.robot.robot import Poses, inverse
from robotcell.track import CellReport, terms_of, track
from specs.finding_rules import OUT_OF_REACH
from specs.progress import Progress, no_progress, subprogress

_NEAREST_M = 0.1
_M_PER_MM = 1e-3
_LONGEST_MM = 1000.0
_CHECKED = 3
"""Places that are checked, one after the other, until the robot can carry out the program at one; then as many again
that would help at those."""
_BETTER = 1e-6
"""Share by which a place has to be better."""


@dataclass(frozen=True, slots=True, eq=False)
class PlacementTrial:
    """A place of the workpiece, and the check of the program there."""

    placement: Placement
    cell: Cell
    """With the workpiece there."""
    checked: CellReport | None = None
    """``None`` for targets on a surface: there is no program that could be carried out."""

    @property
    def report(self) -> CellReport:
        """The check of the program."""
        assert self.checked is not None
        return self.checked

    @property
    def stopped_by(self) -> tuple[str, ...]:
        """Rules of the errors that keep the robot from the program; of targets, whether it reaches them well enough."""
        if self.checked is None:
            return () if self.placement.value >= 0.0 else (OUT_OF_REACH.id,)
        return tuple(dict.fromkeys(each.rule.id for each in self.checked.findings if each.severity == "error"))

    @property
    def held_at(self) -> Place:
        """Where the point that the workpiece is held by is then, as it is written."""
        return place_of(self.placement.T_cell_board @ self.cell.T_board_held)


@dataclass(frozen=True, slots=True, eq=False)
class Relocation:
    """The result of a search."""

    present: PlacementTrial
    """At the cell's own placement."""
    tried: tuple[PlacementTrial, ...]
    """Places with a better value, best first, then those that would help at a refused one; all but the last refused."""
    evaluated: int
    """Number of places of the search."""
    details: PlacementDetails
    """What each configuration reaches at the best place, or, if there is none, at the last that was tried."""
    mapped: PlacementMap | None
    """``None`` if no map was requested."""
    workpiece: Workpiece | None
    """What is placed, if it is known."""

    @property
    def best(self) -> PlacementTrial | None:
        """The place that is better and confirmed; ``None`` if there is none."""
        return self.tried[-1] if self.tried and not self.tried[-1].stopped_by else None

    @property
    def refused(self) -> bool:
        """Whether the robot can do it at no place that was checked."""
        return self.best is None and (self.present.checked is None or bool(self.present.stopped_by))

    @property
    def moved_to(self) -> Place | None:
        """Where the board is held then; ``None`` if it stays where it is."""
        return None if self.best is None else self.best.held_at


def find_place(
    what: TimedProgram | Targets,
    loaded: LoadedCell,
    board: Workpiece | None,
    goal: PlacementGoal | None = None,
    grid: MapGrid | None = None,
    progress: Progress = no_progress,
) -> Relocation:
    """Search a better place for the workpiece that ``board`` of the cell's file holds; ``placements`` stay.

    Args:
        what: The program to be carried out there, or targets on the workpiece's surface, in its frame.
        loaded: The cell.
        board: For collisions, and for room between the fixtures.
        goal: What is maximised; its distance is replaced by as far as the robot reaches. With a table the board may be
            carried around the base's axis; else it stays in its direction.
        grid: A map is made of it if given.
        progress: Receives the stage and the share done.

    Raises:
        CellError: as for ``track``, or the program never moves while the board is at the pose under ``board``.
        ProgramError: The program has no move.
    """
    loaded = hold_board(loaded, board)
    terms, cell = terms_of(loaded), loaded.cell
    mapping = subprogress(progress, 0.3, 0.6)
    if isinstance(what, Targets):
        program, targets = None, what
    else:
        program, targets = what, targets_of(sample_path(what, cell, terms.round_nozzles, terms.placements))
    collider = build_collider(cell, board)
    bounded, has_room = _bounded(cell, board, targets, goal or PlacementGoal())

    def trial(moved: Cell, share: Progress) -> PlacementTrial:
        placement = judge_placement(moved, targets, bounded, collider)
        checked = None if program is None else track(program, moved, board, terms=terms, progress=share)
        return PlacementTrial(placement, moved, checked)

    present = trial(cell, subprogress(progress, 0.0, 0.2))
    search = subprogress(progress, 0.2, 0.6 if grid is None else 0.3)
    found = find_placements(cell, targets, bounded, collider, has_room=has_room, progress=search)
    task = PlacementTask(cell, targets, bounded, collider)
    mapped = None if grid is None else _mapped(task, grid, found[0], has_room, mapping)
    if mapped is not None and mapped.refined is not None and mapped.refined.value > found[0].value:
        found = (_as_found(task, mapped.refined, found[0].tried), *found)
    value = present.placement.value + _BETTER * abs(present.placement.value)
    better = [each for each in found if each.value >= 0.0 and (present.stopped_by or each.value > value)]
    tried: list[PlacementTrial] = []
    # No target is beyond what was evaluated, so that the best place by all of them is the only one to look at.
    waiting = [(each, each.T_cell_board) for each in (found[:1] if program is None else better[:_CHECKED])]
    while waiting and (not tried or tried[-1].stopped_by):
        each, T_cell_board = waiting.pop(0)
        part = len(tried) / (2 * _CHECKED), (len(tried) + 1) / (2 * _CHECKED)
        share = subprogress(progress, *(0.6 + 0.4 * done for done in part))
        made = trial(cell.with_held_at(place_pose(place_of(T_cell_board @ cell.T_board_held))), share)
        judged = replace(made.placement, yaw=each.yaw, direction=each.direction, tried=each.tried)
        tried.append(replace(made, placement=judged))
        # The best by some points may lie just beyond what the whole program allows: the place that would help there.
        if len(tried) + len(waiting) < 2 * _CHECKED and (helped := _moved_by_remedy(made.checked)) is not None:
            waiting.append((each, helped))
    details = describe_placement(tried[-1].cell if tried else cell, targets, bounded, collider)
    details = details if board is None else replace(details, struck=_struck(board, targets))
    progress("board placed", 1.0)
    return Relocation(present, tuple(tried), found[0].tried, details, mapped, board)


def _struck(workpiece: Workpiece, targets: Targets) -> Struck:
    """Follow the jet of each target to the workpiece."""
    bodies = [body for body in workpiece.bodies if body.role != "fixture"]
    patches, normals = (np.concatenate(each) for each in zip(*((b.patches, b.normals) for b in bodies), strict=True))
    owner = np.repeat(np.arange(len(bodies)), [len(each.patches) for each in bodies])
    scene = build_ray_scene(patches, normals, owner, _LONGEST_MM)
    origins, jets = targets.T_board_tcp[:, :3, 3] / _M_PER_MM, targets.T_board_tcp[:, :3, 2]
    faces, distances = cast(scene, origins, jets)
    known = np.where(np.isfinite(distances), distances, np.nan)
    names = tuple(bodies[scene.body[face]].name if face >= 0 else "" for face in faces.tolist())
    return Struck(_M_PER_MM * (origins + known[:, None] * jets), names)


def _bounded(
    cell: Cell, board: Workpiece | None, targets: Targets, goal: PlacementGoal
) -> tuple[PlacementGoal, HasRoom | None]:
    """Bound a goal by the robot's reach; give also where there is room on the table and between the fixtures."""
    distance = float(SearchSpace(PlacementTask(cell, targets, goal, None), None).here[0])
    far = max(longest_reach(cell), distance, 2.0 * _NEAREST_M)
    bounded = replace(goal, distance=(min(_NEAREST_M, distance), far))
    between = None if board is None else room_of(cell, board)
    if goal.table is None:
        return bounded, between
    if board is None:
        points = targets.T_board_tcp[:, :3, 3]
    else:
        own = [body.patches.reshape(-1, 3) for body in board.bodies if body.role != "fixture"]
        points = _M_PER_MM * np.concatenate(own)
    return replace(bounded, direction=(-np.pi, np.pi)), all_rooms(room_on_table(goal.table, points), between)


def _mapped(
    task: PlacementTask, grid: MapGrid, found: Placement, has_room: HasRoom | None, progress: Progress
) -> PlacementMap:
    """Map placements with a node at the best that was found, but for its height; search beside the best node."""
    grid = replace(grid, through=found.T_cell_board) if found.value >= 0.0 else grid
    mapped = map_placements(task, grid, has_room, subprogress(progress, 0.0, 0.8))
    return refine_map(task, mapped, has_room, subprogress(progress, 0.8, 1.0))


def _as_found(task: PlacementTask, placement: Placement, tried: int) -> Placement:
    """Give a place beside the map's best node with its turns counted from where the workpiece lies."""
    yaw, direction = SearchSpace(task, None).turns_of(placement.T_cell_board)
    return replace(placement, yaw=yaw, direction=direction, tried=tried)


def _moved_by_remedy(report: CellReport | None) -> Poses | None:
    """Where the remedy of a refused place puts the board; ``None`` if there is none, or it changes anything else."""
    if report is None or report.remedy is None:
        return None
    before, after = report.cell, report.remedy.cell
    same = after.tools is before.tools and after.fixtures is before.fixtures and after.robot is before.robot
    moved = not np.array_equal(after.T_cell_board, before.T_cell_board)
    return after.T_cell_board if same and moved else None


def targets_of(path: SampledPath) -> Targets:
    """Give the points of a path at which the board is at the pose under ``board``; each counts once.

    Points between which the configuration may not change, as the jet is on, are of one stroke.

    Raises:
        CellError: The robot never moves while the board is there.
    """
    own = np.flatnonzero(path.placement == 0)
    if not len(own):
        raise CellError(
            "the program turns the board over before it moves: the pose under `board` is never used. "
            "Name a program that washes there.",
            path="board",
        )
    T_board_tcp = inverse(path.T_base_board[0]) @ path.T_base_tcp[own]
    off = ~path.jet_on
    may_change = (off[1:] & off[:-1]) | path.changed[1:]
    stroke = np.concatenate([[0], np.cumsum(may_change)]).astype(np.int64)
    return Targets(T_board_tcp, path.tool[own], path.free[own], stroke=stroke[own])
