"""The path of the TCP through a program, sampled densely enough for the joints. Metres, seconds, radians."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars
from geometry.frames import rotation_angles, slerp
from programs.motion.make_motion import find_corners
from programs.playback import Timeline, build_timeline
from programs.program import Command, MoveTo, TimedProgram, Wait
from robotcell.cell.cell import Cell
from robotcell.errors import CellError
from robotcell.robot.robot import Joints, Poses, row_pieces

Flags: TypeAlias = NDArray[np.bool_]

STEP_M = 5e-3
"""Samples are never farther apart than this,"""
STEP_RAD = np.radians(3.0)
"""nor turned by more than this,"""
STEP_S = 0.1
"""nor, while the TCP moves, apart in time by more than this."""
_SAME_M = 1e-8
_FAR_TURN, _LEAST_PARTS = np.radians(10.0), 4
"""A turn on the spot, rad, from which on it may go another way, and in how many samples at least."""
_TURNS = ("flip_to_top", "flip_to_bottom")
"""What a plan calls when the side changes; the cell holds the board with its top up."""


@dataclass(frozen=True, slots=True, eq=False)
class SampledPath:
    """The moves of a program, both ends of its waits, and the samples between them: n in order."""

    times: Scalars
    """(n,) the program's own clock, s."""
    T_base_tcp: Poses
    """(n, 4, 4) as programmed, in the robot's base frame."""
    T_base_board: Poses
    """(p, 4, 4) the board's placements: as the cell holds it, and turned over."""
    placement: Indices
    """(n,) index of the placement in use."""
    instruction: Indices
    """(n,) the move or wait that the sample is, or leads to; ascending."""
    exact: Flags
    """(n,) whether it is the pose of that ``MoveTo`` itself."""
    corner: Flags
    """(n,) whether a line of the program ends here, or something happens at rest."""
    tool: Indices
    """(n,) index into the cell's tools."""
    changed: Flags
    """(n,) whether the tool was changed, or the board turned, since the sample before it."""
    jet_on: Flags
    """(n,) whether the jet is on just before or just after it."""
    free: Flags
    """(n,) whether the azimuth about the jet is free: the jet is off, or it is round."""
    dwelling: Flags
    """(n,) whether the TCP rests from this sample to the next."""


@dataclass(frozen=True, slots=True, eq=False)
class TrackedPath:
    """A path as the robot tracks it: its joints at the n samples."""

    path: SampledPath
    q: Joints
    """(n, dof); inside a reconfiguration move it is where that begins."""
    T_base_tcp: Poses
    """(n, 4, 4) as the robot reaches it: with the chosen azimuth and tilt."""
    azimuth: Scalars
    """(n,) rad, about the jet, from the programmed one."""
    tilt: NDArray[np.float64]
    """(n, 2) rad, from the programmed direction."""
    piece: Indices
    """(n,) samples that are reached without a reconfiguration have the same number."""
    lost: Flags
    """(n,) whether no configuration was found here; the joints are those of the nearest node then."""
    share: Scalars
    """(n,) done of a line along which the turning axes go evenly; NaN elsewhere, and where one begins."""


def sample_path(
    program: TimedProgram, cell: Cell, round_nozzles: frozenset[str], placements: Mapping[str, Poses]
) -> SampledPath:
    """Sample the path of the TCP through a program.

    Args:
        program: The program; it has at least one move.
        cell: Whose tools the program names.
        round_nozzles: Names of nozzles whose jet is the same all around its axis.
        placements: T_cell_board (4, 4) after ``CALL name``, by that name.

    Raises:
        CellError: The program needs a tool or a placement of the board that the cell does not have.
        ProgramError: The program has no move.
    """
    timeline = build_timeline(program)
    moves = [at for at, item in enumerate(program.instructions) if isinstance(item, MoveTo)]
    waits = [at for at, item in enumerate(program.instructions) if isinstance(item, Wait)]
    owner = np.sort(np.array([*moves, *waits, *waits], dtype=np.int64))
    tool, placement_of, is_round, turning = _states(program, cell, round_nozzles, placements)
    keys, state, fresh, turned = _key_poses(owner, tool, placement_of, turning)
    times, T_board_tcp, parent, is_key, dwelling = _interpolate(timeline, keys, fresh | turned)
    switched = [np.searchsorted(timeline.switch_times, times, side="left")]
    switched += [np.searchsorted(timeline.switch_times, times, side="right")]
    jet_on = timeline.switched_on[switched[0]] | timeline.switched_on[switched[1]]
    T_base_board = np.linalg.inv(cell.T_cell_base) @ np.stack((cell.T_cell_board, *placements.values()))
    placement = placement_of[state][parent]
    is_move = np.isin(owner[keys], np.array(moves, dtype=np.int64))
    changed = is_key & (fresh | turned)[parent]
    exact = is_key & (is_move & ~fresh)[parent]
    corner = changed | np.append(changed[1:], True) | dwelling | np.concatenate(([True], dwelling[:-1]))
    corner[exact] |= find_corners(program, timeline)[np.searchsorted(moves, owner[keys][parent[exact]])]
    T_base_tcp = T_board_tcp  # overwritten, some rows at a time: another array would double the memory
    for rows in row_pieces(len(times)):
        T_base_tcp[rows] = T_base_board[placement[rows]] @ T_board_tcp[rows]
    return SampledPath(
        times=times,
        T_base_tcp=T_base_tcp,
        T_base_board=T_base_board,
        placement=placement,
        instruction=np.where(fresh, state, owner[keys])[parent],
        exact=exact,
        corner=corner,
        tool=tool[state][parent],
        changed=changed,
        jet_on=jet_on,
        free=~jet_on | is_round[state][parent],
        dwelling=dwelling,
    )


