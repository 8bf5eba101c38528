"""The tab Cleaning: what was analysed, what of it counts still, and what is shown of it."""

import re
import time
from contextlib import contextmanager
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from cleaning_report import small_report
from made_findings import made_finding
from small_page import find, folder_of, html_in, press, small_page
from small_scene import SmallScene
from tiny_session import tiny_session
from waiting import wait_for

from cleaning.errors import CleaningError
from cleaning.parameters.load import load_parameters
from reports.cards.cleaning import cleaned_component_card, headline_card
from webui.page.evaluations import Analysed, AnalysisSettings, Checked, analyse_run
from webui.page.project import ProjectError, open_project
from webui.page.session import Selection
from webui.panels.cleaning import analysis as cleaning
from webui.panels.cleaning.analysis import CleaningPanel, state_html
from webui.theme.html import card_html


def analysed_session():
    session = tiny_session()
    return replace(session, analysed=Analysed(session.run.program, "default", small_report()))


@contextmanager
def opened(session, folder):
    with small_page(session, open_project(folder)) as page:
        scene = SmallScene(page)
        panel = CleaningPanel(page, scene)
        page.open()
        yield page, scene, panel
        page.close()


@pytest.fixture
def by_hand(monkeypatch):
    """Analyses end at once with the report that was made by hand; which they were is remembered."""
    asked = []

    def analyse(run, wanted, _before, progress):
        asked.append((wanted.parameters_name, wanted.parameters.parameters, wanted.effort))
        progress("casting rays", 0.5)
        return Analysed(run.program, wanted.parameters_name, small_report())

    monkeypatch.setattr(cleaning, "analyse_run", analyse)
    return asked


def heat_nodes(page):
    return [name for name in page.client.scene._handle_from_node_name if name.startswith("/heat/")]


def test_an_analysis_counts_for_its_program_and_its_parameters_alone():
    session = analysed_session()
    assert session.analysis is session.analysed
    assert "1 of 5 components dirty" in state_html(session)
    newer = replace(session, run=replace(session.run, program=replace(session.run.program)))
    assert newer.analysis is None
    assert "changed since" in state_html(newer)
    assert "parameter set default: dirty." in state_html(newer)
    assert replace(session, parameters_name="other").analysis is None
    assert replace(replace(session, parameters_name="other"), parameters_name="default").analysis is session.analysed
    assert session.with_workpiece("other", session.board).analysed is None
    assert "Not analysed" in state_html(tiny_session())
    timed = SimpleNamespace(program=replace(session.run.program))
    checked = replace(session, checked=Checked(session.run, session.cell, timed, SimpleNamespace()))
    assert checked.analysis is None
    assert "Since the check the program has the times of the robot" in state_html(checked)


def test_the_headline_never_claims_more_than_the_model_can():
    text = state_html(analysed_session())
    assert "uncalibrated" in text
    assert "SIR" in text
    assert "J-STD" not in text
    assert "1 dirty, 1 marginal, 1 no verdict, 2 clean" in text


@pytest.mark.slow
def test_the_board_is_made_ready_once_for_its_parameters():
    session = tiny_session()
    parameters = load_parameters()
    told = []
    first = analyse_run(
        session.run, AnalysisSettings("default", parameters, "sketch"), None, lambda what, _: told.append(what)
    )
    again = analyse_run(session.run, AnalysisSettings("default", parameters, "sketch"), first, lambda *_: None)
    assert again.prepared is first.prepared
    assert again.report.facets is first.report.facets
    np.testing.assert_array_equal(again.report.exposures[0].volume_mm, first.report.exposures[0].volume_mm)
    hotter = parameters.model_copy(update={"description": "another one"})
    other = analyse_run(session.run, AnalysisSettings("other", hotter, "sketch"), first, lambda *_: None)
    assert other.prepared is not first.prepared
    assert replace(session, analysed=first).analysis is first
    assert told


@pytest.mark.slow
def test_how_sure_the_verdicts_are_is_told_on_the_headline_and_on_each_part():
    session = tiny_session()
    settings = AnalysisSettings("default", load_parameters(), "sketch", capability=True)
    report = analyse_run(session.run, settings, None, lambda *_: None).report
    found = report.capability
    assert found is not None
    assert f"in {100 * found.together:.0f} of 100 sets of values" in card_html(headline_card(report, "as planned"))
    u1 = next(part for part in report.parts if part.component == "U1")
    (share,) = (each.clean_share for each in found.parts if each.component == "U1")
    assert f"Clean in {100 * share:.0f} of 100 sets of values; else R7" in card_html(cleaned_component_card(report, u1))


def test_the_strokes_that_spray_the_selected_part_are_lit():
    session = replace(analysed_session(), selection=Selection(component="U1"))
    assert set(map(str, session.lit)) == {"sequence[0]/around/U1", "sequence[0]/sweep"}
    assert replace(session, selection=Selection("U1", "sequence[0]/edge")).lit == {"sequence[0]/edge"}
    assert replace(session, selection=Selection()).lit == frozenset()
    assert replace(session, analysed=None).lit == frozenset()


