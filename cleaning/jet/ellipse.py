"""The ellipse in which a cone meets a tilted plane."""

import math
from dataclasses import dataclass

from cleaning.errors import CleaningError
from cleaning.require import require_not_negative, require_positive

_FLAT = 1e-12
_QUARTER = 0.5 * math.pi


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

    Raises:
        CleaningError: an angle or the height is none.
    """
    require_positive(height=height)
    require_not_negative(half_angle=half_angle, tilt=tilt)
    if max(half_angle, tilt) >= _QUARTER:
        raise CleaningError(
            f"half_angle {half_angle:g} and tilt {tilt:g} must be below a quarter turn, {_QUARTER:.4f} rad"
        )
    sine, cosine = math.sin(half_angle), math.cos(half_angle)
    discriminant = math.cos(tilt) ** 2 - sine**2
    near = height * math.tan(tilt - half_angle)
    if discriminant <= _FLAT:
        return Footprint(math.inf, math.inf, math.inf, near, math.inf, math.sin(tilt) / cosine)
    return Footprint(
        semi_major=height * sine * cosine / discriminant,
        semi_minor=height * sine / math.sqrt(discriminant),
        centre=height * math.sin(tilt) * math.cos(tilt) / discriminant,
        near=near,
        far=height * math.tan(tilt + half_angle),
        eccentricity=math.sin(tilt) / cosine,
    )
