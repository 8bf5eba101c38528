"""Geodesics and distances beside what is exact: developed cylinders, great circles, and a torus by its equations."""

import numpy as np
import pytest
import shapely
import trimesh
from curved_parts import TORUS_MM, grid, on_torus, tube, wave, wavy_sheet
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.spatial import KDTree

from geometry.solids.geodesics import Geodesics
from geometry.solids.sections import connected_pieces, length_of, level_below, share_above, surface_mesh

RADIUS_MM = 60.0
EXACT = 0.002


def nearest(mesh, place) -> int:
    return int(np.argmin(np.linalg.norm(mesh.points - place, axis=1)))


def length(points) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


@pytest.mark.parametrize("turn_deg", [0, 35, 75, 120])
def test_on_a_bent_sheet_the_start_is_as_long_as_the_straight_line_of_the_flat_one(turn_deg) -> None:
    mesh = surface_mesh(tube(RADIUS_MM, 200.0, 40, 30, turn=np.pi / 2))
    turn = np.radians(turn_deg)
    across = np.array([-1.0, 1.0, 0.0]) / np.sqrt(2)
    found = Geodesics(mesh).halve(np.cos(turn) * across + np.sin(turn) * np.array([0.0, 0.0, 1.0]))
    assert found is not None
    (line,) = found.lines
    flat = np.column_stack([RADIUS_MM * np.arctan2(line.points[:, 1], line.points[:, 0]), line.points[:, 2]])
    assert length_of(line) == pytest.approx(np.linalg.norm(flat[-1] - flat[0]), rel=EXACT)
    along = (flat[-1] - flat[0]) / np.linalg.norm(flat[-1] - flat[0])
    beside = (flat - flat[0]) @ np.array([-along[1], along[0]])
    assert np.abs(beside).max() < 0.3
    # The flat sheet is a rectangle: what lies left of a line through it is a polygon.
    rectangle = shapely.box(0, 0, RADIUS_MM * np.pi / 2, 200.0)
    far = 1e3 * np.array([-along[1], along[0]])
    side = shapely.Polygon([flat[0] - 1e3 * along, flat[-1] + 1e3 * along, flat[-1] + far, flat[0] + far])
    share = rectangle.intersection(shapely.MultiPoint(side.exterior.coords).convex_hull).area / rectangle.area
    assert min(abs(share - found.share), abs(1 - share - found.share)) < 0.005
    assert abs(share - 0.5) < 0.02
    places = np.column_stack([RADIUS_MM * np.arctan2(mesh.points[:, 1], mesh.points[:, 0]), mesh.points[:, 2]])
    inside = np.abs((places - (flat[0] + flat[-1]) / 2) @ along) < 0.5 * length_of(line)
    exact = (places - flat[0]) @ np.array([-along[1], along[0]])
    off = np.abs(np.abs(found.distances) - np.abs(exact))[inside]
    assert np.median(off) < 0.02
    assert off.max() < 0.8


def test_a_ball_is_halved_by_a_great_circle() -> None:
    ball = trimesh.creation.icosphere(subdivisions=4, radius=RADIUS_MM)
    mesh = surface_mesh(np.asarray(ball.triangles))
    found = Geodesics(mesh).halve(np.array([0.36, 0.48, 0.8]))
    assert found is not None
    (line,) = found.lines
    assert line.closed
    assert length_of(line) == pytest.approx(2 * np.pi * RADIUS_MM, rel=EXACT)
    middle = line.points.mean(axis=0)
    normal = np.linalg.svd(line.points - middle)[2][2]
    assert np.abs((line.points - middle) @ normal).max() < 0.02 * RADIUS_MM
    assert abs(found.share - 0.5) < 0.02
    exact = RADIUS_MM * np.arcsin(np.clip(mesh.points @ normal / RADIUS_MM, -1, 1))
    assert np.abs(np.abs(found.distances) - np.abs(exact)).max() < 2.0


def torus_geodesic(start, end) -> float:
    """Length of the geodesic between two places (u, v), by shooting with the equations of a surface of revolution."""
    wide, thin = TORUS_MM

    def slope(_, state):
        _, v, du, dv = state
        away = wide + thin * np.cos(v)
        return [du, dv, 2 * thin * np.sin(v) / away * du * dv, -away * np.sin(v) / thin * du**2]

    def shot(angle):
        away = wide + thin * np.cos(start[1])
        first = [*start, np.cos(angle) / away, np.sin(angle) / thin]
        reached = lambda _, state: state[0] - end[0]  # noqa: E731
        reached.terminal = True
        return solve_ivp(slope, (0, 500), first, events=reached, rtol=1e-9, atol=1e-9)

    angle = brentq(lambda each: shot(each).y[1, -1] - end[1], 0.0, 0.9, xtol=1e-9)
    return float(shot(angle).t[-1])