def test_analyse_shows_the_parts_worst_first_and_flies_to_the_worst(tmp_path, by_hand):
    with opened(tiny_session(), tmp_path) as (page, scene, panel):
        press(page, "Effort", "Full")
        press(page, "Analyse")
        wait_for(lambda: page.session.analysis is not None)
        assert by_hand == [("default", "default", "full")]
        assert find(page, "Part").options[1:] == tuple(part.component for part in small_report().worst_first())
        wait_for(lambda: "dirty" in panel._run._line.content)
        press(page, "Through", "Worst")
        assert page.session.selection.component == "U1"
        assert scene.looked == ["U1"]
        card = html_in(page, "Why")
        for wanted in ("grade C", "Wash it longer", "What limits it", "Sprayed by", "limit 20"):
            assert wanted in card
        press(page, "Through", "Better")
        press(page, "Through", "Better")
        assert page.session.selection.component == "J1"
        press(page, "Through", "Worse")
        assert page.session.selection.component == "R1"
        page.select(component="C1")
        assert find(page, "Part").value == "C1"


def test_other_parameters_take_the_results_out_of_sight(tmp_path, by_hand):
    (tmp_path / "mine.yaml").write_text("extends: default\nparameters: mine\nprovenance: {}\n")
    (tmp_path / "notes.yaml").write_text("words: none\n")
    with opened(tiny_session(), tmp_path) as (page, _, panel):
        assert "mine.yaml" in find(page, "Parameters").options
        assert "notes.yaml" not in find(page, "Parameters").options
        press(page, "Analyse")
        wait_for(lambda: page.session.analysis is not None)
        press(page, "Show", "Volume")
        wait_for(lambda: heat_nodes(page))
        press(page, "Parameters", "mine.yaml")
        assert page.session.analysis is None
        assert heat_nodes(page) == []
        assert "changed since" in panel._run._line.content
        press(page, "Parameters", "default")
        assert "dirty" in panel._run._line.content


def test_a_parameter_set_outside_the_folder_is_refused(tmp_path):
    with pytest.raises(ProjectError, match="outside"):
        open_project(tmp_path).open_parameters("../default.yaml")
    assert open_project(tmp_path).open_parameters("default").parameters == "default"


def test_what_stops_an_analysis_is_said_in_the_tab(tmp_path, monkeypatch):
    def fail(*_):
        raise CleaningError("no liquid of the name steam; add it", path="liquids")

    monkeypatch.setattr(cleaning, "analyse_run", fail)
    with opened(tiny_session(), tmp_path) as (page, _, panel):
        press(page, "Analyse")
        wait_for(lambda: "steam" in panel._run._line.content)
        assert find(page, "Analyse").label == "Analyse"
        assert page.client.said == []


def test_an_analysis_that_is_given_up_leaves_nothing(tmp_path, monkeypatch):
    def slow(*asked):
        while True:
            time.sleep(0.01)
            asked[-1]("casting rays", 0.5)

    monkeypatch.setattr(cleaning, "analyse_run", slow)
    with opened(tiny_session(), tmp_path) as (page, _, panel):
        press(page, "Analyse")
        wait_for(lambda: "Casting rays" in panel._run._line.content)
        press(page, "Cancel")
        assert find(page, "Analyse").label == "Analyse"
        assert page.session.analysed is None
        assert "Not analysed" in panel._run._line.content


def test_a_heat_map_is_drawn_and_taken_away(tmp_path):
    with opened(analysed_session(), tmp_path) as (page, scene, panel):
        assert not find(page, "Stage").visible
        press(page, "Show", "Volume")
        assert heat_nodes(page)
        assert find(page, "Stage").visible
        assert not find(page, "Limit (mm)").visible
        legend = panel._heat._legend
        assert "mm or more" in legend.content
        press(page, "Colours", "Pass or fail")
        assert find(page, "Limit (mm)").value == 5.0
        assert "at least 5 mm" in legend.content
        press(page, "Stage", "2 rinse")
        assert find(page, "Limit (mm)").value == 2.0
        page.select(component="U1")
        assert len(scene.layers["/heat_selected"]) > 0
        press(page, "Show", "Verdict")
        assert not find(page, "Stage").visible
        assert "Dirty: 1" in legend.content
        press(page, "Show", "Nothing")
        assert heat_nodes(page) == []
        assert scene.layers["/heat_selected"] == b""
        assert legend.content == ""


def test_a_limit_is_kept_for_its_measure_and_a_bad_one_is_refused(tmp_path):
    with opened(analysed_session(), tmp_path) as (page, _, panel):
        press(page, "Show", "Residue under parts")
        press(page, "Colours", "Pass or fail")
        press(page, "Limit (%)", 25.0)
        legend = panel._heat._legend
        assert "at most 25 %" in legend.content
        press(page, "Limit (%)", -3.0)
        assert find(page, "Limit (%)").value == 25.0
        assert "give one above 0" in page.client.said[-1]
        press(page, "Show", "Volume")
        assert find(page, "Limit (mm)").value == 5.0
        press(page, "Show", "Residue under parts")
        assert find(page, "Limit (%)").value == 25.0


