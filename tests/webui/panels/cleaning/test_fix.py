"""Fix this: what is suggested for the part that is selected, and that one of it is one edit that can be undone."""

import time
from contextlib import contextmanager
from dataclasses import replace

import pytest
from cleaning_report import small_report
from small_page import find, folder_of, inputs, press, small_page
from tiny_session import tiny_session
from tuned_recipe import slower
from waiting import wait_for

from cleaning.parameters.load import load_parameters
from cleaning.verdicts.results import Judgement
from cleaning.verdicts.rules import RESIDUE_LEFT, WET_GAP
from recipes.errors import RecipeError
from rulesengine.tuning.report import Effect, Suggestion
from rulesengine.tuning.trial.outcome import Figures
from webui.page.evaluations import Analysed
from webui.page.project import open_project
from webui.page.session import Selection
from webui.panels.cleaning.parts import APPLY, CANCEL, SUGGEST, FixCard
from webui.tuning import background as tuning_suggest
from webui.tuning.proposal_html import Fix

BEFORE, AFTER = Figures(2, 9, 0.31, 90.0, 2.5), Figures(3, 6, 0.04, 104.5, 2.9)


def analysed_session(component="U1", effort="fast"):
    session = tiny_session()
    analysed = Analysed(session.run.program, "default", small_report(), None, effort)
    return replace(replace(session, analysed=analysed), selection=Selection(component=component))


def fix(session, what="templates.sweep.speed_mm_s: 60 -> 45", *, resolved=True):
    text = slower(session.document.text)
    return Fix("U1", what, session.document, text, BEFORE, AFTER, resolved=resolved)


@contextmanager
def opened(session, folder):
    with small_page(session, open_project(folder)) as page:
        card = FixCard(page)
        page.open()
        yield page, card
        page.close()


@pytest.fixture
def by_hand(monkeypatch):
    asked = []

    def suggest_fixes(component, _session, _parameters, progress):
        asked.append(component)
        progress("planning", 0.5)
        return (fix(tiny_session()), fix(tiny_session(), "functions.clean.pressure_bar: 3.5 -> 4.4", resolved=False))

    monkeypatch.setattr(tuning_suggest, "suggest_fixes", suggest_fixes)
    return asked


def shown(page):
    return [handle.visible for handle in inputs(page) if getattr(handle, "label", None) == APPLY]


def test_it_is_offered_only_for_parts_that_are_not_clean(tmp_path):
    with opened(analysed_session("C1"), tmp_path) as (page, _):
        assert not folder_of(page, "Fix this").visible
        page.select(component="U1")
        assert folder_of(page, "Fix this").visible
        page.select(component="R1")
        assert folder_of(page, "Fix this").visible
        page.select()
        assert not folder_of(page, "Fix this").visible  # the bare board is clean
        page.select(component="U1")
        page.remember(lambda session: replace(session, parameters_name="other"))
        assert not folder_of(page, "Fix this").visible


def test_suggestions_tell_effect_and_cost_and_one_is_applied(tmp_path, by_hand):
    with opened(analysed_session(), tmp_path) as (page, card):
        before = page.session.document.text
        press(page, SUGGEST)
        wait_for(lambda: shown(page) == [True, True, False])
        assert by_hand == ["U1"]
        told = card._slots[0][0].content
        for wanted in ("60 -&gt; 45", "clean", "31.0 %", "4.0 %", "+14.5 s, +0.40 l"):
            assert wanted in told
        assert "not clean yet" in card._slots[1][0].content
        press(page, APPLY, at=0)
        assert page.session.document.text == slower(before)
        assert page.session.analysis is None
        assert not folder_of(page, "Fix this").visible
        assert "Analyse again" in page.client.said[-1]
        page.attempt(lambda session: session.with_document(session.document.undone()))
        assert page.session.document.text == before