def test_on_a_torus_a_geodesic_is_as_long_as_its_equations_give() -> None:
    u, v = np.linspace(0, 1.2, 61), np.linspace(-0.4, 0.9, 31)
    mesh = surface_mesh(grid(on_torus, u, v))
    start, end = (u[5], v[4]), (u[55], v[22])
    ends = [nearest(mesh, on_torus(*(np.array([each]) for each in place))[0]) for place in (start, end)]
    found = Geodesics(mesh).straighten(np.array(ends))
    assert found is not None
    assert length(found) == pytest.approx(torus_geodesic(start, end), rel=EXACT)


def test_a_tube_is_halved_by_a_ring_or_by_two_lines_along_it() -> None:
    mesh = surface_mesh(tube(RADIUS_MM, 200.0, 90, 40))
    geodesics = Geodesics(mesh)
    ring, lines = geodesics.halve(np.array([0.0, 0.0, 1.0])), geodesics.halve(np.array([0.0, 1.0, 0.0]))
    assert ring is not None
    assert lines is not None
    assert [line.closed for line in ring.lines] == [True]
    assert length_of(ring.lines[0]) == pytest.approx(2 * np.pi * RADIUS_MM, rel=EXACT)
    np.testing.assert_allclose(ring.distances, mesh.points[:, 2] - ring.lines[0].points[0, 2], atol=0.1)
    assert [line.closed for line in lines.lines] == [False, False]
    for found in (ring, lines):
        assert abs(found.share - 0.5) < 0.02
    assert lines.distances.max() == pytest.approx(np.pi * RADIUS_MM / 2, rel=0.03)


def test_a_wavy_sheet_is_halved_by_an_independent_count() -> None:
    mesh = surface_mesh(wavy_sheet())
    found = Geodesics(mesh).halve(np.array([0.6, 0.8, 0.0]))
    assert found is not None
    (line,) = found.lines
    x, y = (each.ravel() for each in np.meshgrid(np.arange(1, 400, 2.0), np.arange(1, 500, 2.0)))
    step = 1e-3
    area = np.sqrt(1 + ((wave(x + step, y) - wave(x, y)) / step) ** 2 + ((wave(x, y + step) - wave(x, y)) / step) ** 2)
    way = line.points[:, :2]
    out = np.array([1.0, -0.75]) * 1e4
    begin, end = (way[0], way[-1]) if way[0, 0] > way[-1, 0] else (way[-1], way[0])
    chain = way if way[0, 0] > way[-1, 0] else way[::-1]
    above = shapely.Polygon([*chain, end - out, end - out + [1e4, 1e4], begin + out + [1e4, 1e4], begin + out])
    share = area[shapely.contains_xy(above, x, y)].sum() / area.sum()
    assert share == pytest.approx(found.share, abs=0.003)
    assert abs(share - 0.5) < 0.02


def test_pinched_corners_are_two_and_pieces_apart_are_found() -> None:
    triangle = np.array([[[0.0, 0, 0], [1, 0, 0], [1, 1, 0]]])
    pinched = surface_mesh(np.concatenate([triangle, triangle[:, ::-1] * [-1, 1, 1]]))
    assert len(pinched.points) == 6
    assert [len(piece.corners) for piece in connected_pieces(pinched)] == [1, 1]
    whole = surface_mesh(tube(5.0, 10.0, 12, 4), longest_mm=1.0)
    assert len(connected_pieces(whole)) == 1
    assert len(KDTree(whole.points).query_pairs(1e-6)) == 0
    assert share_above(whole, whole.points[:, 2], 2.5) == pytest.approx(0.75)
    slanted = whole.points @ [0.3, -0.5, 0.8]
    for share in (0.03, 0.4, 0.9):
        assert share_above(whole, slanted, level_below(whole, slanted, share)) == pytest.approx(share)


def test_the_share_of_a_triangle_above_a_level_is_that_of_a_polygon() -> None:
    one = surface_mesh(np.array([[[0.0, 0, 0], [6, 0, 0], [1, 5, 0]]]))
    values = one.points[:, 0] - 0.7 * one.points[:, 1]
    for level in (-4.0, -2.5, -1.0, 0.0, 2.0, 5.9, 6.0, 7.0):
        ends = [((level + 0.7 * y), y) for y in (-99.0, 99.0)]
        right = shapely.Polygon([*ends, (999, 99), (999, -99)])
        exact = shapely.Polygon(one.points[:, :2]).intersection(right).area / 15.0
        assert share_above(one, values, level) == pytest.approx(exact, abs=1e-12)
