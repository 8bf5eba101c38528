from dataclasses import replace

import numpy as np
import pytest
from cleaning_report import small_report
from hypothesis import given
from hypothesis import strategies as st
from shapely import box
from small_boards import THICKNESS_MM, part
from small_sprays import solid_board

from cleaning.surface.facets import build_facets, build_scene
from cleaning.verdicts.exposed_area import (
    BARE,
    cells_of,
    cells_of_each,
    cells_of_side,
    exposed_part,
    low_value,
    percentile,
    shown_on_side,
    together,
)

REPORT = small_report()
FACETS, EXPOSURE = REPORT.facets, REPORT.exposures[0]
U1 = np.flatnonzero(FACETS.cell_component == 0)
ROWS = st.lists(st.tuples(st.floats(0, 100), st.floats(0.01, 10)), min_size=1, max_size=30)
BOARD = solid_board(
    part("U1", 10, 10, 6, 4, 2.0), part("U2", 30, 10, 6, 4, 2.0, side="bottom"), outline=box(0, 0, 50, 30, ccw=True)
)
CUT = build_facets(BOARD, build_scene(BOARD))


@given(rows=ROWS, share=st.floats(0.0, 1.0))
def test_at_least_the_share_lies_at_or_below_the_percentile_and_less_of_it_below(rows, share):
    values, weights = np.array(rows).T
    found = percentile(values, weights, share)
    assert found in values
    whole = weights.sum()
    assert weights[values <= found].sum() >= share * whole * (1 - 1e-9)
    assert weights[values < found].sum() <= share * whole * (1 + 1e-9)


@given(rows=st.lists(st.tuples(st.floats(0, 9), st.integers(1, 9)), min_size=1), seed=st.integers(0, 9))
def test_order_and_unit_of_the_weights_do_not_matter(rows, seed):
    values, weights = np.array(rows, dtype=float).T
    order = np.random.default_rng(seed).permutation(len(values))
    found = percentile(values, weights, 0.05)
    assert percentile(values[order], weights[order], 0.05) == found
    assert percentile(values, 4 * weights, 0.05) == found


def test_a_twentieth_of_the_area_may_get_less():
    values, areas = np.array([0.0, 1.0, 9.0]), np.array([4.0, 2.0, 94.0])
    assert percentile(values, areas, 0.05) == 1.0
    assert percentile(values, np.array([5.0, 1.0, 94.0]), 0.05) == 0.0
    assert percentile(values, np.array([1.0, 1.0, 98.0]), 0.05) == 9.0


def test_one_cell_of_a_small_part_is_not_its_least_wetted_twentieth():
    # Five faces of a chip: its worst twentieth is one wall, 0; the mean of the worst three by area is 3.3.
    values, areas = np.array([0.0, 6.0, 20.0, 2.0, 9.0]), np.array([0.2, 0.2, 0.5, 0.1, 0.1])
    assert percentile(values, areas, 0.05) == 0.0
    assert low_value(values, areas) == pytest.approx((0.0 * 0.2 + 2.0 * 0.1 + 6.0 * 0.2) / 0.5)
    assert low_value(values[:2], areas[:2]) == pytest.approx(3.0)


def test_of_many_cells_the_twentieth_counts():
    values, areas = np.arange(100.0), np.ones(100)
    assert low_value(values, areas) == percentile(values, areas, 0.05) == 4.0


def test_a_part_is_summed_up_by_area_over_what_it_shows():
    found = exposed_part(EXPOSURE, FACETS, U1)
    shown = U1[FACETS.cell_exposed[U1]]
    areas = FACETS.cell_areas_mm2
    assert 0 < len(shown) < len(U1)
    assert found.area_mm2 + found.hidden_mm2 == pytest.approx(areas[U1].sum())
    assert found.area_mm2 == pytest.approx(areas[shown].sum())
    least, low, mean = found.volume_mm
    assert least == EXPOSURE.volume_mm[shown].min()
    assert least <= low <= mean
    assert mean * found.area_mm2 == pytest.approx(EXPOSURE.volume_mm[shown] @ areas[shown])
    assert found.peak_pa == EXPOSURE.peak_pa[shown].max()


def test_what_the_cone_never_reaches_is_missed_even_if_it_is_little():
    shown = U1[FACETS.cell_exposed[U1]]
    cone = EXPOSURE.cone_s.copy()
    cone[shown] = 1.0
    assert exposed_part(replace(EXPOSURE, cone_s=cone), FACETS, U1).missed_share == 0.0
    cone[shown[0]] = 1e-6
    assert exposed_part(replace(EXPOSURE, cone_s=cone), FACETS, U1).missed_share == 0.0
    cone[shown[0]] = 0.0
    wanted = FACETS.cell_areas_mm2[shown[0]] / FACETS.cell_areas_mm2[shown].sum()
    assert exposed_part(replace(EXPOSURE, cone_s=cone), FACETS, U1).missed_share == pytest.approx(wanted)


