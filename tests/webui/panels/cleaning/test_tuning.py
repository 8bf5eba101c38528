"""The window of tuning: its inputs, the work beside the page, and what is done with a proposal."""

import time
from contextlib import contextmanager
from dataclasses import replace

import pytest
from small_page import find, inputs, press, small_page, windows
from tiny_session import tiny_session
from tuned_recipe import proposal, slower
from waiting import wait_for

from cleaning.errors import CleaningError
from webui.page.project import open_project
from webui.panels.cleaning.tuning import APPLY, CANCEL, CHOOSE, CLOSE, DISCARD, SAVE, START, TuneCard
from webui.tuning import background as tuning_run

TUNE = "Tune\N{HORIZONTAL ELLIPSIS}"


@contextmanager
def opened(session, folder):
    with small_page(session, open_project(folder)) as page:
        card = TuneCard(page)
        page.open()
        yield page, card
        page.close()


@pytest.fixture
def by_hand(monkeypatch):
    """Tuning ends at once with a proposal that was made by hand; what was asked for is remembered."""
    asked = []

    def propose(task, _before, progress):
        asked.append(task)
        progress("tuning, 3 of at most 40 analyses", 0.5)
        return proposal(tiny_session())

    monkeypatch.setattr(tuning_run, "propose", propose)
    return asked


def seen(page):
    return {handle.label for handle in inputs(page) if handle.visible}


@pytest.mark.slow
def test_what_is_filled_in_is_asked_for_and_what_comes_is_applied(tmp_path, by_hand):
    with opened(tiny_session(), tmp_path) as (page, card):
        before = page.session.document.text
        press(page, TUNE)
        assert not find(page, CANCEL).visible
        press(page, "Pressure", True)
        press(page, "Tilts", False)
        press(page, "Time at most (s), 0: any", 600.0)
        press(page, "Analyses at most", 12)
        press(page, START)
        wait_for(lambda: page.session.proposal is not None)
        request = by_hand[0].request
        assert "pressure" in request.allowed.kinds
        assert "tilts" not in request.allowed.kinds
        assert (request.limits.seconds, request.limits.litres, request.max_analyses) == (600.0, None, 12)
        assert by_hand[0].parameters_name == "default"
        wait_for(lambda: "data-diff" in card._window._rest.content)
        assert page.session.document.text == before
        press(page, APPLY)
        assert page.session.document.text == slower(before)
        assert page.session.proposal is None
        assert windows(page) == []
        page.attempt(lambda session: session.with_document(session.document.undone()))
        assert page.session.document.text == before


def test_impossible_settings_are_shown_in_the_window_and_can_be_corrected(tmp_path, by_hand):
    with opened(tiny_session(), tmp_path) as (page, card):
        press(page, TUNE)
        press(page, "Time at most (s), 0: any", -4.0)
        press(page, START)
        assert "Time at most: -4" in card._window._remark.content
        assert by_hand == []
        press(page, "Time at most (s), 0: any", 400.0)
        press(page, START)
        wait_for(lambda: by_hand)


@pytest.mark.slow
def test_a_proposal_waits_until_somebody_decides(tmp_path, by_hand):
    session = tiny_session()
    with opened(replace(session, proposal=proposal(session)), tmp_path) as (page, card):
        assert "not applied" in card._job._line.content
        press(page, TUNE)
        assert "data-diff" in card._window._rest.content
        press(page, CLOSE)
        assert windows(page) == []
        assert page.session.proposal is not None
        page.attempt(lambda session: session.edited(session.document.text + "# mine\n"))
        assert "edited since" in card._job._line.content
        press(page, TUNE)
        press(page, APPLY)
        assert "not the one that was tuned" in card._window._refusal.content
        assert page.session.document.text.endswith("# mine\n")
        press(page, DISCARD)
        assert page.session.proposal is None
        assert card._job._line.content == ""
        assert page.session.document.text.endswith("# mine\n")


@pytest.mark.slow
def test_a_proposal_is_saved_under_a_name_of_its_own(tmp_path):
    session = tiny_session()
    (tmp_path / "there.yaml").write_text("recipe: there\nextends: smt-aqueous\n")
    with opened(replace(session, proposal=proposal(session)), tmp_path) as (page, card):
        press(page, TUNE)
        assert find(page, "New recipe").value == "smt-aqueous-tuned.yaml"
        press(page, "New recipe", "there.yaml")
        press(page, SAVE)
        assert "there already" in card._window._refusal.content
        press(page, "New recipe", "mine")
        press(page, SAVE)
        assert page.session.document.file == tmp_path / "mine.yaml"
        assert page.session.proposal is None


def test_what_stops_tuning_is_said_and_it_can_begin_again(tmp_path, monkeypatch):
    def fail(*_):
        raise CleaningError("no liquid of the name steam; add it", path="liquids")

    monkeypatch.setattr(tuning_run, "propose", fail)
    with opened(tiny_session(), tmp_path) as (page, card):
        press(page, TUNE)
        press(page, START)
        wait_for(lambda: "steam" in card._job._line.content)
        assert "steam" in card._window._remark.content
        assert find(page, START).visible
        assert page.client.said == []


@pytest.mark.slow
def test_another_recipe_of_the_front_is_taken(tmp_path):
    session = tiny_session()
    with opened(replace(session, proposal=proposal(session)), tmp_path) as (page, card):
        press(page, TUNE)
        window = card._window
        quicker = window._front.options[1]
        assert window._front.value.startswith("2: 5 of 5 clean")
        assert "data-diff" in window._rest.content
        press(page, CHOOSE, quicker)
        assert page.session.proposal.text == session.document.text
        assert "Chosen of the Pareto front." in window._proposal.content
        assert not find(page, APPLY).visible
        press(page, CHOOSE, window._front.options[0])
        assert page.session.proposal.chosen == ""
        press(page, APPLY)
        assert page.session.document.text == slower(session.document.text)


@pytest.mark.slow
def test_tuning_that_is_cancelled_offers_its_best_until_then(tmp_path, monkeypatch):
    def slow(task, _before, progress):
        task.take_best(replace(proposal(tiny_session()), board=task.board, document=task.document, interrupted=True))
        while True:
            time.sleep(0.01)
            progress("tuning, 3 of at most 40 analyses", 0.5)

    monkeypatch.setattr(tuning_run, "propose", slow)
    with opened(tiny_session(), tmp_path) as (page, card):
        press(page, TUNE)
        press(page, START)
        wait_for(lambda: card._best is not None)
        press(page, CANCEL)
        assert "found by 7 analyses" in card._window._proposal.content
        assert page.session.proposal.interrupted
        press(page, APPLY)
        assert "speed_mm_s: 45" in page.session.document.text


def test_tuning_that_is_given_up_leaves_nothing(tmp_path, monkeypatch):
    def slow(_task, _before, progress):
        while True:
            time.sleep(0.01)
            progress("tuning, 3 of at most 40 analyses", 0.5)

    monkeypatch.setattr(tuning_run, "propose", slow)
    with opened(tiny_session(), tmp_path) as (page, card):
        press(page, TUNE)
        press(page, START)
        wait_for(lambda: "Tuning, 3 of" in card._window._working.content)
        press(page, CLOSE)
        wait_for(lambda: "Tuning, 3 of" in card._job._line.content)
        press(page, TUNE)
        assert find(page, CANCEL).visible
        press(page, CANCEL)
        assert page.session.proposal is None
        assert card._job._line.content == ""
        assert find(page, START).visible
