"""Poses in the plane, arcs about a centre, and repetitions: what every layout format builds its placements from."""

import math
from pathlib import Path

import numpy as np
import pytest
from shapely import box

from boards.board import Pad
from boards.errors import BoardError, Line
from boards.formats.layout import THICKNESS_MM, first_thickness
from boards.formats.loops import arc_about, circle
from boards.formats.placed import Pose, StepPanel, StepPlace, TurnConvention, fit_convention

QUARTER = math.pi / 2.0
START, CENTRE = np.array([3.0, 1.0]), np.array([1.0, 1.0])


@pytest.mark.parametrize(
    ("pose", "place"),
    [
        (Pose(10.0, 5.0, 0.0), (12.0, 6.0)),
        (Pose(10.0, 5.0, QUARTER), (9.0, 7.0)),
        (Pose(10.0, 5.0, -QUARTER), (11.0, 3.0)),
        (Pose(10.0, 5.0, 0.0, is_mirrored=True), (8.0, 6.0)),
        (Pose(10.0, 5.0, QUARTER, is_mirrored=True), (9.0, 3.0)),
    ],
)
def test_a_pose_mirrors_then_turns_then_moves(pose: Pose, place: tuple[float, float]) -> None:
    np.testing.assert_allclose(pose.place(np.array([2.0, 1.0])), place, atol=1e-12)
    np.testing.assert_allclose(pose.place(np.array([[0.0, 0.0], [2.0, 1.0]])), [(10.0, 5.0), place], atol=1e-12)
    corner = np.asarray(pose.place_outline(box(0.0, 0.0, 2.0, 1.0)).exterior.coords)
    assert np.hypot(*(corner - place).T).min() < 1e-12
    np.testing.assert_allclose(np.mean(pose.rectangle(4.0, 2.0), axis=0), (10.0, 5.0), atol=1e-12)
    assert np.hypot(*(pose.rectangle(4.0, 2.0) - place).T).min() < 1e-12
    along = pose.place(np.array([math.cos(0.3), math.sin(0.3)])) - pose.place(np.zeros(2))
    assert pose.turn(0.3) % math.pi == pytest.approx(math.atan2(along[1], along[0]) % math.pi)


@pytest.mark.parametrize("clockwise", [False, True])
def test_an_arc_about_a_centre_goes_the_way_it_is_told(clockwise: bool) -> None:
    points = arc_about(START, np.array([1.0, 3.0]), CENTRE, clockwise=clockwise)
    assert points is not None
    np.testing.assert_allclose(np.hypot(*(points - CENTRE).T), 2.0)
    np.testing.assert_array_equal(points[[0, -1]], [START, [1.0, 3.0]])
    length = np.hypot(*np.diff(points, axis=0).T).sum()
    assert length == pytest.approx(math.pi * (3.0 if clockwise else 1.0), rel=5e-3)


@pytest.mark.parametrize("clockwise", [False, True])
def test_an_arc_that_ends_where_it_begins_is_a_full_circle(clockwise: bool) -> None:
    points = arc_about(START, START, CENTRE, clockwise=clockwise)
    assert points is not None
    turned = np.cross(points[0] - CENTRE, points[1] - CENTRE)
    assert (float(turned) < 0.0) is clockwise
    assert np.hypot(*np.diff(points, axis=0).T).sum() == pytest.approx(4.0 * math.pi, rel=5e-3)


@pytest.mark.parametrize(("end", "is_one"), [((1.0, 3.05), True), ((1.0, 3.2), False)])
def test_ends_may_differ_a_little_in_their_radius(end: tuple[float, float], is_one: bool) -> None:
    assert (arc_about(START, np.array(end), CENTRE, clockwise=False) is not None) is is_one


def test_a_circle_is_an_open_ring_from_its_right() -> None:
    ring = circle(CENTRE, 2.0)
    np.testing.assert_allclose(ring[0], START)
    np.testing.assert_allclose(np.hypot(*(ring - CENTRE).T), 2.0)
    assert np.hypot(*(ring[-1] - ring[0])) > 0.1


def test_a_grid_of_boards_goes_row_by_row() -> None:
    first, where = StepPlace(1.0, 2.0, QUARTER, True), Line(Path("b"), 7)
    places = StepPanel.grid((3, 2), first, (10.0, 20.0), where)
    assert [(each.x_mm, each.y_mm) for each in places] == [(1, 2), (11, 2), (21, 2), (1, 22), (11, 22), (21, 22)]
    assert all((each.turn_rad, each.is_turned_over) == (QUARTER, True) for each in places)
    assert len(StepPanel.grid((40, 25), first, (1.0, 1.0), where)) == 1000
    with pytest.raises(BoardError, match="b:7: a panel of more than 1000 boards"):
        StepPanel.grid((1001, 1), first, (1.0, 1.0), where)


@pytest.mark.parametrize(
    ("stated", "taken"),
    [([], THICKNESS_MM), ([0.0, 0.8], 0.8), ([0.8, 2.0], 0.8), ([10.0], 10.0), ([10.1], 1.6), ([math.nan, 0.1], 0.1)],
)
def test_the_first_thickness_that_a_board_can_have_counts(stated: list[float], taken: float) -> None:
    assert first_thickness(stated) == taken


@pytest.mark.parametrize("is_mirrored", [False, True])
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("quarters", [0, 1, 3])
def test_the_convention_is_the_one_under_which_pins_lie_on_their_copper(
    is_mirrored: bool, sign: float, quarters: int
) -> None:
    true = TurnConvention(is_mirrored, sign, quarters)
    pads = [Pad(2.0, 1.0, 1.0, 1.0), Pad(-3.0, 0.5, 1.0, 1.0)]
    found = [
        (pad, true.pose(np.zeros(2), turn).place(np.array([pad.x_mm, pad.y_mm])), turn)
        for turn in (0.3, 1.9)
        for pad in pads
    ]
    taken = fit_convention(found, TurnConvention(is_mirrored=False, sign=1.0, quarters=2))
    for turn in (0.3, 1.9):
        np.testing.assert_allclose(taken.pose(np.zeros(2), turn).matrix(), true.pose(np.zeros(2), turn).matrix())


def test_without_pins_the_usual_convention_is_taken() -> None:
    usual = TurnConvention(is_mirrored=True, sign=-1.0, quarters=2)
    assert fit_convention([], usual) is usual
