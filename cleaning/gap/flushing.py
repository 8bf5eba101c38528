"""Pulses of flow through one gap: inertia, wall shear, renewal, and the residue left in each cell."""

import math
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from cleaning.errors import require_not_negative, require_positive
from geometry.arrays import Scalars
from geometry.compiled import compiled, vectorised

Values: TypeAlias = float | NDArray[np.float64]

_ALL_GONE = 40.0
"""Beyond it, exp(-x) is nothing."""
_ROUNDED_UP = 1.0 + 1e-5
"""Flows are of single precision."""
_SHORT = 0.03
"""A rate times a time that is less has a short series."""
_LEAST_OF_SPEED = 0.5
"""Share that is left where the model does not hold any more, at the least."""


def lubrication_velocity(pressure_pa: Values, height_m: Values, path_m: Values, viscosity_pa_s: float) -> Values:
    """Mean velocity between plates if only viscosity resists, m/s: h^2 dp / (12 mu L)."""
    require_positive(height_m=height_m, path_m=path_m, viscosity_pa_s=viscosity_pa_s)
    return pressure_pa * height_m**2 / (12.0 * viscosity_pa_s * path_m)


def inertial(
    u: Values, height_m: Values, path_m: Values, density_kg_m3: float, viscosity_pa_s: float, loss: float = 0.5
) -> Values:
    """Slow a lubrication velocity down to what inertia and the losses of entrance and exit leave of it, m/s.

    The pressure that drives ``u`` is a u with a = 12 mu L / h^2. It also has to accelerate the liquid, which takes
    b u^2 with b = rho (1 + loss) / 2: the result is the root of a v + b v^2 = a |u|, with the sign of u. Where inertia
    is nothing this is u itself.

    Args:
        u: velocity of the lubrication equation, m/s.
        height_m: open height of the gap.
        path_m: length of the way through it.
        density_kg_m3: of the liquid.
        viscosity_pa_s: of the liquid.
        loss: coefficient of entrance and exit (zeta).
    """
    require_positive(height_m=height_m, path_m=path_m, viscosity_pa_s=viscosity_pa_s)
    require_not_negative(density_kg_m3=density_kg_m3, loss=loss)
    ratio = density_kg_m3 * (1.0 + loss) * height_m**2 / (24.0 * viscosity_pa_s * path_m)  # b / a
    # written without a difference of near numbers, so that it stays exact where inertia is small
    return 2.0 * u / (1.0 + np.sqrt(1.0 + 4.0 * ratio * np.abs(u)))


def reduced_reynolds(
    u: Values, height_m: Values, path_m: Values, density_kg_m3: float, viscosity_pa_s: float
) -> Values:
    """Inertia against viscosity in a thin gap: rho u h^2 / (mu L). Above about 10 it is no thin gap any more."""
    require_positive(height_m=height_m, path_m=path_m, viscosity_pa_s=viscosity_pa_s)
    require_not_negative(density_kg_m3=density_kg_m3)
    return density_kg_m3 * np.abs(u) * height_m**2 / (viscosity_pa_s * path_m)


def bounded(u: Values, reynolds: Values, most_reynolds: float) -> Values:
    """Lower bound of a mean speed that inertia may slow more than `inertial` has it, m/s.

    Above the reduced Reynolds number up to which a gap counts as thin the shape of the flow is not known; inertia takes
    half of speed and shear at most. The speed stays at what it is at that number until half of the model's is more,
    so that more pressure never flushes less.

    Args:
        u: Speed that `inertial` gives.
        reynolds: Reduced Reynolds number of that speed.
        most_reynolds: Up to which the model holds.
    """
    return u * np.clip(most_reynolds / np.maximum(reynolds, most_reynolds), _LEAST_OF_SPEED, 1.0)


class FlushSettings(NamedTuple):
    """What stays the same in one gap during one stage. SI."""

    weights: Scalars
    """(c,) weight of each cell in means over the gap; their sum is 1."""
    height_m: float
    """Of the empty gap."""
    path_m: float
    """Length of the way through the gap."""
    fill: float
    """Share of the height that residue fills before the wash."""
    viscosity_pa_s: float
    drag_pa_s2_m2: float
    """rho (1 + zeta) / 2: what entrance and inertia cost, times the speed squared."""
    thin_m_s: float
    """Mean speed up to which it is a thin gap; what is faster counts as `bounded` has it."""
    k1_per_s: float
    k2_per_s: float
    """At a wall shear of 1 Pa."""
    shear_exponent: float
    shear_threshold_pa: float


