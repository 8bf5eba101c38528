"""Footprints against the closed form of a tilted cone on a plane."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recipes.footprint import core_footprint, footprint, mean_angle, spray_rays
from recipes.nozzles import AirKnife, FlatFan, FullCone, HollowCone, Radial, Wavefront

DOWN = np.array([0.0, 0.0, -1.0])
X = np.array([1.0, 0.0, 0.0])


def leaning(tilt_deg):
    tilt = np.radians(tilt_deg)
    return np.array([np.sin(tilt), 0, -np.cos(tilt)]), np.array([np.cos(tilt), 0, np.sin(tilt)])


@given(half=st.floats(5, 40), tilt=st.floats(0, 44), height=st.floats(1, 300))
@settings(max_examples=50)
def test_cone_meets_the_board_from_near_to_far_edge(half, tilt, height):
    nozzle = FullCone(half_angle_deg=half, flow_lpm=1)
    outline = core_footprint(nozzle, height, *leaning(tilt))
    near, far = height * np.tan(np.radians([tilt - half, tilt + half]))
    assert outline[:, 0].min() == pytest.approx(near, abs=1e-9 * height)
    assert outline[:, 0].max() == pytest.approx(far, rel=1e-9)


def test_tilted_ellipse_has_the_semi_minor_axis_of_the_closed_form():
    outline = core_footprint(HollowCone(half_angle_deg=30, flow_lpm=1), 50, *leaning(15))
    assert outline[:, 1].max() == pytest.approx(30.25, abs=0.02)


def test_ring_edge_lies_outside_its_middle():
    nozzle = HollowCone(half_angle_deg=30, ring_sigma_deg=3, flow_lpm=1)
    assert np.linalg.norm(footprint(nozzle, 50, DOWN, X), axis=1).max() == pytest.approx(50 * np.tan(np.radians(36)))
    assert np.linalg.norm(core_footprint(nozzle, 50, DOWN, X), axis=1).max() == pytest.approx(
        50 * np.tan(np.radians(30))
    )


def test_measured_wave_front_replaces_the_circle_and_scales_with_height():
    measured = Wavefront(height_mm=50, points=[(0, 20, 30), (90, 24, 36), (180, 20, 30), (270, 24, 36)])
    nozzle = HollowCone(half_angle_deg=10, flow_lpm=1, wavefront=measured)
    outline = footprint(nozzle, 100, DOWN, X)
    quarter = len(outline) // 4
    assert outline[0] == pytest.approx([60, 0])
    assert np.linalg.norm(outline[quarter]) == pytest.approx(72)
    assert 20 / 50 < np.tan(mean_angle(nozzle)) < 36 / 50


def test_fan_is_wide_along_its_reference_and_thin_across():
    nozzle = FlatFan(half_angle_deg=40, thickness_half_angle_deg=3, flow_lpm=1)
    span = np.ptp(footprint(nozzle, 50, DOWN, X), axis=0)
    assert span == pytest.approx([100 * np.tan(np.radians(40)), 100 * np.tan(np.radians(3))])


def test_knife_is_as_long_as_its_slot_at_the_slot():
    nozzle = AirKnife(width_mm=80, half_angle_deg=5, flow_lpm=1)
    assert np.ptp(footprint(nozzle, 1e-6, DOWN, X)[:, 0]) == pytest.approx(80, abs=1e-3)


def test_jet_that_never_meets_the_board_is_cut_off_and_stays_finite():
    assert np.isfinite(footprint(FullCone(half_angle_deg=30, flow_lpm=1), 50, *leaning(80))).all()


@pytest.mark.parametrize(("profile", "half_mm"), [([(0, 1), (39.999, 1), (40, 0)], 28.28), ([(0, 1), (40, 0)], 20.0)])
def test_rays_of_a_radial_jet_are_as_dense_on_the_plate_as_its_profile(profile, half_mm):
    """Half of them within a radius that has half of the flux: 40/sqrt(2) of an even one, the middle of a cone."""
    nozzle = Radial(pattern="radial", radius_mm=40, at_mm=100, flow_lpm=1, profile=profile)
    radii = 100.0 * np.hypot(*spray_rays(nozzle, 4000).slopes.T)
    assert np.median(radii) == pytest.approx(half_mm, rel=0.02)
    assert radii.max() == pytest.approx(40.0, rel=0.05)
    assert radii.min() < 2.0
