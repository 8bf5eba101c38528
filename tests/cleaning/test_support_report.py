"""The report that other tests are built on agrees with itself."""

import numpy as np
import pytest
from cleaning_report import small_report

from cleaning.verdicts.rules import VERDICTS


def test_it_has_every_verdict():
    assert {part.verdict for part in small_report().parts} == {*VERDICTS} - {"avoided"}


def test_every_array_speaks_of_the_same_cells():
    report = small_report()
    cells = len(report.facets.cell_areas_mm2)
    assert report.facets.cell_areas_mm2.sum() == pytest.approx(report.facets.areas_mm2.sum())
    for exposure in report.exposures:
        assert len(exposure.volume_mm) == len(exposure.hits) == cells
        grown = np.bincount(exposure.growth.cell, exposure.growth.volume_mm, cells)
        np.testing.assert_allclose(grown, exposure.volume_mm, atol=1e-5)


def test_the_worst_comes_first_and_has_a_field_and_residue_in_the_same_cells():
    worst = small_report().worst_first()[0]
    assert (worst.component, worst.verdict, worst.residue) == ("U1", "dirty", 0.31)
    for gap in worst.gaps:
        field, last = gap.field, gap.stages[-1]
        assert field.pressure.shape == (8, len(field.cells))
        assert field.velocity.shape == (8, len(field.cells), 2)
        assert last is not None
        assert len(last.residue) == len(field.cells) < field.shape[0] * field.shape[1]
        assert last.residue.mean() == pytest.approx(gap.residue, rel=0.05)
