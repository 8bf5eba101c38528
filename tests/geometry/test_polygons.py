"""Shadows, gaps and the order of points."""

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from shapely import MultiPolygon, Polygon, box
from shapely.affinity import rotate
from shapely.geometry.polygon import orient

from geometry.gridframe import GridFrame, find_grid_frame
from geometry.polygons import (
    canonical,
    close_gaps,
    drop_collinear,
    fill_holes,
    fill_notches,
    join_pieces,
    polygons_of,
    project,
    signed_area,
    simplify_within,
    to_grid,
    without_gaps,
)

CUBE_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
CUBE_FACES = [(0, 2, 6, 4), (1, 5, 7, 3), (0, 4, 5, 1), (2, 3, 7, 6), (0, 1, 3, 2), (4, 6, 7, 5)]


def cuboid(x0: float, y0: float, x1: float, y1: float, z1: float = 1.0) -> np.ndarray:
    """Twelve triangles, outward."""
    corners = CUBE_CORNERS * (x1 - x0, y1 - y0, z1) + (x0, y0, 0)
    faces = [corners[list(part)] for a, b, c, d in CUBE_FACES for part in ((a, b, c), (a, c, d))]
    return np.array(faces)


def turned(polygon: Polygon, angle: float, shift: tuple[float, float]) -> Polygon:
    return shapely.transform(polygon, lambda points: points @ turn(angle).T + shift)


def turn(angle: float) -> np.ndarray:
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def test_the_shadow_of_a_box_is_its_plan() -> None:
    shadow = project(cuboid(1, 2, 5, 4))
    assert shadow.symmetric_difference(box(1, 2, 5, 4)).area < 1e-6


def test_the_shadow_does_not_ask_how_triangles_are_wound_or_whether_they_close() -> None:
    patches = cuboid(0, 0, 4, 3)
    mixed = patches.copy()
    mixed[::2] = mixed[::2, ::-1]
    open_mesh = patches[patches[:, :, 2].min(axis=1) > 0.5]
    for some in (mixed, open_mesh, np.concatenate([patches, patches + 1e-7])):
        assert project(some).symmetric_difference(box(0, 0, 4, 3)).area < 1e-4


def test_a_hole_through_a_ring_of_boxes_stays_open() -> None:
    ring = np.concatenate([cuboid(0, 0, 10, 2), cuboid(0, 8, 10, 10), cuboid(0, 2, 2, 8), cuboid(8, 2, 10, 8)])
    shadow = project(ring)
    assert shadow.area == pytest.approx(100 - 36)
    assert len(polygons_of(shadow)[0].interiors) == 1


def test_separate_boxes_have_separate_shadows() -> None:
    shadow = project(np.concatenate([cuboid(0, 0, 1, 1), cuboid(3, 0, 4, 1)]))
    assert isinstance(shadow, MultiPolygon)
    assert shadow.area == pytest.approx(2.0)


def test_upright_triangles_have_no_shadow() -> None:
    assert project(np.array([[[0, 0, 0], [5, 0, 0], [5, 0, 5]]], float)).is_empty


@settings(max_examples=40)
@given(st.lists(st.tuples(*[st.integers(0, 30)] * 2, *[st.integers(1, 9)] * 2), min_size=1, max_size=12))
def test_the_shadow_is_the_union(boxes: list[tuple[int, int, int, int]]) -> None:
    shadow = project(np.concatenate([cuboid(x, y, x + w, y + h) for x, y, w, h in boxes]))
    union = shapely.union_all([box(x, y, x + w, y + h) for x, y, w, h in boxes])
    assert shadow.is_valid
    assert shadow.symmetric_difference(union).area < 1e-6


def test_gaps_between_pins_close_and_corners_stay() -> None:
    pins = shapely.union_all([box(0, 0, 10, 5), *(box(x, 5, x + 0.4, 6) for x in np.arange(0, 10, 1.2))])
    closed = close_gaps(pins, 2.0)
    assert closed.symmetric_difference(box(0, 0, 10, 6)).area < 1e-3
    square = box(0, 0, 10, 5)
    assert close_gaps(square, 2.0).symmetric_difference(square).area < 1e-3
    assert len(drop_collinear(polygons_of(close_gaps(square, 2.0))[0]).exterior.coords) == 5


def test_gaps_that_are_wide_enough_stay_open() -> None:
    two = box(0, 0, 1, 1).union(box(3.1, 0, 4, 1))
    assert len(polygons_of(close_gaps(two, 2.0))) == 2