@pytest.mark.slow
def test_the_volume_grows_with_the_playback(tmp_path):
    with opened(analysed_session(), tmp_path) as (page, scene, panel):
        press(page, "Show", "Volume")
        press(page, "Colours", "Pass or fail")
        press(page, "Limit (mm)", 3.0)
        legend = panel._heat._legend
        in_the_end = legend.content
        press(page, "As it grows", True)
        wait_for(lambda: passed(legend) == 0.0)
        shares = [0.0]
        for moment in (15.0, 30.0, 60.0):
            scene.seek(moment)
            wait_for(lambda: passed(legend) > shares[-1])
            shares.append(passed(legend))
        wait_for(lambda: legend.content == in_the_end)
        scene.seek(0.0)
        wait_for(lambda: passed(legend) == 0.0)
        press(page, "As it grows", False)
        assert legend.content == in_the_end


def passed(legend):
    return float(re.search(r"at least 3 mm: ([\d.]+) %", legend.content)[1])


@pytest.mark.slow
def test_a_moment_that_comes_late_draws_nothing(tmp_path):
    with opened(analysed_session(), tmp_path) as (page, scene, panel):
        press(page, "Show", "Volume")
        press(page, "As it grows", True)
        scene.seek(20.0)
        press(page, "Show", "Nothing")
        panel._heat._draw_growth(30.0)
        scene.seek(40.0)
        time.sleep(0.5)
        assert heat_nodes(page) == []
        assert panel._heat._legend.content == ""


def test_paths_can_be_taken_out_of_the_way(tmp_path):
    with opened(analysed_session(), tmp_path) as (page, scene, _):
        press(page, "Paths too", False)
        assert not scene.view.paths
        press(page, "Paths too", True)
        assert scene.view.paths
        press(page, "Paths too", False)
        page.remember(lambda session: replace(session, parameters_name="other"))
        assert scene.view.paths
        assert find(page, "Paths too").value


def test_the_gap_of_the_selected_part_is_seen_from_above(tmp_path):
    with opened(analysed_session(), tmp_path) as (page, _, _):
        gap = folder_of(page, "Gap from above")
        assert not gap.visible
        page.select(component="C1")
        assert not gap.visible
        page.select(component="U1")
        assert gap.visible
        assert find(page, "Standoff").options == ("50 µm", "75 µm")
        before = html_in(page, "Gap from above")
        press(page, "Standoff", "75 µm")
        press(page, "In the gap", "Pressure")
        assert html_in(page, "Gap from above") != before
        assert "Pa" in html_in(page, "Gap from above")
        page.select(component="R1")
        assert find(page, "Standoff").value == "30 µm"
        report = small_report()
        u1 = next(part for part in report.parts if part.component == "U1")
        dry = replace(u1, gaps=(replace(u1.gaps[0], stages=(None, None)),))
        parts = tuple(dry if part is u1 else part for part in report.parts)
        page.remember(lambda s: replace(s, analysed=replace(s.analysed, report=replace(report, parts=parts))))
        page.select(component="U1")
        assert "does not act" in html_in(page, "Gap from above")


def test_a_board_without_parts_is_analysed_too(tmp_path):
    report = small_report()
    facets = replace(report.facets, cell_component=np.full_like(report.facets.cell_component, -1))
    bare = replace(report, parts=(), facets=facets, verdict="clean")
    session = tiny_session()
    with opened(replace(session, analysed=Analysed(session.run.program, "default", bare)), tmp_path) as (
        page,
        scene,
        panel,
    ):
        press(page, "Through", "Worst")
        assert scene.looked == []
        press(page, "Show", "Residue under parts")
        assert "Nothing to show" in panel._heat._legend.content
        assert "no parts" in html_in(page, "Parts")


def test_where_parts_are_not_clean_what_masks_take_away_is_named():
    session = analysed_session()
    cut = made_finding("cut-by-mask", "warning", "Strokes cut: 2; 40% of the way is left out.", "sequence[0]/sweep")
    little = made_finding("cut-by-mask", "info", "Strokes cut: 1; 3% of the way is left out.", "sequence[0]/edge")
    run = replace(session.run, findings=(cut, little))
    masked = replace(session, run=run)
    assert masked.analysis is not None
    assert "40% of the way" in state_html(masked)
    assert "3% of the way" not in state_html(masked)
    assert "of the way" not in state_html(session)
    clean = replace(masked.analysed.report, parts=(), process=())
    clean = replace(clean, bare=next(each for each in small_report().parts if each.verdict == "clean"))
    assert "of the way" not in state_html(replace(masked, analysed=replace(masked.analysed, report=clean)))
