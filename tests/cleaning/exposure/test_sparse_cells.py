from functools import cache
from pathlib import Path

import numpy as np
import pytest
from analysed import board_of
from shapely import box
from small_boards import part
from small_sprays import RING, downward, samples_of, solid_board, sprayed, stage_of

from boards.load import load_board
from cleaning.exposure.exact import exact_exposure
from cleaning.exposure.exposure import expose
from cleaning.exposure.sparse_cells import MOMENTS, look_at, refine_sparse_cells
from cleaning.surface.facets import build_facets, build_scene
from cleaning.verdicts.exposed_area import cells_of, cells_of_side, exposed_part
from geometry.rays import cast

BOARD = board_of("U1")
SCENE = build_scene(BOARD)
FACETS = build_facets(BOARD, SCENE)
STAGE = stage_of(samples_of([[x, 20.0, 45.0] for x in range(-10, 45, 5)], downward(20.0, 30.0), seconds=4.0))
JET = sprayed(STAGE)
CELLS = cells_of_side(FACETS, BOARD, "top")


@pytest.mark.slow
def test_what_few_rays_do_not_find_is_found_all_the_same():
    few = expose(STAGE, JET, FACETS, SCENE, 3)
    sure = refine_sparse_cells(few, STAGE, JET, FACETS, SCENE, CELLS)
    exact = exact_exposure(STAGE, JET, FACETS, SCENE, CELLS)
    unhit = FACETS.cell_exposed[CELLS] & (few.hits[CELLS] == 0)
    assert np.count_nonzero(unhit) > 100
    assert np.all((sure.cone_s[CELLS] > 0)[unhit & (exact.cone_s > 0.9 * exact.cone_s.max())])
    off = np.abs(sure.volume_mm[CELLS] - exact.volume_mm)[unhit]
    assert np.median(off) <= 0.05 * exact.volume_mm.max()


def test_what_was_hit_often_keeps_its_estimate_and_nothing_else_is_touched():
    many = expose(STAGE, JET, FACETS, SCENE, 8000)
    sure = refine_sparse_cells(many, STAGE, JET, FACETS, SCENE, CELLS)
    kept = (many.hits > 0) & (FACETS.cell_component == -1)
    np.testing.assert_array_equal(sure.volume_mm[kept], many.volume_mm[kept])
    others = np.setdiff1d(np.arange(len(many.hits)), CELLS)
    np.testing.assert_array_equal(sure.cone_s[others], many.cone_s[others])


def test_a_component_that_hardly_any_ray_hit_is_looked_at_at_many_moments():
    few = expose(STAGE, JET, FACETS, SCENE, 40)
    mine = CELLS[(FACETS.cell_component[CELLS] == 0) & FACETS.cell_exposed[CELLS]]
    assert 0 < few.hits[mine].sum() < 30
    sure = refine_sparse_cells(few, STAGE, JET, FACETS, SCENE, CELLS)
    exact = exact_exposure(STAGE, JET, FACETS, SCENE, mine)
    areas = FACETS.cell_areas_mm2[mine]
    assert sure.volume_mm[mine] @ areas == pytest.approx(exact.volume_mm @ areas, rel=0.03)
    assert sure.cone_s[mine] @ areas == pytest.approx(exact.cone_s @ areas, rel=0.01)
    assert sure.peak_pa[mine].max() == pytest.approx(exact.peak_pa.max(), rel=0.02)


def test_a_part_of_few_cells_is_looked_at_at_moments_however_many_rays_hit_it():
    board = solid_board(part("C1", 8.0, 14.0, 1.0, 0.5, 0.5), outline=box(0, 0, 30, 30, ccw=True))
    scene = build_scene(board)
    facets = build_facets(board, scene)
    cells = cells_of_side(facets, board, "top")
    mine = cells[(facets.cell_component[cells] == 0) & facets.cell_exposed[cells]]
    rays = expose(STAGE, JET, facets, scene, 60_000)
    assert rays.hits[mine].sum() >= 30
    sure = refine_sparse_cells(rays, STAGE, JET, facets, scene, cells)
    exact = exact_exposure(STAGE, JET, facets, scene, mine)
    areas = facets.cell_areas_mm2[mine]
    assert sure.cone_s[mine] @ areas == pytest.approx(exact.cone_s @ areas, rel=0.02)
    assert (sure.cone_shared_error_s[mine][exact.cone_s > 0] > 0).all()


