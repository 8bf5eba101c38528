"""The ellipse of a tilted cone."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jet_references import footprint

TABLE = [
    (30, 0, 50, 28.8675, 28.8675, 0.0, -28.868, 28.868),
    (30, 15, 50, 31.6987, 30.2500, 18.3013, -13.397, 50.000),
    (30, 30, 50, 43.3013, 35.3553, 43.3013, 0.0, 86.603),
    (40, 20, 80, 83.8408, 75.0204, 54.7232, -29.118, 138.564),
    (35, 45, 60, 164.8486, 83.2208, 175.4283, 10.580, 340.277),
]
"""Half angle, tilt, height; semi-axes, centre, edges, to the digits that are known."""


@pytest.mark.parametrize("row", TABLE)
def test_known_footprints(row):
    half, tilt, height, *known = row
    found = footprint(math.radians(half), math.radians(tilt), height)
    assert (found.semi_major, found.semi_minor, found.centre) == pytest.approx(known[:3], rel=1e-6, abs=5e-5)
    assert (found.near, found.far) == pytest.approx(known[3:], rel=1e-6, abs=5e-4)
    assert found.closed


@pytest.mark.parametrize("row", TABLE)
def test_edges_lie_half_an_axis_from_the_centre(row):
    half, tilt, height = row[:3]
    found = footprint(math.radians(half), math.radians(tilt), height)
    assert found.far - found.centre == pytest.approx(found.semi_major, rel=1e-6)
    assert found.centre - found.near == pytest.approx(found.semi_major, rel=1e-6)
    flattened = found.semi_major * math.sqrt(1 - found.eccentricity**2)
    assert found.semi_minor == pytest.approx(flattened, rel=1e-6)


@given(half=st.floats(0.05, 1.3), share=st.floats(0.0, 0.99), height=st.floats(1.0, 500.0))
@settings(max_examples=60)
def test_the_ellipse_lies_on_the_cone(half, share, height):
    tilt = share * (math.pi / 2 - half - 0.02)
    found = footprint(half, max(tilt, 0.0), height)
    around = np.linspace(0, 2 * np.pi, 33)
    x = found.centre + found.semi_major * np.cos(around)
    rays = np.column_stack([x, found.semi_minor * np.sin(around), np.full(33, -height)])
    axis = np.array([math.sin(max(tilt, 0.0)), 0.0, -math.cos(max(tilt, 0.0))])
    cosines = rays @ axis / np.linalg.norm(rays, axis=1)
    np.testing.assert_allclose(cosines, math.cos(half), rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize(("half", "tilt"), [(30, 60), (30, 75), (60, 45)])
def test_a_cone_that_leans_too_far_does_not_close(half, tilt):
    found = footprint(math.radians(half), math.radians(tilt), 50.0)
    assert not found.closed
    assert found.near == pytest.approx(50.0 * math.tan(math.radians(tilt - half)))
    assert found.semi_major == math.inf
    assert found.eccentricity >= 1 - 1e-9
