"""The bench on which coupons are made up, and what the model says of them."""

from pathlib import Path

import numpy as np
from made_up import PLAN, coupon_table, written

from cleaning.calibration.coupon import CouponSetup, read_coupons
from cleaning.parameters.load import load_parameters
from recipes.load import load_recipe

PARAMETERS = load_parameters()
BENCH = CouponSetup(load_recipe("smt-aqueous").nozzles["ring60"], PARAMETERS.liquids["saponifier-15"], PARAMETERS)
TRUTH = {"k1_per_s": 0.008, "activation_kj_mol": 42.0, "k_m_per_s": 0.03}


def coupons(folder: Path, *, noise: float, seed: int, first: str = "# synthetic", **truth: float) -> Path:
    """Write the plan of coupons as they come out for a soil of which some values are given."""
    anything = np.linspace(0.0, 1.0, len(PLAN)).tolist()
    plan = read_coupons(written(folder, coupon_table(anything, noise=0.0, seed=0), "plan.csv"), BENCH)
    soil = PARAMETERS.soil.model_copy(update=truth)
    cleaned = plan.predict(soil, plan.shear_pa(plan.drop_pa(PARAMETERS.film.puddle_mm)))
    return written(folder, coupon_table(cleaned.tolist(), noise=noise, seed=seed, first=first), "coupons.csv")
