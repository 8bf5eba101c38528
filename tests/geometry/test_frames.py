import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.arrays import Directions, Quaternions
from geometry.frames import align_signs, quaternions_from_axes, rotation_angles, rotation_vectors, slerp

seeds = st.integers(0, 2**32 - 1)


def random_turns(seed: int, count: int) -> Quaternions:
    q = np.random.default_rng(seed).normal(size=(count, 4))
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def turn(q: Quaternions, v: Directions) -> Directions:
    """Rotate vectors by quaternions, by the sandwich product."""
    w, axis = q[:, :1], q[:, 1:]
    return v + 2.0 * np.cross(axis, np.cross(axis, v) + w * v)


@given(seed=seeds)
@settings(max_examples=50)
def test_the_quaternion_carries_tool_z_to_the_approach_and_tool_x_to_the_reference(seed: int) -> None:
    q = random_turns(seed, 20)
    approach, reference = turn(q, np.tile([0.0, 0.0, 1.0], (20, 1))), turn(q, np.tile([1.0, 0.0, 0.0], (20, 1)))
    got = quaternions_from_axes(approach, reference)
    np.testing.assert_allclose(np.abs(np.einsum("ij,ij->i", got, q)), 1.0, atol=1e-12)
    assert np.all(np.einsum("ij,ij->i", got[1:], got[:-1]) >= 0.0)


def test_straight_down_with_the_reference_along_x_is_half_a_turn_about_x() -> None:
    q = quaternions_from_axes(np.array([[0.0, 0.0, -1.0]]), np.array([[1.0, 0.0, 0.0]]))
    np.testing.assert_allclose(q, [[0.0, 1.0, 0.0, 0.0]], atol=1e-15)


def test_no_orientations_give_none() -> None:
    assert quaternions_from_axes(np.empty((0, 3)), np.empty((0, 3))).shape == (0, 4)


def test_signs_follow_the_short_way() -> None:
    angle = np.radians(np.arange(0, 720, 30))
    q = np.stack((np.cos(angle / 2), 0 * angle, 0 * angle, np.sin(angle / 2)), axis=1)
    flipped = q * np.where(np.arange(len(q)) % 3 == 0, -1.0, 1.0)[:, None]
    np.testing.assert_allclose(align_signs(flipped), q)


@given(seed=seeds, fraction=st.floats(0.0, 1.0))
@settings(max_examples=50)
def test_slerp_turns_at_a_constant_rate_the_short_way(seed: int, fraction: float) -> None:
    a, b = random_turns(seed, 10), random_turns(seed + 1, 10)
    part = slerp(a, b, np.full(10, fraction))
    whole = rotation_angles(a, b)
    np.testing.assert_allclose(np.linalg.norm(part, axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(rotation_angles(a, part), fraction * whole, atol=1e-7)
    np.testing.assert_allclose(rotation_angles(part, b), (1.0 - fraction) * whole, atol=1e-7)


def test_the_rotation_vector_is_in_the_board_frame() -> None:
    tilted = quaternions_from_axes(np.array([[0.6, 0.0, -0.8]]), np.array([[0.8, 0.0, 0.6]]))
    turned = quaternions_from_axes(np.array([[0.0, 0.6, -0.8]]), np.array([[0.0, 0.8, 0.6]]))
    np.testing.assert_allclose(rotation_vectors(tilted, turned), [[0.0, 0.0, np.pi / 2]], atol=1e-12)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-9, 1e-6, 1e-3, 1.0, 3.0, np.pi])
def test_angles_are_exact_however_small(angle: float) -> None:
    start = np.array([[1.0, 0.0, 0.0, 0.0]])
    end = np.array([[np.cos(angle / 2), 0.0, np.sin(angle / 2), 0.0]])
    np.testing.assert_allclose(rotation_vectors(start, end), [[0.0, angle, 0.0]], rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(rotation_angles(start, -end), [angle], rtol=1e-9, atol=1e-15)


@given(seed=seeds, yaw=st.floats(-np.pi, np.pi), noise=st.integers(-3, 3))
@settings(max_examples=50)
def test_half_a_turn_goes_the_same_way_wherever_the_board_lies(seed: int, yaw: float, noise: int) -> None:
    """Half a turn is as long both ways: the last bits must not choose."""
    tilt = np.random.default_rng(seed).uniform(0.1, 1.4)

    def half_turn(heading: float) -> Quaternions:
        headings = np.array([heading, heading + np.pi + noise * 1e-16])
        approach = np.stack(
            (np.sin(tilt) * np.cos(headings), np.sin(tilt) * np.sin(headings), np.full(2, -np.cos(tilt))), axis=1
        )
        along = np.stack(
            (np.cos(tilt) * np.cos(headings), np.cos(tilt) * np.sin(headings), np.full(2, np.sin(tilt))), 1
        )
        return quaternions_from_axes(approach, along)

    here, there = half_turn(0.0), half_turn(yaw)
    halfway = slerp(here[:1], here[1:], np.array([0.5]))
    moved = slerp(there[:1], there[1:], np.array([0.5]))
    spun = np.array([[np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)]])
    expected = turn(spun, turn(halfway, np.array([[1.0, 2.0, 3.0]])))
    np.testing.assert_allclose(turn(moved, np.array([[1.0, 2.0, 3.0]])), expected, atol=1e-6)
