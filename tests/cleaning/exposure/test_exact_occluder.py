import numpy as np
import pytest
from shapely import box
from small_boards import part
from small_sprays import RING, downward, samples_of, solid_board, sprayed, stage_of

from cleaning.exposure.exact import occluder, samples_in_sight
from cleaning.surface.facets import build_facets, build_scene

OUTLINE = box(-40, -40, 40, 40, ccw=True)
LOW, WALL, OTHER = part("U1", -3, -3, 6, 6, 1.0), part("W1", 6, -15, 2, 30, 25.0), part("W2", -8, -15, 2, 30, 25.0)


def blocked_by(board, tcp, axes, chosen=lambda facets: facets.cell_component == 0):
    """Name of what stands before the chosen cells; the first component's unless said."""
    scene = build_scene(board)
    facets = build_facets(board, scene)
    stage = stage_of(samples_of(tcp, axes), RING)
    cells = np.flatnonzero(chosen(facets) & facets.cell_exposed)
    jet = sprayed(stage)
    body = occluder(cells, stage, jet, facets, scene, samples_in_sight(stage, jet, facets.cell_centres))
    return "" if body < 0 else board.bodies[body].name


def beside(side, reach=1.0):
    """A nozzle to the right (1) or left (-1) that leans towards the middle."""
    turn = 180.0 if side > 0 else 0.0
    return [[side * 45.0 * reach, y, 40.0] for y in (-4.0, 0.0, 4.0)], downward(50.0, turn)


@pytest.mark.slow
@pytest.mark.parametrize(("side", "name"), [(1, "W1"), (-1, "W2")])
def test_the_wall_between_nozzle_and_part_is_named(side, name):
    assert blocked_by(solid_board(LOW, WALL, OTHER, outline=OUTLINE), *beside(side)) == name


def test_a_free_view_is_blocked_by_nothing():
    assert blocked_by(solid_board(LOW, outline=OUTLINE), *beside(1)) == ""


@pytest.mark.slow
def test_a_jet_that_points_elsewhere_is_blocked_by_nothing():
    tcp, _ = beside(1)
    away = downward(50.0, 0.0)
    assert blocked_by(solid_board(LOW, WALL, outline=OUTLINE), tcp, away) == ""


@pytest.mark.slow
def test_what_looks_away_from_the_jet_is_not_blocked():
    board = solid_board(LOW, WALL, outline=OUTLINE)

    def left_wall(facets):
        found = (facets.cell_component == 0) & (facets.cell_normals[:, 0] < -0.9)
        assert np.any(found & facets.cell_exposed)
        return found

    assert blocked_by(board, *beside(1), left_wall) == ""
    assert blocked_by(board, *beside(-1), left_wall) == ""


@pytest.mark.slow
def test_what_stands_beyond_the_nozzle_does_not_block():
    beyond = part("W3", 22, -15, 2, 30, 40.0)
    tcp, axes = [[15.0, y, 15.0] for y in (-4.0, 0.0, 4.0)], downward(50.0, 180.0)
    assert blocked_by(solid_board(LOW, beyond, outline=OUTLINE), tcp, axes) == ""
    assert blocked_by(solid_board(LOW, beyond, outline=OUTLINE), *beside(1)) == "W3"


@pytest.mark.slow
def test_what_blocks_more_often_counts():
    board = solid_board(LOW, WALL, OTHER, outline=OUTLINE)
    right, axes = beside(1)
    left, others = beside(-1)
    tcp = [*right, *left[:1]]
    assert blocked_by(board, tcp, [axes] * 3 + [others]) == "W1"
    assert blocked_by(board, [*right[:1], *left], [axes] + [others] * 3) == "W2"


def test_a_part_may_stand_in_its_own_way():
    tall = part("T1", -5, -5, 10, 10, 30.0)

    def behind(facets):
        x, y, _ = facets.cell_centres.T
        return (x < -6) & (x > -12) & (abs(y) < 4) & (facets.cell_normals[:, 2] > 0.9)

    assert blocked_by(solid_board(tall, outline=OUTLINE), *beside(1), behind) == "T1"