def _states(
    program: TimedProgram, cell: Cell, round_nozzles: frozenset[str], placements: Mapping[str, Poses]
) -> tuple[Indices, Indices, Flags, Flags]:
    """Give the cell's state while each instruction runs: tool, placement, whether the nozzle is round.

    And whether it moves around the board's edge while the board is turned over: the robot waits for that.
    """
    if not cell.tools:
        raise CellError(f"cell {cell.name} has no tool. Add one.", path="tools")
    tools = {tool.number: index for index, tool in enumerate(cell.tools)}
    turns = {_TURNS[0]: 0} | {name: index for index, name in enumerate(placements, 1)}
    tool, placement, is_round, turned_by = 0, 0, False, None
    rows: list[tuple[int, int, bool, bool]] = []
    for item in program.instructions:
        if item.made_by != turned_by:
            turned_by = None
        match item:
            case Command(keyword="NOZZLE", arguments=(name, _, number, *_)):
                if int(number) not in tools:
                    raise CellError(
                        f"the program needs tool {number} (nozzle {name}, {item.made_by}), and cell {cell.name} has "
                        f"{', '.join(map(str, tools))}. Add the tool to the cell, or change the nozzle's tool in the "
                        "recipe.",
                        path="tools",
                    )
                tool, is_round = tools[int(number)], name in round_nozzles
            case Command(keyword="CALL", arguments=(name, *_)) if name in turns or name in _TURNS:
                if name not in turns:
                    raise CellError(
                        f"the program turns the board over (CALL {name}, {item.made_by}), and cell {cell.name} has no "
                        f"pose of the board for that. Add it under placements.{name}.",
                        path="placements",
                    )
                placement, turned_by = turns[name], item.made_by
            case _:
                pass
        rows.append((tool, placement, is_round, turned_by is not None and isinstance(item, MoveTo)))
    table = np.array(rows, dtype=np.int64)
    return table[:, 0], table[:, 1], table[:, 2] > 0, table[:, 3] > 0


def _key_poses(
    owner: Indices, tool: Indices, placement: Indices, turning: Flags
) -> tuple[Indices, Indices, Flags, Flags]:
    """Choose the key poses that the robot goes to: their index, the instruction whose state applies, and two flags.

    The flags mark the pose before repeated with another tool, and poses that are reached by turning the board over.
    """
    kept = np.flatnonzero(~(turning[owner] & np.append(turning[owner][1:], False)))
    state = owner[kept]
    turned = np.concatenate(([False], np.diff(placement[state]) != 0))
    other = np.flatnonzero(np.concatenate(([False], np.diff(tool[state]) != 0)) & ~turned)
    keys = np.insert(kept, other, kept[other - 1])
    fresh = np.insert(np.zeros(len(kept), dtype=np.bool_), other, True)
    return keys, np.insert(state, other, state[other]), fresh, np.insert(turned, other, False)


def _interpolate(timeline: Timeline, keys: Indices, apart: Flags) -> tuple[Scalars, Poses, Indices, Flags, Flags]:
    """Put samples between the key poses, straight in position and by slerp, where they are far apart.

    Returns:
        Times, T_board_tcp (n, 4, 4) in metres, the key pose that each sample is or leads to, whether it is that pose,
        and whether the TCP rests until the next sample.
    """
    from scipy.spatial.transform import Rotation

    times, tcp, quaternion = timeline.times[keys], timeline.tcp[keys], timeline.quaternion[keys]
    lengths = np.linalg.norm(np.diff(tcp, axis=0), axis=1) * 1e-3
    angles = rotation_angles(quaternion[:-1], quaternion[1:])
    moves = (lengths > 1e-9) | (angles > 1e-9)
    steps = np.maximum(np.maximum(lengths / STEP_M, angles / STEP_RAD), np.diff(times) / STEP_S)
    parts = np.where(moves & ~apart[1:], np.maximum(np.ceil(np.round(steps, 6)), 1), 1).astype(np.int64)
    parent, before, share, is_key = _divide(parts)
    places = np.where(is_key[:, None], tcp[parent], tcp[before] + share[:, None] * (tcp[parent] - tcp[before]))
    poses = np.zeros((len(parent), 4, 4))
    for rows in row_pieces(len(parent)):
        turn = slerp(quaternion[before[rows]], quaternion[parent[rows]], share[rows])
        poses[rows, :3, :3] = Rotation.from_quat(turn, scalar_first=True).as_matrix()
    poses[:, :3, 3], poses[:, 3, 3] = places * 1e-3, 1.0
    between = times[before] + share * (times[parent] - times[before])
    resting = np.append(~moves & ~apart[1:], False)
    return np.where(is_key, times[parent], between), poses, parent, is_key, is_key & resting[parent]


