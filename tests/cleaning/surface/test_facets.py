"""Facets and cells: what is hidden is left out, areas add up, and a moved board has the same."""

import numpy as np
import pytest
from rigid import Motion
from small_boards import part
from small_sprays import moved_board, solid_board

from cleaning.surface.facets import build_facets, build_scene

BOARD = solid_board(
    part("U1", 20, 20, 14, 14, 2.0),
    part("C1", 60, 20, 2, 1.25, 0.8, turn_deg=30.0),
    part("J1", 70, 30, 10, 10, 4.0, side="bottom"),
)
SCENE = build_scene(BOARD)
FACETS = build_facets(BOARD, SCENE)
of_face = FACETS.cell_component[FACETS.cell]


def faces(component, axis, sign):
    """Facets of a component whose normals point along an axis."""
    return (of_face == component) & (FACETS.normals[:, axis] * sign > 0.9)


def test_undersides_are_hidden_and_tops_are_not():
    for index, sign in ((0, 1), (1, 1), (2, -1)):
        assert np.all(FACETS.exposed[faces(index, 2, sign)])
        assert not np.any(FACETS.exposed[faces(index, 2, -sign)])


def test_walls_are_exposed():
    for axis in (0, 1):
        for sign in (-1, 1):
            assert np.all(FACETS.exposed[faces(0, axis, sign)])
            assert np.all(FACETS.exposed[faces(2, axis, sign)])


def test_the_board_is_hidden_beneath_components_alone():
    bare = (of_face == -1) & (FACETS.normals[:, 2] > 0.9)
    middle = FACETS.triangles.mean(axis=1)
    deep = bare & (np.abs(middle[:, 0] - 27) < 5) & (np.abs(middle[:, 1] - 27) < 5)
    beyond = bare & ((np.abs(middle[:, 0] - 27) > 9) | (np.abs(middle[:, 1] - 27) > 9))
    beyond &= np.hypot(middle[:, 0] - 61, middle[:, 1] - 20.6) > 4
    assert deep.sum() > 20
    assert not np.any(FACETS.exposed[deep])
    assert np.all(FACETS.exposed[beyond])


def test_both_sides_and_the_rim_of_the_board_see_the_sky():
    bare = of_face == -1
    for direction in ([0, 0, 1], [0, 0, -1], [1, 0, 0], [0, -1, 0]):
        facing = bare & (FACETS.normals @ np.array(direction) > 0.9)
        assert FACETS.exposed[facing].mean() > 0.8


def test_areas_add_up():
    bare_up = (of_face == -1) & (FACETS.normals[:, 2] > 0.9)
    assert FACETS.areas_mm2[bare_up].sum() == pytest.approx(100 * 60)
    seen = FACETS.cell_areas_mm2[
        FACETS.cell_exposed & (FACETS.cell_component == -1) & (FACETS.cell_normals[:, 2] > 0.9)
    ]
    assert seen.sum() == pytest.approx(100 * 60 - 14 * 14 - 2.5, rel=0.01)
    top = FACETS.cell_areas_mm2[FACETS.cell_exposed & (FACETS.cell_component == 0) & (FACETS.cell_normals[:, 2] > 0.9)]
    assert top.sum() == pytest.approx(14 * 14)


def test_cells_are_of_one_body_one_direction_and_one_place():
    for cell in np.unique(FACETS.cell)[::37]:
        mine = FACETS.cell == cell
        assert len(np.unique(FACETS.body[mine])) == 1
        normals = FACETS.normals[mine]
        assert np.all(normals @ normals[0] > 0)
        middle = FACETS.triangles[mine].mean(axis=1)
        assert np.ptp(middle, axis=0).max() < 1.5 * 1.5
        component = FACETS.cell_component[cell]
        name = BOARD.components[component].name if component >= 0 else "board"
        assert {BOARD.bodies[body].name for body in FACETS.body[mine].tolist()} == {name}


def test_cells_of_small_parts_are_not_slivers():
    chip = FACETS.cell_areas_mm2[FACETS.cell_exposed & (FACETS.cell_component == 1)]
    assert 5 <= len(chip) <= 24
    assert chip.min() > 0.1


@pytest.mark.slow
@pytest.mark.parametrize(
    "motion", [Motion(90.0, (0, 0, 0)), Motion(33.0, (500.0, -70.0, 12.0)), Motion(180.0, (1, 2, 3))]
)
def test_a_moved_board_has_the_same_cells(motion):
    board = moved_board(BOARD, motion)
    moved = build_facets(board, build_scene(board))
    assert np.array_equal(moved.cell, FACETS.cell)
    assert np.array_equal(moved.exposed, FACETS.exposed)
    np.testing.assert_allclose(moved.cell_areas_mm2, FACETS.cell_areas_mm2, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(moved.cell_centres, motion.points(FACETS.cell_centres), atol=1e-6)
    np.testing.assert_allclose(moved.cell_normals, FACETS.cell_normals @ motion.matrix.T, atol=1e-6)
