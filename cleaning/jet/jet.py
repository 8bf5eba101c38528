"""The jet that leaves a nozzle in one stage: how much flows into which direction, and how hard it presses."""

import math
from dataclasses import dataclass
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from cleaning.jet.compiled_jet import CONE, DECAY, EDGE_SIGMAS, FAN, KNIFE, RING, JetForm, add_stresses
from cleaning.jet.jet_coordinates import flow_density, normalised, steepest
from cleaning.jet.orifice import flow_m3_s, gas_speed_m_s, liquid_speed_m_s
from cleaning.parameters.liquid import density_kg_m3
from cleaning.parameters.model import Spray
from cleaning.process.stages import Stage
from geometry.arrays import Directions, Points, Scalars
from recipes.footprint import mid_angles
from recipes.nozzles import AirKnife, FlatFan, FullCone, HollowCone, Nozzle

_AZIMUTHS = 360
_BAR_PA = 1e5
_LITRE_PER_MINUTE = 1e-3 / 60


@dataclass(frozen=True, slots=True, eq=False)
class Jet:
    """What leaves a nozzle. SI units and rad, except where a name says otherwise."""

    nozzle: Nozzle
    gas: bool
    """Whether it leaves nothing on what it hits."""
    flow_m3_s: float
    speed_m_s: float
    """At the orifice."""
    density_kg_m3: float
    half_angle: float
    """From the axis to the middle of the ring (mean over the azimuth), to the edge of a full cone, to the edge of the
    thin side of a fan or knife."""
    sigma: float
    """Spread about it: mean over the azimuth."""
    azimuths: Scalars
    """(k,) equally spaced from the nozzle's reference."""
    half_angles: Scalars
    """(k,) at these azimuths."""
    sigmas: Scalars
    """(k,) likewise."""
    form: JetForm
    """For compiled code: ``cleaning.jet_form``."""


def jet_of(stage: Stage, spray: Spray) -> Jet:
    """Work out the jet of a stage from its nozzle, pressure and liquid."""
    nozzle, density = stage.nozzle, density_kg_m3(stage.liquid, stage.temperature_c)
    gas = stage.liquid.use == "dry"
    speed_of = gas_speed_m_s if gas else liquid_speed_m_s
    speed = speed_of(stage.pressure_pa, density, spray.discharge)
    flow = flow_m3_s(
        nozzle.flow_lpm * _LITRE_PER_MINUTE,
        nozzle.at_bar * _BAR_PA,
        stage.pressure_pa,
        spray.flow_exponent[nozzle.pattern],
    )
    azimuths: Scalars = np.linspace(0.0, 2 * np.pi, _AZIMUTHS, endpoint=False, dtype=np.float64)
    half_angles = mid_angles(nozzle, azimuths)
    sigmas = _sigmas(nozzle, azimuths, half_angles, spray)
    form = JetForm(
        kind=_kind(nozzle),
        flow_m3_s=flow,
        speed_m_s=speed,
        density_kg_m3=density,
        scale=1.0,
        pressing=0.5 if gas else 1.0,
        table=np.ascontiguousarray(np.column_stack([half_angles, sigmas])),
        wide=math.radians(nozzle.half_angle_deg),
        wide_sigma=math.radians(spray.cone_sigma_deg),
        thin_sigma=float(sigmas[0]),
        half_slot_mm=nozzle.width_mm / 2 if isinstance(nozzle, AirKnife) else 0.0,
        core_mm=_core_mm(nozzle, flow, speed),
        steepest=math.inf,
        gas_curtain=gas and isinstance(nozzle, AirKnife),
    )
    return Jet(
        nozzle=nozzle,
        gas=gas,
        flow_m3_s=flow,
        speed_m_s=speed,
        density_kg_m3=density,
        half_angle=float(half_angles.mean()),
        sigma=float(sigmas.mean()),
        azimuths=azimuths,
        half_angles=half_angles,
        sigmas=sigmas,
        form=normalised(form._replace(steepest=steepest(form))),
    )


