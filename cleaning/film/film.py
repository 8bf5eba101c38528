"""The film that a jet makes on the board: it leaves the rim of the footprint outwards, and fills the pool within.

The footprint's rim is where the wave front of a hollow cone meets the board; cones and fans that are wet to their axis
have theirs where their spray ends. From each bit of the rim the film runs along the straight line from the pole, where
the axis meets the board. How the liquid divides there is the classical balance of an inviscid sheet on a plate, which
keeps its speed: the share (1 + sin g) / 2 runs outwards and the rest back, g the angle between the ray and the board's
normal in the vertical plane of that line. Outside, the film's momentum per width thins with the radius and decays by
friction; inside, it falls to nothing at the pole. Over the inner half of the wave front, one sigma of the ring, the
film turns from inwards to outwards, so that nothing jumps.

Tilted jets need no approximation: rays of one azimuth meet the plane on one line from the pole, so that the flow in
each direction on the board is known, and outward and inward film together carry exactly the flow of the jet.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cleaning.jet.compiled_jet import RING, ROUND
from cleaning.jet.jet import Jet
from cleaning.parameters.model import Film
from geometry.compiled import inlined

REACH = 3.0
"""Distance from the pole, in distances from there to the rim, beyond which a jet does nothing."""
_TURNS = 720
_BROADEST = 0.5


class Rim(NamedTuple):
    """Where the spray of a jet ends, for compiled code. Tool frame."""

    table: NDArray[np.float64]
    """(k, 2) of a cone: tangent of the rim's angle, and flow there over the mean flow, at k equal steps of
    the turn from 0 to 4 that ``_interpolate`` uses."""
    steepest: float
    """Largest of those tangents."""
    wide: float
    """Tangent of the half angle of the long sides of a fan or curtain; 0 for cones."""
    thin: float
    """Tangent of the half angle across; 0 for cones."""
    half_slot_mm: float
    front: float
    """Breadth of the inner half of the wave front as share of its distance from the pole."""
    momentum_n: float
    """What is left of the jet's momentum after the impact: chi rho Q v."""
    decay_mm: float


class Spot(NamedTuple):
    """A direction on the board, seen from the pole of a jet."""

    x: float
    """Unit vector in the tool frame."""
    y: float
    z: float
    standoff_mm: float
    """From the orifice along the axis to the pole."""
    facing: float
    """Cosine of the tilt."""


def rim_of(jet: Jet, film: Film) -> Rim:
    """Find where a jet's spray ends and how its flow is spread along that.

    The flow of a ring goes with its sigma and the sine of its angle; that of a full cone, uniform in solid angle, with
    one minus the cosine of the angle of its edge.
    """
    round_ = jet.form.kind in ROUND
    table = _table_of(jet) if round_ else np.ones((1, 2))
    return Rim(
        table=table,
        steepest=float(table[:, 0].max()),
        wide=0.0 if round_ else math.tan(jet.form.wide),
        thin=0.0 if round_ else math.tan(jet.half_angle),
        half_slot_mm=jet.form.half_slot_mm,
        front=min(_BROADEST, 2.0 * jet.sigma / math.sin(2.0 * jet.half_angle)),
        momentum_n=film.retention * jet.density_kg_m3 * jet.flow_m3_s * jet.speed_m_s,
        decay_mm=film.decay_mm,
    )


@lru_cache(maxsize=1024)  # a fit goes to the same jets again and again
def _table_of(jet: Jet) -> NDArray[np.float64]:
    flow = jet.sigmas * np.sin(jet.half_angles) if jet.form.kind == RING else 1.0 - np.cos(jet.half_angles)
    turns = np.linspace(0.0, 4.0, _TURNS, endpoint=False)
    x = np.where(turns < 2.0, 1.0 - turns, turns - 3.0)
    azimuth = np.arctan2(np.where(turns < 2.0, 1.0, -1.0) * (1.0 - np.abs(x)), x)
    values = np.column_stack([np.tan(jet.half_angles), flow / flow.mean()])
    return np.column_stack([np.interp(azimuth, jet.azimuths, column, period=2.0 * np.pi) for column in values.T])


@inlined
def _interpolate(table: NDArray[np.float64], x: float, y: float) -> tuple[float, float]:
    """Both columns of a rim's table in the direction (x, y).

    Turned from x over y it is 0 to 4 around the circle, without the cost of an arc tangent.
    """
    share = x / max(abs(x) + abs(y), 1e-300)
    place = (1.0 - share if y >= 0.0 else 3.0 + share) * (0.25 * len(table))
    one = int(place)
    part = place - one
    if one >= len(table):  # a remainder would take longer than all the rest
        one = 0
    other = one + 1 if one + 1 < len(table) else 0
    return (
        table[one, 0] + part * (table[other, 0] - table[one, 0]),
        table[one, 1] + part * (table[other, 1] - table[one, 1]),
    )


