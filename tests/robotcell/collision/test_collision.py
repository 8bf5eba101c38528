"""What touches is named, what may touch is left alone, and nothing depends on where the cell is."""

import importlib
from dataclasses import replace

import numpy as np
import pytest
from flying_cells import at, board_with, box_triangles, cell_of, flyer, planar_arm, scattered
from hypothesis import given, settings
from hypothesis import strategies as st

from robotcell.cell.cell import Tool
from robotcell.collision.coal_bodies import coal
from robotcell.collision.collision import build_collider, collides, first_pairs, with_board_at
from robotcell.errors import CellError
from robotcell.robot.robot import Body, Box, Capsule

EXACT = 1e-5
SEEDS = st.integers(0, 2**32 - 1)


@pytest.mark.slow
def test_many_rows_at_once_are_what_each_is_alone():
    soup = box_triangles((80.0, 60.0, 2.0))
    cell = cell_of(
        flyer([Body("arm", Capsule(0.01, 0.05), at())]), [Body("post", Capsule(0.01, 0.1), at(0.05))], margin=0.004
    )
    collider = build_collider(cell, board_with(board=soup))
    q = scattered(3, 120)
    together = collides(collider, np.tile(q, (600, 1)), 1)
    alone = np.array([collides(collider, row[None], 1)[0] for row in q])
    assert 0 < alone.sum() < len(q)
    np.testing.assert_array_equal(together.reshape(600, -1), np.tile(alone, (600, 1)))
    named = np.array([touch is not None for touch in first_pairs(collider, q, 1)])
    np.testing.assert_array_equal(named, alone)


@settings(max_examples=10)
@given(x=st.floats(-2000, 2000), y=st.floats(-2000, 2000), turn=st.floats(-3, 3), seed=SEEDS)
def test_nothing_depends_on_where_the_cell_is(x, y, turn, seed):
    moved = at(x, y, 5.0, (0, 0, turn))
    cell = cell_of(
        flyer([Body("arm", Capsule(0.01, 0.05), at())]), [Body("post", Capsule(0.01, 0.1), at(0.05))], margin=0.003
    )
    there = replace(
        cell,
        T_cell_base=moved @ cell.T_cell_base,
        T_cell_board=moved @ cell.T_cell_board,
        fixtures=tuple(replace(body, T_carrier_shape=moved @ body.T_carrier_shape) for body in cell.fixtures),
    )
    board, q = board_with(board=box_triangles((80.0, 60.0, 2.0))), scattered(seed)
    near = [build_collider(replace(cell, margin=margin), board) for margin in (0.003 - EXACT, 0.003 + EXACT)]
    sure, possible = (collides(collider, q, 1) for collider in near)
    found = collides(build_collider(there, board), q, 1)
    assert found[sure].all()
    assert not found[~possible].any()


def test_a_board_with_a_far_origin_in_its_cad_is_as_good_as_any():
    soup, q = box_triangles((80.0, 60.0, 2.0)), scattered(8)
    robot, far = flyer([Body("arm", Capsule(0.01, 0.05), at())]), np.array([4e6, -3e6, 1e5])
    near = build_collider(cell_of(robot), board_with(board=soup))
    away = build_collider(cell_of(robot, board_at=at(*(-far / 1000))), board_with(board=soup + far))
    np.testing.assert_array_equal(collides(near, q, 1), collides(away, q, 1))


def test_the_component_that_is_touched_is_named():
    board = board_with(
        board=box_triangles((100.0, 60.0, 1.6), (50, 30, -0.8)),
        J12=box_triangles((10.0, 10.0, 8.0), (80, 30, 4)),
        U3=box_triangles((10.0, 10.0, 2.0), (20, 30, 1)),
    )
    cell = cell_of(flyer(), tool=[Body("ring60", Capsule(0.003, 0.02), at(0, 0, 0.013))], board_at=at(1.0, 2.0, 0.5))
    collider = build_collider(cell, board)
    q = np.zeros((4, 6))
    q[:, :3] = np.array([1.0, 2.0, 0.5]) + np.array([[80, 30, 7], [20, 30, 1], [50, 30, -1], [50, 30, 20]]) / 1000
    touches = first_pairs(collider, q, 1)
    assert [touch and (touch.body, touch.other) for touch in touches] == [
        ("ring60", "J12"), ("ring60", "U3"), ("ring60", "board"), None,
    ]  # fmt: skip


def test_a_link_keeps_the_margin_and_a_nozzle_may_come_nearer_to_the_board():
    board = board_with(board=box_triangles((100.0, 60.0, 1.6), (0, 0, -0.8)))
    table = Body("table", Box((2, 2, 0.1)), at(0, 0, -0.55))
    ball = Body("ball", Capsule(0.01, 0.02), at(0, 0, 0.02))
    link = build_collider(cell_of(flyer([ball]), [table], margin=0.01), board)
    nozzle = build_collider(cell_of(flyer(), [table], [ball], margin=0.01), board)
    above = np.zeros((5, 6))
    above[:, 2] = [0.011, 0.009, 0.0012, 0.0008, -0.491]
    assert collides(link, above, 1).tolist() == [False, True, True, True, True]
    assert collides(nozzle, above, 1).tolist() == [False, False, False, True, True]


