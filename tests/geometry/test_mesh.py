"""Measures of triangles."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from geometry.mesh import areas_and_normals


def test_half_a_square_has_half_its_area() -> None:
    areas, normals = areas_and_normals(
        np.array([[[0, 0, 5], [4, 0, 5], [4, 4, 5]], [[0, 0, 0], [0, 2, 0], [0, 0, 2]]], float)
    )
    np.testing.assert_allclose(areas, [8.0, 2.0])
    np.testing.assert_allclose(normals, [[0, 0, 1], [1, 0, 0]])


def test_a_triangle_without_an_area_has_no_normal() -> None:
    areas, normals = areas_and_normals(np.array([[[0, 0, 0], [1, 1, 1], [2, 2, 2]]], float))
    assert areas[0] == 0.0
    np.testing.assert_array_equal(normals, [[0, 0, 0]])


def test_no_triangles_have_no_areas() -> None:
    areas, normals = areas_and_normals(np.empty((0, 3, 3)))
    assert (areas.shape, normals.shape) == ((0,), (0, 3))


@pytest.mark.slow
@settings(max_examples=20)
@given(hnp.arrays(np.float64, (9000, 3, 3), elements=st.floats(-10, 10), fill=st.just(1.0)))
def test_turning_a_triangle_over_turns_its_normal(patches: np.ndarray) -> None:
    areas, normals = areas_and_normals(patches)
    turned_areas, turned = areas_and_normals(patches[:, ::-1])
    np.testing.assert_allclose(turned_areas, areas, atol=1e-9)
    real = areas > 1e-3
    np.testing.assert_allclose(turned[real], -normals[real], atol=1e-6)
    assert np.linalg.norm(normals[real], axis=1) == pytest.approx(1.0)


@pytest.mark.parametrize("count", [1, 8193])
def test_the_triangles_that_are_asked_about_stay_as_they_were(count):
    patches = np.random.default_rng(3).random((count, 3, 3))
    before = patches.copy()
    areas_and_normals(patches)
    np.testing.assert_array_equal(patches, before)
