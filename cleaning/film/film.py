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
from geometry.arrays import Scalars
from geometry.compiled import inlined, inner, quick

REACH = 3.0
"""Distance from the pole, in distances from there to the rim, beyond which a jet does nothing."""
_TURNS = 720
_BROADEST = 0.5
_POLE_MM = 1e-9
"""Nearer to the pole there is no direction."""


class Rim(NamedTuple):
    """Where the spray of a jet ends, for compiled code. Tool frame."""

    table: NDArray[np.float64]
    """(k, 2) of a cone: tangent of the rim's angle, and flow there over the mean flow, at k equal steps of
    the turn from 0 to 4 that ``_rim_of_cone`` uses."""
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
def farthest(rim: Rim, standoff_mm: float, facing: float) -> float:
    """Bound of the distance from the pole to the rim in any direction, mm; infinite where the spray is open."""
    slope = rim.steepest
    if rim.thin > 0.0:
        slope = math.hypot(rim.half_slot_mm / standoff_mm + rim.wide, rim.thin)
    fall = facing - math.sqrt(max(0.0, 1.0 - facing * facing)) * slope
    return standoff_mm * slope / fall if fall > 0.0 else math.inf


@quick
def film_around(
    rim: Rim,
    turn: NDArray[np.float64],
    stand: tuple[float, float],
    ways: tuple[Scalars, Scalars],
    film: tuple[Scalars, Scalars],
) -> None:
    """Find the rim and the film on the ways to places around the pole of a jet.

    Outside the rim nothing of the film is lost (its momentum decays besides).

    Args:
        rim: Of the jet.
        turn: (3, 3) columns are the axes of the tool.
        stand: From the orifice along the axis to the pole, mm, and the cosine of the tilt.
        ways: (n,) x and (n,) y from the pole to places on the board, mm.
        film: What is filled: (n,) distance from the pole to the rim, mm, infinite where the spray does not meet the
            board; and (n,) share of the jet's flow per width at the place, 1/mm, above 0 away from the pole.
    """
    if rim.thin == 0.0:
        _rim_of_cone(rim, turn, stand[0], ways, film)
    else:
        _rim_of_rectangle(rim, turn, stand[0], ways, film)
    _share_film(rim, turn, stand, ways, film)


@inner
def _rim_of_cone(
    rim: Rim, turn: NDArray[np.float64], standoff: float, ways: tuple[Scalars, Scalars], out: tuple[Scalars, Scalars]
) -> None:
    """Fill distances to the rim, and the flow there over the mean flow by azimuth about the jet.

    Turned from x over y the table's argument is 0 to 4 around the circle, without the cost of an arc tangent. Looking
    up and arithmetic are loops of their own, so that the second is vectorised.
    """
    (ways_x, ways_y), (far, flow), table = ways, out, rim.table
    scale, most = 0.25 * len(table), len(table) - 1
    for k in range(len(ways_x)):
        x = ways_x[k] * turn[0, 0] + ways_y[k] * turn[1, 0]
        y = ways_x[k] * turn[0, 1] + ways_y[k] * turn[1, 1]
        share = x / max(abs(x) + abs(y), 1e-300)
        place = (1.0 - share if y >= 0.0 else 3.0 + share) * scale
        one = int(place)
        part = place - one
        if one > most:  # a remainder would take longer than all the rest
            one = 0
        other = one + 1 if one < most else 0
        far[k] = table[one, 0] + part * (table[other, 0] - table[one, 0])
        flow[k] = table[one, 1] + part * (table[other, 1] - table[one, 1])
    lean_x, lean_y = turn[0, 2], turn[1, 2]
    for k in range(len(ways_x)):
        x, y, slope = ways_x[k], ways_y[k], far[k]
        away = math.sqrt(x * x + y * y)
        z = (x * lean_x + y * lean_y) / (away if away > _POLE_MM else _POLE_MM)
        fall = math.sqrt(1.0 - z * z) - z * slope
        far[k] = standoff * slope / fall if fall > 0.0 else math.inf


