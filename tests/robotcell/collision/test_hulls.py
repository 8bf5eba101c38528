"""Proofs that a hull is far from triangles, against sampling."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull
from scipy.spatial.distance import cdist
from scipy.spatial.transform import Rotation

from robotcell.collision.segments import build_hull, build_tree, is_apart


def hull_of(points):
    found = ConvexHull(points)
    return build_hull(points[found.vertices], found.equations)


def cube():
    return hull_of(np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), axis=-1).reshape(-1, 3))


@settings(max_examples=40)
@given(seed=st.integers(0, 10_000), count=st.sampled_from([1, 2, 5, 33]))
def test_nothing_that_is_proven_far_is_near(seed, count):
    rng = np.random.default_rng(seed)
    triangles = rng.uniform(-1, 1, (count, 1, 3)) + rng.uniform(-0.3, 0.3, (count, 3, 3))
    triangles[::7, 2] = triangles[::7, 1]
    tree, corners = build_tree(triangles), rng.uniform(-0.4, 0.4, (12, 3))
    turn, margin = Rotation.random(random_state=seed).as_matrix(), float(rng.uniform(0, 0.3))
    some = np.concatenate([np.eye(3), rng.dirichlet(np.ones(3), 10)]) @ triangles[:, None].reshape(-1, 3, 3)
    inside = np.concatenate([np.eye(12), rng.dirichlet(0.3 * np.ones(12), 40)]) @ corners @ turn.T
    for way in rng.uniform(-1.8, 1.8, (6, 3)):
        if is_apart(tree, hull_of(corners), turn, way, margin):
            assert cdist(some.reshape(-1, 3), inside + way).min() > margin


@pytest.mark.parametrize("place", [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (0.6, 0.8, 0.0)])
def test_the_gap_to_a_face_decides(place):
    """A triangle is before a face of a turned cube, or turned itself towards an edge: its own plane decides then."""
    turn = Rotation.from_rotvec([0.3, -0.2, 0.5])
    toward, reach = np.array(place), float(np.abs(place).sum())
    across = np.linalg.svd(toward[None])[2][1:]
    triangle = (reach + 0.2) * toward + np.array([[5.0, 0.0], [-5.0, 4.0], [-5.0, -4.0]]) @ across
    tree = build_tree(turn.apply(triangle)[None])
    assert is_apart(tree, cube(), turn.as_matrix(), np.zeros(3), 0.2 - 1e-6)
    assert not is_apart(tree, cube(), turn.as_matrix(), np.zeros(3), 0.2 + 1e-6)


def test_one_near_triangle_of_many_is_found():
    far = np.random.default_rng(5).uniform(3, 6, (300, 3, 3))
    near = np.array([[[0.9, 0, 0], [5, 5, 5], [5, 5.1, 5]]])
    assert is_apart(build_tree(far), cube(), np.eye(3), np.zeros(3), 1.9)
    for at in (0, 150, 300):
        triangles = np.concatenate((far[:at], near, far[at:]))
        assert not is_apart(build_tree(triangles), cube(), np.eye(3), np.zeros(3), 0.0)


def test_facets_in_one_plane_are_one_face():
    assert len(cube().faces) == 6
