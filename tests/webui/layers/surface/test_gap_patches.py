"""What is in a gap is seen on top of its part, just above where it is."""

from dataclasses import replace

import numpy as np
import pytest
from cleaning_report import small_report
from drawn_glb import drawn
from hypothesis import given, settings
from hypothesis import strategies as st

from webui.layers.surface.heat import gap_patches_glb, place, pool
from webui.layers.surface.heat_scale import MEASURES, cell_values, harder_gap, make_scale

REPORT = small_report()
U1 = next(part for part in REPORT.parts if part.component == "U1")


def scale_of(name, stage=0):
    measure = MEASURES[name]
    return make_scale(REPORT, measure, cell_values(REPORT, measure, stage), "gradient", 1.0)


def test_patches_cover_the_underside_once():
    values = harder_gap(U1, "residue", 0)
    corners = place(REPORT.board, U1.underside, pool(values, 1))
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    np.testing.assert_allclose(high[:2] - low[:2], [U1.underside.length_mm, U1.underside.width_mm])
    np.testing.assert_allclose((high + low)[:2] / 2, [U1.underside.x_mm, U1.underside.y_mm])
    component = next(each for each in REPORT.board.components if each.name == "U1")
    assert low[2] == high[2]
    assert 0 < low[2] - REPORT.board.top_z_mm - component.height_mm < 0.1
    sides = corners[:, 2] - corners[:, 0]
    assert (sides[:, 0] * sides[:, 1]).sum() == pytest.approx(U1.underside.length_mm * U1.underside.width_mm)


def test_each_cell_lies_where_the_model_has_it():
    values = harder_gap(U1, "residue", 0)
    patches = pool(values, 1)
    np.testing.assert_allclose(patches.middles[values.field.cells], 1000 * values.field.centres, atol=1e-9)
    np.testing.assert_allclose(patches.values[values.field.cells], values.values)
    assert np.isnan(patches.values).sum() == np.prod(values.field.shape) - len(values.field.cells)


@settings(max_examples=15)
@given(together=st.integers(1, 20))
def test_fewer_patches_keep_the_place_and_the_range(together):
    values = harder_gap(U1, "shear", 0)
    patches = pool(values, together)
    assert len(patches.values) == (-(-16 // together)) ** 2
    assert np.nanmax(patches.values) <= values.values.max() + 1e-9
    assert np.nanmin(patches.values) >= values.values.min() - 1e-9
    np.testing.assert_allclose(patches.middles.mean(axis=0), 0.0, atol=1e-9)


@settings(max_examples=10)
@given(turn=st.floats(-4, 4))
def test_patches_turn_with_their_part(turn):
    patches = pool(harder_gap(U1, "residue", 0), 1)
    still = place(REPORT.board, replace(U1.underside, turn_rad=0.0), patches).reshape(-1, 3)
    turned = place(REPORT.board, replace(U1.underside, turn_rad=turn), patches).reshape(-1, 3)
    middle = np.array([U1.underside.x_mm, U1.underside.y_mm])
    there = (still[:, :2] - middle) @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    np.testing.assert_allclose(turned[:, :2] - middle, there, atol=1e-9)


def test_all_gaps_that_a_stage_acts_on_are_drawn():
    corners, _ = drawn(gap_patches_glb(REPORT, 0, scale_of("Residue under parts")))
    assert len(corners) == 2 * 2 * 16 * 16  # U1 and R1, two triangles a patch
    fewer, _ = drawn(gap_patches_glb(REPORT, 0, scale_of("Residue under parts"), most=100))
    assert len(fewer) < len(corners) / 3
    gas = tuple(
        replace(part, gaps=tuple(replace(gap, stages=(None, None)) for gap in part.gaps)) for part in REPORT.parts
    )
    assert gap_patches_glb(replace(REPORT, parts=gas), 0, scale_of("Residue under parts")) == b""
