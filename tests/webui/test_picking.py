"""A click meets what is in front."""

import numpy as np
import pytest
from tiny_session import tiny_session

from webui.layers.strokes import stroke_lines
from webui.picking import first_hit, nearest_stroke, target_of

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


def test_a_click_on_a_stroke_means_it_and_one_beside_it_does_not():
    lines = stroke_lines(tiny_session().run.plan)
    line = lines[-1]
    begin, end = line.segments[0]
    point = begin + 0.4 * (end - begin)
    eye = point + np.array([0.0, 0.0, 200.0])
    found = nearest_stroke(lines, eye, point - eye, np.inf)
    assert found is not None
    away = np.linalg.norm(np.cross(found.segments[:, 1] - found.segments[:, 0], point - found.segments[:, 0]), axis=1)
    lengths = np.linalg.norm(found.segments[:, 1] - found.segments[:, 0], axis=1)
    assert (away / np.maximum(lengths, 1e-9)).min() < 1e-6
    assert nearest_stroke(lines, eye - 50 * DOWN, np.array([1.0, 0.0, 0.0]), np.inf) is None


def test_a_stroke_behind_the_board_is_not_meant():
    lines = stroke_lines(tiny_session().run.plan)
    begin, end = lines[0].segments[0]
    point = (begin + end) / 2
    eye = point + np.array([0.0, 0.0, 50.0])
    assert nearest_stroke(lines, eye, DOWN, 49.0) is None
    assert nearest_stroke(lines, eye, DOWN, 51.0) is not None
    assert nearest_stroke([], eye, DOWN, 51.0) is None
