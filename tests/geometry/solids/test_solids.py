"""Meshes as solids: what is sound, how near a rod comes, where planes cut, what a cone sees."""

import numpy as np
import pytest
from scipy.spatial import KDTree
from small_parts import block, cylinder

from geometry.mesh import areas_and_normals
from geometry.rays import build_ray_scene
from geometry.solids.cone_view import Cone, Stretch, cells_in_view, cut_cells
from geometry.solids.regions import find_regions
from geometry.solids.sections import cut_section, length_of, resample, section_lengths, surface_mesh
from geometry.solids.soundness import count_crossings, find_edges, outward
from geometry.solids.tree import build_tree, capsule_hits, winding_numbers

CUBE = block((0, 0, 0), (10, 10, 10))


def test_a_box_is_closed_and_wound_outwards() -> None:
    edges = find_edges(CUBE)
    turn, twisted = outward(CUBE, edges)
    assert (edges.open, edges.crowded, len(edges.first)) == (0, 0, 18)
    assert not turn.any()
    assert not twisted
    assert count_crossings(CUBE, edges) == 0


def test_patches_that_face_inwards_are_turned_around() -> None:
    wrong = [0, 3, 7]
    bent = CUBE.copy()
    bent[wrong] = bent[wrong][:, ::-1]
    turn, _ = outward(bent, find_edges(bent))
    assert np.flatnonzero(turn).tolist() == wrong
    inside_out = CUBE[:, ::-1]
    assert outward(inside_out, find_edges(inside_out))[0].all()


def test_a_cavity_keeps_its_normals_into_the_hollow() -> None:
    hollow = np.concatenate([CUBE, block((3, 3, 3), (6, 6, 6))[:, ::-1]])
    assert not outward(hollow, find_edges(hollow))[0].any()


def test_a_missing_patch_leaves_three_open_edges() -> None:
    assert find_edges(CUBE[1:]).open == 3


def test_boxes_that_reach_into_each_other_cross() -> None:
    both = np.concatenate([CUBE, block((5.1, 4.2, 6.3), (15, 14, 16))])
    assert count_crossings(both, find_edges(both)) >= 6
    apart = np.concatenate([CUBE, block((11, 0, 0), (15, 5, 5))])
    assert count_crossings(apart, find_edges(apart)) == 0


def sampled_distance(begin, end, patches) -> float:
    """Distance of a segment from triangles, by many points of both."""
    u, v = np.meshgrid(np.linspace(0, 1, 60), np.linspace(0, 1, 60))
    inside = (u + v <= 1).ravel()
    u, v = u.ravel()[inside], v.ravel()[inside]
    a, b, c = patches[:, 0], patches[:, 1], patches[:, 2]
    cloud = (a[:, None] * (1 - u - v)[:, None] + b[:, None] * u[:, None] + c[:, None] * v[:, None]).reshape(-1, 3)
    line = begin + (end - begin) * np.linspace(0, 1, 200)[:, None]
    return float(KDTree(cloud).query(line)[0].min())


def test_a_capsule_hits_what_is_nearer_than_its_radius() -> None:
    rng = np.random.default_rng(5)
    patches = rng.uniform(0, 20, (12, 1, 3)) + rng.uniform(-4, 4, (12, 3, 3))
    tree = build_tree(patches)
    for _ in range(25):
        begin, end = rng.uniform(-5, 25, (2, 3))
        distance = sampled_distance(begin, end, patches)
        near = capsule_hits(tree, begin[None], end[None], distance + 0.5)
        far = capsule_hits(tree, begin[None], end[None], max(distance - 0.5, 1e-9))
        assert near[0] >= 0
        assert far[0] == -1 or distance < 0.5


def test_touching_exactly_is_no_hit() -> None:
    tree = build_tree(CUBE)
    begin, end = np.array([[5.0, 5.0, 13.0]]), np.array([[5.0, 5.0, 40.0]])
    assert capsule_hits(tree, begin, end, 3.0)[0] == -1
    assert capsule_hits(tree, begin, end, 3.001)[0] >= 0
    assert capsule_hits(tree, np.array([[5.0, 5.0, 5.0]]), np.array([[5.0, 5.0, 40.0]]), 0.1)[0] >= 0


def test_a_point_inside_a_box_is_gone_around_once() -> None:
    numbers = winding_numbers(CUBE, np.array([[5.0, 5.0, 5.0], [15.0, 5.0, 5.0]]))
    np.testing.assert_allclose(numbers, [1.0, 0.0], atol=1e-9)


@pytest.mark.parametrize(("patches", "faces", "flat"), [(CUBE, 6, 6), (cylinder(20, 50), 3, 2)])
def test_faces_are_grown_over_smooth_edges(patches, faces: int, flat: int) -> None:
    areas, normals = areas_and_normals(patches.copy())
    found = find_regions(normals, areas, find_edges(patches), 20)
    assert int(found.face.max()) + 1 == faces
    assert int(found.flat.sum()) == flat


