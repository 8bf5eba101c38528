"""A prism is a closed mesh, whatever its outline."""

import math

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import MultiPolygon, Point, Polygon, box

from boards.formats.prism import prism


def as_mesh(patches: np.ndarray) -> trimesh.Trimesh:
    mesh = trimesh.Trimesh(patches.reshape(-1, 3), np.arange(patches.shape[0] * 3).reshape(-1, 3), process=False)
    mesh.merge_vertices()
    return mesh


def test_holes_go_through_and_normals_point_out() -> None:
    outline = box(0, 0, 30, 20).difference(Point(8, 8).buffer(3)).difference(box(20, 5, 25, 15))
    assert isinstance(outline, Polygon)
    patches, normals, surfaces = prism(outline, 0.5, 2.1)
    mesh = as_mesh(patches)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(outline.area * 1.6, rel=1e-3)
    np.testing.assert_allclose(mesh.face_normals, normals, atol=1e-6)
    assert sum(surface.patches for surface in surfaces) == len(patches)
    top = patches[: surfaces[0].patches]
    assert np.all(top[:, :, 2] == 2.1)


def test_two_pieces_are_two_closed_meshes() -> None:
    patches, _, _ = prism(MultiPolygon([box(0, 0, 1, 1), box(2, 0, 4, 1)]), 0.0, 1.0)
    mesh = as_mesh(patches)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(3.0)
    assert mesh.body_count == 2


def test_what_is_thinner_than_a_micrometre_is_the_box_around_it() -> None:
    sliver = Polygon([(0, 0), (5, 0), (5, 0.0004), (0, 0.0004)])
    patches, normals, _ = prism(sliver, 0.0, 1.6)
    mesh = as_mesh(patches)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(5.002 * 0.0024 * 1.6, rel=1e-6)
    assert np.isfinite(normals).all()


def test_points_on_a_straight_edge_make_no_thin_patches() -> None:
    ring = [(x / 10, 0.0) for x in range(100)] + [(10.0, 0.0), (10.0, 5.0), (0.0, 5.0)]
    patches, _, _ = prism(Polygon(ring), 0.0, 1.0)
    edges = np.cross(patches[:, 1] - patches[:, 0], patches[:, 2] - patches[:, 0])
    assert np.linalg.norm(edges, axis=1).min() > 0.01
    assert len(patches) == 12


@given(corners=st.integers(3, 40), radius=st.floats(0.2, 200.0), height=st.floats(0.05, 40.0), dents=st.integers(0, 5))
@settings(max_examples=40)
def test_volume_is_area_times_height(corners: int, radius: float, height: float, dents: int) -> None:
    turn = np.linspace(0.0, 2.0 * math.pi, corners, endpoint=False)
    reach = radius * (1.0 + 0.4 * np.cos(dents * turn))
    outline = Polygon(np.column_stack([reach * np.cos(turn), reach * np.sin(turn)]))
    patches, _, _ = prism(outline, -height, 0.0)
    mesh = as_mesh(patches)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(outline.area * height, rel=0.02)
