"""A smooth height through a sheet, continued beyond its rim; geodesics on it are as far apart as is asked."""

from itertools import pairwise

import numpy as np
import pytest
from curved_parts import grid

from geometry.rays import build_ray_scene
from geometry.solids.sections import surface_mesh
from geometry.solids.sheet_field import geodesic_net, is_sheet, plane_net, sheet_field

UP = np.array([0.0, 1.0, 0.0])
RADIUS = 200.0


def field_over(place, x=(0.0, 120.0), y=(0.0, 80.0), step=4.0, keep=None):
    u, v = (np.linspace(*each, round((each[1] - each[0]) / step) + 1) for each in (x, y))
    patches = grid(place, u, v)
    if keep is not None:
        patches = patches[keep(patches.mean(axis=1))]
    mesh = surface_mesh(patches)
    assert is_sheet(mesh)
    triangles = mesh.points[mesh.corners]
    scene = build_ray_scene(triangles, mesh.facing, np.zeros(len(triangles), dtype=np.int64), np.inf)
    return sheet_field(mesh, scene, UP, 60.0, 4.0)


def plane(x, y):
    return np.column_stack([x, y, 0.3 * x - 0.2 * y])


def barrel(x, y):
    """A piece of a cylinder whose axis is along x."""
    angle = (y - 40.0) / RADIUS
    return np.column_stack([x, 40.0 + RADIUS * np.sin(angle), RADIUS * np.cos(angle)])


def test_a_plane_goes_on_as_a_plane_past_its_rim_and_over_a_hole() -> None:
    field = field_over(plane, keep=lambda middles: np.hypot(middles[:, 0] - 60, middles[:, 1] - 40) > 15)
    points, normals = field.lift(np.array([[0.0, 0.0], [-95.0, 70.0], [60.0, -70.0]]))
    np.testing.assert_allclose(points[:, 2], 0.3 * points[:, 0] - 0.2 * points[:, 1], atol=1e-3)
    np.testing.assert_allclose(normals, np.tile(np.array([-0.3, 0.2, 1.0]) / np.sqrt(1.13), (3, 1)), atol=1e-4)


@pytest.mark.parametrize("lay", [geodesic_net, plane_net])
def test_curves_over_a_cylinder_are_as_far_apart_over_the_surface_as_asked(lay) -> None:
    net = lay(field_over(barrel), 4.0)
    curves = [net.curve(aside, 20.0, 10.0, 4.0)[0].points for aside in (-30.0, 0.0, 30.0)]
    inner = [each[(each[:, 0] > 0) & (each[:, 0] < 120)] for each in curves]
    angles = [np.arctan2(each[:, 1] - 40.0, each[:, 2]) * RADIUS for each in inner]
    for one, other in pairwise(angles):
        np.testing.assert_allclose(abs(other.mean() - one.mean()), 30.0, atol=0.05)
    for each in angles:
        assert np.ptp(each) < 0.05
    assert np.ptp(curves[1][:, 0]) == pytest.approx(160.0, abs=4.0)


def test_what_turns_out_of_sight_is_no_sheet() -> None:
    angles = np.linspace(0, 2 * np.pi, 33)
    tube = grid(lambda a, z: np.column_stack([np.cos(a), np.sin(a), z]) * 20, angles, np.linspace(0, 3, 7))
    assert not is_sheet(surface_mesh(tube))


def test_geodesics_over_a_cap_that_run_together_are_crowded() -> None:
    def ball(x, y):
        z = np.sqrt(np.maximum(80.0**2 - (x - 60) ** 2 - (y - 60) ** 2, 0.0))
        return np.column_stack([x, y, z])

    assert not geodesic_net(field_over(barrel), 4.0).is_crowded
    gentle = field_over(ball, (20.0, 100.0), (20.0, 100.0))
    assert not geodesic_net(gentle, 4.0).is_crowded
