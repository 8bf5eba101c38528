"""What a heat map says is what the report says."""

import re
from dataclasses import replace

import numpy as np
import pytest
from cleaning_report import small_report, soaked_report

from cleaning.verdicts.rules import OUTCOMES
from reports.tables.cleaning_tables import OUTCOME_WORDS
from webui.layers.surface.heat_scale import (
    FAILS,
    MEASURES,
    MISSED,
    PASSES,
    LimitError,
    cell_values,
    check_limit,
    make_scale,
    scale_html,
    tint_cells,
)
from webui.theme.palette import BOARD, COMPONENT, VERDICT_COLOURS


def shown(name, colouring="gradient", stage=0, limit=None):
    report, measure = small_report(), MEASURES[name]
    values = cell_values(report, measure, stage)
    chosen = measure.limit(report.parameters.limits, report.stages[stage]) if limit is None else limit
    scale = make_scale(report, measure, values, colouring, chosen)
    return values, tint_cells(report.facets, values, scale), scale_html(report, values, scale), scale


def plain_cells(facets):
    return np.where((facets.cell_component < 0)[:, None], BOARD, COMPONENT)


def cells_of(name):
    report = small_report()
    number = next(at for at, part in enumerate(report.parts) if part.component == name)
    return (report.facets.cell_component == number) & report.facets.cell_exposed


@pytest.mark.parametrize("name", [name for name, measure in MEASURES.items() if measure.per == "cell"])
def test_numbers_of_the_surface_are_those_of_the_stage(name):
    report, measure = small_report(), MEASURES[name]
    fields = {"cone": "cone_s", "front": "front_s", "volume": "volume_mm", "supply": "supply_mm", "peak": "peak_pa"}
    for stage, exposure in enumerate(report.exposures):
        values = cell_values(report, measure, stage)
        exposed = report.facets.cell_exposed
        np.testing.assert_array_equal(values[exposed], getattr(exposure, fields[measure.name])[exposed])
        assert np.isnan(values[~exposed]).all()


def test_nothing_is_said_of_a_side_that_is_not_sprayed():
    report = small_report()
    turned = replace(report.stages[0].samples, axes=-report.stages[0].samples.axes)
    below = replace(report, stages=(replace(report.stages[0], samples=turned), report.stages[1]))
    for name in ("Volume", "Peak pressure"):
        assert np.isnan(cell_values(below, MEASURES[name], 0)).all()
        assert np.isfinite(cell_values(below, MEASURES[name], 1)).any()


def test_numbers_of_parts_stand_on_their_parts_alone():
    for name in ("Shear under parts", "Residue under parts"):
        values = cell_values(small_report(), MEASURES[name], 0)
        said = np.isfinite(values)
        np.testing.assert_array_equal(said, cells_of("U1") | cells_of("R1"))
    residue = cell_values(small_report(), MEASURES["Residue under parts"], 0)
    u1 = next(part for part in small_report().parts if part.component == "U1")
    hard = u1.gaps[0].stages[0].residue
    assert residue[cells_of("U1")] == pytest.approx(100 * hard.mean())  # the harder of its two bounds


def test_a_verdict_has_its_colour_and_its_word():
    values, colours, html, _ = shown("Verdict")
    for part in small_report().parts:
        mine = cells_of(part.component)
        assert (colours[mine] == VERDICT_COLOURS[part.verdict]).all()
        assert OUTCOME_WORDS[part.verdict] in html
    assert np.isnan(values[small_report().facets.cell_component < 0]).all()
    assert tuple(VERDICT_COLOURS) == tuple(OUTCOME_WORDS) == OUTCOMES
    assert "Clean: 2" in html
    assert "Clean, wet underneath: 0" in html


