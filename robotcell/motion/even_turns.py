"""Lines along which a gantry's two turning axes go evenly: its turns on the spot, and its ways with the jet off.

Along such a line only the ends are programmed for the axes: between them each goes straight, and the carriage keeps
the orifice on its line. So a turn is one motion of both axes, as a controller in tool points drives one block, and it
may end with the jet tilted the other way: then it passes by the vertical, and the first axis turns a quarter or so back
where it would wind up otherwise. Laps around a part turn a tilted jet at each corner, always the same way.
"""

from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Indices, Scalars
from robotcell.cell.cell import Cell
from robotcell.kinematics.inverse import gantry_of
from robotcell.motion.sampled_path import (
    Flags,
    SampledPath,
    TrackedPath,
    find_spot_turns,
    jet_turns,
    runs_of,
    turns_between,
)
from robotcell.robot.robot import Poses, flange_poses

_STILL_M, _STILL_RAD = 1e-7, 1e-6
_LAP_EVERY = np.radians(60.0)
"""The jet turns by this from one short line of a lap to the next: by 200 degrees a lap if it is tilted by 35."""
_LAP_TURN, _LAP_M = np.radians(6.0), 1.5e-3
"""Such a line ends where the jet has turned so far, or the orifice has gone so far: it is nearly straight."""
_CARRIAGE = 3
"""Joints of the carriage come first, those that turn after them."""


@dataclass(frozen=True, slots=True, eq=False)
class EvenLines:
    """Lines of a path, in order: l of them."""

    first: Indices
    """(l,) sample at which each begins"""
    last: Indices
    """(l,) sample at which it ends; another one may begin there"""

    def at(self, place: Indices) -> "EvenLines":
        """Give the lines of a finer path, in which each old sample is at a place (n,)."""
        return EvenLines(place[self.first], place[self.last])

    def inside(self, count: int) -> Flags:
        """Mark the samples (count,) between the ends of a line."""
        step = np.zeros(count + 1, dtype=np.int64)
        np.add.at(step, self.first + 1, 1)
        np.add.at(step, self.last, -1)
        return np.cumsum(step)[:count] > 0


NO_LINES = EvenLines(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64))


def find_even_lines(path: SampledPath, cell: Cell) -> EvenLines:
    """Find the lines of a path along which the turning axes of a gantry may go evenly; none for other robots.

    These are the turns on the spot of a jet whose azimuth is free, and the lines with the jet off all the way.
    """
    if gantry_of(cell.robot) is None:
        return NO_LINES
    corner = np.flatnonzero(path.corner)
    bounds = {
        name: np.concatenate(([0], np.cumsum(flags)))
        for name, flags in (("on", path.jet_on), ("changed", path.changed), ("held", ~path.free))
    }
    begin, end = corner[:-1], corner[1:]
    inner = bounds["on"][end] - bounds["on"][begin + 1]
    fits = (inner == 0) & (end > begin + 1) & (bounds["changed"][end + 1] == bounds["changed"][begin + 1])
    fits &= ~path.dwelling[begin]
    found = set(zip(begin[fits].tolist(), end[fits].tolist(), strict=True))
    found |= {(a, b) for a, b in find_spot_turns(path) if bounds["held"][b + 1] == bounds["held"][a]}
    return EvenLines(*np.array(sorted(found), dtype=np.int64).reshape(-1, 2).T)


def with_lap_lines(path: SampledPath, lines: EvenLines) -> EvenLines:
    """Give the lines of a gantry's path, and short ones of laps that turn a round jet without a turn on the spot."""
    turns = jet_turns(path.T_base_tcp)
    way = np.linalg.norm(np.diff(path.T_base_tcp[:, :3, 3], axis=0), axis=1)
    laps = path.jet_on[:-1] & path.jet_on[1:] & path.free[:-1] & path.free[1:]
    laps &= (turns > _STILL_RAD) & (way > _STILL_M) & ~path.changed[1:]
    found = list(zip(lines.first.tolist(), lines.last.tolist(), strict=True))
    for a, b in runs_of(laps):
        turned, gone = (np.concatenate(([0.0], np.cumsum(each[a:b]))) for each in (turns, way))
        begin = np.searchsorted(turned, np.arange(0.5 * _LAP_EVERY, turned[-1] - _LAP_TURN, _LAP_EVERY))
        ends = (np.searchsorted(turned, turned[begin] + _LAP_TURN), np.searchsorted(gone, gone[begin] + _LAP_M))
        end = np.minimum(np.maximum(np.minimum(*ends), begin + 1), b - a)
        found += zip((a + begin).tolist(), (a + end).tolist(), strict=True)
    return EvenLines(*np.array(sorted(found), dtype=np.int64).reshape(-1, 2).T)


