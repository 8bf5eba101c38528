import numpy as np
import pytest
from cleaning_report import small_report

from reports.pictures.cell_pixels import see_cells
from reports.pictures.sheet import view_of


@pytest.fixture(scope="module")
def seen():
    report = small_report()
    return see_cells(report.facets, "top", view_of(report.board), 300)


def pixel_of(seen, x, y):
    rows, columns = seen.cell.shape
    (x0, y0), (x1, y1) = seen.view.low, seen.view.high
    return int((y1 - y) / (y1 - y0) * rows), int((x - x0) / (x1 - x0) * columns)


def test_each_pixel_shows_the_cell_that_lies_there(seen):
    centres = small_report().facets.cell_centres
    for x, y in ((3.5, 2.5), (20.5, 17.5), (12.5, 8.5)):
        cell = seen.cell[pixel_of(seen, x, y)]
        assert np.abs(centres[cell][:2] - (x, y)).max() < 1e-6


def test_a_component_hides_the_board_beneath_it(seen):
    facets = small_report().facets
    top = seen.cell[pixel_of(seen, 9.0, 12.0)]
    assert small_report().board.components[facets.cell_component[top]].name == "U1"
    assert facets.cell_centres[top][2] > 0.5


def test_what_is_outside_of_the_board_has_no_value(seen):
    values = seen.filled(np.ones(len(small_report().facets.cell_areas_mm2)))
    assert np.isnan(values[0, 0])
    assert np.nanmin(values) == np.nanmax(values) == 1.0


def test_the_bottom_of_a_board_that_has_no_facets_there_is_empty():
    report = small_report()
    facing_down = see_cells(report.facets, "bottom", view_of(report.board), 100)
    assert not np.isin(facing_down.cell, np.flatnonzero(report.facets.cell_normals[:, 2] > 0.9)).any()