@pytest.mark.slow
@settings(max_examples=40)
@given(st.lists(st.tuples(*[st.integers(0, 60)] * 2, *[st.integers(1, 20)] * 2), min_size=1, max_size=10))
def test_closing_gaps_only_adds(boxes: list[tuple[int, int, int, int]]) -> None:
    union = shapely.union_all([box(x / 4, y / 4, (x + w) / 4, (y + h) / 4) for x, y, w, h in boxes])
    closed = close_gaps(union, 2.0)
    assert union.difference(closed).area < 1e-3
    assert closed.difference(union.buffer(1.5, join_style="mitre")).area < 1e-3
    joined = join_pieces(union)
    assert isinstance(joined, Polygon)
    assert union.difference(joined).area < 1e-3
    assert joined.difference(union.convex_hull).area < 1e-3


def test_far_pieces_become_their_hull() -> None:
    assert join_pieces(box(0, 0, 1, 1).union(box(20, 0, 21, 1))).area == pytest.approx(21.0)


def test_holes_are_filled() -> None:
    frame = box(0, 0, 10, 10).difference(box(2, 2, 8, 8))
    assert fill_holes(frame).equals(box(0, 0, 10, 10))


SHAPE = Polygon(
    [(0, 0), (9, 0), (9, 6), (4, 6), (4, 9), (0, 9)],
    [[(1, 1), (2, 1), (2, 2)], [(6, 1), (7, 1), (7, 2)], [(1, 6), (2, 6), (2, 7)]],
)
ANCHORS = np.array([(4, 6), (4, 6), (9, 0), (0, 0)], float)


@settings(max_examples=60)
@given(st.floats(-4, 4), st.integers(0, 5), st.booleans(), st.permutations(range(3)))
def test_the_order_of_points_moves_with_the_shape(angle: float, roll: int, turn_round: bool, holes: list[int]) -> None:
    points = np.roll(np.asarray(SHAPE.exterior.coords)[:-1], roll, axis=0)
    rings = [np.asarray(SHAPE.interiors[hole].coords)[:-1] for hole in holes]
    same = Polygon(points[::-1] if turn_round else points, rings)
    moved = canonical(turned(same, angle, (100.3, -7.7)), ANCHORS @ turn(angle).T + (100.3, -7.7))
    np.testing.assert_allclose(
        shapely.get_coordinates(moved), shapely.get_coordinates(turned(canonical(SHAPE, ANCHORS), angle, (100.3, -7.7)))
    )


def test_rings_begin_at_the_anchor_and_turn_as_promised() -> None:
    shape = canonical(SHAPE, ANCHORS)
    assert shape.exterior.coords[0] == (4.0, 6.0)
    assert signed_area(np.asarray(shape.exterior.coords)) > 0
    assert all(signed_area(np.asarray(hole.coords)) < 0 for hole in shape.interiors)
    assert shape.equals(SHAPE)


def test_a_tie_is_broken_by_the_next_anchor() -> None:
    square = box(-1, -1, 1, 1)
    assert canonical(square, np.array([(0, 0), (5, 4)], float)).exterior.coords[0] == (1.0, 1.0)
    assert canonical(square, np.array([(0, 0), (-5, 4)], float)).exterior.coords[0] == (-1.0, 1.0)


@settings(max_examples=40)
@given(st.integers(8, 200), st.floats(0.3, 30), st.floats(0.01, 0.2))
def test_a_simplified_circle_stays_within_the_tolerance(count: int, radius: float, tolerance: float) -> None:
    turns = np.linspace(0, 2 * np.pi, count, endpoint=False)
    circle = Polygon(radius * np.column_stack((np.cos(turns), np.sin(turns))))
    simple = simplify_within(circle, tolerance)
    assert simple.exterior.hausdorff_distance(circle.exterior) <= tolerance + 1e-9
    assert len(simple.exterior.coords) <= len(circle.exterior.coords)


def test_points_on_a_straight_line_are_dropped_wherever_the_ring_begins() -> None:
    square = Polygon([(5, 0), (10, 0), (10, 10), (0, 10), (0, 3), (0, 0)])
    assert len(drop_collinear(square).exterior.coords) == 5


def test_a_decimal_number_and_its_neighbours_are_the_same_point_of_the_grid() -> None:
    typed = np.round(np.random.default_rng(3).uniform(-300, 300, 5000), 4)
    for noisy in (np.nextafter(typed, 1e9), np.nextafter(typed, -1e9), typed + 1e-12):
        np.testing.assert_array_equal(to_grid(noisy), to_grid(typed))


@settings(max_examples=40)
@given(st.floats(-4, 4), st.tuples(st.floats(-500, 500), st.floats(-500, 500)))
def test_a_grid_frame_sees_the_same_numbers_in_every_pose(angle: float, shift: tuple[float, float]) -> None:
    face = cuboid(0, 0, 30.1, 20.3)[2:4]
    moved = face.copy()
    moved[:, :, :2] = moved[:, :, :2] @ turn(angle).T + shift
    one, other = find_grid_frame(face), find_grid_frame(moved)
    np.testing.assert_array_equal(one.triangles_to_frame(face), other.triangles_to_frame(moved))


