"""How far drops fly, and where a jet ends, against figures and integrals of somebody else."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from small_parts import surface_recipe

from cleaning.errors import CleaningError
from cleaning.jet.drops import drop_um_at, speed_after_m_s, spray_cone, spray_range_mm, stopping_length_mm
from recipes.nozzles import AirKnife, FullCone


def jet(**keys: float) -> FullCone:
    return FullCone.model_validate({"pattern": "full_cone", "half_angle_deg": 15, "flow_lpm": 1, **keys})


def slowed(speed: float, drop_um: float, way_m: float) -> float:
    """Fall of the speed over a way by an integration of its own, Schiller and Naumann's drag in air at 22 degrees."""

    def fall(_: float, v: np.ndarray) -> np.ndarray:
        reynolds = 1.19 * v * drop_um * 1e-6 / 1.82e-5
        relaxation = 1000 * (drop_um * 1e-6) ** 2 / (18 * 1.82e-5)
        return -(1 + 0.15 * reynolds**0.687) / relaxation

    return float(solve_ivp(fall, (0, way_m), [speed], rtol=1e-9).y[0, -1])


@pytest.mark.parametrize(("drop_um", "left"), [(300, 21.8), (80, 12.6)])
def test_drops_of_a_jet_at_three_and_a_half_bar_slow_down_as_computed_elsewhere(drop_um: float, left: float) -> None:
    found = float(speed_after_m_s(23.8, drop_um, np.array([50.0]))[0])
    assert found == pytest.approx(left, abs=0.05)
    assert found == pytest.approx(slowed(23.8, drop_um, 0.05), rel=2e-3)


def test_a_drop_stops_and_flies_no_farther() -> None:
    stop = stopping_length_mm(23.8, 80)
    assert speed_after_m_s(23.8, 80, np.array([0.0, 0.999 * stop, 1.001 * stop])) == pytest.approx(
        [23.8, 0, 0], abs=0.1
    )
    assert stopping_length_mm(23.8, 300) > 3 * stop
    with pytest.raises(CleaningError):
        stopping_length_mm(23.8, 0.0)


def test_the_range_is_where_the_impact_is_a_quarter() -> None:
    """Twice the standoff without drag, less with finer drops, and the pressure makes them finer and faster."""
    assert spray_range_mm(jet(drop_um=20_000), 3, 60) == pytest.approx(120, abs=1)
    for drop in (300.0, 80.0):
        reach = spray_range_mm(jet(drop_um=drop), 3, 60)
        speeds = speed_after_m_s(0.9 * np.sqrt(2 * 3e5 / 1000), drop, np.array([60.0, reach]))
        assert speeds[1] * 60**2 == pytest.approx(0.25 * speeds[0] * reach**2, rel=1e-6)
    assert spray_range_mm(jet(drop_um=80), 3, 60) < spray_range_mm(jet(), 3, 60) < 120
    assert drop_um_at(jet(drop_um=240), 24) == pytest.approx(120)


def test_a_stated_range_counts_and_a_curtain_of_air_reaches_farther() -> None:
    knife = AirKnife(width_mm=50, flow_lpm=100)
    assert spray_range_mm(jet(range_mm=90), 3, 60) == 90
    assert spray_range_mm(knife, 3, 20) == 80


def test_plan_and_analysis_have_one_cone() -> None:
    recipe = surface_recipe()
    spec, nozzle, function = recipe.templates["all"], recipe.nozzles["jet"], recipe.functions["clean"]
    sharp, soft = (spray_cone(nozzle, function, spec, edge) for edge in (0.0, 0.5))  # type: ignore[arg-type]
    assert sharp.range_mm == spray_range_mm(nozzle, 3, 60) == soft.range_mm - soft.edge_mm / 2
    assert sharp.half_angle_rad == pytest.approx(np.radians(15))
