"""Corner blending: the vertices of a plan become lines, arcs and smoothly turning orientations.

One path parameter runs through the whole plan: millimetres of the rounded path, and radians where the nozzle turns
on the spot. Board frame.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Directions, Indices, Points, Quaternions, Scalars
from geometry.frames import rotation_vectors, slerp
from recipes.recipe import Limits

Flags = NDArray[np.bool_]  # (n,)

_STRAIGHT_RAD = 1e-4
"""A bend below this is gone through: its jump in velocity is lost in the rounding of the program."""
_REVERSAL_RAD = np.radians(170.0)
"""A bend above this is a turning back: the nozzle stops there."""
_MIN_RADIUS_MM = 1e-3
"""A corner that can only be rounded more sharply than this is a stop."""
_CURVE_MARGIN = 1.2
"""Corners are rounded no wider than the speed needs, with this much left for rounding in the program."""
_SPRAY_SWING_RAD = np.radians(3.0)
"""How far the jet may point away from the orientation of a vertex, so that the turning need not stop there."""
_WINDOW_TURN_RAD = 0.25
"""How far the nozzle turns in half a window at most: the quadratic curve of orientations is only nearly exact."""
_STEADY_RAD_S = np.radians(0.02)
"""A jump of the speed of rotation below this is gone through."""


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """All vertices of a plan in order, n of them, and what is programmed on the n - 1 segments between them."""

    tcp: Points
    quaternion: Quaternions
    """Sign-continuous."""
    item: Indices
    """(n - 1,) which item of the plan each segment belongs to."""
    speed: Scalars
    """(n - 1,) programmed speed, mm/s."""
    spraying: Flags
    """(n - 1,)"""
    stop: Flags
    """(n,) at rest here, whatever the geometry."""
    lead_in: Flags
    """(n,) at rest here unless the path goes straight on: a run-up meets the pass that it serves."""


@dataclass(frozen=True, eq=False)
class Path:
    """A chain made smooth: n vertices, n - 1 segments, 2 n - 3 pieces (line, arc, line, ..., line)."""

    chain: Chain
    rest: Flags
    """(n,) vertices where the nozzle stops."""
    spin: Flags
    """(n - 1,) segments that turn on the spot."""
    start: Scalars
    """(2 n - 3,) path parameter where each piece begins."""
    origin: Points
    """(2 n - 3, 3) place where each piece begins."""
    tangent: Directions
    """(2 n - 3, 3) direction there; zero where the nozzle turns on the spot."""
    normal: Directions
    """(2 n - 3, 3) from there to the middle of the arc; zero for lines."""
    curvature: Scalars
    """(2 n - 3,) per mm."""
    knots: Scalars
    """(n,) path parameter of each vertex: the middle of its arc."""
    rate: Directions
    """(n - 1, 3) rotation per path parameter, radians, board frame."""
    window: Scalars
    """(n,) half of the stretch around each vertex in which one rate goes over into the next; 0 for none."""

    @cached_property
    def length(self) -> float:
        """Path parameter of the end."""
        return float(self.knots[-1])

    def positions(self, at: Scalars) -> Points:
        """(m, 3) Places at path parameters (m,)."""
        piece = np.searchsorted(self.start, at, side="right") - 1
        along = at - self.start[piece]
        curvature = self.curvature[piece]
        bent = curvature > 0.0
        divisor = np.where(bent, curvature, 1.0)
        forward = np.where(bent, np.sin(curvature * along) / divisor, along)
        aside = np.where(bent, (1.0 - np.cos(curvature * along)) / divisor, 0.0)
        return self.origin[piece] + forward[:, None] * self.tangent[piece] + aside[:, None] * self.normal[piece]

    def orientations(self, at: Scalars) -> Quaternions:
        """(m, 4) Orientations at path parameters (m,).

        Slerp from vertex to vertex; within a window the quadratic Bezier curve of Shoemake's construction, which
        meets both rates.
        """
        last = len(self.knots) - 2
        segment = np.clip(np.searchsorted(self.knots, at, side="right") - 1, 0, last)
        turned = self._slerp(segment, at)
        vertex = segment + (at - self.knots[segment] > self.knots[segment + 1] - at)
        inside = np.flatnonzero(np.abs(at - self.knots[vertex]) < self.window[vertex])
        vertex, window = vertex[inside], self.window[vertex[inside]]
        centre = self.knots[vertex]
        fraction = (at[inside] - centre + window) / (2.0 * window)
        planned = self.chain.quaternion[vertex]
        before = slerp(self._slerp(vertex - 1, centre - window), planned, fraction)
        after = slerp(planned, self._slerp(vertex, centre + window), fraction)
        turned[inside] = slerp(before, after, fraction)
        return turned

    def _slerp(self, segment: Indices, at: Scalars) -> Quaternions:
        begin, end = self.knots[segment], self.knots[segment + 1]
        turns = self.chain.quaternion
        return slerp(turns[segment], turns[segment + 1], np.clip((at - begin) / (end - begin), 0.0, 1.0))


def round_corners(chain: Chain, limits: Limits) -> Path:
    """Round each corner by a circular arc within ``limits.blend_mm`` of it and no wider than its speed needs.

    An arc keeps to half of each neighbouring segment, so that neighbouring corners never meet. Corners that cannot
    be rounded, turnings back and turns on the spot become stops. No two neighbouring vertices may be the same pose.
    """
    steps = np.diff(chain.tcp, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    turns = rotation_vectors(chain.quaternion[:-1], chain.quaternion[1:])
    angles = np.linalg.norm(turns, axis=1)
    spin = lengths < 1e-6
    lengths = np.where(spin, 0.0, lengths)
    along = np.where(spin[:, None], 0.0, steps / np.where(spin, 1.0, lengths)[:, None])
    bend = np.zeros(len(chain.tcp))
    cross = np.linalg.norm(np.cross(along[:-1], along[1:]), axis=1)
    bend[1:-1] = np.arctan2(cross, np.einsum("ij,ij->i", along[:-1], along[1:]))  # exact for small angles too
    cut, radius = _corner_arcs(bend, lengths, chain.speed, limits)
    same_axis = np.linalg.norm(_unit(turns)[1:] - _unit(turns)[:-1], axis=1) < 1e-6
    rest = _stops(chain, spin, same_axis, (bend, radius))
    cut[rest] = 0.0
    bent = (cut > 0.0) & (bend > _STRAIGHT_RAD)
    cut[~bent] = 0.0
    arcs = np.where(bent, radius * bend, 0.0)
    param = np.where(spin, angles, lengths - cut[:-1] - cut[1:])
    spans = _interleave(np.maximum(param, 0.0), arcs[1:-1])
    ends = np.cumsum(spans)
    start = ends - spans
    knots = np.concatenate(([0.0], start[1::2] + 0.5 * arcs[1:-1], ends[-1:]))
    rate = turns / np.diff(knots)[:, None]
    sideways = _unit(along[1:] - np.cos(bend[1:-1])[:, None] * along[:-1])
    return Path(
        chain=chain,
        rest=rest,
        spin=spin,
        start=start,
        origin=_interleave(chain.tcp[:-1] + cut[:-1, None] * along, chain.tcp[1:-1] - cut[1:-1, None] * along[:-1]),
        tangent=_interleave(along, along[:-1]),
        normal=_interleave(np.zeros_like(along), np.where(bent[1:-1, None], sideways, 0.0)),
        curvature=_interleave(np.zeros(len(along)), np.where(bent, 1.0 / np.where(bent, radius, 1.0), 0.0)[1:-1]),
        knots=knots,
        rate=rate,
        window=_windows(chain, knots, rate, rest),
    )


def _corner_arcs(bend: Scalars, lengths: Scalars, speed: Scalars, limits: Limits) -> tuple[Scalars, Scalars]:
    """Tangent length and radius (n,) of the arc at each vertex.

    An arc of radius r that turns by b leaves the segments r tan(b/2) before the corner and passes it at that times
    tan(b/4).
    """
    cut, radius = np.zeros_like(bend), np.zeros_like(bend)
    inner = bend[1:-1]
    half = np.tan(0.5 * np.clip(inner, 1e-12, _REVERSAL_RAD))
    quarter = np.tan(0.25 * np.clip(inner, 1e-12, _REVERSAL_RAD))
    room = 0.5 * np.minimum(lengths[:-1], lengths[1:])
    needed = _CURVE_MARGIN * np.maximum(speed[:-1], speed[1:]) ** 2 / limits.acceleration_mm_s2 * half
    cut[1:-1] = np.minimum(np.minimum(limits.blend_mm / quarter, room), needed)
    radius[1:-1] = cut[1:-1] / half
    return cut, radius


def _stops(chain: Chain, spin: Flags, same_axis: Flags, corner: tuple[Scalars, Scalars]) -> Flags:
    """Where the nozzle has to stop (n,): stated, at an end, around a turn on the spot, where it cannot go round."""
    bend, radius = corner
    rest = chain.stop.copy()
    rest[0] = rest[-1] = True
    inner = rest[1:-1]
    inner |= chain.lead_in[1:-1] & (bend[1:-1] > _STRAIGHT_RAD)
    inner |= spin[:-1] != spin[1:]
    inner |= spin[:-1] & spin[1:] & ~same_axis
    inner |= bend[1:-1] > _REVERSAL_RAD
    inner |= (bend[1:-1] > _STRAIGHT_RAD) & (radius[1:-1] < _MIN_RADIUS_MM)
    return rest


def _windows(chain: Chain, knots: Scalars, rate: Directions, rest: Flags) -> Scalars:
    """Half windows (n,) in which the rates of rotation go over into each other."""
    window = np.zeros(len(knots))
    jump = np.linalg.norm(np.diff(rate, axis=0), axis=1)
    fastest = np.linalg.norm(rate, axis=1)
    fastest = np.maximum(np.maximum(fastest[:-1], fastest[1:]), 1e-12)
    speed = np.maximum(chain.speed[:-1], chain.speed[1:])
    moving = ~rest[1:-1] & (jump * speed > _STEADY_RAD_S)
    room = 0.5 * np.minimum(np.diff(knots)[:-1], np.diff(knots)[1:])
    room = np.minimum(room, _WINDOW_TURN_RAD / fastest)
    # A quadratic curve passes its corner at a quarter of the jump times the half window.
    swing = np.where(chain.spraying[:-1] | chain.spraying[1:], 4.0 * _SPRAY_SWING_RAD, np.inf)
    window[1:-1] = np.where(moving, np.minimum(room, swing / np.maximum(jump, 1e-12)), 0.0)
    return window


def _unit(vectors: Directions) -> Directions:
    """Unit vectors; zero stays zero."""
    norms = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(norms > 1e-12, vectors / np.where(norms > 1e-12, norms, 1.0), 0.0)


def _interleave(lines: NDArray[np.float64], arcs: NDArray[np.float64]) -> NDArray[np.float64]:
    """Put the n - 2 arcs between the n - 1 lines."""
    mixed = np.empty((len(lines) + len(arcs), *lines.shape[1:]))
    mixed[0::2], mixed[1::2] = lines, arcs
    return mixed