def test_a_polygon_comes_back_on_the_very_vertices_of_the_mesh() -> None:
    patches = cuboid(1 / 3, np.pi, 7 / 3, 9.1)
    frame = GridFrame((1 / 7, 2 / 7), (0.6, 0.8))
    framed = frame.triangles_to_frame(patches)
    shadow = polygons_of(project(framed))[0]
    vertices = patches[:, :, :2].reshape(-1, 2)
    (back,) = frame.polygons_from_frame([shadow], framed[:, :, :2].reshape(-1, 2), vertices)
    assert {tuple(point) for point in back.exterior.coords} == {tuple(point) for point in vertices}


def zigzag(depth, teeth=6, pitch=3.0):
    """A box whose upper edge is a row of teeth."""
    tips = [(pitch * (index + 0.5) / 1.0, 10.0) for index in range(teeth)][::-1]
    valleys = [(x - pitch / 2, 10.0 - depth) for x, _ in tips][:-1]
    edge = [point for pair in zip(tips, [*valleys, None], strict=True) for point in pair if point is not None]
    return Polygon([(0, 0), (pitch * teeth, 0), (pitch * teeth, 10), *edge, (0, 10)])


def test_teeth_shallower_than_the_depth_become_a_straight_edge():
    filled = fill_notches(zigzag(1.4), 1.5)
    assert filled.equals(box(0, 0, 18, 10))
    assert fill_notches(zigzag(1.6), 1.5).equals(zigzag(1.6))


def test_filling_notches_only_adds_and_keeps_convex_corners():
    steps = Polygon([(0, 0), (10, 0), (10, 4), (9.6, 4), (9.6, 4.5), (5, 4.5), (5, 9), (0, 9)])
    filled = fill_notches(steps, 0.5)
    assert filled.covers(steps)
    assert len(filled.exterior.coords) < len(steps.exterior.coords)
    assert (5, 4.5) in filled.exterior.coords  # this corner is a real one
    assert filled.convex_hull.equals(steps.convex_hull)


@given(seed=st.integers(0, 10_000), depth=st.floats(0.01, 3.0))
@settings(max_examples=40)
def test_a_filled_ring_covers_what_it_was_and_stays_a_polygon(seed, depth):
    rng = np.random.default_rng(seed)
    angles = np.sort(rng.uniform(0, 2 * np.pi, 14))
    star = Polygon(np.column_stack([np.cos(angles), np.sin(angles)]) * rng.uniform(3, 8, (14, 1)))
    if not star.is_valid:
        return
    filled = fill_notches(star, depth)
    assert filled.is_valid
    assert filled.buffer(1e-6).covers(star)
    assert fill_notches(filled, depth).equals(filled)


SIMPLE_MM = 0.049


def simplified_without_gaps(polygon: Polygon, anchors) -> Polygon:
    (closed,) = polygons_of(close_gaps(polygon, 2.0))
    return simplify_within(canonical(drop_collinear(Polygon(closed.exterior)), anchors), SIMPLE_MM)


@given(
    angles=st.lists(st.floats(0.0, 2 * np.pi), min_size=3, max_size=9, unique=True),
    size=st.floats(0.2, 20.0),
    dent=st.floats(0.0, 1.0),
)
@settings(max_examples=60)
def test_where_there_is_no_gap_the_short_way_gives_the_same_shape(angles, size: float, dent: float) -> None:
    ring = to_grid(size * np.column_stack([np.cos(sorted(angles)), np.sin(sorted(angles))]) + 3.0)
    ring[0] = to_grid(ring[0] + dent * (ring.mean(axis=0) - ring[0]))  # some are not convex then
    shape = Polygon(ring)
    assume(shape.is_valid and shape.area > 1e-3)
    polygon = simplify_within(canonical(drop_collinear(shape), ring), SIMPLE_MM)
    short = without_gaps(polygon, SIMPLE_MM)
    if short is not None:  # the long way leaves a point within a straight edge now and then
        long = simplified_without_gaps(polygon, ring)
        assert canonical(short, ring).wkb == long.wkb or drop_collinear(long).symmetric_difference(short).area < 1e-4


def test_rectangles_take_the_short_way_and_what_may_have_a_gap_does_not() -> None:
    turned = rotate(box(0.0, 0.0, 1.0, 0.5), 30.0)
    for each in (orient(box(0.0, 0.0, 1.0, 0.5)), orient(turned)):
        short = without_gaps(each, SIMPLE_MM)
        assert short is not None
        ring = np.asarray(each.exterior.coords)[:-1]
        assert canonical(short, ring).wkb == simplified_without_gaps(each, ring).wkb
    angled = Polygon([(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)])
    bent = Polygon([(0, 0), (2, -0.02), (4, 0), (4, 2), (0, 2)])
    ringed = Polygon(box(0, 0, 9, 9).exterior, [box(2, 2, 3, 3).exterior])
    assert [without_gaps(orient(each), SIMPLE_MM) for each in (angled, bent, ringed)] == [None] * 3
