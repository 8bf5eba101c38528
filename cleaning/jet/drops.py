"""How far a jet reaches: its drops slow down in the air while it spreads, and what it counts as spraying ends there."""

import math

import numpy as np

from cleaning.errors import require_not_negative, require_positive
from cleaning.jet.jet import liquid_speed_m_s
from geometry.arrays import Scalars
from geometry.solids.cone_view import Cone
from recipes.footprint import mean_angle
from recipes.nozzles import AirKnife, Nozzle
from recipes.paths import OverFaces
from recipes.recipe import Function, film_in

DROP_UM = 300.0
"""Median by volume of a nozzle that states none: small hydraulic nozzles at 3 bar lie between 200 and 900."""
_FILM_RANGE = 10.0
"""Standoffs within which a film's jet counts."""
_FINER = -1.0 / 3.0
"""Power of the pressure with which drops of one nozzle go."""
_DISCHARGE = 0.9
"""Velocity coefficient of the orifice, as in the default parameter set."""
_WATER_KG_M3 = 1000.0
_AIR_KG_M3, _AIR_PA_S = 1.19, 1.82e-5
"""At 22 degrees C."""
USEFUL = 0.25
"""Of the impact at the standoff: where the jet has less it does not count. A cone without drag has it at twice the
standoff."""
_SPEEDS = 400
_NEWTON_RE, _NEWTON = 1000.0, 0.44
_HALVINGS = 60


def drop_um_at(nozzle: Nozzle, pressure_bar: float) -> float:
    """Median diameter by volume of a nozzle's drops at a pressure, micrometres: finer with its cube root."""
    stated = DROP_UM if nozzle.drop_um is None else nozzle.drop_um
    return stated * (max(pressure_bar, 1e-6) / nozzle.at_bar) ** _FINER


def speed_after_m_s(speed_m_s: float, drop_um: float, way_mm: Scalars) -> Scalars:
    """Speeds of a drop that has flown ways (n,) through air at rest.

    Drag of a sphere after Schiller and Naumann (1933), 24/Re (1 + 0.15 Re^0.687), and 0.44 above Re 1000. Gravity, and
    that drops draw the air along, are left out: a dense jet reaches farther.

    Raises:
        CleaningError: a size that is not positive, or a negative speed.
    """
    speeds, ways = _flight(speed_m_s, drop_um)
    return np.interp(way_mm, ways, speeds, right=0.0)


def stopping_length_mm(speed_m_s: float, drop_um: float) -> float:
    """Way on which air at rest takes 99.9 % of a drop's speed."""
    return float(_flight(speed_m_s, drop_um)[1][-1])


def _flight(speed_m_s: float, drop_um: float) -> tuple[Scalars, Scalars]:
    """Speeds (n,) of a drop, falling, m/s, and the ways (n,) after which it has them, mm."""
    require_positive(drop_um=drop_um)
    require_not_negative(speed_m_s=speed_m_s)
    size = drop_um * 1e-6
    speeds = max(speed_m_s, 1e-9) * np.geomspace(1.0, 1e-3, _SPEEDS)
    reynolds = _AIR_KG_M3 * speeds * size / _AIR_PA_S
    drag = np.where(reynolds > _NEWTON_RE, _NEWTON, 24.0 / reynolds * (1.0 + 0.15 * reynolds**0.687))
    # m v dv/dx = -drag pi/8 rho d^2 v^2, so that dx = -d(ln v) 4/3 rho_drop / rho_air d / drag
    lengths = 4.0 / 3.0 * _WATER_KG_M3 / _AIR_KG_M3 * size / drag
    ways = np.concatenate([[0.0], np.cumsum((lengths[1:] + lengths[:-1]) / 2 * -np.diff(np.log(speeds)))])
    return speeds, 1000.0 * ways


def spray_range_mm(nozzle: Nozzle, pressure_bar: float, standoff_mm: float) -> float:
    """Greatest distance from the orifice at which a nozzle's jet counts.

    As the nozzle states it, else where its impact, the momentum that lands on an area in a second, has fallen to a
    quarter of that at the standoff: it spreads with the square of the distance, and its drops slow down. The curtain
    of an air knife spreads to one side only, and draws the air along.
    """
    if nozzle.range_mm is not None:
        return nozzle.range_mm
    if isinstance(nozzle, AirKnife):
        return standoff_mm / USEFUL
    speed = liquid_speed_m_s(pressure_bar * 1e5, _WATER_KG_M3, _DISCHARGE)
    drop = drop_um_at(nozzle, pressure_bar)
    low, high = 1.0, math.sqrt(1.0 / USEFUL)
    at = float(speed_after_m_s(speed, drop, np.array([standoff_mm]))[0])
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        there = float(speed_after_m_s(speed, drop, np.array([middle * standoff_mm]))[0])
        low, high = (middle, high) if there >= USEFUL * at * middle**2 else (low, middle)
    return low * standoff_mm


def spray_cone(nozzle: Nozzle, function: Function, spec: OverFaces, edge_mm: float = 0.0) -> Cone:
    """What counts as sprayed by a nozzle along a template over faces: the one statement for plan and analysis.

    Args:
        nozzle: Its angle and range.
        function: Its pressure.
        spec: Standoff and least angle of incidence.
        edge_mm: Width at the standoff over which a cell passes from inside to outside of a cone at rest.
    """
    edge = edge_mm / spec.standoff_mm
    reach = spray_range_mm(nozzle, function.pressure_bar, spec.standoff_mm)
    if film_in(spec) is not None:  # what lands there counts, however fast
        reach = max(reach, _FILM_RANGE * spec.standoff_mm)
    incidence = float(np.radians(spec.incidence_min_deg))
    return Cone(mean_angle(nozzle) + edge / 2, incidence, edge, reach + edge_mm / 2, edge_mm)
