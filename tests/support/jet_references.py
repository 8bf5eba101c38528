"""What a jet does by closed forms and sums over directions, that results of the model are compared with."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cleaning.jet.compiled_jet import KNIFE, JetForm, misses, profile, ray_to, stress_factor
from cleaning.jet.jet import Jet
from cleaning.jet.jet_coordinates import flow_density
from geometry.arrays import Directions, Points, Scalars
from geometry.compiled import compiled


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


@compiled
def stress_of(jet: JetForm, place: tuple[float, float, float], normal: tuple[float, float, float]) -> float:
    """Normal stress at a place with an outward normal, Pa, as if nothing stood in between; all in the tool frame."""
    x, y, z = place
    if misses(jet, x, y, z):
        return 0.0
    ux, uy, uz, length, spread = ray_to(jet, x, y, z)
    facing = -(ux * normal[0] + uy * normal[1] + uz * normal[2])
    if facing <= 0.0:
        return 0.0
    strength, _ = profile(jet, ux, uy, uz)
    if strength <= 0.0:
        return 0.0
    return stress_factor(jet, strength, length, spread) * facing * facing


@compiled
def add_stresses(jet: JetForm, poses: tuple[Any, Any], wall: tuple[Any, Any], found: NDArray[np.float64]) -> None:
    """Fill (n, k) normal stresses: n poses (tcp (n, 3), axes (n, 3, 3)), k places (points, normals (k, 3))."""
    tcp, axes = poses
    points, normals = wall
    for i in range(len(tcp)):
        turn = axes[i]
        for j in range(len(points)):
            x, y, z = points[j, 0] - tcp[i, 0], points[j, 1] - tcp[i, 1], points[j, 2] - tcp[i, 2]
            nx, ny, nz = normals[j, 0], normals[j, 1], normals[j, 2]
            found[i, j] = stress_of(
                jet,
                (
                    turn[0, 0] * x + turn[1, 0] * y + turn[2, 0] * z,
                    turn[0, 1] * x + turn[1, 1] * y + turn[2, 1] * z,
                    turn[0, 2] * x + turn[1, 2] * y + turn[2, 2] * z,
                ),
                (
                    turn[0, 0] * nx + turn[1, 0] * ny + turn[2, 0] * nz,
                    turn[0, 1] * nx + turn[1, 1] * ny + turn[2, 1] * nz,
                    turn[0, 2] * nx + turn[1, 2] * ny + turn[2, 2] * nz,
                ),
            )


@dataclass(frozen=True, slots=True)
class Footprint:
    """Where a cone meets a plane. Lengths as the height was given, from the foot of the perpendicular from the apex.

    The x axis of the plane points to where the cone leans. Where the cone does not close on the plane, the far edge,
    the centre and the axes are infinite and only the near edge and the eccentricity mean anything.
    """

    semi_major: float
    """Along x."""
    semi_minor: float
    centre: float
    near: float
    """The edge of the footprint that is least along x; negative on the other side of the foot."""
    far: float
    eccentricity: float
    """Above 1 for a hyperbola."""

    @property
    def closed(self) -> bool:
        """Whether the spray closes on the plane."""
        return math.isfinite(self.far)


def footprint(half_angle: float, tilt: float, height: float) -> Footprint:
    """Meet a circular cone with a plane.

    The section of a cone: with D = cos² b - sin² a the semi-axes are H sin a cos a / D and H sin a / sqrt(D), the
    centre H sin b cos b / D, the edges H tan(b -+ a), the eccentricity sin b / cos a. Open where D <= 0.

    Args:
        half_angle: From the axis to the cone, rad, between 0 and a quarter turn.
        tilt: From the normal of the plane to the axis, rad, from 0 to below a quarter turn.
        height: Of the apex above the plane, in any unit: lengths come out in it.
    """
    sine, cosine = math.sin(half_angle), math.cos(half_angle)
    discriminant = math.cos(tilt) ** 2 - sine**2
    near = height * math.tan(tilt - half_angle)
    if discriminant <= 1e-12:
        return Footprint(math.inf, math.inf, math.inf, near, math.inf, math.sin(tilt) / cosine)
    return Footprint(
        semi_major=height * sine * cosine / discriminant,
        semi_minor=height * sine / math.sqrt(discriminant),
        centre=height * math.sin(tilt) * math.cos(tilt) / discriminant,
        near=near,
        far=height * math.tan(tilt + half_angle),
        eccentricity=math.sin(tilt) / cosine,
    )
