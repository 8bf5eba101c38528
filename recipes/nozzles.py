"""Nozzles and the pattern each sprays."""

import math
from itertools import pairwise
from typing import Annotated, Literal, TypeAlias, get_args

from pydantic import Field, model_validator

from specs.spec import (
    Bounds,
    Duration,
    Flow,
    HalfAngle,
    OrificeHeight,
    PositiveDistance,
    Pressure,
    Spec,
    Spread,
    ToolNumber,
    Turn,
)

Radius: TypeAlias = Annotated[float, Bounds(0.01, 20_000, "mm", "radii of a wave front")]
RadiusFromAxis: TypeAlias = Annotated[float, Bounds(0, 20_000, "mm", "radii of a spray pattern")]
Flux: TypeAlias = Annotated[float, Bounds(0, 1_000_000_000)]
DropSize: TypeAlias = Annotated[float, Bounds(1, 20_000, "micrometres", "drop sizes")]
Range: TypeAlias = Annotated[float, Bounds(1, 20_000, "mm", "distances that a jet reaches")]


class Wavefront(Spec):
    """The ring where the cone meets a flat plate, as measured with the nozzle at right angles to it."""

    height_mm: OrificeHeight = Field(description="Orifice above the plate during the measurement.")
    points: list[tuple[Turn, Radius, Radius]] = Field(
        min_length=3,
        description="[azimuth from the nozzle's reference (deg, ascending), inner radius (mm), outer radius (mm)].",
    )

    @model_validator(mode="after")
    def _check_points(self) -> "Wavefront":
        azimuths = [point[0] for point in self.points]
        if any(b <= a for a, b in pairwise(azimuths)):
            raise ValueError("azimuths must ascend; sort the points by their first number")
        if azimuths[0] < 0 or azimuths[-1] >= 360:
            raise ValueError("azimuths must lie in 0 <= azimuth < 360")
        if any(inner >= outer for _, inner, outer in self.points):
            raise ValueError("each inner radius must be smaller than its outer radius")
        return self


class NozzleBody(Spec):
    """The lance behind the orifice as a rod with round ends: from the orifice backwards along the jet's axis."""

    radius_mm: PositiveDistance = Field(description="Of the rod and its round ends.")
    length_mm: PositiveDistance = Field(description="From the orifice to the centre of the other round end.")


class _Nozzle(Spec):
    flow_lpm: Flow = Field(description="Flow at the reference pressure, litres per minute.")
    at_bar: Pressure = Field(default=3.0, description="Reference pressure of flow_lpm.")
    drop_um: DropSize | None = Field(
        default=None, description="Median diameter by volume of the drops at the reference pressure; left out: 300."
    )
    range_mm: Range | None = Field(
        default=None,
        description="Greatest distance at which the jet counts over parts; left out: where its impact is a quarter.",
    )
    open_lag_s: Duration = Field(default=0.04, description="From the signal to the full jet.")
    close_lag_s: Duration = Field(default=0.02, description="From the signal to no jet.")
    tool: ToolNumber = Field(default=1, description="Number of the tool on the robot.")
    body: NozzleBody | None = Field(
        default=None, description="Lance that paths over parts keep clear of everything; boards do not use it."
    )


class HollowCone(_Nozzle):
    """A hollow cone; its wave front does the work (Sandia 1993)."""

    pattern: Literal["hollow_cone"] = Field(
        default="hollow_cone", description="A hollow cone; its wave front does the work."
    )
    half_angle_deg: HalfAngle = Field(description="From the axis to the middle of the wave front.")
    ring_sigma_deg: Spread = Field(default=3.0, description="Spread of the ring about its half angle.")
    wavefront: Wavefront | None = Field(default=None, description="Measured ring; replaces the ideal circle.")


class FullCone(_Nozzle):
    """A cone that is wet all the way to its axis."""

    pattern: Literal["full_cone"] = Field(default="full_cone", description="A cone that is wet to its axis.")
    half_angle_deg: HalfAngle = Field(description="From the axis to the edge of the cone.")


class FlatFan(_Nozzle):
    """A flat sheet; the wide side lies along the nozzle's reference azimuth."""

    pattern: Literal["flat_fan"] = Field(default="flat_fan", description="A flat sheet.")
    half_angle_deg: HalfAngle = Field(description="From the axis to the end of the wide side.")
    thickness_half_angle_deg: HalfAngle = Field(default=3.0, description="From the axis to the edge of the thin side.")

    @model_validator(mode="after")
    def _check_sides(self) -> "FlatFan":
        if self.thickness_half_angle_deg >= self.half_angle_deg:
            raise ValueError("thickness_half_angle_deg must be smaller than half_angle_deg, the wide side")
        return self


class AirKnife(_Nozzle):
    """A slot that blows a curtain of gas; the slot lies along the nozzle's reference azimuth."""

    pattern: Literal["air_knife"] = Field(default="air_knife", description="A slot that blows a curtain of gas.")
    width_mm: PositiveDistance = Field(description="Length of the slot.")
    half_angle_deg: HalfAngle = Field(
        default=5.0, description="Spread of the curtain on either side of the slot's ends."
    )
    thickness_half_angle_deg: HalfAngle = Field(default=5.0, description="Spread of the curtain across the slot.")


class Radial(_Nozzle):
    """A round jet of any profile, as its spray pattern on a flat plate at right angles to it shows.

    The flow is what lands: for the thickness of a dry film multiply it by the transfer efficiency and volume solids.
    """

    pattern: Literal["radial"] = Field(default="radial", description="A round jet of any profile.")
    radius_mm: Radius = Field(description="Radius of the pattern on the plate.")
    at_mm: OrificeHeight = Field(description="Orifice above the plate.")
    profile: Literal["parabola"] | list[tuple[RadiusFromAxis, Flux]] = Field(
        default="parabola",
        description="`parabola` (R² - r²), or [radius (mm, ascending from 0 to radius_mm), flux (any unit)].",
    )

    @model_validator(mode="after")
    def _check_profile(self) -> "Radial":
        if self.half_angle_deg >= 85.0:
            raise ValueError("radius_mm is wider than 85 degrees from the axis; correct radius_mm or at_mm")
        if self.profile == "parabola":
            return self
        radii = [radius for radius, _ in self.profile]
        if len(radii) < 2 or radii[0] != 0 or radii[-1] != self.radius_mm:
            raise ValueError("profile must begin at radius 0 and end at radius_mm")
        if any(b <= a for a, b in pairwise(radii)):
            raise ValueError("radii of the profile must ascend; sort the points by their first number")
        if not any(flux > 0 for _, flux in self.profile):
            raise ValueError("profile must have some flux above 0")
        return self

    @property
    def half_angle_deg(self) -> float:
        """From the axis to the edge of the pattern."""
        return math.degrees(math.atan2(self.radius_mm, self.at_mm))


Nozzle: TypeAlias = Annotated[HollowCone | FullCone | FlatFan | AirKnife | Radial, Field(discriminator="pattern")]
NOZZLE_PATTERNS: tuple[type[Nozzle], ...] = get_args(get_args(Nozzle)[0])
"""The nozzle patterns, in the order of the union."""
