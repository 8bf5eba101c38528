"""The shape of a jet as compiled code reads it: what it sprays into each direction, and what that does at a place.

Everything is in the tool frame, mm: origin in the orifice, z along the jet, x along the nozzle's reference azimuth.

Cones and fans come from a point. The curtain of an air knife is made of ribbons: what leaves the slot at u times its
half width (-1 <= u <= 1) spreads with u times the tangent of its half angle, so that exactly one ribbon passes through
each place.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Scalars
from geometry.compiled import compiled, inner

RING, CONE, FAN, KNIFE, RADIAL = 0, 1, 2, 3, 4
ROUND = (RING, CONE, RADIAL)
"""Jets whose coordinates are the azimuth and the cosine of the polar angle."""
TAIL_SIGMAS = 5.0
"""The Gaussian flanks of a jet end here."""
EDGE_SIGMAS = 2.0
"""The outer cone, within which a place counts as sprayed, ends here."""
DECAY = 2.4
"""A curtain of gas slows down as 2.4 sqrt(b / x) behind its core, b the opening of the slot (plane free jet)."""


class JetForm(NamedTuple):
    """A jet for compiled code."""

    kind: int
    """RING, CONE, FAN, KNIFE or RADIAL."""
    flow_m3_s: float
    speed_m_s: float
    density_kg_m3: float
    scale: float
    """Density of the flow in the jet's coordinates where its profile is 1, as share of the flow."""
    pressing: float
    """Stress over density, speed and flux at right angles: 1 for liquids, 1/2 for gases (stagnation pressure)."""
    table: NDArray[np.float64]
    """(k, 2) angle from the axis to the middle of the ring and its sigma, rad, at k equally spaced azimuths; of a full
    cone to its edge and the softness of that. Of a radial pattern: flux on a plate at right angles to the axis at k
    equally spaced tangents of the polar angle from 0 to the edge, where the strongest direction is 1; and 0."""
    wide: float
    """Half angle of a fan's wide side, of a curtain's ends or of the edge of a radial pattern, rad."""
    wide_sigma: float
    """Softness of the ends of a fan, rad."""
    thin_sigma: float
    """Sigma across a fan or curtain, rad."""
    half_slot_mm: float
    """Half the length of the slot; 0 for all but knives."""
    core_mm: float
    """Length of a curtain's core, in which the gas is as fast as in the slot."""
    steepest: float
    """Square of the tangent of the largest angle between the axis and a ray from the orifice; infinite for knives."""
    gas_curtain: bool
    """Whether stress follows the decay of a plane free jet."""


@inner
def ring_at(table: NDArray[np.float64], x: float, y: float) -> tuple[float, float]:
    """Angle and sigma of the ring at the azimuth of (x, y), rad."""
    count = len(table)
    place = math.atan2(y, x) / (2 * math.pi) * count
    if place < 0:
        place += count
    index = int(place)
    part = place - index
    one, other = index % count, (index + 1) % count
    return (
        table[one, 0] + part * (table[other, 0] - table[one, 0]),
        table[one, 1] + part * (table[other, 1] - table[one, 1]),
    )


@inner
def soft_edge(beyond: float, sigma: float) -> float:
    """One inside, zero outside of an edge, with a Gaussian in between; nothing beyond its tail."""
    if beyond > TAIL_SIGMAS * sigma:
        return 0.0
    return 0.5 * math.erfc(beyond / (math.sqrt(2.0) * sigma))


@inner
def bell(away: float, sigma: float) -> float:
    """Gaussian of height 1; nothing beyond its tail."""
    if abs(away) > TAIL_SIGMAS * sigma:
        return 0.0
    return math.exp(-0.5 * (away / sigma) ** 2)


@inner
def radial_strength(jet: JetForm, slope: float) -> float:
    """Flow per solid angle of a radial pattern at a tangent of the polar angle, compared with the strongest.

    A plate at right angles at distance h gets q = I cos³ / h² of the intensity I: so I is q (1 + tan²)^1.5.
    """
    last = len(jet.table) - 1
    place = slope / math.tan(jet.wide) * last
    if place > last:
        return 0.0
    index = min(int(place), last - 1)
    flux = jet.table[index, 0] + (place - index) * (jet.table[index + 1, 0] - jet.table[index, 0])
    return flux * (1.0 + slope * slope) ** 1.5