def intensity(jet: Jet, directions_tool: Directions) -> Scalars:
    """Flow per solid angle into each direction, m³/s per sr; over all directions it adds up to the jet's flow.

    The curtain of a knife is taken together along its slot, as seen from far away.

    Args:
        jet: Which jet.
        directions_tool: (n, 3) unit vectors, tool frame.
    """
    density, _ = flow_density(jet.form, directions_tool)
    if jet.form.kind == KNIFE:
        z = np.maximum(directions_tool[:, 2], 1e-12)
        x, y = directions_tool[:, 0] / z, directions_tool[:, 1] / z
        density = density / (math.tan(jet.form.wide) * z**3 * (1 + y**2)) * (np.abs(x) <= math.tan(jet.form.wide))
    return jet.flow_m3_s * density


def stress_at(jet: Jet, tcp: Points, axes: NDArray[np.float64], points: Points, normals: Directions) -> Scalars:
    """Normal stress at places of the board from each pose of the nozzle, as if nothing stood in between.

    Args:
        jet: Which jet.
        tcp: (n, 3) orifice, mm, board frame.
        axes: (n, 3, 3) rotations of T_board_tool.
        points: (k, 3) places, mm.
        normals: (k, 3) outward unit normals.

    Returns:
        (n, k) Pa.
    """
    found = np.empty((len(tcp), len(points)))
    poses = np.ascontiguousarray(tcp), np.ascontiguousarray(axes)
    add_stresses(jet.form, poses, (np.ascontiguousarray(points), np.ascontiguousarray(normals)), found)
    return found


def gas_speed_at(jet: Jet, distance_mm: Scalars) -> Scalars:
    """Speed of a gas on the strongest ray at (n,) distances from the orifice, m/s.

    A curtain slows down as U = U0 2.4 sqrt(b / x) behind its core (plane free jet); what blows from a round nozzle
    keeps the momentum that flows in its solid angle: U² = q v with the flux q = I / r².
    """
    if jet.form.gas_curtain:
        return jet.speed_m_s * np.sqrt(np.minimum(1.0, jet.form.core_mm / np.maximum(distance_mm, 1e-9)))
    flux = jet.flow_m3_s * jet.form.scale / (np.maximum(distance_mm, 1e-9) * 1e-3) ** 2
    return np.minimum(jet.speed_m_s, np.sqrt(flux * jet.speed_m_s))


def _kind(nozzle: Nozzle) -> int:
    match nozzle:
        case HollowCone():
            return RING
        case FullCone():
            return CONE
        case FlatFan():
            return FAN
        case AirKnife():
            return KNIFE
        case _:
            assert_never(nozzle)


def _sigmas(nozzle: Nozzle, azimuths: Scalars, half_angles: Scalars, spray: Spray) -> Scalars:
    """(k,) spread of the ring, softness of the edge of a full cone, or sigma across a thin side."""
    match nozzle:
        case HollowCone():
            if nozzle.wavefront is None:
                return np.full(len(azimuths), math.radians(nozzle.ring_sigma_deg))
            table = np.array(nozzle.wavefront.points)
            outer = np.interp(np.degrees(azimuths), table[:, 0], table[:, 2], period=360)
            return (np.arctan2(outer, nozzle.wavefront.height_mm) - half_angles) / EDGE_SIGMAS
        case FullCone():
            return np.full(len(azimuths), math.radians(spray.cone_sigma_deg))
        case FlatFan():
            return half_angles / EDGE_SIGMAS
        case AirKnife():
            # Where its momentum has fallen to 1/e is the edge of a curtain: 5.4 degrees make the decay 2.4 sqrt(b / x).
            return half_angles / math.sqrt(2)
        case _:
            assert_never(nozzle)


def _core_mm(nozzle: Nozzle, flow: float, speed: float) -> float:
    """Behind this length the decay of a plane jet begins: U = U0 at x = 2.4² b."""
    if not isinstance(nozzle, AirKnife):
        return 0.0
    return DECAY**2 * flow / (speed * nozzle.width_mm * 1e-3) * 1e3
