"""The jet: all of the flow leaves it, and it presses as its momentum says."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jet_references import footprint, gas_speed_at, intensity, stress_at
from small_sprays import CONE, FAN, KNIFE, LOPSIDED, NOZZLES, RING, downward, one_jet

from cleaning.jet.jet import flow_m3_s, gas_speed_m_s, liquid_speed_m_s
from recipes.nozzles import FlatFan, FullCone, HollowCone, Wavefront

LITRE_PER_MINUTE = 1e-3 / 60
LOPSIDED_JET = one_jet(LOPSIDED)


def sphere(count=600):
    """Directions in front of the orifice and the solid angle of each: midpoints in the tangent plane's angles."""
    polar = (np.arange(count) + 0.5) * (np.pi / 2 / count)
    around = np.arange(360) * (2 * np.pi / 360)
    theta, phi = (grid.ravel() for grid in np.meshgrid(polar, around, indexing="ij"))
    rays = np.column_stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    return rays, np.sin(theta) * (np.pi / 2 / count) * (2 * np.pi / 360)


def plane(half_mm, step_mm):
    """Places of a plate at z = 0."""
    line = np.arange(-half_mm + step_mm / 2, half_mm, step_mm)
    x, y = (grid.ravel() for grid in np.meshgrid(line, line))
    return np.column_stack([x, y, np.zeros_like(x)])


def flux_on_plate(jet, tilt_deg, points, height_mm=50.0):
    """Volume flux into a plate, m/s, from a nozzle that leans along x; and the cosine of each ray with the axis."""
    ways = points - [0.0, 0.0, height_mm]
    lengths = np.linalg.norm(ways, axis=1)
    rays = ways / lengths[:, None]
    tool = rays @ downward(tilt_deg)
    return intensity(jet, tool) * -rays[:, 2] / (lengths * 1e-3) ** 2, tool[:, 2]


@pytest.mark.parametrize("name", NOZZLES)
def test_all_of_the_flow_leaves(name):
    rays, areas = sphere()
    jet = one_jet(NOZZLES[name], use="dry" if name == "knife" else "wash")
    whole = (intensity(jet, rays) * areas).sum() / jet.flow_m3_s
    assert whole == pytest.approx(1.0, abs=5e-3 if name == "knife" else 1e-3)


@pytest.mark.slow
@given(half=st.floats(5, 70), sigma=st.floats(1.0, 8.0), shift=st.floats(0.0, 350.0), bulge=st.floats(0.7, 1.4))
@settings(max_examples=5)
def test_all_of_the_flow_leaves_any_ring(half, sigma, shift, bulge):
    radius = 50 * np.tan(np.radians(half))
    points = [(azimuth, radius * size * 0.9, radius * size * 1.1) for azimuth, size in ((0, 1), (120, bulge), (250, 1))]
    rays, areas = sphere(800)
    measured = Wavefront(height_mm=50, points=points)
    for nozzle in (
        HollowCone(half_angle_deg=half, ring_sigma_deg=sigma, flow_lpm=1 + shift / 100),
        HollowCone(half_angle_deg=half, flow_lpm=2.0, wavefront=measured),
        FullCone(half_angle_deg=half, flow_lpm=2.0),
        FlatFan(half_angle_deg=half, thickness_half_angle_deg=half / 2, flow_lpm=2.0),
    ):
        jet = one_jet(nozzle)
        assert (intensity(jet, rays) * areas).sum() == pytest.approx(jet.flow_m3_s, rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("tilt", "share"), [(0, 1.0), (15, 1.0), (30, 1.0)])
def test_all_of_the_flow_lands_on_a_plate(tilt, share):
    jet = one_jet(RING)
    flux, _ = flux_on_plate(jet, tilt, plane(600.0, 2.0))
    assert flux.sum() * 4e-6 / jet.flow_m3_s == pytest.approx(share, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("tilt", "force"), [(0, 0.6824), (15, 0.6591), (30, 0.5910)])
def test_the_plate_bears_the_momentum_of_the_spray(tilt, force):
    jet = one_jet(RING)
    points = plane(600.0, 2.0)
    up = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    stress = stress_at(jet, np.array([[0.0, 0.0, 50.0]]), downward(tilt)[None], points, up)
    assert stress.sum() * 4e-6 == pytest.approx(force, rel=1e-3)
    flux, along = flux_on_plate(jet, tilt, points)
    mean = (flux * along).sum() / flux.sum()
    momentum = jet.density_kg_m3 * jet.flow_m3_s * jet.speed_m_s * np.cos(np.radians(tilt)) * mean
    assert stress.sum() * 4e-6 == pytest.approx(momentum, rel=2e-3)


