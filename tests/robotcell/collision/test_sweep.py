"""Between two rows of joints nothing is jumped over, however thin."""

import numpy as np
import pytest
from flying_cells import at, board_with, box_triangles, cell_of, flyer, joint, mesh, planar_arm
from hypothesis import given, settings
from hypothesis import strategies as st

from robotcell.collision.body_pairs import RESOLUTION
from robotcell.collision.clearance import clearance
from robotcell.collision.collision import build_collider, collides, collides_between, touch_between
from robotcell.robot.robot import Body, Box, Capsule, Robot

BALL = Body("ball", Capsule(0.01, 0.02), at())
SHEET = mesh([[[0, -1, -1], [0, 1, -1], [0, 1, 1]], [[0, -1, -1], [0, 1, 1], [0, -1, 1]]])


def test_a_wall_without_thickness_is_not_jumped_over():
    collider = build_collider(cell_of(flyer([BALL]), [Body("wall", SHEET, at(0.05))]), None)
    start, end = np.zeros((2, 6)), np.zeros((2, 6))
    end[0, 0], end[1, 1] = 2.0, 2.0
    samples = start[0] + np.linspace(0, 1, 11)[:, None] * (end[0] - start[0])
    assert not collides(collider, samples, 1).any()
    assert collides_between(collider, start, end, 1).tolist() == [True, False]
    touch = touch_between(collider, start[0], end[0], 1)
    assert touch is not None
    assert (touch.body, touch.other) == ("ball", "wall")
    assert touch_between(collider, start[1], end[1], 1) is None


def test_a_turning_arm_does_not_jump_over_a_pin():
    hand = Body("hand", Capsule(0.005, 0.2), at(0.2, 0, 0, (0, np.pi / 2, 0)))
    pin = Body("pin", Capsule(0.0005, 0.1), at(1.1 * np.cos(0.7), 1.1 * np.sin(0.7), 0))
    collider = build_collider(cell_of(planar_arm((), (), (), (hand,)), [pin], home=[0, 0, 0]), None)
    start, end = np.zeros((2, 3)), np.array([[1.4, 0.0, 0.0], [0.68, 0.0, 0.0]])
    assert not collides(collider, np.concatenate([start, end, (start + end) / 2 + 0.05]), 1).any()
    assert collides_between(collider, start, end, 1).tolist() == [True, False]


def test_an_arm_on_a_slide_has_the_longer_lever():
    """The slide carries the hand 3 m out, so that a small turn before it goes far."""
    hand = Body("hand", Capsule(0.005, 0.02), at())
    joints = (joint("revolute", (0, 0, 1)), joint("prismatic", (1, 0, 0)))
    pin = Body("pin", Capsule(0.0005, 0.1), at(3.0 * np.cos(0.03), 3.0 * np.sin(0.03), 0))
    collider = build_collider(cell_of(Robot("crane", joints, at(), ((), (), (hand,))), [pin]), None)
    ends = np.array([[0.0, 3.0]]), np.array([[0.06 * 1.3, 3.0]])
    assert not collides(collider, np.concatenate([*ends, (ends[0] + ends[1]) / 2]), 1).any()
    assert collides_between(collider, *ends, 1)[0]


@pytest.mark.slow
@settings(max_examples=40)
@given(seed=st.integers(0, 2**32 - 1), margin=st.sampled_from([0.0, 0.004]), far=st.sampled_from([0.02, 0.2, 1.0]))
def test_ways_agree_with_very_many_samples(seed, margin, far):
    rng = np.random.default_rng(seed)
    bar = Body("bar", Box((0.04, 0.01, 0.12)), at(0.01, 0, 0.03))
    post = Body("post", Capsule(0.01, 0.1), at(0.03, 0.02, 0.01, (0.4, 0.2, 0.1)))
    collider = build_collider(cell_of(flyer([bar]), [post], margin=margin), None)
    start = np.hstack([rng.uniform(-0.15, 0.15, (6, 3)), rng.uniform(-np.pi, np.pi, (6, 3))])
    end = start + far * rng.uniform(-1, 1, (6, 6)) * [0.2, 0.2, 0.2, 1, 1, 1]
    found = collides_between(collider, start, end, 1)
    for row in range(6):
        samples = start[row] + np.linspace(0, 1, 400)[:, None] * (end[row] - start[row])
        if collides(collider, samples, 1).any():
            assert found[row]
        elif clearance(collider, samples, 1).distances.min() > margin + RESOLUTION:
            assert not found[row]


@pytest.mark.slow
@settings(max_examples=15)
@given(seed=st.integers(0, 2**32 - 1))
def test_folding_arms_agree_with_very_many_samples(seed):
    rng = np.random.default_rng(seed)
    link = Body("link", Capsule(0.03, 0.35), at(0.2, 0, 0, (0, np.pi / 2, 0)))
    hand = Body("hand", Capsule(0.02, 0.3), at(0.2, 0, 0, (0, np.pi / 2, 0)))
    collider = build_collider(cell_of(planar_arm((), (link,), (link,), (hand,)), home=[0, 0, 0]), None)
    start, end = rng.uniform(-2.9, 2.9, (8, 3)), rng.uniform(-2.9, 2.9, (8, 3))
    found = collides_between(collider, start, end, 1)
    for row in range(8):
        samples = start[row] + np.linspace(0, 1, 300)[:, None] * (end[row] - start[row])
        assert found[row] or not collides(collider, samples, 1).any()


def test_a_way_of_no_length_is_a_row():
    collider = build_collider(cell_of(flyer([BALL]), [Body("wall", SHEET, at(0.05))], margin=0.004), None)
    q = np.zeros((40, 6))
    q[:, 0] = np.linspace(0, 0.1, 40)
    np.testing.assert_array_equal(collides_between(collider, q, q, 1), collides(collider, q, 1))


@pytest.mark.slow
def test_both_ways_are_the_same_way():
    board = board_with(board=box_triangles((80.0, 60.0, 2.0)))
    collider = build_collider(cell_of(flyer([BALL]), margin=0.002), board)
    rng = np.random.default_rng(5)
    start, end = rng.uniform(-0.1, 0.1, (1100, 6)), rng.uniform(-0.1, 0.1, (1100, 6))
    there = collides_between(collider, start, end, 1)
    assert 0 < there.sum() < len(start)
    np.testing.assert_array_equal(there, collides_between(collider, end, start, 1))
    alone = np.concatenate(
        [collides_between(collider, start[i : i + 1], end[i : i + 1], 1) for i in range(0, 1100, 40)]
    )
    np.testing.assert_array_equal(alone, there[::40])


def test_ways_that_do_not_fit_together_are_refused():
    collider = build_collider(cell_of(flyer([BALL])), None)
    with pytest.raises(ValueError, match="shape"):
        collides_between(collider, np.zeros((2, 6)), np.zeros((3, 6)), 1)
    with pytest.raises(ValueError, match="finite"):
        collides_between(collider, np.zeros((1, 6)), np.full((1, 6), np.inf), 1)
    assert collides_between(collider, np.zeros((0, 6)), np.zeros((0, 6)), 1).shape == (0,)
