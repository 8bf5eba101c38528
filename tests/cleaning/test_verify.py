from dataclasses import replace

import numpy as np
import pytest
from cleaning_report import small_report

from cleaning import verify as module
from cleaning.errors import CleaningError
from cleaning.exposure.exact import ExactExposure
from cleaning.prepared_board import PreparedBoard
from cleaning.verdicts.exposed_area import cells_of_each
from cleaning.verify import check_names, verify


def prepared() -> PreparedBoard:
    report = small_report()
    nothing = np.zeros(0)
    return PreparedBoard(
        board=report.board, parameters=report.parameters, scene=nothing, facets=report.facets,
        cells=cells_of_each(report.facets, report.board), overrides=(),
        undersides=(), rows=(), edges=nothing, run_off={}, fields=(),
    )  # fmt: skip


def twice_the_rays(stage, _jet, _facets, _scene, cells):
    report = small_report()
    at = [each.made_by for each in report.stages].index(stage.made_by)
    volume = 2 * report.exposures[at].volume_mm[cells]
    return ExactExposure(cells, *(volume,) * 6)


def test_both_ways_are_told_for_each_stage_that_sprays_a_liquid(monkeypatch):
    monkeypatch.setattr(module, "exact_exposure", twice_the_rays)
    report = small_report()
    told = verify(report, prepared(), ["U1", "C1", "U1"])
    assert [(each.component, each.function) for each in told] == [
        ("U1", "clean"), ("U1", "rinse"), ("C1", "clean"), ("C1", "rinse"),
    ]  # fmt: skip
    for each in told:
        assert each.exact_mm == pytest.approx(2 * each.rays_mm)
        assert 0 < each.rays_mm <= each.worst_mm
    dry = replace(report, stages=(report.stages[0], replace(report.stages[1], use="dry")))
    assert [each.function for each in verify(dry, prepared(), ["U1"])] == ["clean"]


def test_the_mean_is_by_area_of_what_is_exposed(monkeypatch):
    monkeypatch.setattr(module, "exact_exposure", twice_the_rays)
    report = small_report()
    facets = report.facets
    cells = (facets.cell_component == 0) & facets.cell_exposed
    expected = np.average(report.exposures[0].volume_mm[cells], weights=facets.cell_areas_mm2[cells])
    assert verify(report, prepared(), ["U1"])[0].rays_mm == pytest.approx(expected)


def test_an_unknown_component_is_refused_with_one_like_it():
    with pytest.raises(CleaningError, match=r"tiny has no component 'U9'\. Did you mean U1\?"):
        check_names(small_report().board, ["C1", "U9"])


def test_what_faces_the_other_side_is_not_looked_at_as_it_is_not_judged(monkeypatch):
    monkeypatch.setattr(module, "exact_exposure", twice_the_rays)
    report, before = small_report(), prepared()
    normals = report.facets.cell_normals.copy()
    mine = np.flatnonzero((report.facets.cell_component == 0) & report.facets.cell_exposed & (normals[:, 2] > 0.9))
    normals[mine[0]] = (0.0, 0.0, -1.0)
    facets = replace(report.facets, cell_normals=normals)
    turned = replace(before, facets=facets, cells=cells_of_each(facets, report.board))
    assert verify(report, turned, ["U1"])[0].cells == verify(report, before, ["U1"])[0].cells - 1
