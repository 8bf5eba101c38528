"""What the mass of a liquid does to its flow in a gap, and how a plugged gap is eaten open from its rim."""

import numpy as np
from numpy.typing import NDArray

from cleaning.require import require_not_negative, require_positive

Values = float | NDArray[np.float64]


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


def plug_front_m(softening_per_s: Values, depth_m: float, seconds: Values) -> Values:
    """How deep from its rim a plugged gap has opened: nothing flows, softening proceeds layer by layer.

    Each layer of ``depth_m`` softens at the rate of the chemistry, so the front moves at their product.
    """
    require_not_negative(softening_per_s=softening_per_s, depth_m=depth_m, seconds=seconds)
    return softening_per_s * depth_m * seconds