def turn_evenly(cell: Cell, tracked: TrackedPath, lines: EvenLines) -> TrackedPath:
    """Let the turning axes of a gantry go evenly along lines; what is beyond the carriage's travel is lost.

    Args:
        cell: Whose robot it is.
        tracked: The path, with the joints at the ends of the lines.
        lines: Those that a change of the configuration interrupts are left as they are.
    """
    whole = tracked.piece[lines.first] == tracked.piece[lines.last]
    lines = EvenLines(lines.first[whole], lines.last[whole])
    count = len(tracked.q)
    inner, share = np.flatnonzero(lines.inside(count)), np.full(count, np.nan)
    share[lines.last] = 1.0
    if len(inner) == 0:
        return replace(tracked, share=share)
    at = np.searchsorted(lines.first, inner, side="right") - 1
    begin, end = lines.first[at], lines.last[at]
    way = np.linalg.norm(np.diff(tracked.path.T_base_tcp[:, :3, 3], axis=0), axis=1)
    way = np.where(way < _STILL_M, 1e-6 * turns_between(tracked.path.T_base_tcp), way)  # angles, where no metres pass
    done = np.concatenate(([0.0], np.cumsum(way)))
    share[inner] = (done[inner] - done[begin]) / np.maximum(done[end] - done[begin], 1e-12)
    q = tracked.q.copy()
    turning = q[:, _CARRIAGE:]
    turning[inner] = turning[begin] + share[inner, None] * (turning[end] - turning[begin])
    q[inner, :_CARRIAGE] = 0.0
    poses = tracked.T_base_tcp.copy()
    gantry = gantry_of(cell.robot)
    assert gantry is not None
    for tool in np.unique(tracked.path.tool[inner]).tolist():
        rows = inner[tracked.path.tool[inner] == tool]
        tips = flange_poses(cell.robot, q[rows]) @ cell.tools[tool].T_flange_tcp
        q[rows, :_CARRIAGE] = (poses[rows, :3, 3] - tips[:, :3, 3]) @ gantry.straight.T
        poses[rows, :3, :3] = tips[:, :3, :3]
    lost = tracked.lost.copy()
    lost[inner] = np.any((q[inner] < cell.robot.lowest - 1e-9) | (q[inner] > cell.robot.highest + 1e-9), axis=1)
    azimuth, tilt = tracked.azimuth.copy(), tracked.tilt.copy()
    azimuth[inner], tilt[inner] = _apart(tracked.path.T_base_tcp[inner, :3, :3], poses[inner, :3, :3])
    path = replace(tracked.path, corner=tracked.path.corner & ~lines.inside(count))
    return replace(tracked, path=path, q=q, T_base_tcp=poses, azimuth=azimuth, tilt=tilt, lost=lost, share=share)


def _apart(here: Poses, goal: Poses) -> tuple[Scalars, Poses]:
    """Give the azimuths (n,) and the tilts (n, 2) that lead from rotations (n, 3, 3) to others."""
    from scipy.spatial.transform import Rotation

    turn = np.swapaxes(here, 1, 2) @ goal
    z = turn[:, :, 2]
    sine = np.hypot(z[:, 0], z[:, 1])
    scale = np.where(sine > 1e-12, np.arctan2(sine, z[:, 2]) / np.maximum(sine, 1e-12), 0.0)
    tilt = np.stack((-z[:, 1], z[:, 0]), axis=1) * scale[:, None]
    left = np.swapaxes(Rotation.from_rotvec(np.pad(tilt, ((0, 0), (0, 1)))).as_matrix(), 1, 2) @ turn
    return np.arctan2(left[:, 1, 0], left[:, 0, 0]), tilt
