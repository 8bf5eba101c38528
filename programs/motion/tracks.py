"""Few straight lines in place of many samples, with their speeds and zones.

Positions in mm and orientations in degrees are measured alike, as six coordinates: a plan that is kept within 0.004 mm
and 0.004 degrees treats a millimetre like a degree.
"""

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Points, Quaternions, Scalars
from geometry.frames import rotation_angles, rotation_vectors
from programs.motion.samples import SampledLine
from programs.motion.steps import GOES_MM, RESOLUTION_MM, Line, limit_speed, split_line
from programs.pose import Pose
from programs.timing.forecast import SHORT_S
from specs.source import Source

Flags: TypeAlias = NDArray[np.bool_]

TOLERANCE = 0.004
"""mm and degrees that a sample may be off the line that replaces it."""
_EVEN_S, _EVEN_DEG = 0.03, 0.2
"""Lines are to take this long in the plan at least, so they take 20 ms at the commanded speed, the greatest on them;
degrees that the tool may be turned off the plan for that."""
_SHORT_DEG = 0.5
"""What a robot divides into lines of less than 20 ms is joined if the tool stays so near to its planned direction."""
_REST_SHARE, _REST_FLOOR = 0.25, 0.6
"""A motion rests at a sample if, carried on to it, its speed falls below this share of the mean speed of the segment
beside it; mm/s or deg/s that the rounding of two samples can pretend do not count."""
_SHARP_RAD = np.radians(45.0)
_ALIKE = 3.0
_LEVEL_SHARE, _LEVEL_FLOOR = 0.02, 0.5
"""What speeds on one level may differ by."""
_LEVEL_S, _LONG_S = 0.04, 0.25
"""What lasts less is no level; what lasts longer is one also beside a segment that is not much shorter."""
_DIP_SHARE, _DIP_FLOOR = 0.15, 3.0
"""A dip of the speed between two rises is one if it is deeper than this."""

BLEND_ERROR_MM = 0.05
"""How far a corner may be cut."""
_WIDEST_MM, _NARROWEST_MM = 5.0, 0.01
LARGEST_TURN_RAD = math.radians(170.0)
"""Of more it is not known which way round a controller turns."""
_ROOM = 0.4
"""Share of either line that a zone may take, so that two zones never meet."""


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Samples of a motion without a pause. Board frame, mm, s."""

    times: Scalars
    """(n,) strictly increasing."""
    tcp: Points
    """(n, 3)"""
    quaternion: Quaternions
    """(n, 4) neighbours with the same sign."""
    maker: Indices
    """(n,) number of the recipe path of the segment that ends at each sample."""
    joints: NDArray[np.float64]
    """(n, dof); dof is 0 where they are not known."""
    clock: Scalars
    """(n,) strictly increasing: the times as planned, where a robot takes others"""
    node: Scalars
    """(n,) the program's move that each sample is, counted from 0; a fraction lies between two"""
    corner: Flags | None
    """(n,) samples at which lines end; ``None`` where they are to be found"""
    share: Scalars | None = None
    """(n,) done of a line along which the turning axes go evenly, whatever the poses between its ends; NaN elsewhere"""

    def part(self, rows: slice | Indices) -> "Track":
        """Give some of the samples."""
        return Track(
            self.times[rows], self.tcp[rows], self.quaternion[rows], self.maker[rows], self.joints[rows],
            self.clock[rows], self.node[rows], None if self.corner is None else self.corner[rows],
            None if self.share is None else self.share[rows],
        )  # fmt: skip

    def steps(self) -> NDArray[np.float64]:
        """(n - 1, 6) way and turn of each segment: mm, axis times degrees."""
        turn = np.degrees(rotation_vectors(self.quaternion[:-1], self.quaternion[1:]))
        return np.hstack((np.diff(self.tcp, axis=0), turn))


@dataclass(frozen=True, slots=True, eq=False)
class Vertices:
    """Which samples remain, the first and the last always, and at which of them the motion rests."""

    kept: Indices
    rests: Flags
    """Of each kept sample."""


