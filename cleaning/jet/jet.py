"""The jet that leaves a nozzle in one stage: how much flows into which direction, and how hard it presses."""

import math
from dataclasses import dataclass
from typing import assert_never

import numpy as np

from cleaning.errors import require_not_negative, require_positive
from cleaning.jet.compiled_jet import CONE, DECAY, EDGE_SIGMAS, FAN, KNIFE, RADIAL, RING, JetForm
from cleaning.jet.jet_coordinates import normalised, steepest
from cleaning.parameters.liquid import density_kg_m3
from cleaning.parameters.model import Spray
from cleaning.process.stages import Stage
from geometry.arrays import Scalars
from recipes.footprint import mid_angles, plate_profile
from recipes.nozzles import AirKnife, FlatFan, FullCone, HollowCone, Nozzle, Radial

_AZIMUTHS = 360
_PLACES = 1025
"""Of a radial pattern: even a parabola is linear between them within 1e-6 of its peak."""
_BAR_PA = 1e5
_LITRE_PER_MINUTE = 1e-3 / 60
AMBIENT_PA = 101_325.0
_HEAT_RATIO = 1.4
"""Ratio of the specific heats of air."""


@dataclass(frozen=True, slots=True, eq=False)
class Jet:
    """What leaves a nozzle. SI units and rad, except where a name has another unit."""

    nozzle: Nozzle
    gas: bool
    """Whether it leaves nothing on what it hits."""
    flow_m3_s: float
    speed_m_s: float
    """At the orifice."""
    density_kg_m3: float
    half_angle: float
    """From the axis to the middle of the ring (mean over the azimuth), to the edge of a full cone or radial pattern, to
    the edge of the thin side of a fan or knife."""
    sigma: float
    """Spread about it: mean over the azimuth."""
    azimuths: Scalars
    """(k,) equally spaced from the nozzle's reference."""
    half_angles: Scalars
    """(k,) at these azimuths."""
    sigmas: Scalars
    """(k,) likewise."""
    form: JetForm
    """The same for compiled code."""


