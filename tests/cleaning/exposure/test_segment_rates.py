"""A segment lays what its flow is, integrated along it; what stands in between keeps it off."""

import numpy as np
import pytest
from small_sprays import GUN

from cleaning.exposure.segment_rates import Segments, film_of_pass, segment_rates
from cleaning.jet.jet import form_of
from cleaning.parameters.load import load_parameters
from geometry.rays import build_ray_scene

SPRAY = load_parameters("default").spray
FORM = form_of(GUN, GUN.flow_lpm, SPRAY)


def straight(ends, height=100.0):
    """Segments over the plane z = 0 with the jet down, from x to x."""
    count = len(ends) - 1
    tcp = np.zeros((count, 2, 3))
    tcp[:, 0, 0], tcp[:, 1, 0], tcp[:, :, 2] = ends[:-1], ends[1:], height
    down, along = np.array([0.0, 0.0, -1.0]), np.array([0.0, 1.0, 0.0])
    return Segments(tcp, np.broadcast_to(down, (count, 2, 3)).copy(), np.broadcast_to(along, (count, 2, 3)).copy())


def plate(half=60.0, step=2.0):
    line = np.arange(-half + step / 2, half, step)
    points = np.stack(np.meshgrid(line, line, indexing="ij"), axis=-1).reshape(-1, 2)
    return np.column_stack([points, np.zeros(len(points))]), np.tile([0.0, 0.0, 1.0], (len(points), 1))


@pytest.mark.slow
def test_all_of_the_flow_lands() -> None:
    rates = segment_rates(FORM, straight([-15.0, 5.0]), *plate())
    assert rates.sum() * 4.0 * 1e-3 == pytest.approx(FORM.flow_m3_s * 1e9, rel=2e-3)


@pytest.mark.parametrize("count", [3, 8, 20])
def test_a_long_pass_leaves_the_film_of_a_pass_however_it_is_divided(count) -> None:
    across = np.arange(-45.0, 46.0, 3.0)
    points = np.column_stack([0 * across, across, 0 * across])
    segments = straight(np.linspace(-100.0, 100.0, count + 1))
    film = segment_rates(FORM, segments, points, np.tile([0.0, 0.0, 1.0], (len(across), 1))) @ segments.lengths
    assert film == pytest.approx(np.interp(across, *film_of_pass(FORM, 100.0)), abs=25.0)  # of 10,667


def test_a_turn_on_the_spot_lays_the_mean_of_its_directions() -> None:
    tilt = np.radians(30)
    leaning = np.array([[0.0, 0.0, -1.0], [np.sin(tilt), 0.0, -np.cos(tilt)]])
    turn = Segments(np.tile([0.0, 0.0, 60.0], (1, 2, 1)), leaning[None], np.tile([0.0, 1.0, 0.0], (1, 2, 1)))
    points, normals = plate(120.0)
    film = segment_rates(FORM, turn, points, normals).toarray()[:, 0]
    middle = (film * points[:, 0]).sum() / film.sum()
    assert 60 * np.tan(tilt) * 0.3 < middle < 60 * np.tan(tilt) * 0.7


def test_what_stands_in_between_keeps_the_film_off() -> None:
    corners = [[-50, -50, 30], [0, -50, 30], [0, 50, 30], [-50, 50, 30]]
    screen = np.array([[corners[k] for k in (0, 1, 2)], [corners[k] for k in (0, 2, 3)]], dtype=float)
    scene = build_ray_scene(screen, np.tile([0.0, 0.0, 1.0], (2, 1)), np.zeros(2, np.int64), 100.0)
    points, normals = plate()
    segment = straight([-1.0, 1.0])
    shaded = segment_rates(FORM, segment, points, normals, scene).toarray()[:, 0]
    clear = segment_rates(FORM, segment, points, normals).toarray()[:, 0]
    assert not shaded[(points[:, 0] < -3) & (np.abs(points[:, 1]) < 60)].any()
    assert shaded[points[:, 0] > 3] == pytest.approx(clear[points[:, 0] > 3])


def test_faces_that_look_away_get_nothing() -> None:
    points, normals = plate()
    assert segment_rates(FORM, straight([-5.0, 5.0]), points, -normals).nnz == 0
