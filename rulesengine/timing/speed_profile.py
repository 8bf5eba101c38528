"""How fast along the path: squared speed over the path parameter, straight-lined between grid points.

Every run (from one stop to the next) starts and ends at rest. Along a stage the tangential acceleration u is
constant, so the squared speed x is linear in the path parameter. With curvature k, rotation rate w and its change c
(per path parameter) the limits of a stage are

    x <= speed^2,  x k <= a,  x w^2 <= Omega^2,  x c <= alpha      caps on x alone
    u^2 + (k x)^2 <= a^2,  |u| w + c x <= alpha                    where they couple

The widest x within the caps and |u| <= min(a, alpha / w) is found directly (``envelope``): nothing can be faster, so
where it also keeps to the coupled limits it is the answer. Only the other runs go to toppra.
"""

import numpy as np

from geometry.arrays import Indices, Scalars
from recipes.recipe import Limits
from rulesengine.timing.corner_blending import Path
from rulesengine.timing.limit_intervals import Profile, Stages, envelope, join
from rulesengine.timing.pace import FREE, Pace

_SAME = 1e-8
"""Breaks of the path closer than this (mm, radians) are one."""


def parametrise(path: Path, limits: Limits, pace: Pace = FREE) -> Profile:
    """Find the fastest motion along the path within the limits and no faster than a pace, at rest at every stop."""
    spin_rate = np.radians(limits.rotation_acceleration_deg_s2)
    profile = envelope(_stages(path, limits, pace))
    stages, push = profile.stages, np.abs(profile.accelerations())
    highest = np.maximum(profile.begin, profile.end)
    sideways = np.where(np.isinf(stages.grip), 0.0, np.hypot(push, stages.curvature * highest) / stages.grip)
    turning = (push * stages.turn + highest * stages.turn_change) / spin_rate
    coupled = np.unique(stages.run[np.maximum(sideways, turning) > 1.0 + 1e-6])
    if len(coupled) == 0:
        return profile
    from rulesengine.timing.coupled_limits import parametrise_coupled

    chosen = np.isin(stages.run, coupled)
    solved = parametrise_coupled(profile.pick(np.flatnonzero(chosen)), spin_rate)
    return join(profile.pick(np.flatnonzero(~chosen)), solved)


def _stages(path: Path, limits: Limits, pace: Pace) -> Stages:
    """Cut the path wherever a limit changes."""
    borders = _borders(path, pace)
    middle = 0.5 * (borders[:-1] + borders[1:])
    segment = np.clip(np.searchsorted(path.knots, middle, side="right") - 1, 0, len(path.knots) - 2)
    piece = np.searchsorted(path.start, middle, side="right") - 1
    # In a window the rate of rotation goes over linearly.
    rates = np.stack([_rates_at(path, at, segment) for at in (borders[:-1], borders[1:])])
    turn = np.max(np.linalg.norm(rates, axis=2), axis=0)
    turn_change = np.linalg.norm(rates[1] - rates[0], axis=1) / np.diff(borders)
    turn_change = np.where(turn_change > 1e-9, turn_change, 0.0)
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
    bounded, highest = pace.between(borders)
    first, last = np.minimum(cap, highest[0]), np.minimum(cap, highest[1])
    lengths = np.diff(borders)
    cap = np.maximum(first, last)
    return Stages(
        borders[:-1], lengths, run, segment, curvature, turn, turn_change, cap, first, last, bounded, push, grip
    )


def _borders(path: Path, pace: Pace) -> Scalars:
    """Path parameters where a limit may change, the stops exactly among them."""
    window = path.window[:, None] * np.array([-1.0, -0.5, 0.5, 1.0])
    around = (path.knots[:, None] + window)[path.window > 0.0].ravel()
    ends = np.concatenate((pace.begin, pace.end))
    inner = np.sort(np.concatenate((path.start, path.knots, around, ends[(ends > 0.0) & (ends < path.length)])))
    stops = path.knots[path.rest]
    nearest = np.minimum(np.searchsorted(stops, inner), len(stops) - 1)
    far = np.minimum(np.abs(inner - stops[nearest]), np.abs(inner - stops[np.maximum(nearest - 1, 0)])) > _SAME
    borders = np.sort(np.concatenate((stops, inner[far])))
    return borders[np.concatenate(([True], np.diff(borders) > _SAME))]


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