def jet_of(stage: Stage, spray: Spray) -> Jet:
    """Work out the jet of a stage from its nozzle, pressure and liquid."""
    nozzle, density = stage.nozzle, density_kg_m3(stage.liquid, stage.temperature_c)
    gas = stage.liquid.use == "dry"
    speed_of = gas_speed_m_s if gas else liquid_speed_m_s
    speed = speed_of(stage.pressure_pa, density, spray.discharge)
    stated_m3_s, exponent = nozzle.flow_lpm * _LITRE_PER_MINUTE, spray.exponent_of(nozzle.pattern)
    flow = flow_m3_s(stated_m3_s, nozzle.at_bar * _BAR_PA, stage.pressure_pa, exponent)
    azimuths: Scalars = np.linspace(0.0, 2 * np.pi, _AZIMUTHS, endpoint=False, dtype=np.float64)
    half_angles = mid_angles(nozzle, azimuths)
    kind, sigmas = _shape(nozzle, azimuths, half_angles, spray)
    slot_mm = nozzle.width_mm if isinstance(nozzle, AirKnife) else 0.0
    form = _spread(nozzle, kind, (half_angles, sigmas), spray)._replace(
        flow_m3_s=flow,
        speed_m_s=speed,
        density_kg_m3=density,
        pressing=0.5 if gas else 1.0,
        core_mm=DECAY**2 * flow / (speed * slot_mm * 1e-3) * 1e3 if slot_mm else 0.0,  # there U = U0 at x = 2.4² b
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


def form_of(nozzle: Nozzle, flow_lpm: float, spray: Spray) -> JetForm:
    """Form of a nozzle's jet for what lands where, whatever the pressure and liquid: its speed and density are 1.

    Args:
        nozzle: Whose pattern.
        flow_lpm: What leaves it, litres per minute.
        spray: Softness of the edges.
    """
    azimuths: Scalars = np.linspace(0.0, 2 * np.pi, _AZIMUTHS, endpoint=False, dtype=np.float64)
    half_angles = mid_angles(nozzle, azimuths)
    kind, sigmas = _shape(nozzle, azimuths, half_angles, spray)
    form = _spread(nozzle, kind, (half_angles, sigmas), spray)._replace(flow_m3_s=flow_lpm * _LITRE_PER_MINUTE)
    return normalised(form._replace(steepest=steepest(form)))


def _spread(nozzle: Nozzle, kind: int, rings: tuple[Scalars, Scalars], spray: Spray) -> JetForm:
    """Form with the angles of a nozzle and nothing of what flows; (k,) half angles and sigmas are of ``_shape``."""
    slot_mm = nozzle.width_mm if isinstance(nozzle, AirKnife) else 0.0
    table = np.column_stack(rings)
    if isinstance(nozzle, Radial):
        slope, flux = plate_profile(nozzle, _PLACES)
        table = np.column_stack([flux / (flux * (1.0 + slope**2) ** 1.5).max(), np.zeros(len(flux))])
    return JetForm(
        kind=kind,
        flow_m3_s=1.0,
        speed_m_s=1.0,
        density_kg_m3=1.0,
        scale=1.0,
        pressing=1.0,
        table=table,
        wide=math.radians(nozzle.half_angle_deg),
        wide_sigma=math.radians(spray.cone_sigma_deg),
        thin_sigma=float(rings[1][0]),
        half_slot_mm=slot_mm / 2,
        core_mm=0.0,
        steepest=math.inf,
        gas_curtain=False,
    )


def flow_m3_s(reference_m3_s: float, reference_pa: float, pressure_pa: float, exponent: float) -> float:
    """Flow at a pressure, from that at a reference pressure: Q = Q_ref (P / P_ref)^n."""
    require_positive(reference_pa=reference_pa, exponent=exponent)
    require_not_negative(reference_m3_s=reference_m3_s, pressure_pa=pressure_pa)
    return reference_m3_s * (pressure_pa / reference_pa) ** exponent


def liquid_speed_m_s(pressure_pa: float, density_kg_m3: float, discharge: float) -> float:
    """Speed of a liquid behind an orifice: v = C_v sqrt(2 P / rho), Bernoulli with a velocity coefficient."""
    require_positive(density_kg_m3=density_kg_m3)
    require_not_negative(pressure_pa=pressure_pa, discharge=discharge)
    return discharge * math.sqrt(2 * pressure_pa / density_kg_m3)


def gas_speed_m_s(pressure_pa: float, density_kg_m3: float, discharge: float) -> float:
    """Speed of a gas behind an orifice, no faster than sound in its throat.

    Isentropic expansion from the pressure above ambient; where that would be faster than sound, a plain orifice chokes
    and the speed is sound's at the throat, sqrt(2 gamma / (gamma + 1) p / rho).

    Args:
        pressure_pa: Before the orifice, above ambient.
        density_kg_m3: At ambient pressure and the temperature before the orifice.
        discharge: Velocity coefficient.
    """
    require_positive(density_kg_m3=density_kg_m3)
    require_not_negative(pressure_pa=pressure_pa, discharge=discharge)
    heat = _HEAT_RATIO
    expanded = 1 - (AMBIENT_PA / (AMBIENT_PA + pressure_pa)) ** ((heat - 1) / heat)
    squared = min(expanded / (heat - 1), 1 / (heat + 1))
    return discharge * math.sqrt(2 * heat * AMBIENT_PA / density_kg_m3 * squared)


def _shape(nozzle: Nozzle, azimuths: Scalars, half_angles: Scalars, spray: Spray) -> tuple[int, Scalars]:
    """Kind of jet, and (k,) the spread of a ring, softness of the edge of a full cone, or sigma across a thin side."""
    match nozzle:
        case HollowCone():
            if nozzle.wavefront is None:
                return RING, np.full(len(azimuths), math.radians(nozzle.ring_sigma_deg))
            table = np.array(nozzle.wavefront.points)
            outer = np.interp(np.degrees(azimuths), table[:, 0], table[:, 2], period=360)
            return RING, (np.arctan2(outer, nozzle.wavefront.height_mm) - half_angles) / EDGE_SIGMAS
        case FullCone():
            return CONE, np.full(len(azimuths), math.radians(spray.cone_sigma_deg))
        case Radial():
            # The pattern ends where it was seen to end; the film before it begins to run off as that of a full cone.
            return RADIAL, np.full(len(azimuths), math.radians(spray.cone_sigma_deg))
        case FlatFan():
            return FAN, half_angles / EDGE_SIGMAS
        case AirKnife():
            # Where its momentum has fallen to 1/e is the edge of a curtain: 5.4 degrees make the decay 2.4 sqrt(b / x).
            return KNIFE, half_angles / math.sqrt(2)
        case _:
            assert_never(nozzle)
