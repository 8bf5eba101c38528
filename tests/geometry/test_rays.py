"""Rays against boxes whose faces are known."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rigid import Motion
from small_boards import part
from small_sprays import moved_board, solid_board

from cleaning.surface.facets import build_scene
from geometry.mesh import areas_and_normals
from geometry.rays import are_blocked, cast, split_patches

BOARD = solid_board(part("U1", 40, 20, 20, 20, 5.0))
SCENE = build_scene(BOARD)
DOWN = np.array([[0.0, 0.0, -1.0]])


def test_rays_stop_at_the_first_body():
    origins = np.array([[50.0, 30.0, 25.0], [10.0, 10.0, 25.0], [-50.0, 10.0, 25.0]])
    faces, distances = cast(SCENE, origins, np.repeat(DOWN, 3, axis=0))
    assert SCENE.body[faces[:2]].tolist() == [1, 0]
    assert faces[2] == -1
    np.testing.assert_allclose(distances[:2], [20.0, 25.0], atol=1e-9)
    assert distances[2] == np.inf


def test_a_face_knows_where_it_is_hit():
    rng = np.random.default_rng(3)
    origins = np.column_stack([rng.uniform(2, 98, 500), rng.uniform(2, 58, 500), np.full(500, 40.0)])
    aim = np.column_stack([rng.uniform(-0.5, 0.5, (500, 2)), -np.ones(500)])
    aim /= np.linalg.norm(aim, axis=1, keepdims=True)
    faces, distances = cast(SCENE, origins, aim)
    hit = faces >= 0
    places = origins[hit] + aim[hit] * distances[hit, None]
    from_middle = np.linalg.norm(places - SCENE.triangles[faces[hit]].mean(axis=1), axis=1)
    assert np.count_nonzero(hit) > 300
    assert from_middle.max() < 2.0


def test_a_line_of_sight_ends_at_a_body_and_not_at_its_target():
    nozzle = np.array([[20.0, 30.0, 4.0]] * 3)
    ways = np.array([[40.0, 30.0, 2.0], [70.0, 30.0, 2.0], [25.0, 30.0, 0.0]]) - nozzle
    lengths = np.linalg.norm(ways, axis=1)
    single = [(nozzle - SCENE.origin), ways / lengths[:, None], lengths]
    assert are_blocked(SCENE, *(each.astype(np.float32) for each in single)).tolist() == [False, True, False]


def test_stated_normals_decide_which_way_is_out():
    body = BOARD.bodies[1]
    flipped = body.patches.copy()
    flipped[::2] = flipped[::2, ::-1]
    mixed = build_scene(replace(BOARD, bodies=(BOARD.bodies[0], replace(body, patches=flipped))))
    middle = np.array([50.0, 30.0, 2.5])
    outward = mixed.triangles[mixed.body == 1].mean(axis=1) - middle
    assert np.all((outward * mixed.normals[mixed.body == 1]).sum(axis=1) > 0)


def test_a_scene_far_from_its_origin_is_as_sharp():
    far = build_scene(moved_board(BOARD, Motion(0.0, (8000.0, -9000.0, 500.0))))
    _, distances = cast(far, np.array([[8050.0, -8970.0, 525.0]]), DOWN)
    assert distances[0] == pytest.approx(20.0, abs=1e-6)


@given(
    corners=st.lists(st.tuples(*[st.floats(-30, 30)] * 3), min_size=3, max_size=3),
    longest=st.floats(1.5, 20.0),
)
@settings(max_examples=40)
def test_splitting_keeps_area_and_direction(corners, longest):
    patch = np.array([corners])
    triangles, parent = split_patches(patch, longest)
    areas, normals = areas_and_normals(triangles.copy())
    area, normal = areas_and_normals(patch.copy())
    assert areas.sum() == pytest.approx(area.sum(), rel=1e-9, abs=1e-9)
    edges = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2)
    assert edges.max() <= longest * (1 + 1e-6)
    assert np.all(parent == 0)
    if area[0] > 1.0:
        np.testing.assert_allclose(normals, np.repeat(normal, len(normals), axis=0), atol=1e-6)