def test_suggestions_are_kept_by_part_while_their_analysis_counts(tmp_path, by_hand):
    with opened(analysed_session(), tmp_path) as (page, _):
        press(page, SUGGEST)
        wait_for(lambda: any(shown(page)))
        page.select(component="R1")
        assert not any(shown(page))
        page.select(component="U1")
        assert shown(page) == [True, True, False]
        newer = Analysed(page.session.run.program, "default", small_report())
        page.remember(lambda session: replace(session, analysed=newer))
        assert not any(shown(page))


def test_a_suggestion_for_another_text_is_refused(tmp_path, by_hand):
    with opened(analysed_session(), tmp_path) as (page, _):
        press(page, SUGGEST)
        wait_for(lambda: any(shown(page)))
        page.attempt(lambda session: session.edited(session.document.text + "# mine\n"))
        press(page, APPLY, at=0)
        assert "edited since" in page.client.said[-1]
        assert page.session.document.text.endswith("# mine\n")


def test_suggesting_can_be_given_up_and_what_stops_it_is_said(tmp_path, monkeypatch):
    def slow(_component, _session, _parameters, progress):
        while True:
            time.sleep(0.01)
            progress("casting rays", 0.5)

    def fail(*_):
        raise RecipeError("no such thing")

    monkeypatch.setattr(tuning_suggest, "suggest_fixes", slow)
    with opened(analysed_session(), tmp_path) as (page, card):
        press(page, SUGGEST)
        wait_for(lambda: "Casting rays" in card._run._line.content)
        press(page, CANCEL)
        assert find(page, SUGGEST).visible
        assert not any(shown(page))
        monkeypatch.setattr(tuning_suggest, "suggest_fixes", fail)
        press(page, SUGGEST)
        wait_for(lambda: "no such thing" in card._run._line.content)


@pytest.mark.parametrize(("effort", "again"), [("fast", 0), ("sketch", 1)])
def test_what_cannot_be_planned_is_left_out_and_like_is_compared_with_like(monkeypatch, effort, again):
    session = analysed_session(effort=effort)
    analysed = []
    asked = (("U1", "a"), ("R1", "b"), ("U1", "c"), ("U1", "d"))
    suggestions = tuple(Suggestion(component, RESIDUE_LEFT, what, ()) for component, what in asked)

    def predict(suggestion, recipe, _goal, progress):
        progress("planning", 0.5)
        assert recipe.text == session.document.text
        if suggestion.what == suggestions[0].what:
            raise RecipeError("too fast")
        resolved = suggestion is suggestions[3]
        return Effect("text", BEFORE, AFTER, resolved)

    def analyse_on(*_):
        analysed.append(1)
        return small_report()

    monkeypatch.setattr(tuning_suggest, "suggest", lambda *_: suggestions)
    monkeypatch.setattr(tuning_suggest, "predict", predict)
    monkeypatch.setattr(tuning_suggest, "analyse_on", analyse_on)
    monkeypatch.setattr(tuning_suggest, "prepare_again", lambda *_: None)
    found = tuning_suggest.suggest_fixes("U1", session, load_parameters(), lambda *_: None)
    assert [(each.what, each.resolved) for each in found] == [("d", True), ("c", False)]
    assert len(analysed) == again


def small_part(name):
    return next(part for part in small_report().parts if part.component == name)


def test_water_under_a_part_counts_where_nothing_else_is_open():
    report = small_report()
    wet = Judgement(rule=WET_GAP, verdict="marginal", because="It stays wet.")
    clean = report.bare.judgements
    more = {"U1": (wet, *small_part("U1").judgements), "C1": (wet, *clean)}
    parts = tuple(replace(part, judgements=more.get(part.component, clean)) for part in report.parts)
    changed = replace(report, parts=parts)
    assert tuning_suggest.goal_for(changed, "C1") == "clean-and-dry"
    assert tuning_suggest.goal_for(changed, "U1") == "clean"
    assert tuning_suggest.goal_for(changed, "board") == "clean"
