"""The camera sees all of a box, and little else."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from webui.scene.camera import Lens, Pose, between, frame_box

SIZES = st.floats(1.0, 500.0)


def seen_at(pose, lens, points):
    """(n, 2) places in the picture, -1 to 1 to the right and upwards in the free part of it."""
    forward = (pose.target - pose.eye) / np.linalg.norm(pose.target - pose.eye)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    upward = np.cross(right, forward)
    away = points - pose.eye
    depth = away @ forward
    assert (depth > 0).all()
    tall = np.tan(lens.fov / 2)
    return np.column_stack([away @ right / (tall * lens.aspect), away @ upward / tall]) / depth[:, None]


@settings(max_examples=100)
@given(
    width=SIZES,
    depth=SIZES,
    height=st.floats(0.0, 60.0),
    aspect=st.floats(0.4, 3.0),
    fov=st.floats(0.3, 1.0),
    below=st.booleans(),
)
def test_every_corner_is_seen_and_the_box_fills_the_picture(width, depth, height, aspect, fov, below):
    low = np.array([-30.0, 12.0, -1.6])
    high = low + np.array([width, depth, height])
    lens = Lens(fov, aspect)
    pose = frame_box(low, high, lens, from_below=below)
    places = seen_at(pose, lens, np.array(list(product(*zip(low, high, strict=True)))))
    assert np.abs(places[:, 0]).max() <= 0.95
    assert places[:, 1].max() <= 0.95
    assert places[:, 1].min() >= -0.95
    assert np.abs(places[:, 0]).max() > 0.5 or np.ptp(places[:, 1]) > 0.6
    assert (pose.eye[2] < pose.target[2]) == below


def test_the_view_moves_with_the_board():
    low, high, shift = np.zeros(3), np.array([100.0, 60.0, 5.0]), np.array([7.0, -900.0, 3.0])
    lens = Lens(1.2, 1.0)
    here, there = frame_box(low, high, lens), frame_box(low + shift, high + shift, lens)
    np.testing.assert_allclose(there.eye - here.eye, shift)
    np.testing.assert_allclose(there.target - here.target, shift)


def test_a_flight_begins_and_ends_at_rest():
    begin = Pose(np.zeros(3), np.ones(3))
    end = Pose(np.array([10.0, 0.0, 0.0]), np.array([5.0, 1.0, 1.0]))
    np.testing.assert_array_equal(between(begin, end, 0.0).eye, begin.eye)
    np.testing.assert_array_equal(between(begin, end, 1.0).target, end.target)
    steps = np.diff([between(begin, end, share).eye[0] for share in np.linspace(0, 1, 11)])
    assert (steps > 0).all()
    assert steps[0] == pytest.approx(steps[-1])
    assert steps[0] < steps[5] / 3
