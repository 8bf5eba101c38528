"""Numbers that mean nothing are refused where they come in, with their name."""

import math
from functools import partial

import numpy as np
import pytest

from boards.undersides.underside import Joint
from cleaning.errors import CleaningError, require_not_negative, require_positive, require_temperature
from cleaning.gap.flow_field import solve_gap
from cleaning.gap.flushing import inertial, lubrication_velocity, reduced_reynolds
from cleaning.gap.joint_lattice import post_factor, round_posts, square_posts, tall_posts
from cleaning.jet.jet import flow_m3_s, gas_speed_m_s, liquid_speed_m_s
from cleaning.parameters.liquid import capillary_pa, surface_tension_n_m, viscosity_pa_s, wet_surface_c
from cleaning.parameters.load import load_parameters
from cleaning.undersides.residue import fill_share, removal_rate, softening_rate, step
from cleaning.undersides.rinse import (
    blow_off_m,
    diluted_g_m3,
    film_dry_s,
    film_exchanges,
    gap_dry_s,
    ionic_ug_cm2,
    salt_g_m3,
)

P = load_parameters()
AGENT = P.liquids["saponifier-15"]
GOOD = {
    flow_m3_s: {"reference_m3_s": 3e-5, "reference_pa": 3e5, "pressure_pa": 2e5, "exponent": 0.5},
    liquid_speed_m_s: {"pressure_pa": 3e5, "density_kg_m3": 1e3, "discharge": 0.9},
    gas_speed_m_s: {"pressure_pa": 3e5, "density_kg_m3": 1.0, "discharge": 0.9},
    partial(softening_rate, P.soil): {"temperature_c": 60.0, "concentration_pct": 15.0},
    partial(removal_rate, P.soil): {"shear_pa": 1.0},
    step: {"hard": 1.0, "soft": 0.0, "k1": 0.01, "k2": 0.02, "seconds": 10.0},
    partial(capillary_pa, AGENT): {"temperature_c": 60.0, "height_m": 5e-5},
    partial(surface_tension_n_m, P.liquids["di-water"]): {"temperature_c": 60.0},
    partial(viscosity_pa_s, AGENT): {"temperature_c": 60.0},
    partial(lubrication_velocity, 500.0): {"height_m": 5e-5, "path_m": 7e-3, "viscosity_pa_s": 6e-4},
    partial(inertial, 0.1): {"height_m": 5e-5, "path_m": 7e-3, "density_kg_m3": 1e3, "viscosity_pa_s": 6e-4},
    partial(reduced_reynolds, 0.1): {"height_m": 5e-5, "path_m": 7e-3, "density_kg_m3": 1e3, "viscosity_pa_s": 6e-4},
    partial(film_exchanges, P.rinse): {"volume_mm": 2.0},
    salt_g_m3: {"resistivity_mohm_cm": 1.0},
    partial(diluted_g_m3, P.rinse): {"before_g_m3": 3e4, "exchanges": 7.0, "water_g_m3": 0.4},
    ionic_ug_cm2: {"content_g_m3": 3e4, "film_um": 50.0},
    partial(blow_off_m, P.drying): {"tension_n_m": 0.07, "head_pa": 1400.0},
    partial(film_dry_s, P.drying): {"air_c": 80.0, "film_m": 5e-5, "liquid_kg_m3": 1e3},
    partial(gap_dry_s, P.drying): {"board_c": 80.0, "depth_m": 3e-3, "liquid_kg_m3": 1e3},
    wet_surface_c: {"air_c": 60.0, "vapour_pa": 1200.0},
    partial(fill_share, P.soil): {"coverage": 0.4},
    round_posts: {"solid": 0.3},
    square_posts: {"solid": 0.3},
    tall_posts: {"solid": 0.3},
    post_factor: {"diameter": 0.5, "pitch": 1.0, "height": 0.3},
    partial(solve_gap, joints=(), cells=4): {"length_m": 7e-3, "width_m": 5e-3, "height_m": 5e-5},
}
MAY_BE_NEGATIVE = {"temperature_c", "air_c", "board_c", "head_pa"}
BOUNDED = {"coverage": 1.1, "temperature_c": -274.0, "air_c": -274.0, "board_c": -274.0}
NAMES = [(function, name) for function, numbers in GOOD.items() for name in numbers]
WRONG = [
    *((function, name, math.nan) for function, name in NAMES),
    *((function, name, -1.0) for function, name in NAMES if name not in MAY_BE_NEGATIVE),
    *((function, name, BOUNDED[name]) for function, name in NAMES if name in BOUNDED),
]


@pytest.mark.parametrize("function", GOOD)
def test_what_can_be_is_taken(function):
    function(**GOOD[function])


@pytest.mark.parametrize(("function", "name", "wrong"), WRONG)
def test_what_cannot_be_is_refused_by_its_name(function, name, wrong):
    with pytest.raises(CleaningError, match=name.removesuffix("_m")):
        function(**(GOOD[function] | {name: wrong}))


@pytest.mark.parametrize("demand", [require_positive, require_not_negative, require_temperature])
@pytest.mark.parametrize("wrong", [math.nan, math.inf, -math.inf, -300.0])
@pytest.mark.parametrize("shape", [(), (1,), (2, 3)])
def test_numbers_are_asked_one_by_one_in_arrays_of_any_shape(demand, wrong, shape):
    values = np.full(shape, 2.0)
    demand(some=values, other=1)
    values[(-1,) * len(shape)] = wrong
    with pytest.raises(CleaningError, match=f"some must be .* not {wrong:g}"):
        demand(other=1.0, some=values)


def test_nothing_is_positive_but_not_negative():
    require_not_negative(some=0, others=np.zeros(3), none=np.empty(0))
    require_positive(none=np.empty(0))
    with pytest.raises(CleaningError, match="some must be a positive number, not 0"):
        require_positive(some=0)


@pytest.mark.parametrize(
    "joint",
    [Joint(math.nan, 0, 1, 1), Joint(0, 0, -1, 1), Joint(0, 0, 1, math.inf), Joint(0, 0, 1, 1, False, math.nan)],
)
def test_a_joint_that_is_no_outline_is_refused(joint):
    with pytest.raises(CleaningError, match=r"joint needs a place|length_mm|width_mm"):
        solve_gap(7e-3, 5e-3, 5e-5, [joint], 4)
