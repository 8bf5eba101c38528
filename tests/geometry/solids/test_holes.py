"""Holes of meshes: closed up to a width, wound as what is beside them, and all others left open."""

import numpy as np
import pytest
from small_parts import block

from geometry.mesh import areas_and_normals
from geometry.solids.holes import fill_holes
from geometry.solids.soundness import find_edges, outward


def sheet(holes=(), bend_mm=400.0, size=24, step=2.0):
    """A bent sheet of squares, each two triangles, with round holes: middle and diameter."""
    at = step * np.arange(size + 1)
    x, y = np.meshgrid(at, at, indexing="ij")
    corners = np.stack([x, y, (x**2 + y**2) / bend_mm], axis=-1)
    a, b, c, d = corners[:-1, :-1], corners[1:, :-1], corners[1:, 1:], corners[:-1, 1:]
    patches = np.concatenate([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)]).reshape(-1, 3, 3)
    middles = patches.mean(axis=1)[:, :2]
    for middle, wide in holes:
        keep = np.linalg.norm(middles - middle, axis=1) > wide / 2
        patches, middles = patches[keep], middles[keep]
    return patches


@pytest.mark.parametrize("holes", [[((20, 20), 12)], [((12, 12), 8), ((34, 30), 14)], [((25, 24), 5), ((10, 36), 9)]])
def test_holes_are_closed_and_the_rim_is_left(holes) -> None:
    whole, open_ = sheet(), sheet(holes)
    filled, found = fill_holes(open_, 18.0)
    assert len(found) == len(holes)
    assert filled[: len(open_)].tolist() == open_.tolist()
    edges = find_edges(filled)
    assert edges.open == find_edges(whole).open
    assert not edges.against.any()
    assert not outward(filled, edges)[0].any()
    area = areas_and_normals(filled.copy())[0].sum()
    assert area == pytest.approx(areas_and_normals(whole.copy())[0].sum(), rel=0.01)
    for (middle, wide), (width, place) in zip(sorted(holes), sorted(found, key=lambda each: each[1][0]), strict=True):
        assert place[:2] == pytest.approx(middle, abs=2.0)
        assert width == pytest.approx(wide, abs=5.0)


def test_wider_holes_are_left_open() -> None:
    both = sheet([((12, 12), 8), ((34, 30), 14)])
    filled, found = fill_holes(both, 12.5)
    assert len(found) == 1
    assert find_edges(filled).open < find_edges(both).open
    assert fill_holes(both, 2.0)[0].tolist() == both.tolist()


def test_a_missing_triangle_of_a_box_is_put_back_whichever_way_the_others_face() -> None:
    cube = block((0, 0, 0), (40, 30, 20))
    for missing in range(len(cube)):
        for inverted in (False, True):
            left = np.delete(cube, missing, axis=0)
            left = left[:, ::-1] if inverted else left
            filled, found = fill_holes(left, 100.0)
            assert len(found) == 1
            assert find_edges(filled).open == 0
            expected = cube[missing, ::-1] if inverted else cube[missing]
            assert any(filled[-1].tolist() == np.roll(expected, turn, axis=0).tolist() for turn in range(3))


def test_a_closed_mesh_and_rings_that_touch_stay_as_they_are() -> None:
    cube = block((0, 0, 0), (40, 30, 20))
    assert fill_holes(cube, 100.0)[0].tolist() == cube.tolist()
    touching = sheet(size=8)
    middles = touching.mean(axis=1)[:, :2]
    near = [np.abs(middles - at).max(axis=1) < 2.0 for at in ((6.0, 6.0), (10.0, 10.0))]  # a corner in common at (8, 8)
    touching = touching[~(near[0] | near[1])]
    assert fill_holes(touching, 15.0)[0].tolist() == touching.tolist()
