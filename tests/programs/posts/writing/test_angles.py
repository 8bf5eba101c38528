import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from programs.pose import IDENTITY, Pose, Quaternion, angle, between, compose, distance, inverse, rotate
from programs.posts.writing import angles

_PARTS = st.floats(-1, 1)


@st.composite
def quaternions(draw: st.DrawFn) -> Quaternion:
    parts = np.array([draw(_PARTS) for _ in range(4)])
    size = float(np.linalg.norm(parts))
    w, x, y, z = (parts / size).tolist() if size > 0.1 else (0.0, 1.0, 0.0, 0.0)
    return w, x, y, z


@st.composite
def poses(draw: st.DrawFn) -> Pose:
    x, y, z = (draw(st.floats(-500, 500)) for _ in range(3))
    return Pose((x, y, z), draw(quaternions()))


def apart_deg(one: Quaternion, other: Quaternion) -> float:
    return math.degrees(angle(Pose((0, 0, 0), one), Pose((0, 0, 0), other)))


def rounded(values: tuple[float, float, float]) -> tuple[float, float, float]:
    a, b, c = (round(value, 4) for value in values)
    return a, b, c


_HALF = math.sqrt(0.5)


@settings(max_examples=100)
@example(q=(_HALF, 0.0, _HALF, 0.0))
@example(q=(_HALF, 0.0, -_HALF, 0.0))
@example(q=(0.5, 0.5, 0.5, 0.5))
@example(q=(0.5, 0.5, -0.5, 0.5))
@example(q=(0.6532815, 0.2705981, -0.6532815, 0.2705981))
@example(q=(0.6532815, -0.2705981, 0.6532815, 0.2705981))
@example(q=(0.0, 1.0, 0.0, 0.0))
@example(q=(0.0, 0.0, 0.0, 1.0))
@given(q=quaternions())
def test_angles_written_with_four_decimals_are_read_as_the_same_orientation(q: Quaternion) -> None:
    assert apart_deg(q, angles.from_fixed_xyz(*rounded(angles.fixed_xyz(q)))) < 1e-3
    assert apart_deg(q, angles.from_moving_xyz(*rounded(angles.moving_xyz(q)))) < 1e-3
    assert apart_deg(q, angles.from_rotation_vector(*angles.rotation_vector(q))) < 1e-6


@settings(max_examples=50)
@given(q=quaternions())
def test_angles_are_those_of_scipy(q: Quaternion) -> None:
    turn = Rotation.from_quat(q, scalar_first=True)
    for made, sequence in ((angles.from_fixed_xyz, "xyz"), (angles.from_moving_xyz, "XYZ")):
        theirs = Rotation.from_euler(sequence, [10.0, 20.0, 30.0], degrees=True).as_quat(scalar_first=True)
        assert apart_deg(made(10.0, 20.0, 30.0), tuple(theirs)) < 1e-9
    np.testing.assert_allclose(angles.matrix(q), turn.as_matrix(), atol=1e-9)
    assert math.hypot(*angles.rotation_vector(q)) == pytest.approx(turn.magnitude(), abs=1e-9)


@settings(max_examples=50)
@given(one=poses(), other=poses())
def test_a_pose_and_its_inverse_cancel(one: Pose, other: Pose) -> None:
    back = compose(inverse(one), compose(one, other))
    assert distance(back, other) < 1e-6
    assert angle(back, other) < 1e-6
    assert distance(compose(one, IDENTITY), one) == 0.0


@settings(max_examples=50)
@given(one=poses(), other=poses(), share=st.floats(0, 1))
def test_between_two_poses_way_and_turn_are_shared_alike(one: Pose, other: Pose, share: float) -> None:
    middle = between(one, other, share)
    assert distance(one, middle) == pytest.approx(share * distance(one, other), abs=1e-6)
    assert angle(one, middle) == pytest.approx(share * angle(one, other), abs=1e-6)
    assert angle(middle, other) == pytest.approx((1 - share) * angle(one, other), abs=1e-6)


def test_a_vector_turns_with_the_frame() -> None:
    assert rotate((_HALF, 0.0, 0.0, _HALF), (1.0, 0.0, 5.0)) == pytest.approx((0.0, 1.0, 5.0))