@pytest.mark.slow
def test_the_time_in_the_cone_is_within_its_error_of_a_finer_reference():
    places = [(x, y) for x in (4.0, 9.0, 17.0, 22.0, 26.0) for y in (3.0, 8.0, 13.0, 18.0, 23.0)]
    parts = [part(f"R{i}", *place, 0.6, 0.3, 0.3) for i, place in enumerate(places)]
    board = solid_board(*parts, part("U1", 12.0, 10.0, 2.0, 6.0, 9.0), outline=box(0, 0, 30, 30, ccw=True))
    scene = build_scene(board)
    facets = build_facets(board, scene)
    way = np.linspace([-25.0, 12.0, 30.0], [55.0, 18.0, 30.0], 1600)
    fine = stage_of(samples_of(way, downward(15.0, 40.0), seconds=0.01))
    coarse = stage_of(samples_of(way[30::60], downward(15.0, 40.0), seconds=0.6))
    rays = expose(coarse, sprayed(coarse), facets, scene, 3000)
    cells = cells_of_side(facets, board, "top")
    sure = refine_sparse_cells(rays, coarse, sprayed(coarse), facets, scene, cells)
    held = []
    for index in range(len(places)):
        mine = cells_of(facets, board, index, "top")
        shown = mine[facets.cell_exposed[mine]]
        found = exposed_part(sure, facets, mine)
        exact = exact_exposure(fine, sprayed(fine), facets, scene, shown).cone_s
        off = abs(found.cone_s[2] - np.average(exact, weights=facets.cell_areas_mm2[shown]))
        held.append(off <= found.cone_error_s)
        assert found.cone_error_s < 0.25 * found.cone_s[2]
    assert sum(held) >= 24