@inner
def _rim_of_rectangle(
    rim: Rim, turn: NDArray[np.float64], standoff: float, ways: tuple[Scalars, Scalars], out: tuple[Scalars, Scalars]
) -> None:
    """Fill what ``_rim_of_cone`` does for a rectangle that is sprayed evenly.

    Flow by azimuth goes with the square of the distance to its edge.
    """
    (ways_x, ways_y), (far, flow) = ways, out
    long, short = rim.half_slot_mm + standoff * rim.wide, standoff * rim.thin
    for k in range(len(ways_x)):
        away = max(math.sqrt(ways_x[k] * ways_x[k] + ways_y[k] * ways_y[k]), _POLE_MM)
        to_x, to_y = ways_x[k] / away, ways_y[k] / away
        x = abs(to_x * turn[0, 0] + to_y * turn[1, 0])
        y = abs(to_x * turn[0, 1] + to_y * turn[1, 1])
        z = to_x * turn[0, 2] + to_y * turn[1, 2]
        fall_long, fall_short = x - z * rim.wide, y - z * rim.thin
        there = long / fall_long if fall_long > 0.0 else math.inf
        far[k] = min(there, short / fall_short) if fall_short > 0.0 else there
        across = min(long / max(x, 1e-300), short / max(y, 1e-300))
        flow[k] = across * across * (1.0 - z * z) * math.pi / (4.0 * long * short)


@inner
def _share_film(
    rim: Rim,
    turn: NDArray[np.float64],
    stand: tuple[float, float],
    ways: tuple[Scalars, Scalars],
    film: tuple[Scalars, Scalars],
) -> None:
    """Put the share of the film in the place of the flow over the mean flow.

    At the rim the share (1 + sin g) / 2 runs outwards. Of a ray that begins in a slot the angle g counts from there.
    """
    (ways_x, ways_y), (fars, shares), (standoff, facing) = ways, film, stand
    slot, opening, front = rim.half_slot_mm, rim.half_slot_mm + standoff * rim.wide + _POLE_MM, rim.front
    for k in range(len(ways_x)):
        to_x, to_y = ways_x[k], ways_y[k]
        squared = to_x * to_x + to_y * to_y
        away = math.sqrt(squared) if squared > _POLE_MM * _POLE_MM else _POLE_MM
        x = (to_x * turn[0, 0] + to_y * turn[1, 0]) / away
        y = (to_x * turn[0, 1] + to_y * turn[1, 1]) / away
        z = (to_x * turn[0, 2] + to_y * turn[1, 2]) / away
        is_open = fars[k] == math.inf
        far = 1.0 if is_open else fars[k]
        flat = 1.0 - z * z
        # Azimuth about the jet per azimuth on the board, both seen from the pole.
        leaving = shares[k] * facing / ((flat if flat > 1e-12 else 1e-12) * 2.0 * math.pi * far)
        ray_x, ray_y, ray_z = far * x, far * y, standoff + far * z
        begin = ray_x / opening
        begin = -1.0 if begin < -1.0 else 1.0 if begin > 1.0 else begin
        ray_x -= slot * begin
        outward = ray_x * x + ray_y * y + ray_z * z
        sine = outward / math.sqrt(ray_x * ray_x + ray_y * ray_y + ray_z * ray_z)
        outwards, inwards, part = 0.5 * (1.0 + sine) * leaving, 0.5 * (1.0 - sine) * leaving, away / far
        within = 1.0 - (1.0 - part) / front
        within = within if within > 0.0 else 0.0
        share = outwards / part if part >= 1.0 else within * outwards - (1.0 - within) * inwards * part
        shares[k] = 0.0 if is_open else share


@inlined
def film_momentum(rim: Rim, far: float, share: float, away_mm: float) -> float:
    """Momentum of the film per width at a distance from the pole, N/m: above 0 away from the pole, below 0 towards it.

    With R the distance to the rim, outside: M'_out (R/r) exp(-(r-R)/l); inside: -M'_in r/R. For an upright hollow cone
    M' = chi rho v (1 +- sin g)/2 Q/(2 pi R).

    Args:
        rim: Of the jet.
        far: Distance from the pole to the rim, mm, and
        share: of the flow there, both of ``film_around``.
        away_mm: How far from the pole.
    """
    kept = 1e3 * rim.momentum_n * share
    return kept * math.exp(-(away_mm - far) / rim.decay_mm) if away_mm > far else kept
