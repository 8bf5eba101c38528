"""The straight lines of one stretch of motion, with their speeds and zones."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from geometry.frames import rotation_angles
from programs.motion.steps import SAME_MM, Line, SampledLine, split_line
from programs.motion.tracks import Track, find_vertices, shares_along
from programs.pose import Pose
from specs.source import Source

BLEND_ERROR_MM = 0.05
"""How far a corner may be cut."""
_WIDEST_MM, _NARROWEST_MM = 5.0, 0.01
_LARGEST_TURN_RAD = math.radians(170.0)
_ROOM = 0.4
"""Share of either line that a zone may take, so that two zones never meet."""


def lines_of(track: Track, makers: tuple[Source, ...]) -> list[Line]:
    """Draw the lines of a track; the last ends with a stop, and so does each that ends where the motion rests."""
    vertices = find_vertices(track)
    kept = vertices.kept.tolist()
    rates = _rates(track)
    lines = [_line(track, first, last, rates, makers) for first, last in pairwise(kept)]
    stops = vertices.rests[1:].tolist()
    passed = [
        line if stop else replace(line, blend_mm=_zone(line, after))
        for line, stop, after in zip(lines, stops, [*lines[1:], lines[-1]], strict=True)
    ]
    return [part for line in passed for part in _without_half_turns(line)]


def _rates(track: Track) -> NDArray[np.float64]:
    """(n - 1, 2) speed of the orifice and rate of the turn of each segment: mm/s, rad/s."""
    way = np.linalg.norm(np.diff(track.tcp, axis=0), axis=1)
    turn = rotation_angles(track.quaternion[:-1], track.quaternion[1:])
    return np.column_stack((way, turn)) / np.diff(track.times)[:, None]


def _line(track: Track, first: int, last: int, rates: NDArray[np.float64], makers: tuple[Source, ...]) -> Line:
    """Draw the line between two samples; it ends with a stop."""
    start, target = (pose_of(track, at) for at in (first, last))
    speed, turn = rates[first:last].max(axis=0).tolist()
    samples = SampledLine(
        seconds=track.times[first : last + 1] - track.times[first],
        shares=shares_along(track, first, last),
        joints=track.joints[first : last + 1],
    )
    line = Line(
        start=start,
        target=target,
        speed_mm_s=speed,
        turn_rad_s=turn,
        blend_mm=0.0,
        samples=samples,
        time_s=float(track.times[first]),
        made_by=makers[track.maker[last]],
    )
    return replace(line, speed_mm_s=0.0) if line.turns_on_the_spot else line


def pose_of(track: Track, at: int) -> Pose:
    """Give a sample of a track as a pose."""
    x, y, z = track.tcp[at].tolist()
    a, b, c, d = track.quaternion[at].tolist()
    return Pose((x, y, z), (a, b, c, d))


def _without_half_turns(line: Line) -> list[Line]:
    """Divide a line on which the tool turns about half way round: controllers would choose the way by themselves."""
    return split_line(line, (0.5,), _NARROWEST_MM) if line.angle_rad > _LARGEST_TURN_RAD else [line]


def _zone(line: Line, after: Line) -> float:
    """Find how early the corner may be left.

    A parabola that leaves the corner r before it and meets the next line r behind it stays r sin(angle / 2) / 2 away
    from the corner, the angle being the change of direction.
    """
    room = _ROOM * min(line.length_mm, after.length_mm)
    if room <= SAME_MM:
        return _NARROWEST_MM
    one, two = (
        [(b - a) / each.length_mm for a, b in zip(each.start.position, each.target.position, strict=True)]
        for each in (line, after)
    )
    sine = 0.5 * math.dist(one, two)  # of half the change of direction
    widest = 2.0 * BLEND_ERROR_MM / sine if sine > 1e-9 else _WIDEST_MM
    return max(min(room, widest, _WIDEST_MM), _NARROWEST_MM)
