import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from small_boards import THICKNESS_MM, board_of
from tiny_session import tiny_session

from geometry.frames import quaternions_from_axes
from programs.playback import build_timeline, play
from recipes.nozzles import AirKnife, FlatFan, FullCone, HollowCone
from webui.layers.paths.nozzle import cone_of, moment, nozzle_body, outlines_of, rotation, spray_rims

BOARD = board_of()
DOWN = np.array([0.0, 1.0, 0.0, 0.0])


def leaning(tilt_deg, heading_deg, up=1.0):
    tilt, heading = np.radians([tilt_deg, heading_deg])
    level = np.array([np.cos(heading), np.sin(heading), 0.0])
    approach = np.sin(tilt) * level - up * np.cos(tilt) * np.array([0, 0, 1.0])
    reference = np.cross(np.cross(approach, [1.0, 0.0, 0.0]), approach)
    reference /= np.linalg.norm(reference)
    return quaternions_from_axes(approach[None], reference[None])[0]


@given(st.integers(0, 10_000))
@settings(max_examples=25)
def test_the_axes_are_those_of_the_quaternion(seed):
    turn = Rotation.random(rng=np.random.default_rng(seed))
    np.testing.assert_allclose(rotation(turn.as_quat(scalar_first=True)), turn.as_matrix().T, atol=1e-12)


def test_a_full_cone_straight_down_wets_a_circle():
    rim, core = spray_rims(FullCone(flow_lpm=1, half_angle_deg=30), BOARD, np.array([10.0, 20.0, 50.0]), DOWN)
    np.testing.assert_allclose(np.linalg.norm(rim[:, :2], axis=1), 50 * np.tan(np.radians(30)))
    assert len(core) == 0
    assert np.ptp(rim[:, 2]) == 0
    assert rim[0, 2] == pytest.approx(-50, abs=0.3)


def test_a_wave_front_lies_inside_the_edge_of_the_spray():
    nozzle = HollowCone(flow_lpm=1, half_angle_deg=30, ring_sigma_deg=3)
    rim, core = spray_rims(nozzle, BOARD, np.array([0.0, 0.0, 40.0]), DOWN)
    assert np.linalg.norm(core[:, :2], axis=1).max() < np.linalg.norm(rim[:, :2], axis=1).min()


def test_a_tilted_jet_wets_where_it_leans():
    rim, _ = spray_rims(FullCone(flow_lpm=1, half_angle_deg=20), BOARD, np.array([0.0, 0.0, 40.0]), leaning(30, 90))
    assert rim[:, 1].max() == pytest.approx(40 * np.tan(np.radians(50)))
    assert rim[:, 1].min() == pytest.approx(40 * np.tan(np.radians(10)))


def test_from_below_the_spray_meets_the_bottom_and_is_no_mirror_image():
    """Every rim point lies on the ray that the tool frame says: azimuth from tool +X towards tool +Y."""
    nozzle = HollowCone(
        flow_lpm=1,
        half_angle_deg=20,
        wavefront={"height_mm": 50, "points": [[0, 10, 20], [90, 15, 30], [200, 12, 25]]},
    )
    for side, up, z in (("top", 1.0, 40.0), ("bottom", -1.0, -THICKNESS_MM - 40.0)):
        quaternion = leaning(15, 25, up)
        rim, _ = spray_rims(nozzle, BOARD, np.array([3.0, 4.0, z]), quaternion)
        tool = rim @ rotation(quaternion).T
        azimuth = np.degrees(np.arctan2(tool[:, 1], tool[:, 0])) % 360
        slope = np.linalg.norm(tool[:, :2], axis=1) / tool[:, 2]
        table = np.array(nozzle.wavefront.points)
        expected = np.interp(azimuth, table[:, 0], table[:, 2], period=360) / 50
        np.testing.assert_allclose(slope, expected, rtol=0.03)
        assert BOARD.surface_z_mm(side) == pytest.approx(z + rim[0, 2], abs=0.3)


def test_a_jet_that_misses_the_board_shows_nothing_and_a_grazing_one_ends_somewhere():
    wide = FullCone(flow_lpm=1, half_angle_deg=60)
    assert len(spray_rims(wide, BOARD, np.array([0.0, 0.0, -5.0]), DOWN)[0]) == 0
    rim, _ = spray_rims(wide, BOARD, np.array([0.0, 0.0, 20.0]), leaning(60, 0))
    assert np.linalg.norm(rim[:, :2], axis=1).max() == pytest.approx(6 * 20)


@pytest.mark.parametrize("nozzle", [FlatFan(flow_lpm=1, half_angle_deg=40), AirKnife(flow_lpm=400, width_mm=80)])
def test_flat_patterns_lie_along_the_reference(nozzle):
    rim, _ = spray_rims(nozzle, BOARD, np.array([0.0, 0.0, 30.0]), DOWN)
    assert np.ptp(rim[:, 0]) > 5 * np.ptp(rim[:, 1])


def test_what_is_drawn_is_what_the_playback_says():
    session = tiny_session()
    timeline = build_timeline(session.run.program)
    for now_s in np.linspace(-1, session.run.program.totals.duration_s + 1, 60):
        shown, state = moment(timeline, session.recipe, session.board, now_s), play(timeline, np.array([now_s]))
        np.testing.assert_array_equal(shown.tcp, state.tcp[0])
        assert (len(shown.rim) > 0) == bool(state.spraying[0])
        assert shown.function == state.functions[state.function[0]]


def signed_volume(points, faces):
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6


def test_the_body_is_closed_faces_outwards_and_ends_at_the_orifice():
    points, faces = nozzle_body()
    assert points[:, 2].max() == 0.0
    assert signed_volume(points, faces) > 0
    moved = points + np.array([5.0, -3.0, 7.0])
    assert signed_volume(moved, faces) == pytest.approx(signed_volume(points, faces))


def test_cone_and_outline_go_around_the_rim():
    rim = np.array([[1.0, 0, -1], [0, 1.0, -1], [-1.0, 0, -1]])
    points, faces = cone_of(rim)
    assert faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 3, 1]]
    np.testing.assert_array_equal(points[0], 0)
    assert outlines_of(rim, np.empty((0, 3))).shape == (3, 2, 3)
    assert outlines_of().shape == (0, 2, 3)