def test_more_moments_come_nearer_to_the_exact_integral():
    mine = CELLS[(FACETS.cell_component[CELLS] == 0) & FACETS.cell_exposed[CELLS]]
    exact = exact_exposure(STAGE, JET, FACETS, SCENE, mine)
    wet = exact.volume_mm > 0.1 * exact.volume_mm.max()
    off = {}
    for moments in (MOMENTS // 16, 16 * MOMENTS):
        found = look_at(STAGE, JET, FACETS, SCENE, mine, moments)
        off[moments] = np.sqrt(np.mean((found[wet, 2] / exact.volume_mm[wet] - 1.0) ** 2))
    assert off[16 * MOMENTS] <= 0.05
    assert off[16 * MOMENTS] <= 0.3 * off[MOMENTS // 16]


def test_each_cell_is_looked_at_by_itself():
    mine = CELLS[(FACETS.cell_component[CELLS] == 0) & FACETS.cell_exposed[CELLS]]
    together = look_at(STAGE, JET, FACETS, SCENE, mine)
    backwards = look_at(STAGE, JET, FACETS, SCENE, mine[::-1].copy())[::-1]
    np.testing.assert_allclose(backwards, together, rtol=1e-12)
    assert look_at(STAGE, JET, FACETS, SCENE, mine[:0]).shape == (0, 8)


def seen_from(scene, places, normals, tcp):
    """(n,) whether an orifice is before each place, with nothing between: one ray from each, and no other shortcut."""
    ways = tcp - places
    reach = np.linalg.norm(ways, axis=1)
    ways /= reach[:, None]
    _, free = cast(scene, places + 1e-3 * normals, ways)
    return ((ways * normals).sum(axis=1) > 0.0) & (free >= reach - 1e-2)


def brute_force_s(stage, facets, scene, cells, random, places=80):
    """Mean time in the outer cone over some cells: random places on them, all samples, angle with the axis, one ray."""
    chosen = np.flatnonzero(np.isin(facets.cell, cells) & facets.exposed)
    corners, areas = facets.triangles[chosen], facets.areas_mm2[chosen]
    counts = np.maximum(np.round(places * areas / areas.sum()).astype(int), 2)
    whose = np.repeat(np.arange(len(chosen)), counts)
    first, second = np.sqrt(random.random(len(whose))), random.random(len(whose))
    weights = np.column_stack([1.0 - first, first * (1.0 - second), first * second])
    places = np.einsum("nk,nkd->nd", weights, corners[whose])
    normals, shares = facets.normals[chosen][whose], (areas / counts)[whose] / areas.sum()
    outer = np.cos(np.radians(RING.half_angle_deg + 2.0 * RING.ring_sigma_deg))
    total = 0.0
    for tcp, axes, seconds in zip(stage.samples.tcp, stage.samples.axes, stage.samples.seconds, strict=True):
        ways = places - tcp
        within = ways @ axes[:, 2] >= outer * np.linalg.norm(ways, axis=1)
        if within.any():
            total += seconds * shares[within] @ seen_from(scene, places[within], normals[within], tcp)
    return total


@cache
def chips_of_a_sample():
    """Board, scene and facets of radio-stick, and its 0201 parts on the upper side: chips among larger parts."""
    board = load_board(Path("radio-stick"))
    scene = build_scene(board)
    rows = [row for row, each in enumerate(board.components) if "0201" in each.package and each.side == "top"]
    assert len(rows) >= 30
    return board, scene, build_facets(board, scene), rows


def three_lines(board):
    """Way of an orifice along a board, 900 places."""
    x0, y0, x1, y1 = board.outline.bounds
    return np.vstack([
        np.linspace([x0 - 20, y0 + share * (y1 - y0), 32.0], [x1 + 20, y0 + share * (y1 - y0), 32.0], 300)
        for share in (0.1, 0.5, 0.9)
    ])  # fmt: skip


@pytest.mark.slow
def test_the_exact_sum_on_walls_of_small_parts_is_that_of_many_random_places():
    board, scene, facets, rows = chips_of_a_sample()
    stage = stage_of(samples_of(three_lines(board)[5::10], downward(15.0, 40.0), seconds=0.4))
    walls = (abs(facets.cell_normals[:, 2]) < 0.1) & facets.cell_exposed & np.isin(facets.cell_component, rows)
    cells = np.flatnonzero(walls)
    shown = np.bincount(facets.cell, facets.areas_mm2 * facets.exposed, len(walls))[cells]
    exact = exact_exposure(stage, sprayed(stage), facets, scene, cells)
    found = exact.cone_s @ facets.cell_areas_mm2[cells] / shown.sum()
    truth = brute_force_s(stage, facets, scene, cells, np.random.default_rng(5), 20_000)
    assert found == pytest.approx(truth, rel=2e-3)


@pytest.mark.slow
def test_the_error_holds_the_brute_force_time_of_all_0201_parts_of_a_sample_in_95_of_100():
    board, scene, facets, rows = chips_of_a_sample()
    way = three_lines(board)
    fine = stage_of(samples_of(way, downward(15.0, 40.0), seconds=0.04))
    coarse = stage_of(samples_of(way[5::10], downward(15.0, 40.0), seconds=0.4))
    rays = expose(coarse, sprayed(coarse), facets, scene, 3000)
    sure = refine_sparse_cells(rays, coarse, sprayed(coarse), facets, scene, cells_of_side(facets, board, "top"))
    random, held, shares = np.random.default_rng(5), 0, []
    for row in rows:
        mine = cells_of(facets, board, row, "top")
        found = exposed_part(sure, facets, mine)
        truth = brute_force_s(fine, facets, scene, mine[facets.cell_exposed[mine]], random)
        held += abs(found.cone_s[2] - truth) <= found.cone_error_s
        shares.append(found.cone_error_s / found.cone_s[2])
    assert held >= 0.95 * len(rows), held
    assert np.median(shares) < 0.1, "an error that is everything holds everything"
