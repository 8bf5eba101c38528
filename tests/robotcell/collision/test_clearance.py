"""How near robot and tool come, to what, and where the nearest points are."""

import numpy as np
import pytest
from flying_cells import at, board_with, box_triangles, cell_of, flyer, planar_arm
from hypothesis import given, settings
from hypothesis import strategies as st

from robotcell.collision.body_pairs import place, probe_of
from robotcell.collision.clearance import clearance
from robotcell.collision.collision import build_collider
from robotcell.robot.robot import Body, Box, Capsule

BALL = Body("ball", Capsule(0.01, 0.02), at())
EXACT = 1e-4


@pytest.mark.slow
@settings(max_examples=30)
@given(
    height=st.floats(0.0, 0.08),
    x=st.floats(-30, 30),
    y=st.floats(-20, 20),
    farthest=st.sampled_from([0.005, 0.02, 0.06]),
)
def test_over_a_flat_board_it_is_the_height(height, x, y, farthest):
    rows = np.stack(np.meshgrid(np.linspace(-50, 50, 21), np.linspace(-40, 40, 17), indexing="ij"), axis=-1)
    tiles = np.concatenate([box_triangles((5.0, 5.0, 2.0), (*tile, -1.0)) for tile in rows.reshape(-1, 2)])
    collider = build_collider(cell_of(flyer(), tool=[BALL]), board_with(board=tiles))
    q = np.array([[x / 1000, y / 1000, 0.02 + height, 0, 0, 0]])
    result = clearance(collider, q, 1, farthest)
    assert result.distances[0] == pytest.approx(min(height, farthest), abs=EXACT)
    touch = result.touches[0]
    assert (touch is None) == (height > farthest + EXACT) or abs(height - farthest) < EXACT
    if touch is not None and height > EXACT:
        np.testing.assert_allclose(touch.points[0], [x / 1000, y / 1000, height], atol=2e-3)
        np.testing.assert_allclose(touch.points[1, 2], 0.0, atol=1e-6)
        assert np.linalg.norm(touch.points[1] - touch.points[0]) == pytest.approx(touch.distance, abs=1e-6)


@pytest.mark.parametrize("gap", [0.001, 0.004, 0.012, 0.019])
@pytest.mark.parametrize("what", ["fixture", "board"])
def test_past_a_corner_it_is_the_distance_and_not_that_of_the_boxes_around_the_bodies(what, gap):
    size = np.array([0.1, 0.06, 0.04])
    block = Body("block", Box(tuple(size.tolist())), at())
    far_off = board_with(board=box_triangles((10.0, 10.0, 1.0), (900.0, 0.0, 0.0)))
    board = board_with(board=box_triangles(tuple(1e3 * size))) if what == "board" else far_off
    collider = build_collider(cell_of(flyer(), [block] if what == "fixture" else [], [BALL]), board)
    aside = (0.01 + gap) / np.sqrt(2.0)  # less than the ball's radius for a small gap: its box overlaps the block's
    q = np.array([[size[0] / 2 + aside, size[1] / 2 + aside, 0, 0, 0, 0]])
    assert clearance(collider, q, 1).distances[0] == pytest.approx(gap, abs=EXACT)


def test_the_nearest_of_several_is_named():
    board = board_with(
        board=box_triangles((100.0, 60.0, 1.6), (0, 0, -0.8)), C7=box_triangles((2.0, 2.0, 4.0), (0, 0, 2))
    )
    post = Body("post", Box((0.02, 0.02, 0.1)), at(0.04, 0, 0.05))
    collider = build_collider(cell_of(flyer(), [post], [BALL]), board)
    q = np.zeros((3, 6))
    q[:, :3] = [[0, 0, 0.03], [0.013, 0, 0.03], [0.3, 0, 0.03]]
    result = clearance(collider, q, 1)
    assert [touch and touch.other for touch in result.touches] == ["C7", "post", None]
    np.testing.assert_allclose(result.distances, [0.006, 0.007, 0.02], atol=EXACT)


def test_it_is_zero_where_bodies_overlap_and_never_less():
    collider = build_collider(cell_of(flyer(), tool=[BALL]), board_with(board=box_triangles((100.0, 60.0, 1.6))))
    result = clearance(collider, np.zeros((1, 6)), 1)
    assert result.distances.tolist() == [0.0]
    assert result.touches[0] is not None
    assert result.touches[0].distance == 0.0


def test_bodies_of_the_robot_are_not_measured_against_each_other():
    link = Body("link", Capsule(0.03, 0.35), at(0.2, 0, 0, (0, np.pi / 2, 0)))
    collider = build_collider(cell_of(planar_arm((), (link,), (link,), (link,)), home=[0, 0, 0]), None)
    folded = np.array([[0.0, 2.6, 2.574]])
    assert clearance(collider, folded, 1).touches == (None,)


def test_a_capsule_over_a_rugged_board_is_as_near_as_another_library_has_it():
    rng = np.random.default_rng(4)
    parts = {
        f"C{number}": box_triangles(rng.uniform(2, 9, 3), (*rng.uniform(-40, 40, 2), rng.uniform(-2, 4)))
        for number in range(60)
    }
    lance = Body("lance", Capsule(0.004, 0.03), at(0, 0, 0.02, (0.3, 0.2, 0)))
    collider = build_collider(cell_of(flyer(), tool=[lance]), board_with(**parts))
    q = np.hstack([rng.uniform(-0.04, 0.04, (80, 2)), rng.uniform(0.0, 0.03, (80, 1)), rng.uniform(-0.6, 0.6, (80, 3))])
    result, bodies = clearance(collider, q, 1), collider.by_tool[1]
    probe = probe_of(bodies, place(bodies, q))
    pair = next(each for each in range(len(bodies.first)) if bodies.outside[each])
    apart = np.flatnonzero((result.distances > EXACT) & (result.distances < 0.02 - EXACT)).tolist()
    assert len(apart) > 20
    for row in apart:
        assert probe(row, pair, float(result.distances[row]) - EXACT) is None
        assert probe(row, pair, float(result.distances[row]) + EXACT) is not None
    for row in np.flatnonzero(result.distances == 0.0).tolist():
        assert probe(row, pair, EXACT) is not None
