"""The nearest triangle to a segment, against sampling."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robotcell.collision.segments import build_tree, nearest_triangles


def scattered(seed: int, count: int):
    """Triangles of all sizes and shapes, slivers among them, and segments, some of them points."""
    rng = np.random.default_rng(seed)
    triangles = rng.uniform(-1, 1, (count, 1, 3)) + rng.uniform(-1, 1, (count, 3, 3)) * rng.choice(
        [0.01, 0.3], (count, 1, 1)
    )
    triangles[::7, 2] = triangles[::7, 1]
    begin = rng.uniform(-1.5, 1.5, (40, 3))
    end = begin + rng.uniform(-1, 1, (40, 3)) * rng.choice([0.0, 0.1, 1.0], (40, 1))
    return triangles, begin, end


@pytest.mark.slow
@settings(max_examples=40)
@given(seed=st.integers(0, 10_000), count=st.sampled_from([1, 2, 5, 33, 200]))
def test_the_points_are_on_both_and_no_sampled_pair_is_nearer(seed, count):
    triangles, begin, end = scattered(seed, count)
    found = nearest_triangles(build_tree(triangles), begin, end, 10.0)
    assert (found.triangle >= 0).all()
    np.testing.assert_allclose(
        np.linalg.norm(found.points[:, 0] - found.points[:, 1], axis=1), found.distances, atol=1e-12
    )
    for row in range(len(begin)):
        line = np.stack((begin[row], end[row]))
        weights = np.linalg.lstsq(np.vstack((line.T, [1, 1])), np.append(found.points[row, 0], 1.0), rcond=None)[0]
        np.testing.assert_allclose(weights @ line, found.points[row, 0], atol=1e-9)
        corners = triangles[found.triangle[row]]
        weights = np.linalg.lstsq(np.vstack((corners.T, np.ones(3))), np.append(found.points[row, 1], 1.0), rcond=None)[
            0
        ]
        np.testing.assert_allclose(weights @ corners, found.points[row, 1], atol=1e-9)
    steps = np.linspace(0, 1, 9)
    u, v = (grid.ravel() for grid in np.meshgrid(steps, steps))
    u, v = u[u + v <= 1], v[u + v <= 1]
    places = np.einsum("k,nj->nkj", 1 - u - v, triangles[:, 0]) + np.einsum("k,nj->nkj", u, triangles[:, 1])
    places = (places + np.einsum("k,nj->nkj", v, triangles[:, 2])).reshape(-1, 3)
    for share in steps:
        on = begin + share * (end - begin)
        nearest = np.sqrt(((on[:, None] - places[None]) ** 2).sum(axis=2)).min(axis=1)
        assert (found.distances <= nearest + 1e-12).all()


def test_nothing_beyond_the_most_is_found():
    triangles, begin, end = scattered(5, 60)
    tree = build_tree(triangles)
    every = nearest_triangles(tree, begin, end, 10.0)
    most = float(np.median(every.distances))
    some = nearest_triangles(tree, begin, end, most)
    near = every.distances <= most
    np.testing.assert_array_equal(some.triangle, np.where(near, every.triangle, -1))
    assert np.isinf(some.distances[~near]).all()


def test_a_segment_through_a_triangle_touches_it():
    triangle = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]], dtype=float)
    found = nearest_triangles(build_tree(triangle), np.array([[0.2, 0.3, -1.0]]), np.array([[0.2, 0.3, 2.0]]), 1.0)
    assert found.distances[0] == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(found.points[0], [[0.2, 0.3, 0], [0.2, 0.3, 0]], atol=1e-15)