class Flushed(NamedTuple):
    """One gap after one stage. SI."""

    hard: float
    """Share of the residue that is hard, the same everywhere: softening does not depend on shear."""
    soft: Scalars
    """(c,) share that is soft."""
    shear_pa: Scalars
    """(c,) highest wall shear."""
    travelled_m: float
    """Way of the liquid: mean speed in the gap over time, at its lower bound."""
    fastest_m_s: float
    """Highest mean speed in the gap, as the model has it."""


@compiled
def flush(
    basis: NDArray[np.float32],
    pressures_pa: NDArray[np.float64],
    seconds: NDArray[np.float64],
    setting: FlushSettings,
    hard: float,
    soft: NDArray[np.float64],
) -> Flushed:
    """Carry a gap's residue through the pulses of one stage.

    What is left narrows the gap: with the mean fill f the speed goes with (1 - f)^2 and the shear with 1 - f. Inertia
    slows the whole field by as much as `inertial` takes from its mean speed, and `bounded` of what is left.

    Args:
        basis: (2, 8, c) components of velocity times viscosity for one pascal on each edge segment.
        pressures_pa: (k, 8) on the segments, one row per pulse.
        seconds: (k, 2) soak before each pulse, and the pulse itself.
        setting: What stays the same.
        hard: Share that is hard at first.
        soft: (c,) share that is soft at first; it is not changed.
    """
    cells, weights = soft.shape[0], setting.weights
    left = soft.copy()
    highest = np.zeros(cells)
    flow = np.empty(cells, np.float32)
    most, travelled, fastest = _fastest(basis), 0.0, 0.0
    whole, soft_share = weights.sum(), (weights * left).sum()
    for pulse in range(pressures_pa.shape[0]):
        softened = -hard * math.expm1(-setting.k1_per_s * seconds[pulse, 0])
        hard -= softened
        mean = _superpose(basis, pressures_pa[pulse].astype(np.float32), weights, flow)
        gap = 1.0 - setting.fill * (hard + soft_share + whole * softened)
        slow, speed = _slow(mean, gap, setting)
        fastest = max(fastest, speed)
        held = max(min(1.0, setting.thin_m_s / max(speed, 1e-300)), _LEAST_OF_SPEED)
        slow *= held
        travelled += held * speed * seconds[pulse, 1]
        per_flow = slow * gap * 6.0 / setting.height_m
        at_most = per_flow * _bound(pressures_pa[pulse], most)
        shearing = (flow, per_flow, at_most)
        soft_share = _remove((left, highest, weights), (hard, softened), setting, shearing, seconds[pulse, 1])
        hard *= math.exp(-setting.k1_per_s * seconds[pulse, 1])
    return Flushed(hard, left, highest, travelled, fastest)


@vectorised
def _superpose(
    basis: NDArray[np.float32], p: NDArray[np.float32], weights: NDArray[np.float64], flow: NDArray[np.float32]
) -> float:
    """Set ``flow`` to the length of the sum of all segments' flows, and give its weighted sum.

    Written out, it is twice as fast.
    """
    x, y = basis[0], basis[1]
    mean = 0.0
    for i in range(flow.shape[0]):
        u = p[0] * x[0, i] + p[1] * x[1, i] + p[2] * x[2, i] + p[3] * x[3, i]
        u += p[4] * x[4, i] + p[5] * x[5, i] + p[6] * x[6, i] + p[7] * x[7, i]
        v = p[0] * y[0, i] + p[1] * y[1, i] + p[2] * y[2, i] + p[3] * y[3, i]
        v += p[4] * y[4, i] + p[5] * y[5, i] + p[6] * y[6, i] + p[7] * y[7, i]
        flow[i] = math.sqrt(u * u + v * v)
        mean += weights[i] * flow[i]
    return mean


@compiled
def _slow(flow: float, gap: float, setting: FlushSettings) -> tuple[float, float]:
    """Give the share of a speed that inertia leaves, and the mean speed; ``gap`` is the open share of the height."""
    lubricated = flow * gap * gap / setting.viscosity_pa_s
    height = setting.height_m * gap
    a = 12.0 * setting.viscosity_pa_s * setting.path_m / (height * height)
    slow = 2.0 / (1.0 + math.sqrt(1.0 + 4.0 * setting.drag_pa_s2_m2 * lubricated / a))
    return slow, slow * lubricated


