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
    way = np.linalg.norm(np.diff(track.tcp, axis=0), axis=1)
    turn = rotation_angles(track.quaternion[:-1], track.quaternion[1:])
    rates = np.column_stack((way, turn)) / np.diff(track.times)[:, None]
    lines = [_line(track, first, last, rates, makers) for first, last in pairwise(vertices.kept.tolist())]
    parts: list[Line] = []
    for line, rests, after in zip(lines, vertices.rests[1:].tolist(), [*lines[1:], lines[-1]], strict=True):
        passed = line if rests else replace(line, blend_mm=_zone(line, after))
        # Where the tool turns about half way round, controllers would choose the way by themselves.
        turns_far = line.angle_rad > _LARGEST_TURN_RAD
        parts += split_line(passed, (0.5,), _NARROWEST_MM) if turns_far else [passed]
    return parts


def _line(track: Track, first: int, last: int, rates: NDArray[np.float64], makers: tuple[Source, ...]) -> Line:
    """Draw the line between two samples; it ends with a stop."""
    speed, turn = rates[first:last].max(axis=0).tolist()
    samples = SampledLine(
        seconds=track.times[first : last + 1] - track.times[first],
        shares=shares_along(track, first, last),
        joints=track.joints[first : last + 1],
    )
    line = Line(
        start=pose_of(track, first),
        target=pose_of(track, last),
        speed_mm_s=speed,
        turn_rad_s=turn,
        blend_mm=0.0,
        samples=samples,
        time_s=float(track.times[first]),
        made_by=makers[track.maker[last]],
    )
    return replace(line, speed_mm_s=0.0) if line.turns_on_the_spot else line


def pose_of(track: Track, at: int) -> Pose:
    """Pose of a sample of a track."""
    x, y, z = track.tcp[at].tolist()
    a, b, c, d = track.quaternion[at].tolist()
    return Pose((x, y, z), (a, b, c, d))


def _zone(line: Line, after: Line) -> float:
    """Distance from the corner at which it may be left.

    A parabola that leaves the corner r before it and meets the next line r behind it stays r sin(angle / 2) / 2 away
    from the corner, the angle being the change of direction.
    """
    room = _ROOM * min(line.length_mm, after.length_mm)
    if room <= SAME_MM:
        return _NARROWEST_MM
    sine = 0.5 * math.dist(line.direction, after.direction)  # of half the change of direction
    widest = 2.0 * BLEND_ERROR_MM / sine if sine > 1e-9 else _WIDEST_MM
    return max(min(room, widest, _WIDEST_MM), _NARROWEST_MM)
