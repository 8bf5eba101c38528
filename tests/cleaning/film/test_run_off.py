"""Film and run-off of tops: numbers by hand for an upright ring that stands still."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cleaning_surface import no_edges
from shapely import affinity, box
from small_boards import THICKNESS_MM, part
from small_sprays import PARAMETERS, downward, samples_of, solid_board, sprayed, stage_of

from cleaning.film.run_off import film_supply, run_off_of
from cleaning.gap.edge_segments import SEGMENTS
from cleaning.surface.facets import build_facets, build_scene
from cleaning.verdicts.exposed_area import cells_of_side

FILM = PARAMETERS.film
HEIGHT_MM = 30.0
RADIUS_MM = HEIGHT_MM * math.tan(math.radians(30.0))
SIDE_MM = 120.0
MIDDLE = np.array([60.0, 60.0])
LARGE = box(0, 0, SIDE_MM, SIDE_MM, ccw=True)
SMALL = box(0, 0, 60, 40, ccw=True)


def spread_on(board, side="top", edges=None):
    facets = build_facets(board, build_scene(board))
    cells = cells_of_side(facets, board, side)
    return facets, run_off_of(side, board, facets, cells, no_edges() if edges is None else edges, FILM)


def supplied(board, tcp, axes=None, side="top", seconds=1.0):
    """(nodes,) mm, and the distance of each node from the place under the nozzle; the volume sprayed, mm3."""
    _, run_off = spread_on(board, side)
    stage = stage_of(samples_of([tcp], axes, seconds=seconds))
    jet = sprayed(stage)
    film_mm = film_supply(stage, jet, run_off, FILM, np.array([stage.end_s]))[0]
    nodes = run_off.nodes
    numbers = np.stack(np.indices(nodes.counts), axis=-1).reshape(-1, 2)
    places = nodes.corner + (numbers * nodes.steps_mm) @ nodes.axes
    return film_mm, np.linalg.norm(places - tcp[:2], axis=1), jet.flow_m3_s * 1e9 * seconds, run_off


def test_the_film_thins_with_the_square_of_the_radius_and_is_even_in_the_pool():
    film_mm, away, volume_mm3, _ = supplied(solid_board(outline=LARGE), [*(MIDDLE + 0.7), HEIGHT_MM])
    outside = (away > 1.001 * RADIUS_MM) & (away < 2.999 * RADIUS_MM)
    assert outside.sum() > 100
    # Three quarters of a ring of 30 degrees run outwards, a quarter inwards.
    np.testing.assert_allclose(film_mm[outside], 0.75 * volume_mm3 / (2 * np.pi * away[outside] ** 2), rtol=1e-5)
    pool = away < 0.6 * RADIUS_MM
    np.testing.assert_allclose(film_mm[pool], 0.25 * volume_mm3 / (2 * np.pi * RADIUS_MM**2), rtol=1e-5)
    assert not film_mm[away > 3.001 * RADIUS_MM].any()


@pytest.mark.slow
def test_all_that_flows_outwards_is_counted_about_once():
    total, volume_mm3 = 0.0, 0.0
    for shift in np.stack(np.meshgrid(np.linspace(0, 4, 6)[:-1], np.linspace(0, 4, 6)[:-1]), axis=-1).reshape(-1, 2):
        film_mm, away, sprayed_mm3, run_off = supplied(solid_board(outline=LARGE), [*(MIDDLE + shift - 2), HEIGHT_MM])
        total += film_mm[away > RADIUS_MM].sum() * np.prod(run_off.nodes.steps_mm)
        volume_mm3 += sprayed_mm3
    assert total == pytest.approx(0.75 * math.log(3.0) * volume_mm3, rel=0.01)


@pytest.mark.slow
def test_a_spray_beside_the_board_sends_no_film_over_it():
    board = solid_board(outline=LARGE)
    beside, _, _, _ = supplied(board, [-RADIUS_MM - 2.1, 60.0, HEIGHT_MM])
    assert not beside.any()
    half, _, _, _ = supplied(board, [0.0, 60.0, HEIGHT_MM])
    assert half.any()


def test_both_sides_and_turned_boards_get_the_same():
    first, _, _, _ = supplied(solid_board(outline=box(0, 0, 90, 60)), [30.0, 20.0, HEIGHT_MM])
    up = downward() * np.array([1.0, -1.0, -1.0])
    below, _, _, _ = supplied(
        solid_board(outline=box(0, 0, 90, 60)), [30.0, 20.0, -HEIGHT_MM - THICKNESS_MM], up, "bottom"
    )
    np.testing.assert_allclose(below, first, rtol=1e-5)
    turned = affinity.rotate(box(0, 0, 90, 60, ccw=True), 30.0, origin=(30.0, 20.0))
    again, _, _, _ = supplied(solid_board(outline=turned), [30.0, 20.0, HEIGHT_MM])
    np.testing.assert_allclose(np.sort(again), np.sort(first), rtol=1e-4)


def test_film_reaches_what_is_lower_than_the_puddle_and_less_of_it_between_neighbours():
    low, tall = part("C1", 50.0, 50.0, 2.0, 1.2, height=0.6), part("U1", 70.0, 50.0, 9.0, 9.0, height=6.0)
    board = solid_board(low, tall, outline=LARGE)
    edges = no_edges()
    sheltered = np.array([[1.0] * 4 + [np.inf] * 4])
    edges = replace(
        edges,
        component=np.array([0]),
        middles=np.zeros((1, SEGMENTS, 3)),
        outward=np.zeros((1, SEGMENTS, 3)),
        heights_mm=np.array([0.6]),
        sheltered=sheltered,
        facing=np.ones(1),
    )
    facets, run_off = spread_on(board, edges=edges)
    even = run_off.on_cells(np.zeros(len(facets.cell_areas_mm2)), np.full(run_off.nodes.on_board.size, 2.0))
    of_board = cells_of_side(facets, board, "top")
    bare = of_board[(facets.cell_component[of_board] == -1) & (facets.cell_normals[of_board, 2] > 0.9)]
    np.testing.assert_allclose(even[bare], 2.0)
    # Half of its edges have a neighbour within 5 mm, which leaves 0.3 of the film there.
    np.testing.assert_allclose(even[facets.cell_component == 0].max(), 2.0 * 0.65)
    tall_cells = np.flatnonzero(facets.cell_component == 1)
    high = facets.cell_centres[tall_cells, 2] > FILM.puddle_mm
    assert not even[tall_cells[high]].any()
    np.testing.assert_allclose(
        even[tall_cells[~high & (facets.cell_normals[tall_cells, 2] > -0.5)]], 2.0 * FILM.shelter
    )


def test_what_lands_on_a_top_runs_down_its_walls():
    board = solid_board(part("U1", 50.0, 50.0, 8.0, 5.0, height=4.1), outline=LARGE)
    facets, run_off = spread_on(board)
    mine = facets.cell_component == 0
    top = mine & (facets.cell_normals[:, 2] > 0.9)
    volume = np.where(top, 3.0, 0.0)
    found = run_off.on_cells(volume, np.zeros(run_off.nodes.on_board.size))
    wall = mine & (np.abs(facets.cell_normals[:, 2]) < 0.1)
    # 8 x 5 mm of top, 26 mm of wall that is 4 mm high.
    np.testing.assert_allclose(found[wall], 3.0 * 40.0 / (26.0 * 4.0))
    assert not found[~wall].any()


def edges_of(component, *near_mm, side="top"):
    """The edges of one component whose segments have a neighbour so near, and of the others none."""
    sheltered = np.array([[*near_mm, *[np.inf] * (SEGMENTS - len(near_mm))]])
    return replace(
        no_edges(),
        component=np.array([component]),
        middles=np.zeros((1, SEGMENTS, 3)),
        outward=np.zeros((1, SEGMENTS, 3)),
        heights_mm=np.array([0.6]),
        sheltered=sheltered,
        facing=np.array([1.0 if side == "top" else -1.0]),
    )


@pytest.mark.parametrize("side", ["top", "bottom"])
@pytest.mark.parametrize("near", [0, 1, 3, SEGMENTS])
def test_each_edge_with_a_near_neighbour_takes_its_share_on_both_sides(side, near):
    """The neighbour counts up to its distance; of two parts each has its own edges, and the other side gets nothing."""
    first, low = (part(name, x, 15.0, 2.0, 1.2, height=0.6, side=side) for name, x in (("C1", 15.0), ("C2", 35.0)))
    board = solid_board(first, low, outline=SMALL)
    near_mm = [FILM.shelter_mm] * near + [1.001 * FILM.shelter_mm] * (SEGMENTS - near)
    facets, run_off = spread_on(board, side, edges_of(1, *near_mm, side=side))
    found = run_off.on_cells(np.zeros(len(facets.cell_areas_mm2)), np.full(run_off.nodes.on_board.size, 2.0))
    share = 1.0 - near / SEGMENTS * (1.0 - FILM.shelter)
    assert found[facets.cell_component == 1].max() == pytest.approx(2.0 * share)
    assert found[facets.cell_component == 0].max() == pytest.approx(2.0 * FILM.shelter), "nothing is known of its edges"
    up = 1.0 if side == "top" else -1.0
    bare = facets.cell_component == -1
    assert found[bare & (up * facets.cell_normals[:, 2] > 0.9)] == pytest.approx(2.0)
    assert not found[bare & (up * facets.cell_normals[:, 2] < -0.9)].any()


@pytest.mark.parametrize("side", ["top", "bottom"])
def test_film_reaches_no_higher_than_the_puddle_on_both_sides(side):
    board = solid_board(part("U1", 25.0, 15.0, 9.0, 9.0, height=6.0, side=side), outline=SMALL)
    facets, run_off = spread_on(board, side)
    found = run_off.on_cells(np.zeros(len(facets.cell_areas_mm2)), np.full(run_off.nodes.on_board.size, 2.0))
    up = 1.0 if side == "top" else -1.0
    above = up * (facets.cell_centres[:, 2] - board.surface_z_mm(side))
    wall = (facets.cell_component == 0) & (np.abs(facets.cell_normals[:, 2]) < 0.1)
    assert found[wall & (above < FILM.puddle_mm)] == pytest.approx(2.0 * FILM.shelter)
    assert not found[wall & (above > FILM.puddle_mm)].any()
    assert (wall & (above > FILM.puddle_mm)).any()


@pytest.mark.parametrize("side", ["top", "bottom"])
def test_of_two_parts_each_wets_its_own_walls(side):
    parts = [part(name, x, 15.0, 8.0, 5.0, height=4.1, side=side) for name, x in (("U1", 10.0), ("U2", 40.0))]
    board = solid_board(*parts, outline=SMALL)
    facets, run_off = spread_on(board, side)
    up = 1.0 if side == "top" else -1.0
    top = (facets.cell_component >= 0) & (up * facets.cell_normals[:, 2] > 0.9)
    landed = np.where(top, 3.0 * (1.0 + facets.cell_component), 0.0)
    found = run_off.on_cells(landed, np.zeros(run_off.nodes.on_board.size))
    for row in range(2):
        wall = (facets.cell_component == row) & (np.abs(facets.cell_normals[:, 2]) < 0.1)
        np.testing.assert_allclose(found[wall], 3.0 * (1 + row) * 40.0 / (26.0 * 4.0))
    assert not found[top].any()


@pytest.mark.parametrize("side", ["top", "bottom"])
@pytest.mark.parametrize("poses", [1, 2, 5])
def test_film_is_added_up_pose_by_pose_in_the_block_of_its_time(side, poses):
    """Each pose counts for as long as it lasts, in the first block that ends no earlier; the blocks share nothing."""
    board = solid_board(outline=SMALL)
    height, turn = (HEIGHT_MM, 1.0) if side == "top" else (-HEIGHT_MM - THICKNESS_MM, -1.0)
    axes = downward() * np.array([1.0, turn, turn])
    places = [[10.0 + 9.0 * number, 15.0, height] for number in range(poses)]
    seconds = 0.5 + np.arange(poses)
    _, run_off = spread_on(board, side)
    stage = stage_of(samples_of(places, axes, seconds=seconds))
    split = stage.samples.times[poses // 2]
    found = film_supply(stage, sprayed(stage), run_off, FILM, np.array([split, stage.end_s]))
    for block, chosen in enumerate((stage.samples.times <= split, stage.samples.times > split)):
        alone = np.zeros(run_off.nodes.on_board.size)
        for place, lasting in zip(np.array(places)[chosen], seconds[chosen], strict=True):
            one = stage_of(samples_of([place], axes, seconds=lasting))
            alone += film_supply(one, sprayed(one), run_off, FILM, np.array([one.end_s]))[0]
        np.testing.assert_allclose(found[block], alone, rtol=1e-5, atol=1e-9)
    away = film_supply(
        stage_of(samples_of(places, downward() * np.array([1.0, -turn, -turn]))), sprayed(stage), run_off, FILM,
        np.array([stage.end_s]),
    )  # fmt: skip
    assert not away.any(), "a jet that points away from the side"
