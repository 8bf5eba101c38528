import numpy as np
import pytest
from analysed import board_of
from small_sprays import downward, samples_of, sprayed, stage_of

from cleaning.exposure.exact import exact_exposure, refine_sparse_cells, visible_flux
from cleaning.exposure.exposure import expose
from cleaning.surface.facets import build_facets, build_scene
from cleaning.verdicts.exposed_area import cells_of_side

BOARD = board_of("U1")
SCENE = build_scene(BOARD)
FACETS = build_facets(BOARD, SCENE)
STAGE = stage_of(samples_of([[x, 20.0, 45.0] for x in range(-10, 45, 5)], downward(20.0, 30.0), seconds=4.0))
JET = sprayed(STAGE)
CELLS = cells_of_side(FACETS, BOARD, "top")


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
    kept = many.hits > 0
    np.testing.assert_array_equal(sure.volume_mm[kept], many.volume_mm[kept])
    others = np.setdiff1d(np.arange(len(many.hits)), CELLS)
    np.testing.assert_array_equal(sure.cone_s[others], many.cone_s[others])


def test_a_component_that_hardly_any_ray_hit_is_worked_out_exactly():
    few = expose(STAGE, JET, FACETS, SCENE, 40)
    mine = CELLS[(FACETS.cell_component[CELLS] == 0) & FACETS.cell_exposed[CELLS]]
    assert 0 < few.hits[mine].sum() < 30
    sure = refine_sparse_cells(few, STAGE, JET, FACETS, SCENE, CELLS)
    exact = visible_flux(STAGE, JET, FACETS, SCENE, mine)
    np.testing.assert_allclose(sure.volume_mm[mine], exact.volume_mm)
    np.testing.assert_allclose(sure.peak_pa[mine], exact.peak_pa)


def test_one_place_in_a_cell_says_about_what_all_of_it_gets():
    middle = visible_flux(STAGE, JET, FACETS, SCENE, CELLS)
    whole = exact_exposure(STAGE, JET, FACETS, SCENE, CELLS)
    areas = FACETS.cell_areas_mm2[CELLS] * FACETS.cell_exposed[CELLS]
    assert middle.volume_mm @ areas == pytest.approx(whole.volume_mm @ areas, rel=0.02)