def runs_of(flags: Flags) -> list[tuple[int, int]]:
    """Give the stretches in which flags are set: the first place, and the one after the last."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], flags, [False])).astype(np.int8)))
    return list(zip(edges[0::2].tolist(), edges[1::2].tolist(), strict=True))


def find_spot_turns(path: SampledPath) -> list[tuple[int, int]]:
    """Give the first and the last sample of each stretch in which the tool turns far on the spot with the jet on."""
    way = np.linalg.norm(np.diff(path.T_base_tcp[:, :3, 3], axis=0), axis=1)
    turns = jet_turns(path.T_base_tcp)
    turning = (way < _SAME_M) & (turns > 1e-6) & path.jet_on[1:] & path.jet_on[:-1] & ~path.changed[1:]
    found = runs_of(turning)
    return [(a, b) for a, b in found if b - a >= _LEAST_PARTS and turns[a:b].sum() > _FAR_TURN]


def jet_turns(poses: Poses) -> Scalars:
    """Give by how much the jets of poses (n, 4, 4) turn from each to the next: (n - 1,) rad."""
    jets = poses[:, :3, 2]
    return np.arccos(np.clip(np.sum(jets[1:] * jets[:-1], axis=1), -1.0, 1.0))


def turns_between(poses: Poses) -> Scalars:
    """Give by how much poses (n, 4, 4) turn from each to the next: (n - 1,) rad."""
    turns = np.einsum("nji,njk->nik", poses[:-1, :3, :3], poses[1:, :3, :3])
    return np.arccos(np.clip(0.5 * (np.trace(turns, axis1=1, axis2=2) - 1.0), -1.0, 1.0))


def turns_within(poses: Poses, begin: Indices, end: Indices, share: Scalars) -> Poses:
    """Give the rotations (k, 3, 3) a share (k,) of the way from one of some poses (n, 4, 4) to another, by slerp."""
    from scipy.spatial.transform import Rotation

    ends = [np.asarray(Rotation.from_matrix(poses[at, :3, :3]).as_quat(scalar_first=True)) for at in (begin, end)]
    return Rotation.from_quat(slerp(ends[0], ends[1], share), scalar_first=True).as_matrix()


def _divide(parts: Indices) -> tuple[Indices, Indices, Scalars, Flags]:
    """Cut k - 1 intervals between k rows into parts.

    Returns:
        Of each new row the old one that it is or leads to, the old one before that, its share of the way from the one
        to the other, and whether it is an old row.
    """
    parts = np.concatenate(([1], parts))
    parent = np.repeat(np.arange(len(parts)), parts)
    number = np.arange(len(parent)) - (np.cumsum(parts) - parts)[parent] + 1
    return parent, np.maximum(parent - 1, 0), number / parts[parent], number == parts[parent]


def refine_path(path: SampledPath, parts: Indices) -> tuple[SampledPath, Indices]:
    """Cut intervals (n - 1,) into parts; give the new path and where each old sample is in it."""
    parent, before, share, is_old = _divide(parts)
    poses, new = path.T_base_tcp[parent], ~is_old
    poses[new, :3, :3] = turns_within(path.T_base_tcp, before[new], parent[new], share[new])
    start, end = path.T_base_tcp[before[new], :3, 3], path.T_base_tcp[parent[new], :3, 3]
    poses[new, :3, 3] = start + share[new, None] * (end - start)
    times = path.times[before] + share * (path.times[parent] - path.times[before])
    kept = {name: getattr(path, name)[parent] for name in ("placement", "instruction", "tool")}
    kept |= {name: getattr(path, name)[parent] & is_old for name in ("exact", "corner", "changed", "dwelling")}
    refined = SampledPath(
        times=np.where(is_old, path.times[parent], times),
        T_base_tcp=poses,
        T_base_board=path.T_base_board,
        jet_on=np.where(is_old, path.jet_on[parent], path.jet_on[parent] & path.jet_on[before]),
        free=np.where(is_old, path.free[parent], path.free[parent] | path.free[before]),
        **kept,
    )
    return refined, np.flatnonzero(is_old)