def test_nothing_shown_is_nothing_missed():
    hidden = U1[~FACETS.cell_exposed[U1]]
    found = exposed_part(EXPOSURE, FACETS, hidden)
    assert (found.area_mm2, found.missed_share, found.peak_pa) == (0.0, 0.0, 0.0)
    assert found.hidden_mm2 == pytest.approx(FACETS.cell_areas_mm2[hidden].sum())


def test_stages_add_up_and_the_highest_pressure_counts():
    other = replace(EXPOSURE, peak_pa=2 * EXPOSURE.peak_pa[::-1], cone_s=0.5 * EXPOSURE.cone_s)
    both = together([EXPOSURE, other])
    assert together([EXPOSURE]) is EXPOSURE
    np.testing.assert_allclose(both.volume_mm, 2 * EXPOSURE.volume_mm)
    np.testing.assert_allclose(both.cone_s, 1.5 * EXPOSURE.cone_s)
    np.testing.assert_allclose(both.front_s, 2 * EXPOSURE.front_s)
    np.testing.assert_allclose(both.impulse_n_pa_s, 2 * EXPOSURE.impulse_n_pa_s)
    np.testing.assert_allclose(both.impulse_t_pa_s, 2 * EXPOSURE.impulse_t_pa_s)
    np.testing.assert_array_equal(both.hits, 2 * EXPOSURE.hits)
    np.testing.assert_array_equal(both.peak_pa, np.maximum(EXPOSURE.peak_pa, other.peak_pa))


@pytest.mark.parametrize(
    ("component", "side", "size"),
    [(0, "top", (6, 4)), (1, "bottom", (6, 4)), (BARE, "top", (50, 30)), (BARE, "bottom", (50, 30))],
)
def test_a_side_is_what_faces_it_and_the_walls(component, side, size):
    cells = cells_of(CUT, BOARD, component, side)
    up = 1.0 if side == "top" else -1.0
    height = THICKNESS_MM if component < 0 else 2.0 - BOARD.components[component].gap_height_mm
    face, walls = size[0] * size[1], 2 * (size[0] + size[1]) * height
    normals, areas = CUT.cell_normals[cells], CUT.cell_areas_mm2[cells]
    assert np.all(CUT.cell_component[cells] == component)
    assert np.all(up * normals[:, 2] > -0.2)
    facing = up * normals[:, 2] > 0.9
    # Of the bare board what lies under a part is hidden; its walls are seen from both sides.
    wanted = face if component >= 0 else face - 24
    assert areas[facing & CUT.cell_exposed[cells]].sum() == pytest.approx(wanted, rel=0.03)
    assert areas[abs(normals[:, 2]) < 0.1].sum() == pytest.approx(walls, rel=1e-6)


def test_a_side_has_its_own_components_and_the_bare_board_and_nothing_else():
    for side, own in (("top", 0), ("bottom", 1)):
        cells = cells_of_side(CUT, BOARD, side)
        pieces = np.concatenate([cells_of(CUT, BOARD, component, side) for component in (BARE, own)])
        np.testing.assert_array_equal(cells, np.sort(pieces))
        shown = shown_on_side(CUT, BOARD, side)
        np.testing.assert_array_equal(np.flatnonzero(shown), cells[CUT.cell_exposed[cells]])


def test_what_stands_beyond_the_other_surface_belongs_to_no_side():
    pins = replace(part("J1", 25, 15, 2, 2, 8.0), gap_height_mm=-THICKNESS_MM - 3.0)
    board = solid_board(pins, outline=box(0, 0, 50, 30, ccw=True))
    cut = build_facets(board, build_scene(board))
    beyond = (cut.cell_component == 0) & (cut.cell_centres[:, 2] < board.bottom_z_mm - 0.1)
    assert beyond.any()
    for side in ("top", "bottom"):
        assert not np.isin(np.flatnonzero(beyond), cells_of_side(cut, board, side)).any()


def test_fixtures_belong_to_no_side():
    clamp = replace(BOARD.bodies[1], name="F1", role="fixture")
    bodies = (BOARD.bodies[0], clamp, *BOARD.bodies[2:])
    clamped = replace(BOARD, bodies=bodies)
    mine = np.unique(CUT.cell[CUT.body == 1])
    loose = replace(
        CUT, cell_component=np.where(np.isin(np.arange(len(CUT.cell_component)), mine), BARE, CUT.cell_component)
    )
    for side in ("top", "bottom"):
        assert not np.isin(mine, cells_of_side(loose, clamped, side)).any()
        assert np.isin(cells_of_side(loose, clamped, side), cells_of_side(loose, BOARD, side)).all()
    assert np.isin(mine, cells_of_side(loose, BOARD, "top")).any()


def test_all_components_at_once_have_the_cells_that_each_has_alone():
    for row, (component, cells) in enumerate(zip(BOARD.components, cells_of_each(CUT, BOARD), strict=True)):
        np.testing.assert_array_equal(cells, cells_of(CUT, BOARD, row, component.side))