def lines_of(track: Track, makers: tuple[Source, ...]) -> list[Line]:
    """Draw the lines of a track; the last ends with a stop, and so does each that ends where the motion rests."""
    vertices = find_vertices(track)
    way = np.linalg.norm(np.diff(track.tcp, axis=0), axis=1)
    turn = rotation_angles(track.quaternion[:-1], track.quaternion[1:])
    rates = np.column_stack((way, turn)) / np.diff(track.clock)[:, None]
    lines = [_line(track, first, last, rates, makers) for first, last in pairwise(vertices.kept.tolist())]
    parts: list[Line] = []
    for line, rests, after in zip(lines, vertices.rests[1:].tolist(), [*lines[1:], lines[-1]], strict=True):
        passed = line
        if not rests:
            room = _ROOM * min(line.length_mm, after.length_mm)  # two zones never meet
            passed = replace(line, blend_mm=max(min(room, widest_zone(line, after)), _NARROWEST_MM))
        # Where the tool turns about half way round, controllers would choose the way by themselves.
        turns_far = line.angle_rad > LARGEST_TURN_RAD and not line.even
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
        even=track.share is not None and bool(np.isfinite(track.share[last])),
    )
    line = limit_speed(line, SHORT_S)
    return replace(line, speed_mm_s=0.0) if line.turns_on_the_spot else line


def pose_of(track: Track, at: int) -> Pose:
    """Pose of a sample of a track."""
    x, y, z = track.tcp[at].tolist()
    a, b, c, d = track.quaternion[at].tolist()
    return Pose((x, y, z), (a, b, c, d))


def widest_zone(line: Line, after: Line) -> float:
    """Give the distance from a corner at which it may be left if it is not to be cut by more than ``BLEND_ERROR_MM``.

    A parabola that leaves the corner r before it and meets the next line r behind it stays r sin(angle / 2) / 2 away
    from the corner, the angle being the change of direction.
    """
    if min(line.length_mm, after.length_mm) <= RESOLUTION_MM:
        return _NARROWEST_MM
    sine = 0.5 * math.dist(line.direction, after.direction)  # of half the change of direction
    return min(2.0 * BLEND_ERROR_MM / sine if sine > 1e-9 else _WIDEST_MM, _WIDEST_MM)


def find_vertices(track: Track) -> Vertices:
    """Choose the fewest samples whose straight connections pass every sample within the tolerance."""
    steps, lasting = track.steps(), np.diff(track.clock)
    lengths = np.linalg.norm(steps, axis=1)
    rates = lengths / lasting
    ways = steps / np.maximum(lengths, 1e-12)[:, None]
    cosine = np.einsum("ij,ij->i", ways[:-1], ways[1:])
    bends = np.concatenate(([0.0], np.arccos(np.clip(cosine, -1.0, 1.0)), [0.0]))  # changes of direction, radians
    rests = _rests(rates, lasting, bends)
    fixed = rests.copy()
    fixed[1:-1] |= np.diff(track.maker[1:]) != 0
    forced = fixed.copy()
    if track.corner is not None:
        forced |= track.corner
    else:
        borders = np.flatnonzero(rests)
        for first, last in zip(borders[:-1].tolist(), borders[1:].tolist(), strict=True):
            for at in _speed_borders(rates[first:last].tolist(), lasting[first:last].tolist()):
                forced[first + at] = True
    from programs.motion.thinning import merge_short, thin  # compiled: only those who export should wait for it

    tcp, quaternion = np.ascontiguousarray(track.tcp), np.ascontiguousarray(track.quaternion)
    kept = thin(tcp, quaternion, forced, TOLERANCE)
    clock, held = np.ascontiguousarray(track.clock), fixed if track.corner is None else fixed | track.corner
    kept = merge_short(tcp, quaternion, clock, kept, held, (_EVEN_S, _EVEN_DEG))
    if track.corner is not None:  # a robot may have divided the lines of the plan again
        if track.share is not None:  # both ends of lines along which the turning axes go evenly remain
            even = np.isfinite(track.share)
            fixed |= even | np.append(even[1:], False)
        kept = merge_short(tcp, quaternion, clock, kept, fixed, (SHORT_S, _SHORT_DEG))
    if track.share is not None:
        inner = track.share < 1.0
        inner[[0, -1]] = False
        kept = kept[~inner[kept]]
    return Vertices(kept, rests[kept])


def shares_along(track: Track, first: int, last: int) -> Scalars:
    """Give how much of the line from one kept sample to the next is done at each sample between and at both.

    That is of the way, as controllers drive lines, or of way and turn where the line hardly goes anywhere.
    """
    if track.share is not None and np.isfinite(track.share[last]):
        before = track.share[first]
        before = before if before < 1.0 else 0.0
        done = (track.share[first : last + 1] - before) / (track.share[last] - before)
        done[0] = 0.0
        shares = np.maximum.accumulate(np.clip(done, 0.0, 1.0))
        shares[0], shares[-1] = 0.0, 1.0
        return shares
    way = track.tcp[first : last + 1] - track.tcp[first]
    run = way
    if float(np.linalg.norm(way[-1])) <= GOES_MM:
        start = np.repeat(track.quaternion[first : first + 1], last + 1 - first, axis=0)
        run = np.hstack((way, np.degrees(rotation_vectors(start, track.quaternion[first : last + 1]))))
    squared = float(run[-1] @ run[-1])
    if squared == 0.0:
        return np.linspace(0.0, 1.0, last + 1 - first)
    shares = np.maximum.accumulate(np.clip(run @ run[-1] / squared, 0.0, 1.0))
    shares[0], shares[-1] = 0.0, 1.0
    return shares


