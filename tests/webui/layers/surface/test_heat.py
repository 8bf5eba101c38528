"""The surface in changing colours: all of what is exposed is drawn, once, in the colours of its cells."""

from dataclasses import replace

import numpy as np
import pytest
from cleaning_report import small_report
from drawn_glb import drawn
from hypothesis import given, settings
from hypothesis import strategies as st

from cleaning.exposure.exposure import Growth
from webui.layers.surface.heat import Accumulation, has_changed, heat_pieces, paint_piece, shade


@pytest.mark.parametrize("most", [1, 50, 10**6])
def test_every_exposed_facet_is_drawn_once_and_lies_on_the_board(most):
    facets = small_report().facets
    pieces = heat_pieces(facets, most)
    colours = np.zeros((len(facets.cell_areas_mm2), 3), np.uint8)
    corners = np.concatenate([drawn(paint_piece(piece, colours))[0] for piece in pieces])
    wanted = facets.triangles[facets.exposed]
    assert len(corners) == len(wanted)
    middles, there = np.sort(corners.mean(axis=1), axis=0), np.sort(wanted.mean(axis=1), axis=0)
    np.testing.assert_allclose(middles, there, atol=0.05)
    cells = np.concatenate([piece.cells for piece in pieces])
    np.testing.assert_array_equal(np.sort(cells), np.unique(facets.cell[facets.exposed]))


def test_a_facet_has_the_colour_of_its_cell():
    facets = small_report().facets
    count = len(facets.cell_areas_mm2)
    shades = np.where(np.arange(count) % 2, 255, 0).astype(np.uint8)
    colours = np.column_stack([shades, shades, shades])
    for piece in heat_pieces(facets, 100):
        corners, tints = drawn(paint_piece(piece, colours))
        assert (tints[:, :, 0] == tints[:, :1, 0]).all()
        lit = np.isin(facets.cell, np.flatnonzero(shades)) & np.isin(facets.cell, piece.cells) & facets.exposed
        assert (tints[:, 0, 0] == 255).sum() == lit.sum()
        assert len(corners) == (np.isin(facets.cell, piece.cells) & facets.exposed).sum()


def test_only_the_piece_of_a_changed_cell_changes():
    facets = small_report().facets
    pieces = heat_pieces(facets, 100)
    assert len(pieces) > 3
    before = np.zeros((len(facets.cell_areas_mm2), 3), np.uint8)
    after = before.copy()
    after[pieces[1].cells[0]] = 9
    assert [has_changed(piece, after, before) for piece in pieces] == [at == 1 for at in range(len(pieces))]
    assert has_changed(pieces[0], before, None)


def test_nothing_is_drawn_of_a_board_that_sees_no_sky():
    facets = small_report().facets
    assert heat_pieces(replace(facets, exposed=np.zeros_like(facets.exposed))) == ()


@settings(max_examples=25)
@given(times=st.lists(st.floats(-5, 120), min_size=1, max_size=8))
def test_what_has_landed_does_not_depend_on_the_way_there(times):
    exposure = small_report().exposures[1]
    growth, cells = exposure.growth, len(exposure.volume_mm)
    kept = Accumulation(growth, cells)
    for time_s in times:
        ended = growth.until_s <= time_s
        entries = np.repeat(ended, np.diff(growth.start))
        wanted = np.bincount(growth.cell[entries], growth.volume_mm[entries], minlength=cells)
        np.testing.assert_allclose(kept.until(time_s), wanted, atol=1e-9)


def test_in_the_end_all_has_landed():
    for exposure in small_report().exposures:
        landed = Accumulation(exposure.growth, len(exposure.volume_mm)).until(1e9)
        np.testing.assert_allclose(landed, exposure.volume_mm, rtol=1e-5)


def test_where_nothing_ever_lands_nothing_grows():
    nothing = Growth(np.empty(0), np.zeros(1, np.int64), np.empty(0, np.int64), np.empty(0, np.float32))
    np.testing.assert_array_equal(Accumulation(nothing, 3).until(5.0), np.zeros(3))


def test_of_too_many_facets_the_largest_are_drawn():
    facets = small_report().facets
    pieces = heat_pieces(facets, drawn=200)
    colours = np.zeros((len(facets.cell_areas_mm2), 3), np.uint8)
    corners = np.concatenate([drawn(paint_piece(piece, colours))[0] for piece in pieces]).astype(float)
    sides = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas = np.linalg.norm(np.cross(*sides), axis=1) / 2
    np.testing.assert_allclose(np.sort(areas), np.sort(facets.areas_mm2[facets.exposed])[-200:], atol=1e-3)


def test_tops_are_as_the_legend_says_and_walls_darker():
    colours = np.tile(np.array([200, 100, 40], np.uint8), (4, 1))
    normals = np.array([[0, 0, 1], [0, 0, -1], [1, 0, 0], [0, -1, 0]], dtype=float)
    shaded = shade(colours, normals).astype(int)
    np.testing.assert_array_equal(shaded[:2], colours[:2])
    assert (shaded[2:] < colours[2:]).all()
    assert (shaded[2] != shaded[3]).any()
