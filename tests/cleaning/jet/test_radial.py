"""A radial pattern keeps its flow, and lands by the solid angle; the printed gun of Jiangsu 2010 is one."""

import numpy as np
import pytest
from small_sprays import GUN, downward, one_jet

from cleaning.exposure.segment_rates import film_of_pass
from cleaning.jet.compiled_jet import flux_of, profile
from geometry.coverage.spacing import overlap
from recipes.nozzles import Radial

JET = one_jet(GUN)
DONUT = Radial(radius_mm=50, at_mm=80, profile=[(0, 2), (20, 5), (35, 4), (50, 0)], flow_lpm=0.5)


def film_rate(jet, axes, orifice, points, normals):
    """(n,) um/s."""
    local, facing = (points - orifice) @ axes, normals @ axes
    rates = [flux_of(jet.form, tuple(p), tuple(n)) for p, n in zip(local, facing, strict=True)]
    return np.array(rates) * 1e6


def test_a_plate_at_right_angles_gets_the_printed_parabola() -> None:
    radius = np.array([0.0, 7.0, 20.0, 33.3, 39.9, 40.1, 55.0])
    points = np.column_stack([radius * 0.6, radius * 0.8, 0 * radius])
    up = np.tile([0.0, 0.0, 1.0], (len(radius), 1))
    found = film_rate(JET, downward(), [0.0, 0.0, 100.0], points, up)
    assert found == pytest.approx(np.maximum(40.0**2 - radius**2, 0) / 8, rel=1e-5, abs=1e-3)


def test_any_wall_gets_what_the_corrected_equation_4_says() -> None:
    """Jiangsu 2010, eq. (4) with the exponent corrected: q1 = q (h / l)² cos(alpha) / cos³(theta)."""
    rng = np.random.default_rng(4)
    slope, around = rng.uniform(0.0, 0.39, 60), rng.uniform(0.0, 2 * np.pi, 60)
    rays = np.column_stack([slope * np.cos(around), slope * np.sin(around), np.ones(60)])
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    length = rng.uniform(30.0, 400.0, 60)
    normals = rng.normal(size=(60, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    found = film_rate(JET, np.eye(3), np.zeros(3), rays * length[:, None], normals)
    alpha, theta = -np.sum(rays * normals, axis=1), rays[:, 2]
    law = (40.0**2 - (100.0 * slope) ** 2) / 8 * (100.0 / length) ** 2 * np.maximum(alpha, 0.0) / theta**3
    assert np.any(alpha <= 0)
    assert found == pytest.approx(law, rel=1e-5, abs=1e-6)


def test_rays_within_the_printed_radius_are_in_the_cone_and_those_beyond_get_nothing() -> None:
    within, beyond = (profile(JET.form, 0.6 * slope, 0.8 * slope, 1.0) for slope in (0.39, 0.41))
    assert within[0] > 0.0
    assert within[1]
    assert beyond == (0.0, False)
    assert profile(JET.form, 0.1, 0.0, -1.0) == (0.0, False)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("nozzle", "tilt"), [(GUN, 0), (GUN, 30), (GUN, 45), (GUN, 60), (DONUT, 0), (DONUT, 30), (DONUT, 50)]
)
def test_all_of_the_flow_lands_on_a_tilted_plate(nozzle, tilt) -> None:
    jet, height = one_jet(nozzle), 100.0
    edges = height * np.tan(np.radians([tilt - nozzle.half_angle_deg, tilt + nozzle.half_angle_deg]))
    x = np.linspace(*edges, 321)
    y = np.linspace(-1.0, 1.0, 321) * nozzle.radius_mm / nozzle.at_mm * np.hypot(height, np.abs(edges).max())
    x, y = 0.5 * (x[1:] + x[:-1]), 0.5 * (y[1:] + y[:-1])
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    points = np.column_stack([grid, np.zeros(len(grid))])
    rates = film_rate(jet, downward(tilt), [0.0, 0.0, height], points, np.tile([0.0, 0.0, 1.0], (len(grid), 1)))
    landed = rates.sum() * (x[1] - x[0]) * (y[1] - y[0]) * 1e-3  # mm³/s
    assert landed == pytest.approx(jet.flow_m3_s * 1e9, rel=5e-3)


def test_one_pass_leaves_the_three_halves_power() -> None:
    across, film = film_of_pass(JET.form, 100.0)
    assert film == pytest.approx(np.clip(1600 - across**2, 0, None) ** 1.5 / 6, abs=0.05)  # of 10,667
    assert np.trapezoid(film, across) == pytest.approx(JET.flow_m3_s * 1e12, rel=1e-4)


@pytest.mark.parametrize(
    ("spacing", "speed", "low", "high"),
    [(48.665, 256.604, 38.431, 41.569), (51.2, 231.3, 40.187, 46.116)],
    ids=["best of two passes", "the paper's pair"],
)
def test_the_printed_gun_on_the_flat_plate(spacing, speed, low, high) -> None:
    found = overlap(*film_of_pass(JET.form, 100.0), spacing)
    assert (found.low / speed, found.high / speed) == pytest.approx((low, high), abs=0.005)
    assert found.mean / speed == pytest.approx(502_654.8 / (speed * spacing), abs=0.005)