def test_a_board_that_is_moved_is_as_if_built_there():
    cell = cell_of(flyer([Body("arm", Capsule(0.01, 0.05), at())]))
    board, there = board_with(board=box_triangles((80.0, 60.0, 2.0))), at(0.05, -0.02, 0.03, (0.2, 0.1, 0.7))
    moved = with_board_at(build_collider(cell, board), there)
    built = build_collider(replace(cell, T_cell_board=there), board)
    q = scattered(11, 300)
    np.testing.assert_array_equal(collides(moved, q, 1), collides(built, q, 1))
    assert (collides(moved, q, 1) != collides(build_collider(cell, board), q, 1)).any()


def folding_arm(gap):
    """Four links; the last can fold onto the first. ``gap`` parts the third body from the first at home."""
    thin = Capsule(0.02, 0.3)
    along = at(0.25, 0, 0, (0, np.pi / 2, 0))
    foot = Body("foot", Box((0.1, 0.1, 0.1)), at(-0.2))
    last = Body("hand", Capsule(0.02, 0.2), at(0.2, 0, 0, (0, np.pi / 2, 0)))
    return planar_arm(
        (foot,), (Body("upper arm", thin, along),), (Body("forearm", thin, along),), (last,), lengths=(0.5, gap)
    )


def test_a_robot_meets_itself_but_not_its_neighbours():
    collider = build_collider(cell_of(folding_arm(0.5), home=[0, 0, 0]), None)
    folded = np.array([[0.0, 0.0, 0.0], [0.0, np.pi, 0.0], [0.0, 2.6, 2.574], [0.0, np.pi - 0.1, 0.0]])
    touches = first_pairs(collider, folded, 1)
    assert touches[0] is None  # stretched
    assert touches[3] is None or touches[3].body == "hand"  # neighbours lie on each other
    assert touches[2] is not None  # a triangle: the hand is back at the upper arm
    assert (touches[2].body, touches[2].other) == ("hand", "upper arm")
    near = build_collider(cell_of(folding_arm(0.5), home=[0, 2.6, 2.574]), None)
    assert first_pairs(near, folded[2:3], 1) == (None,)  # made to touch at home: never a collision


def test_the_first_link_may_touch_what_the_base_stands_on_and_nothing_else_may():
    foot = Body("foot", Box((0.1, 0.1, 0.1)), at())
    shoulder, arm = (Body(name, Box((0.3, 0.1, 0.1)), at(0.2, 0, 0)) for name in ("shoulder", "arm"))
    pedestal = Body("pedestal", Box((0.1, 0.1, 0.5)), at(0, 0, -0.3))
    plinth = Body("plinth", Box((2, 2, 0.1)), at(0, 0, -0.1005))
    robot = planar_arm((foot,), (shoulder,), (arm,), ())
    fixtures = (pedestal, plinth)
    cell = cell_of(robot, fixtures, margin=0.01, home=[0, 0, 0])
    touches = first_pairs(build_collider(cell, None), np.zeros((1, 3)), 1)
    assert touches[0] is not None
    assert (touches[0].body, touches[0].other) == ("arm", "plinth")
    high = replace(cell, fixtures=(pedestal, replace(plinth, T_carrier_shape=at(0.6, 0, -0.1055))))
    met = first_pairs(build_collider(high, None), np.zeros((1, 3)), 1)[0]
    assert met is not None
    assert (met.body, met.other) == ("shoulder", "plinth")  # the base does not stand on it


def test_a_tool_is_checked_against_the_arm_but_not_against_the_link_that_carries_it():
    nozzle = Body("nozzle", Capsule(0.01, 0.05), at(0.2, 0, 0))
    collider = build_collider(cell_of(folding_arm(0.5), tool=[nozzle], home=[0, 0, 0]), None)
    stretched, folded = np.zeros((1, 3)), np.array([[0.0, 0.0, 3.0]])
    assert first_pairs(collider, stretched, 1) == (None,)
    touch = first_pairs(collider, folded, 1)[0]
    assert touch is not None
    assert (touch.body, touch.other) == ("nozzle", "forearm")


def test_every_tool_has_its_own_bodies():
    wall = Body("wall", Box((0.01, 1, 1)), at(0.1))
    cell = cell_of(flyer(), [wall])
    long = Tool(2, "lance", at(), (Body("lance", Capsule(0.005, 0.3), at(0, 0, 0, (0, np.pi / 2, 0))),))
    collider = build_collider(replace(cell, tools=(*cell.tools, long)), None)
    q = np.zeros((1, 6))
    assert not collides(collider, q, 1)[0]
    assert collides(collider, q, 2)[0]
    with pytest.raises(CellError, match="no tool 3 \\(it has 1, 2\\)"):
        collides(collider, q, 3)


def test_no_rows_collide_nowhere():
    collider = build_collider(cell_of(flyer()), None)
    assert collides(collider, np.zeros((0, 6)), 1).shape == (0,)
    assert collides(collider, np.zeros((3, 6)), 1).tolist() == [False] * 3


@pytest.mark.parametrize("q", [np.zeros((2, 5)), np.zeros(6), np.full((1, 6), np.nan)])
def test_rows_that_are_no_joints_are_refused(q):
    with pytest.raises(ValueError, match="finite and of shape"):
        collides(build_collider(cell_of(flyer()), None), q, 1)


def test_without_coal_the_error_says_what_to_install(monkeypatch):
    def refuse(name):
        raise ImportError(name)

    coal.cache_clear()
    monkeypatch.setattr(importlib, "import_module", refuse)
    with pytest.raises(CellError, match=r"pip install washboard\[robot\]"):
        build_collider(cell_of(flyer([Body("arm", Capsule(0.01, 0.05), at())])), None)
    coal.cache_clear()