@compiled
def profile(jet: JetForm, x: float, y: float, z: float) -> tuple[float, bool]:
    """How strong a direction is sprayed compared with the strongest, and whether it is in the outer cone.

    Args:
        jet: Which jet.
        x: Direction of the ray that leaves the orifice, any length.
        y: Likewise.
        z: Likewise, along the axis.
    """
    if z <= 0.0:
        return 0.0, False
    if jet.kind == RADIAL:
        slope = math.sqrt(x * x + y * y) / z
        return radial_strength(jet, slope), slope <= math.tan(jet.wide)
    if jet.kind in (RING, CONE):
        angle, sigma = ring_at(jet.table, x, y)
        beyond = math.atan2(math.sqrt(x * x + y * y), z) - angle
        strength = bell(beyond, sigma) if jet.kind == RING else soft_edge(beyond, sigma)
        return strength, beyond <= EDGE_SIGMAS * sigma
    wide, thin = abs(math.atan2(x, z)), math.atan2(y, z)
    within = abs(thin) <= EDGE_SIGMAS * jet.thin_sigma
    if jet.kind == FAN:
        strength = soft_edge(wide - jet.wide, jet.wide_sigma) * bell(thin, jet.thin_sigma)
        return strength, within and wide <= jet.wide + EDGE_SIGMAS * jet.wide_sigma
    within_slot = wide <= jet.wide
    return (bell(thin, jet.thin_sigma) if within_slot else 0.0), within and within_slot


@compiled
def ray_to(jet: JetForm, x: float, y: float, z: float) -> tuple[float, float, float, float, float]:
    """The ray that reaches a place in front of the orifice: its direction, its length, and its spread there.

    Returns:
        Unit vector (three numbers), length in mm, and the area at right angles to the ray over which one unit of the
        jet's coordinates has spread, mm²: for cones and fans the square of the length (coordinates: solid angle), for
        knives of ribbon u and the angle across the slot.
    """
    from_x = 0.0
    opening = 0.0
    if jet.kind == KNIFE:
        slope = math.tan(jet.wide)
        opening = jet.half_slot_mm + z * slope
        from_x = x / opening * jet.half_slot_mm
    dx = x - from_x
    length = math.sqrt(dx * dx + y * y + z * z)
    ux, uy, uz = dx / length, y / length, z / length
    spread = length * length
    if jet.kind == KNIFE:
        spread = uz * z * (1.0 + (y / z) ** 2) * opening
    return ux, uy, uz, length, spread


@compiled
def stress_factor(jet: JetForm, strength: float, length: float, spread: float) -> float:
    """Normal stress on a wall at right angles to the ray, Pa.

    Liquids press with rho q v; gases with the stagnation pressure, half of what their momentum flux rho U² would be,
    where U² = q v keeps the momentum of the jet, and a curtain slows down as a plane free jet does.
    """
    if jet.gas_curtain:
        slower = 1.0 if length <= jet.core_mm else jet.core_mm / length
        return jet.pressing * jet.density_kg_m3 * jet.speed_m_s**2 * slower * strength
    # Spray is never denser than what it is made of: close to the orifice it is the jet itself.
    flux = min(jet.flow_m3_s * jet.scale * strength / max(spread * 1e-6, 1e-12), jet.speed_m_s)
    return jet.pressing * jet.density_kg_m3 * jet.speed_m_s * flux


@compiled
def misses(jet: JetForm, x: float, y: float, z: float) -> bool:
    """Whether a place is surely out of reach: a cheap bound before anything else is computed."""
    return z <= 0.0 or x * x + y * y > jet.steepest * z * z


@compiled
def flux_of(jet: JetForm, place: tuple[float, float, float], normal: tuple[float, float, float]) -> float:
    """Volume that lands at a place with an outward normal, m³/(m² s), as if nothing stood in between; tool frame.

    Of the intensity I (flow per solid angle) a wall at distance l gets I cos(alpha) / l², alpha between its normal
    and the ray. For a pattern q on a plate at right angles at distance h that is q (h / l)² cos(alpha) / cos³(theta),
    the law of Jiangsu 2010, eq. (4), with the square that its printed form has at cos(alpha) corrected.
    """
    x, y, z = place
    if misses(jet, x, y, z):
        return 0.0
    ux, uy, uz, _, spread = ray_to(jet, x, y, z)
    facing = -(ux * normal[0] + uy * normal[1] + uz * normal[2])
    if facing <= 0.0:
        return 0.0
    strength, _ = profile(jet, ux, uy, uz)
    return jet.flow_m3_s * jet.scale * strength / max(spread * 1e-6, 1e-12) * facing


@compiled
def strengths(jet: JetForm, directions: NDArray[np.float64], found: Scalars, within: NDArray[np.bool_]) -> None:
    """Fill (n,) profiles and whether they are in the outer cone, for (n, 3) directions."""
    for i in range(len(directions)):
        found[i], within[i] = profile(jet, directions[i, 0], directions[i, 1], directions[i, 2])