@compiled
def _fastest(basis: NDArray[np.float32]) -> NDArray[np.float64]:
    """Give the greatest flow in any cell for a pascal on each segment (8,), rounded up."""
    most = np.zeros(basis.shape[1])
    for segment in range(basis.shape[1]):
        for cell in range(basis.shape[2]):
            most[segment] = max(most[segment], math.hypot(basis[0, segment, cell], basis[1, segment, cell]))
        most[segment] *= _ROUNDED_UP
    return most


@compiled
def _bound(pressures_pa: NDArray[np.float64], most: NDArray[np.float64]) -> float:
    """Give a flow that no cell exceeds."""
    bound = 0.0
    for segment in range(len(most)):
        bound += abs(pressures_pa[segment]) * most[segment]
    return bound


@vectorised
def _remove(
    soft: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
    hard: tuple[float, float],
    setting: FlushSettings,
    shearing: tuple[NDArray[np.float32], float, float],
    seconds: float,
) -> float:
    """Do one step of `residue.step` in each cell, and give the weighted sum of what is soft afterwards.

    All that a pulse does to a cell is one loop: the cells are few, and every pass over them counts.

    Args:
        soft: What is soft in each cell, the highest wall shear of each, and its weight.
        hard: What is hard, and what has softened everywhere since the pulse before.
        setting: Has the rates.
        shearing: Flow in each cell, wall shear per flow, and a shear that no cell exceeds.
        seconds: How long.
    """
    (left, highest, weights), (flow, per_flow, bound) = soft, shearing
    a, rate, threshold = setting.k1_per_s * seconds, setting.k2_per_s * seconds, setting.shear_threshold_pa
    decay, (firm, softened), share = _decay(a), hard, 0.0
    soaked = firm * a
    if bound <= threshold:  # what softens stays
        grown = softened + soaked * _passed(decay, 1.0, -a)
        for cell in range(left.shape[0]):
            shear = per_flow * flow[cell]
            highest[cell] = shear if shear > highest[cell] else highest[cell]
            left[cell] += grown
            share += weights[cell] * left[cell]
    elif setting.shear_exponent != 1.0:  # a power in the loops below would cost more than all the rest
        for cell in range(left.shape[0]):
            shear = per_flow * flow[cell]
            highest[cell] = shear if shear > highest[cell] else highest[cell]
            b = rate * shear**setting.shear_exponent if shear > threshold else 0.0
            gone = _decay(b)
            left[cell] = (left[cell] + softened) * gone + soaked * _passed(decay, gone, b - a)
            share += weights[cell] * left[cell]
    elif max(a, rate * bound) < _SHORT:
        for cell in range(left.shape[0]):
            shear = per_flow * flow[cell]
            highest[cell] = shear if shear > highest[cell] else highest[cell]
            b = rate * shear if shear > threshold else 0.0
            left[cell] = (left[cell] + softened) * (1.0 - b * _series(b)) + soaked * decay * _series(b - a)
            share += weights[cell] * left[cell]
    else:
        for cell in range(left.shape[0]):
            shear = per_flow * flow[cell]
            highest[cell] = shear if shear > highest[cell] else highest[cell]
            b = rate * shear if shear > threshold else 0.0
            gone = _decay(b)
            left[cell] = (left[cell] + softened) * gone + soaked * _passed(decay, gone, b - a)
            share += weights[cell] * left[cell]
    return share


@vectorised
def _passed(decay: float, gone: float, d: float) -> float:
    """Give (exp(-a) - exp(-b)) / (b - a) from exp(-a), exp(-b) and d = b - a."""
    # The quotient loses digits where both rates are alike.
    alike = abs(d) < _SHORT
    return decay * _series(d) if alike else np.divide(decay - gone, 1.0 if alike else d)


@vectorised
def _series(x: float) -> float:
    """Give (1 - exp(-x)) / x within 1e-11 for numbers of less than ``_SHORT``."""
    return 1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x * (1.0 / 120.0))))


@vectorised
def _decay(x: float) -> float:
    """Give exp(-x) within 1e-9, by Pade's fraction at x / 16: a loop over it is seven times as fast."""
    part = min(x, _ALL_GONE) / 16.0
    even, odd = 120.0 + 12.0 * part * part, part * (60.0 + part * part)
    root = np.divide(even - odd, even + odd)
    root *= root
    root *= root
    root *= root
    return root * root