@pytest.mark.parametrize(
    ("height", "peak", "radius"),
    [(25, 1319, 14.1), (50, 330, 28.1), (75, 147, 42.2), (100, 82, 56.2), (150, 37, 84.4), (200, 21, 112.6)],
)
def test_the_peak_falls_with_the_square_of_the_height(height, peak, radius):
    jet = one_jet(RING)
    x = np.linspace(0, 2 * height, 20001)
    points = np.column_stack([x, 0 * x, 0 * x])
    up = np.tile([0.0, 0.0, 1.0], (len(x), 1))
    stress = stress_at(jet, np.array([[0.0, 0.0, height]]), downward()[None], points, up)[0]
    assert stress.max() == pytest.approx(peak, abs=0.5)
    assert x[stress.argmax()] == pytest.approx(radius, rel=3e-3)
    half, sigma = np.radians([30, 4])
    roughly = jet.density_kg_m3 * jet.speed_m_s * jet.flow_m3_s * np.cos(half) ** 4
    roughly /= (2 * np.pi) ** 1.5 * sigma * np.sin(half) * (height * 1e-3) ** 2
    assert stress.max() == pytest.approx(roughly, rel=0.05)


def test_pressure_changes_flow_and_speed():
    low, high = one_jet(RING, pressure_bar=1.5), one_jet(RING, pressure_bar=6.0)
    assert high.flow_m3_s == pytest.approx(2 * low.flow_m3_s)
    assert high.speed_m_s == pytest.approx(2 * low.speed_m_s)
    cone = one_jet(CONE, pressure_bar=7.0).flow_m3_s / (2.0 * LITRE_PER_MINUTE)
    assert cone == pytest.approx(2.0**0.46)


def test_a_measured_ring_is_sprayed_as_it_was_measured():
    jet = one_jet(LOPSIDED)
    for azimuth, inner, outer in LOPSIDED.wavefront.points:
        index = round(azimuth)
        edges = np.arctan2([inner, outer], 50.0)
        assert jet.half_angles[index] == pytest.approx(edges.mean())
        assert jet.sigmas[index] == pytest.approx(np.diff(edges)[0] / 4)
        angles = np.linspace(0.1, 1.0, 901)
        turn = np.radians(azimuth)
        rays = np.column_stack([np.sin(angles) * np.cos(turn), np.sin(angles) * np.sin(turn), np.cos(angles)])
        assert angles[intensity(jet, rays).argmax()] == pytest.approx(edges.mean(), abs=2e-3)


def test_a_fan_is_wide_along_its_reference():
    jet = one_jet(FAN)
    angles = np.radians([0, 20, 38])
    zero = 0 * angles
    along = intensity(jet, np.column_stack([np.sin(angles), zero, np.cos(angles)]))
    across = intensity(jet, np.column_stack([zero, np.sin(angles), np.cos(angles)]))
    assert along[2] > 0.5 * along[0]
    assert np.all(across[1:] == 0)
    assert np.all(intensity(jet, np.array([[0.0, 0.0, -1.0]])) == 0)


def test_walls_that_face_away_bear_nothing():
    jet = one_jet(CONE)
    tcp, axes = np.array([[0.0, 0.0, 50.0]]), downward()[None]
    points = np.array([[5.0, 0.0, 0.0], [5.0, 0.0, 60.0]])
    down = np.tile([0.0, 0.0, -1.0], (2, 1))
    assert np.all(stress_at(jet, tcp, axes, points, down) == 0)
    assert stress_at(jet, tcp, axes, points, -down)[0, 0] > 0


@given(turn=st.floats(-180, 180), tilt=st.floats(0, 40), shift=st.floats(-200, 200))
@settings(max_examples=20)
def test_stress_moves_with_nozzle_and_wall(turn, tilt, shift):
    jet = LOPSIDED_JET
    points, tcp, axes = plane(60.0, 7.0), np.array([[3.0, -2.0, 50.0]]), downward(tilt, 20.0)[None]
    up = np.tile([0.1, 0.0, np.sqrt(0.99)], (len(points), 1))
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    moved = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    here = stress_at(jet, tcp, axes, points, up)
    there = stress_at(jet, tcp @ moved.T + shift, moved @ axes, points @ moved.T + shift, up @ moved.T)
    np.testing.assert_allclose(there, here, rtol=1e-6, atol=1e-6 * here.max())


