"""How fast along the path: squared speed over the path parameter, straight-lined between grid points.

Every run (from one stop to the next) starts and ends at rest. Along a stage the tangential acceleration u is
constant, so the squared speed x is linear in the path parameter. With curvature k, rotation rate w and its change c
(per path parameter) the limits of a stage are

    x <= speed^2,  x k <= a,  x w^2 <= Omega^2,  x c <= alpha      caps on x alone
    u^2 + (k x)^2 <= a^2,  |u| w + c x <= alpha                    where they couple

The widest x within the caps and |u| <= min(a, alpha / w) is found directly (``_envelope``): nothing can be faster, so
where it also keeps to the coupled limits it is the answer. Only the other runs go to toppra.
"""

from dataclasses import dataclass, fields

import numpy as np

from geometry.arrays import Indices, Scalars
from recipes.recipe import Limits
from rulesengine.blend import Path

_SAME = 1e-8
"""Breaks of the path closer than this (mm, radians) are one."""


@dataclass(frozen=True, slots=True, eq=False)
class Stages:
    """Short stretches of the path with constant limits, in order; every array is (m,)."""

    start: Scalars
    """Path parameter, mm (radians on turns on the spot)."""
    length: Scalars
    run: Indices
    segment: Indices
    """Segment of the chain."""
    curvature: Scalars
    turn: Scalars
    """Highest rate of rotation, radians per path parameter."""
    turn_change: Scalars
    """Highest change of the vector of that rate per path parameter."""
    cap: Scalars
    """Highest squared speed on its own account."""
    push: Scalars
    """Highest tangential acceleration where nothing couples."""
    grip: Scalars
    """Highest acceleration of the orifice; infinite on turns on the spot, where it stays."""

    def pick(self, index: Indices) -> "Stages":
        """Take stages by index, again and again if asked."""
        return Stages(*(getattr(self, field.name)[index] for field in fields(self)))

    def cut(self, start: Scalars, length: Scalars) -> "Stages":
        """Give the same limits to other stretches."""
        rest = (getattr(self, field.name) for field in fields(self)[2:])
        return Stages(start, length, *rest)


@dataclass(frozen=True, slots=True, eq=False)
class Profile:
    """Stages and the squared speeds (m,) at which each begins and ends."""

    stages: Stages
    begin: Scalars
    end: Scalars

    def accelerations(self) -> Scalars:
        """Give the tangential acceleration (m,) of each stage."""
        return 0.5 * (self.end - self.begin) / self.stages.length

    def durations(self) -> Scalars:
        """Give the seconds (m,) each stage takes."""
        return 2.0 * self.stages.length / (np.sqrt(self.begin) + np.sqrt(self.end))


def parametrise(path: Path, limits: Limits) -> Profile:
    """Find the fastest motion along the path within the limits, at rest at every stop."""
    spin_rate = np.radians(limits.rotation_acceleration_deg_s2)
    profile = _envelope(_stages(path, limits))
    coupled = _coupled_runs(profile, spin_rate)
    if len(coupled) == 0:
        return profile
    from rulesengine.coupling import parametrise_coupled

    chosen = np.isin(profile.stages.run, coupled)
    solved = parametrise_coupled(take(profile, np.flatnonzero(chosen)), spin_rate)
    return join(take(profile, np.flatnonzero(~chosen)), solved)


def cautious(stages: Stages, turn_acceleration: float) -> Profile:
    """Find a motion that keeps to the coupled limits whatever happens, by halving what the couples share."""
    with np.errstate(divide="ignore"):
        share = np.minimum(stages.grip * np.sqrt(0.5) / stages.curvature, 0.5 * turn_acceleration / stages.turn_change)
        push = np.where(stages.curvature > 0.0, stages.grip * np.sqrt(0.5), stages.push)
        push = np.where(stages.turn_change > 0.0, np.minimum(push, 0.5 * turn_acceleration / stages.turn), push)
    careful = Stages(
        **{field.name: getattr(stages, field.name) for field in fields(stages) if field.name not in {"cap", "push"}},
        cap=np.minimum(stages.cap, share),
        push=np.minimum(stages.push, push),
    )
    return _envelope(careful)


def _stages(path: Path, limits: Limits) -> Stages:
    """Cut the path wherever a limit changes."""
    borders = _borders(path)
    middle = 0.5 * (borders[:-1] + borders[1:])
    segment = np.clip(np.searchsorted(path.knots, middle, side="right") - 1, 0, len(path.knots) - 2)
    piece = np.searchsorted(path.start, middle, side="right") - 1
    turn, turn_change = _turning(path, borders, segment)
    curvature, spin = path.curvature[piece], path.spin[segment]
    grip = np.where(spin, np.inf, limits.acceleration_mm_s2)
    speed = np.where(spin, np.inf, path.chain.speed[segment])
    omega, alpha = np.radians(limits.rotation_deg_s), np.radians(limits.rotation_acceleration_deg_s2)
    with np.errstate(divide="ignore", invalid="ignore"):
        centripetal = np.where(curvature > 0.0, grip / curvature, np.inf)
        cap = np.minimum(np.minimum(speed**2, centripetal), np.minimum((omega / turn) ** 2, alpha / turn_change))
        push = np.minimum(grip, alpha / turn)
    stops = path.knots[path.rest]
    run = np.searchsorted(stops, middle) - 1
    return Stages(borders[:-1], np.diff(borders), run, segment, curvature, turn, turn_change, cap, push, grip)