def test_a_flat_piece_with_rounded_edges_is_a_face_by_itself() -> None:
    quarter = np.radians(np.arange(0, 91, 15))
    ring = [
        (x + 4 * np.cos(a + t), y + 4 * np.sin(a + t))
        for x, y, t in ((26, 16, 0), (-26, 16, np.pi / 2), (-26, -16, np.pi), (26, -16, 3 * np.pi / 2))
        for a in quarter
    ]
    from small_parts import prism

    patches = prism(ring, 0.0, 30.0)
    areas, normals = areas_and_normals(patches.copy())
    found = find_regions(normals, areas, find_edges(patches), 20)
    assert int(found.flat.sum()) == 6  # two caps, four sides; the round corners are curved faces
    assert int(found.face.max()) + 1 == 10


def test_a_plane_cuts_a_ring_out_of_a_cylinder() -> None:
    patches = cylinder(20, 50)[-96:]  # the wall
    mesh = surface_mesh(patches)
    sections = cut_section(mesh, mesh.points[:, 2], 12.3)
    assert section_lengths(mesh, mesh.points[:, 2], 12.3) == pytest.approx([length_of(sections[0])])
    assert [section.closed for section in sections] == [True]
    even = resample(sections[0], 2.0)
    assert length_of(even) == pytest.approx(2 * np.pi * 20, rel=0.01)
    np.testing.assert_allclose(even.points[:, 2], 12.3)
    outwards = even.points[:, :2] / np.linalg.norm(even.points[:, :2], axis=1, keepdims=True)
    assert (np.einsum("ij,ij->i", outwards, even.normals[:, :2]) > 0.995).all()


@pytest.mark.slow
def test_cones_pass_over_no_cell_by_an_independent_count() -> None:
    rng = np.random.default_rng(11)
    ball = cut_cells(cylinder(40, 90), 5.0)
    empty = build_ray_scene(block((900, 0, 0), (901, 1, 1)), *(np.zeros((12, 3)), np.zeros(12, dtype=np.int64)), 1e9)
    orifices = rng.uniform((-90, -90, -45), (90, 90, 135), (150, 3))
    axes = rng.normal(size=(150, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    for half in (0.1, 0.5, 1.2):
        cone = Cone(half, np.radians(20), 0.05)
        ways = ball.points[None] - orifices[:, None]
        lengths = np.linalg.norm(ways, axis=2)
        inside = np.einsum("pci,pi->pc", ways, axes) >= lengths * np.cos(half)
        steep = -np.einsum("pci,ci->pc", ways, ball.normals) >= lengths * np.sin(np.radians(20))
        found = cells_in_view(ball, empty, cone, orifices, axes)
        np.testing.assert_array_equal(np.diff(found.indptr), (inside & steep).sum(axis=1))
        rows, columns = np.nonzero(inside & steep)
        np.testing.assert_array_equal(found.indices, columns)
        assert len(np.unique(rows)) > 10


@pytest.mark.slow
def test_the_share_of_a_stretch_is_that_of_many_poses_along_it() -> None:
    rng = np.random.default_rng(3)
    plate = cut_cells(block((-40, -40, -1), (40, 40, 0)), 4.0)
    bare = build_ray_scene(block((900, 0, 0), (901, 1, 1)), *(np.zeros((12, 3)), np.zeros(12, dtype=np.int64)), 1e9)
    orifices = np.column_stack([rng.uniform(-30, 30, (20, 2)), rng.uniform(50, 70, 20)])
    axes = rng.normal((0, 0, -1), 0.15, (20, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    stretch = Stretch(rng.normal(0, 2.0, (20, 3)), rng.normal(0, 0.01, (20, 3)))
    cone, top = Cone(np.radians(15), np.radians(5)), plate.normals[:, 2] > 0.5
    found = cells_in_view(plate, bare, cone, orifices, axes, stretch).toarray()
    mean = np.zeros_like(found)
    for along in (np.arange(200) + 0.5) / 200 - 0.5:
        turned = axes + along * np.cross(stretch.turns, axes)
        turned /= np.linalg.norm(turned, axis=1, keepdims=True)
        mean += cells_in_view(plate, bare, cone, orifices + along * stretch.ways, turned).toarray() / 200
    assert ((mean > 0.05) & (mean < 0.95)).sum() > 200
    np.testing.assert_allclose(found[:, top], mean[:, top], rtol=0, atol=0.06)


def test_a_cone_sees_the_disc_under_it_and_nothing_behind_a_screen() -> None:
    plate = block((-40, -40, -1), (40, 40, 0))
    cells = cut_cells(plate, 3.0)
    cone = Cone(np.radians(20), np.radians(30))
    orifice, axis = np.array([[0.0, 0.0, 60.0]]), np.array([[0.0, 0.0, -1.0]])
    bare = build_ray_scene(plate, areas_and_normals(plate.copy())[1], np.zeros(12, dtype=np.int64), 1e9)
    seen = cells_in_view(cells, bare, cone, orifice, axis).toarray()[0] > 0
    radius = np.hypot(cells.points[:, 0], cells.points[:, 1])
    disc = (cells.points[:, 2] > -0.5) & (radius < 60 * np.tan(np.radians(20)))
    assert (seen == disc).all()
    both = np.concatenate([plate, block((0, -40, 20), (40, 40, 21))])
    screened = build_ray_scene(both, areas_and_normals(both.copy())[1], np.zeros(24, dtype=np.int64), 1e9)
    seen = cells_in_view(cells, screened, cone, orifice, axis).toarray()[0] > 0
    assert (seen == (disc & (cells.points[:, 0] < 0))).all()