def test_a_curtain_of_air_slows_down_as_a_plane_jet_does():
    jet = one_jet(KNIFE, use="dry", pressure_bar=4.0)
    assert jet.gas
    slot_mm = jet.flow_m3_s / (jet.speed_m_s * 0.08) * 1e3
    speeds = gas_speed_at(jet, np.array([slot_mm, 25.0, 50.0, 100.0]))
    assert speeds[0] == jet.speed_m_s
    np.testing.assert_allclose(speeds[1:], jet.speed_m_s * 2.4 * np.sqrt(slot_mm / np.array([25.0, 50.0, 100.0])))
    tcp, points = np.array([[0.0, 0.0, 50.0]]), np.zeros((1, 3))
    stress = stress_at(jet, tcp, downward()[None], points, np.array([[0.0, 0.0, 1.0]]))
    assert stress[0, 0] == pytest.approx(jet.density_kg_m3 * speeds[2] ** 2 / 2)


def test_a_curtain_of_air_is_as_long_as_its_slot():
    jet = one_jet(KNIFE, use="dry", pressure_bar=4.0)
    points = np.array([[0.0, 0.0, 0.0], [38.0, 0.0, 0.0], [50.0, 0.0, 0.0], [0.0, 20.0, 0.0]])
    up = np.tile([0.0, 0.0, 1.0], (4, 1))
    stress = stress_at(jet, np.array([[0.0, 0.0, 50.0]]), downward()[None], points, up)[0]
    assert stress[1] > 0.9 * stress[0]
    assert stress[2] == 0
    assert stress[3] < 0.01 * stress[0]


def test_the_ring_lies_on_the_ellipse_of_its_cone():
    jet = one_jet(HollowCone(half_angle_deg=30, ring_sigma_deg=1.0, flow_lpm=2.0))
    x = np.linspace(0, 120, 24001)
    points = np.column_stack([x, 0 * x, 0 * x])
    flux, _ = flux_on_plate(jet, 20, points)
    far = footprint(np.radians(30), np.radians(20), 50.0).far
    assert x[flux.argmax()] == pytest.approx(far, rel=0.02)


@pytest.mark.parametrize(("nozzle", "use", "share"), [(RING, "wash", 1.0), (CONE, "dry", 0.5), (KNIFE, "dry", 0.5)])
def test_no_wall_bears_more_than_the_jet_itself(nozzle, use, share):
    jet = one_jet(nozzle, use=use)
    most = share * jet.density_kg_m3 * jet.speed_m_s**2
    height = np.array([1e-4, 1e-2, 1.0, 10.0])
    points = np.column_stack([height * np.tan(jet.half_angle if nozzle is RING else 0.0), 0 * height, -height])
    up = np.tile([0.0, 0.0, 1.0], (len(height), 1))
    stress = stress_at(jet, np.zeros((1, 3)), downward()[None], points, up)[0]
    assert np.all(np.diff(stress) <= 0)
    assert 0.5 * most < stress[0] <= most * (1 + 1e-9)


def test_speed_behind_an_orifice():
    assert liquid_speed_m_s(3.5e5, 1000.0, 0.9) == pytest.approx(23.81, abs=0.005)


def test_flow_follows_a_power_of_the_pressure():
    assert flow_m3_s(2.0, 3e5, 12e5, 0.5) == pytest.approx(4.0)
    assert flow_m3_s(2.0, 3e5, 3e5, 0.46) == 2.0


def test_gas_is_never_faster_than_sound_in_its_throat():
    sound = math.sqrt(2 * 1.4 / 2.4 * 101_325.0 / 1.2)
    assert gas_speed_m_s(4e5, 1.2, 1.0) == pytest.approx(sound)
    assert gas_speed_m_s(8e5, 1.2, 1.0) == gas_speed_m_s(4e5, 1.2, 1.0)


def test_slow_gas_flows_as_a_liquid_would():
    assert gas_speed_m_s(500.0, 1.2, 0.9) == pytest.approx(liquid_speed_m_s(500.0, 1.2, 0.9), rel=2e-3)