def _rests(rates: Scalars, lasting: Scalars, bends: Scalars) -> Flags:
    """At which samples the motion comes to rest: both ends, and where its speed, carried on, vanishes."""
    count = len(rates) + 1
    rests = np.zeros(count, dtype=np.bool_)
    rests[[0, -1]] = True
    if len(rates) < 2:
        return rests
    change = np.diff(rates) / (lasting[1:] + lasting[:-1])  # half the slope
    left = np.ones((2, count))  # of the speed of the segment before, and of the one after
    left[0, 2:] = _left_at_end(rates[1:], change * lasting[1:], lasting[1:] <= _ALIKE * lasting[:-1])
    left[1, :-2] = _left_at_end(rates[:-1], -change * lasting[:-1], lasting[:-1] <= _ALIKE * lasting[1:])
    least, most = left.min(axis=0), left.max(axis=0)
    sharp = bends > _SHARP_RAD
    # Nothing turns sharply in full flight; on a straight way both sides have to agree.
    inner = np.flatnonzero((np.where(sharp, least, most) <= _REST_SHARE)[1:-1]) + 1
    # A stop whose neighbours are slow too is one stop: at the sharpest corner, or where both sides agree best.
    for group in np.split(inner, np.flatnonzero(np.diff(inner) > 1) + 1):
        if len(group):
            score = np.where(sharp[group], -np.round(bends[group], 2), np.round(most[group] + least[group], 3))
            rests[group[int(np.argmin(score))]] = True
    return rests


def _left_at_end(rates: Scalars, change: Scalars, alike: Flags) -> Scalars:
    """What is left of the mean speed of a segment at one end of it, carried on from its neighbour on the other.

    Over a segment much longer than its neighbour the speed is level: a slope between the two does not apply to it.
    """
    left = np.maximum(rates + change - _REST_FLOOR, 0.0) / np.maximum(rates, 1e-9)
    return np.where(alike, left, 1.0)


def _speed_borders(rates: list[float], lasting: list[float]) -> set[int]:
    """Where the commanded speed has to change between two rests: samples, counted from the first rest.

    Where the motion slows down to a lower level the border is where the level begins; where it speeds up, where the
    level ends. So the faster line never covers what is to be slow.
    """
    borders = _dips(rates)
    for first, last in _levels(rates, lasting):
        fast = max(rates[first:last]) * (1.0 + _LEVEL_SHARE) + _LEVEL_FLOOR
        length_s = sum(lasting[first:last])
        for beside, border in ((first - 1, first), (last, last)):
            is_level = length_s >= _LONG_S or length_s >= _ALIKE * lasting[beside % len(lasting)]
            if 0 <= beside < len(rates) and is_level and rates[beside] > fast:
                borders.add(border)
    return borders


def _levels(rates: list[float], lasting: list[float]) -> list[tuple[int, int]]:
    """Find stretches of steady speed: the first segment of each, and the first after it."""
    levels: list[tuple[int, int]] = []
    first = 0
    for at in range(1, len(rates) + 1):
        allowed = _LEVEL_FLOOR + _LEVEL_SHARE * rates[first]
        if at < len(rates) and abs(rates[at] - rates[first]) <= allowed:
            continue
        half = (at - first) // 2
        drift = abs(_mean(rates[at - half : at]) - _mean(rates[first : first + half])) if half else 0.0
        if sum(lasting[first:at]) >= _LEVEL_S and drift <= 0.3 * allowed:
            levels.append((first, at))
        first = at
    return levels


def _dips(rates: list[float]) -> set[int]:
    """Find where the speed falls and rises again: the samples at both ends of the slowest part."""
    found: set[int] = set()
    high = low = rates[0]
    lowest = 0
    for at, rate in enumerate(rates):
        if rate < low:
            low, lowest = rate, at
        elif rate > low + _DIP_FLOOR + _DIP_SHARE * low and high > low + _DIP_FLOOR + _DIP_SHARE * low:
            ceiling = low + 0.3 * (min(high, rate) - low)
            first, last = lowest, lowest + 1
            while rates[first - 1] <= ceiling:
                first -= 1
            while rates[last] <= ceiling:
                last += 1
            found |= {first, last}
            high = low = rate
            lowest = at
        if rate >= high:
            high = low = rate
            lowest = at
    return found


def _mean(values: list[float]) -> float:
    return sum(values) / len(values)