def _borders(path: Path) -> Scalars:
    """Path parameters where a limit may change, the stops exactly among them."""
    window = path.window[:, None] * np.array([-1.0, -0.5, 0.5, 1.0])
    around = (path.knots[:, None] + window)[path.window > 0.0].ravel()
    inner = np.sort(np.concatenate((path.start, path.knots, around)))
    stops = path.knots[path.rest]
    nearest = np.minimum(np.searchsorted(stops, inner), len(stops) - 1)
    far = np.minimum(np.abs(inner - stops[nearest]), np.abs(inner - stops[np.maximum(nearest - 1, 0)])) > _SAME
    borders = np.sort(np.concatenate((stops, inner[far])))
    return borders[np.concatenate(([True], np.diff(borders) > _SAME))]


def _turning(path: Path, borders: Scalars, segment: Indices) -> tuple[Scalars, Scalars]:
    """Highest rate of rotation and change of rate on each stage; in a window the rate goes over linearly."""
    rates = np.stack([_rates_at(path, at, segment) for at in (borders[:-1], borders[1:])])
    turn = np.max(np.linalg.norm(rates, axis=2), axis=0)
    turn_change = np.linalg.norm(rates[1] - rates[0], axis=1) / np.diff(borders)
    return turn, np.where(turn_change > 1e-9, turn_change, 0.0)


def _rates_at(path: Path, at: Scalars, segment: Indices) -> Scalars:
    """Vector of rotation per path parameter (m, 3) at each place, seen from inside its segment."""
    left, right = at - path.knots[segment], path.knots[segment + 1] - at
    vertex = np.where(left < right, segment, segment + 1)
    window = path.window[vertex]
    inside = (window > 0.0) & (np.minimum(left, right) < window)
    fraction = np.clip(0.5 + 0.5 * (at - path.knots[vertex]) / np.where(inside, window, 1.0), 0.0, 1.0)[:, None]
    last = len(path.rate) - 1
    before, after = path.rate[np.maximum(vertex - 1, 0)], path.rate[np.minimum(vertex, last)]
    return np.where(inside[:, None], (1.0 - fraction) * before + fraction * after, path.rate[segment])


def _envelope(stages: Stages) -> Profile:
    """Widest squared speed within caps and pushes: trapezoids and triangles, cut at their kinks.

    With e the energy the pushes could have given since the beginning, no x can be above another x plus the
    difference of their e; a running minimum of x - e finds that, and once more from the other end.
    """
    gain = 2.0 * stages.push * stages.length
    energy = np.concatenate(([0.0], np.cumsum(gain)))
    at = np.zeros(len(gain) + 1)
    at[1:-1] = np.where(stages.run[:-1] == stages.run[1:], np.minimum(stages.cap[:-1], stages.cap[1:]), 0.0)
    at = energy + np.minimum.accumulate(at - energy)
    at = np.minimum.accumulate((at + energy)[::-1])[::-1] - energy
    first, last = np.maximum(at[:-1], 0.0), np.maximum(at[1:], 0.0)
    peak = np.minimum(stages.cap, 0.5 * (first + last + gain))
    peak = np.maximum(peak, np.maximum(first, last))
    rise, fall = 0.5 * (peak - first) / stages.push, 0.5 * (peak - last) / stages.push
    lengths = np.stack((rise, np.maximum(stages.length - rise - fall, 0.0), fall), axis=1)
    lengths *= (stages.length / lengths.sum(axis=1))[:, None]
    begins = stages.start[:, None] + np.cumsum(lengths, axis=1) - lengths
    speeds = np.stack((first, peak, peak, last), axis=1)
    kept = lengths > np.minimum(_SAME, 1e-3 * stages.length)[:, None]
    parent = np.nonzero(kept)[0]
    parts = stages.pick(parent).cut(begins[kept], lengths[kept])
    return Profile(parts, speeds[:, :3][kept], speeds[:, 1:][kept])


def _coupled_runs(profile: Profile, turn_acceleration: float) -> Indices:
    """Runs whose envelope asks too much where limits couple."""
    stages, push = profile.stages, np.abs(profile.accelerations())
    highest = np.maximum(profile.begin, profile.end)
    on_spot = np.isinf(stages.grip)
    sideways = np.where(on_spot, 0.0, np.hypot(push, stages.curvature * highest) / stages.grip)
    turning = (push * stages.turn + highest * stages.turn_change) / turn_acceleration
    return np.unique(stages.run[np.maximum(sideways, turning) > 1.0 + 1e-6])


def take(profile: Profile, index: Indices) -> Profile:
    """Take stages by index."""
    return Profile(profile.stages.pick(index), profile.begin[index], profile.end[index])


def join(one: Profile, other: Profile) -> Profile:
    """Put two profiles of different runs together, in the order of the path."""
    both = Stages(
        *(
            np.concatenate((getattr(one.stages, field.name), getattr(other.stages, field.name)))
            for field in fields(Stages)
        )
    )
    profile = Profile(both, np.concatenate((one.begin, other.begin)), np.concatenate((one.end, other.end)))
    return take(profile, np.argsort(both.start, kind="stable"))
