"""A click meets what is in front."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tiny_session import tiny_session

from specs.source import NO_SOURCE, Source
from webui.layers.paths.strokes import stroke_lines
from webui.scene.camera import choose_stroke, first_hit, strokes_at, target_of

DOWN = np.array([0.0, 0.0, -1.0])


@pytest.mark.parametrize("index", range(5))
def test_a_ray_from_above_meets_the_component_below_it(index):
    session = tiny_session()
    component = session.board.components[index]
    middle = component.footprint.representative_point()
    hit = first_hit(target_of(session.board), np.array([middle.x, middle.y, 100.0]), 3.0 * DOWN)
    assert hit is not None
    assert hit.body == component.name
    assert hit.point[2] <= session.board.top_z_mm + component.height_mm + 1e-9
    assert hit.distance_mm == pytest.approx(100.0 - hit.point[2])


def test_a_ray_beside_the_board_or_away_from_it_meets_nothing():
    target = target_of(tiny_session().board)
    assert first_hit(target, np.array([-500.0, 0.0, 100.0]), DOWN) is None
    assert first_hit(target, np.array([5.0, 5.0, 100.0]), -DOWN) is None


def test_of_two_bodies_the_nearer_is_met_from_either_side():
    session = tiny_session()
    target = target_of(session.board)
    middle = session.board.components[0].footprint.representative_point()
    above = first_hit(target, np.array([middle.x, middle.y, 50.0]), DOWN)
    below = first_hit(target, np.array([middle.x, middle.y, -50.0]), -DOWN)
    assert above.body == session.board.components[0].name
    assert below.body == next(body.name for body in session.board.bodies if body.role == "board")
    assert below.point[2] == pytest.approx(session.board.bottom_z_mm)


@settings(max_examples=60)
@given(
    spot=st.tuples(st.floats(0, 30), st.floats(0, 20)),
    lean=st.tuples(st.floats(-1, 1), st.floats(-1, 1)),
)
def test_boxes_leave_out_nothing_that_the_ray_meets(spot, lean):
    board = tiny_session().board
    direction = np.array([*lean, -1.0])
    origin = np.array([*spot, 0.0]) - 80.0 * direction
    hit = first_hit(target_of(board), origin, direction)
    whole = replace(board.bodies[0], patches=np.concatenate([body.patches for body in board.bodies]))
    slow = first_hit(target_of(replace(board, bodies=(whole,))), origin, direction)
    assert (hit is None) == (slow is None)
    if hit is not None:
        assert hit.distance_mm == pytest.approx(slow.distance_mm)


@pytest.mark.parametrize("index", range(5))
def test_the_hit_moves_with_the_board(index):
    board = tiny_session().board
    middle = board.components[index].footprint.representative_point()
    origin, shift = np.array([middle.x, middle.y, 90.0]), np.array([-255.0, 1000.0, 7.5])
    moved = tuple(replace(body, patches=body.patches + shift) for body in board.bodies)
    here = first_hit(target_of(board), origin, DOWN)
    there = first_hit(target_of(replace(board, bodies=moved)), origin + shift, DOWN)
    assert there.body == here.body
    np.testing.assert_allclose(there.point, here.point + shift, atol=1e-9)


def test_a_click_on_a_stroke_means_it_and_one_beside_it_does_not():
    lines = stroke_lines(tiny_session().run.plan)
    line = lines[-1]
    begin, end = line.segments[0]
    point = begin + 0.4 * (end - begin)
    eye = point + np.array([0.0, 0.0, 200.0])
    assert line.made_by in strokes_at(lines, eye, point - eye, np.inf)
    aside = np.cross(end - begin, DOWN) / np.linalg.norm(end - begin)
    assert strokes_at([line], eye, DOWN + 0.004 * aside, np.inf) == (line.made_by,)
    assert strokes_at([line], eye, DOWN + 0.006 * aside, np.inf) == ()
    assert strokes_at(lines, eye + np.array([0, 0, 50]), np.array([1.0, 0.0, 0.0]), np.inf) == ()


def test_a_click_so_many_millimetres_beside_a_stroke_means_it_from_wherever_it_is_seen():
    line = stroke_lines(tiny_session().run.plan)[-1]
    begin, end = line.segments[0]
    point = begin + 0.4 * (end - begin)
    aside = np.cross(end - begin, DOWN) / np.linalg.norm(end - begin)
    for height in (20.0, 100.0):
        for gap, meant in ((1.9, (line.made_by,)), (2.1, ())):
            eye = point + gap * aside - height * DOWN
            assert strokes_at([line], eye, DOWN, np.inf, 2.0) == meant
    eye = point + 2.1 * aside - 1000.0 * DOWN
    assert strokes_at([line], eye, DOWN, np.inf, 2.0) == (line.made_by,), "few pixels are near, whatever they measure"


def test_the_closest_stroke_comes_first():
    lines = stroke_lines(tiny_session().run.plan)
    first = replace(lines[0], points=np.array([[0.0, 0.0, 50.0], [10.0, 0.0, 50.0]]), made_by=Source.parse("near"))
    second = replace(lines[0], points=np.array([[0.0, 0.4, 50.0], [10.0, 0.4, 50.0]]), made_by=Source.parse("far"))
    eye = np.array([5.0, 0.1, 250.0])
    assert strokes_at([second, first], eye, DOWN, np.inf) == (Source.parse("near"), Source.parse("far"))


def test_a_stroke_behind_the_board_is_not_meant():
    lines = stroke_lines(tiny_session().run.plan)
    begin, end = lines[0].segments[0]
    point = (begin + end) / 2
    eye = point + np.array([0.0, 0.0, 50.0])
    assert strokes_at(lines, eye, DOWN, 49.0) == ()
    assert strokes_at(lines, eye, DOWN, 51.0) != ()
    assert strokes_at([], eye, DOWN, 51.0) == ()


def test_click_after_click_goes_through_all_that_lies_there():
    makers = tuple(map(Source.parse, "bca"))
    chosen = choose_stroke(makers, NO_SOURCE)
    seen = [chosen]
    for _ in range(3):
        chosen = choose_stroke(makers, chosen)
        seen.append(chosen)
    assert [str(source) for source in seen] == ["b", "c", "a", "b"]
    assert choose_stroke((), Source.parse("a")) == NO_SOURCE
    assert choose_stroke(makers[:1], makers[0]) == makers[0]