def test_what_is_clean_and_stays_wet_does_not_look_as_what_is_near_a_limit():
    report, measure = soaked_report(), MEASURES["Verdict"]
    values = cell_values(report, measure, 0)
    scale = make_scale(report, measure, values, "gradient", 0.0)
    colours = tint_cells(report.facets, values, scale)
    for name, said in (("C1", "clean, wet"), ("R1", "marginal"), ("U1", "dirty"), ("J1", "no verdict")):
        assert (colours[cells_of(name)] == VERDICT_COLOURS[said]).all()
    html = scale_html(report, values, scale)
    for legend in ("Dirty: 1", "Marginal: 1", "No verdict: 1", "Clean, wet underneath: 2", "Clean: 0"):
        assert legend in html


def test_a_gradient_marks_what_nothing_reached_and_rises_with_the_value():
    values, colours, html, scale = shown("Volume")
    exposed = np.isfinite(values)
    missed = exposed & (values <= 0)
    assert missed.any()
    assert (colours[missed] == MISSED).all()
    wet = np.flatnonzero(exposed & (values > 0))
    order = wet[np.argsort(values[wet])]
    reds = colours[order, 0].astype(int)
    assert reds[-1] > reds[0]
    assert values[wet].max() <= 1.5 * scale.top
    assert "mm or more" in html
    assert "nothing landed" in html
    np.testing.assert_array_equal(colours[~exposed], plain_cells(small_report().facets)[~exposed])


@pytest.mark.parametrize(("name", "limit", "beyond"), [("Volume", 5.0, np.less), ("Peak pressure", 300.0, np.greater)])
def test_a_limit_parts_the_surface_in_two(name, limit, beyond):
    values, colours, html, _ = shown(name, "limit", limit=limit)
    exposed = np.isfinite(values)
    fails = exposed & beyond(values, limit)
    assert 0 < fails.sum() < exposed.sum()
    assert (colours[fails] == FAILS).all()
    assert (colours[exposed & ~fails] == PASSES).all()
    share = small_report().facets.cell_areas_mm2[fails].sum() / small_report().facets.cell_areas_mm2[exposed].sum()
    said = re.findall(r"([\d.]+) % of the area", html)
    assert [float(each) for each in said] == pytest.approx([100 * (1 - share), 100 * share], abs=0.5)


def test_limits_come_from_the_parameter_set():
    report = small_report()
    volume = MEASURES["Volume"].limit
    assert [volume(report.parameters.limits, stage) for stage in report.stages] == [5.0, 2.0]
    assert MEASURES["Residue under parts"].limit(report.parameters.limits, report.stages[0]) == pytest.approx(5.0)


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan, np.inf, 101.0])
def test_a_limit_that_parts_nothing_is_refused_with_a_reason(bad):
    with pytest.raises(LimitError, match="give"):
        check_limit(MEASURES["Residue under parts"], bad)
    assert check_limit(MEASURES["Residue under parts"], 20.0) == 20.0


def test_a_stage_that_reaches_nothing_says_so():
    report = small_report()
    hidden = replace(report.facets, cell_exposed=np.zeros_like(report.facets.cell_exposed))
    report = replace(report, facets=hidden)
    measure = MEASURES["Volume"]
    values = cell_values(report, measure, 0)
    scale = make_scale(report, measure, values, "gradient", 5.0)
    assert "Nothing to show" in scale_html(report, values, scale)
    np.testing.assert_array_equal(tint_cells(report.facets, values, scale), plain_cells(report.facets))


def test_little_residue_looks_like_little():
    report, measure = small_report(), MEASURES["Residue under parts"]
    values = cell_values(report, measure, 0)
    tops = [make_scale(report, measure, values * share, "gradient", 5.0).top for share in (1e-3, 1.0, 10.0)]
    assert tops == [10.0, pytest.approx(50.0, abs=20.0), 100.0]
    full = make_scale(report, measure, values * 10, "gradient", 5.0)
    assert "100 %<" in scale_html(report, values, full)
    assert "% or more" in scale_html(report, values, make_scale(report, measure, values, "gradient", 5.0))