@inlined
def farthest(rim: Rim, standoff_mm: float, facing: float) -> float:
    """Bound of the distance from the pole to the rim in any direction, mm; infinite where the spray is open."""
    slope = rim.steepest
    if rim.thin > 0.0:
        slope = math.hypot(rim.half_slot_mm / standoff_mm + rim.wide, rim.thin)
    fall = facing - math.sqrt(max(0.0, 1.0 - facing * facing)) * slope
    return standoff_mm * slope / fall if fall > 0.0 else math.inf


@inlined
def rim_at(rim: Rim, spot: Spot) -> tuple[float, float]:
    """Distance from the pole to the rim, mm, and the flow there over the mean flow by azimuth about the jet.

    The distance is infinite where the spray does not meet the board.
    """
    flat = math.sqrt(max(0.0, 1.0 - spot.z * spot.z))
    if rim.thin == 0.0:
        slope, flow = _interpolate(rim.table, spot.x, spot.y)
        fall = flat - spot.z * slope
        return (spot.standoff_mm * slope / fall if fall > 0.0 else math.inf), flow
    long, short = rim.half_slot_mm + spot.standoff_mm * rim.wide, spot.standoff_mm * rim.thin
    far, across = math.inf, math.inf
    fall_long, fall_short = abs(spot.x) - spot.z * rim.wide, abs(spot.y) - spot.z * rim.thin
    if fall_long > 0.0:
        far = long / fall_long
    if fall_short > 0.0:
        far = min(far, short / fall_short)
    # A rectangle that is sprayed evenly: flow by azimuth goes with the square of the distance to its edge.
    if abs(spot.x) > 0.0:
        across = long / abs(spot.x)
    if abs(spot.y) > 0.0:
        across = min(across, short / abs(spot.y))
    return far, (across * flat) ** 2 * math.pi / (4.0 * long * short)


@inlined
def film_momentum(rim: Rim, spot: Spot, there: tuple[float, float], away_mm: float) -> float:
    """Momentum of the film per width at a distance from the pole, N/m: above 0 away from the pole, below 0 towards it.

    With R the distance to the rim, outside: M'_out (R/r) exp(-(r-R)/l); inside: -M'_in r/R. For an upright hollow cone
    M' = chi rho v (1 +- sin g)/2 Q/(2 pi R).

    Args:
        rim: Of the jet.
        spot: Which way from the pole.
        there: ``rim_at`` of that way.
        away_mm: How far.
    """
    kept = 1e3 * rim.momentum_n * film_share(rim, spot, there, away_mm)
    return kept * math.exp(-(away_mm - there[0]) / rim.decay_mm) if away_mm > there[0] else kept


@inlined
def film_share(rim: Rim, spot: Spot, there: tuple[float, float], away_mm: float) -> float:
    """Share of the jet's flow, per width, in the film at a distance from the pole, 1/mm: signs as of ``film_momentum``.

    Outside nothing of it is lost; the momentum decays besides.
    """
    far, flow = there
    if far == math.inf:
        return 0.0
    # Azimuth about the jet per azimuth on the board, both seen from the pole.
    turning = spot.facing / max(1e-12, 1.0 - spot.z * spot.z)
    leaving = flow * turning / (2.0 * math.pi * far)
    sine = _outward(rim, spot, far)
    outwards, inwards = 0.5 * (1.0 + sine) * leaving, 0.5 * (1.0 - sine) * leaving
    if away_mm >= far:
        return outwards * far / away_mm
    within = max(0.0, 1.0 - (1.0 - away_mm / far) / rim.front)
    return within * outwards - (1.0 - within) * inwards * away_mm / far


@inlined
def _outward(rim: Rim, spot: Spot, far: float) -> float:
    """Sine of the angle g: how much of the ray that meets the rim points away from the pole."""
    x, y, z = far * spot.x, far * spot.y, spot.standoff_mm + far * spot.z
    if rim.half_slot_mm > 0.0:
        opening = rim.half_slot_mm + spot.standoff_mm * rim.wide
        x -= rim.half_slot_mm * max(-1.0, min(1.0, x / opening))
    return (x * spot.x + y * spot.y + z * spot.z) / math.sqrt(x * x + y * y + z * z)
