"""What a page does with edits and plans; nobody is connected to it."""

import threading
import time
from contextlib import nullcontext
from dataclasses import dataclass, field, replace

import pytest
from tiny_session import tiny_session
from waiting import wait_for

from programs.errors import ProgramError
from recipes.errors import RecipeError
from webui.downloads.downloads import make_download
from webui.page import page as pages
from webui.page.page import Page

SPEED = ("templates", "edge", "speed_mm_s")


@dataclass
class Client:
    said: list[str] = field(default_factory=list)

    def add_notification(self, title, body, **_):
        self.said.append(f"{title}: {body}")

    def atomic(self):
        return nullcontext()


@pytest.fixture
def page():
    page = Page(Client(), None, tiny_session())
    page.shown = []
    page.follow(page.shown.append, lambda session: session)
    page.open()
    yield page
    page.close()


def wait_until_planned(page):
    wait_for(lambda: page.session.planned)


def test_a_planned_session_is_shown_and_not_planned_again(page):
    assert page.shown == [tiny_session()]
    assert page.planned_s is None


def test_an_edit_is_shown_at_once_and_then_with_its_plan(page):
    first = page.session
    assert page.attempt(lambda session: session.set_value(SPEED, 33))
    assert page.session.run is first.run
    wait_until_planned(page)
    assert page.session.run.recipe.templates["edge"].speed_mm_s == 33
    assert page.session.run.program.totals.duration_s > first.run.program.totals.duration_s
    assert page.planned_s > 0
    assert (page.shown[0], page.shown[-1]) == (first, page.session)
    assert [each.recipe.templates["edge"].speed_mm_s for each in page.shown[1:]] == [33] * len(page.shown[1:])


def test_what_is_followed_is_shown_at_first_and_when_it_is_another():
    page, shown = Page(Client(), None, tiny_session()), []
    page.follow(lambda session: shown.append(session.selection.component), lambda session: session.selection)
    page.follow(lambda session: shown.append(session.language), lambda session: session.language)
    page.select(component="U1")
    assert shown == []  # it is not open yet
    page.open()
    assert shown == ["U1", ""]
    page.select(component="U1")
    page.remember(lambda session: replace(session, language="abb"))
    page.select(component="U2")
    assert shown == ["U1", "", "abb", "U2"]
    page.close()


def test_what_shows_another_session_is_followed_by_the_newest_one():
    page, shown = Page(Client(), None, tiny_session()), []

    def correct(session):
        if session.language == "abb":
            page.remember(lambda now: replace(now, language="ur"))

    for show in (correct, lambda session: shown.append(session.language)):
        page.follow(show, lambda session: session.language)
    page.open()
    page.remember(lambda session: replace(session, language="abb"))
    assert shown == ["", "ur"]
    page.close()


def test_a_refused_edit_says_why_and_changes_nothing(page):
    first = page.session
    assert not page.attempt(lambda session: session.set_value(SPEED, -1))
    assert page.session is first
    assert "speed_mm_s" in page.client.said[0]


def test_a_refusal_can_be_said_elsewhere(page):
    reasons = []
    assert not page.attempt(lambda session: session.set_value(SPEED, -1), reasons.append)
    assert isinstance(reasons[0], RecipeError)
    assert page.client.said == []


def test_a_defect_asks_for_a_report_without_a_traceback(page):
    first = page.session
    assert not page.attempt(lambda session: session.nothing)
    assert page.session is first
    assert "report" in page.client.said[0]
    assert "Traceback" not in page.client.said[0]


def test_only_the_newest_edit_is_shown_with_a_plan(page):
    for speed in (31, 32, 33, 34):
        page.attempt(lambda session, speed=speed: session.set_value(SPEED, speed))
    wait_until_planned(page)
    planned = {session.run.recipe.templates["edge"].speed_mm_s for session in page.shown}
    assert page.session.run.recipe.templates["edge"].speed_mm_s == 34
    assert planned <= {50, 34}


def test_an_undone_edit_needs_no_plan(page, monkeypatch):
    monkeypatch.setattr(pages, "run_levelled", forever)
    run = page.session.run
    page.attempt(lambda session: session.set_value(SPEED, 33))
    page.attempt(lambda session: session.with_document(session.document.undone()))
    assert page.session.planned
    assert page.session.run is run


def test_a_cancelled_plan_leaves_the_last_one_in_sight_and_can_be_made_again(page, monkeypatch):
    told = []
    page.on_progress(lambda what, _: told.append(what))
    monkeypatch.setattr(pages, "run_levelled", forever)
    run = page.session.run
    page.attempt(lambda session: session.set_value(SPEED, 33))
    page.cancel()
    assert told[-1] == "cancelled"
    assert page.session.run is run
    monkeypatch.undo()
    page.plan()
    wait_until_planned(page)


class Sketching:
    """Plans in two rounds: shows a sketch, and waits until it may go on."""

    def __init__(self, monkeypatch):
        self.go_on, self.sketches, self.ended, self._run = threading.Event(), [], 0, pages.run_levelled
        monkeypatch.setattr(pages, "run_levelled", self.run)

    def run(self, recipe, board, progress, sketched, before):
        done = self._run(recipe, board, progress, None, before)
        self.sketches.append(replace(done.plan))
        self.sketched = sketched
        sketched(self.sketches[-1])
        while not self.go_on.wait(0.01):
            progress("refining", 0.5)
        self.ended += 1
        return done


def wait_for_sketch(page):
    wait_for(lambda: page.session.sketch is not None)


def test_a_sketch_is_shown_until_the_run_comes(page, monkeypatch):
    sketching, first = Sketching(monkeypatch), page.session
    page.attempt(lambda session: session.set_value(SPEED, 33))
    wait_for_sketch(page)
    assert page.session.plan is sketching.sketches[0]
    assert page.session.run is first.run
    assert not page.session.planned
    sketching.go_on.set()
    wait_until_planned(page)
    assert page.session.sketch is None
    assert page.session.plan is page.session.run.plan


def test_what_is_no_edit_of_the_recipe_does_not_begin_anew(page, monkeypatch):
    sketching = Sketching(monkeypatch)
    page.attempt(lambda session: session.set_value(SPEED, 33))
    wait_for_sketch(page)
    page.attempt(lambda session: replace(session, compared=session.run))
    assert page.session.sketch is sketching.sketches[0]
    sketching.go_on.set()
    wait_until_planned(page)
    assert page.session.compared is not None
    assert len(sketching.sketches) == 1


def test_nothing_but_the_recipe_is_downloaded_while_a_sketch_is_shown(page, monkeypatch):
    Sketching(monkeypatch)
    page.attempt(lambda session: session.set_value(SPEED, 33))
    wait_for_sketch(page)
    with pytest.raises(ProgramError, match="not planned yet"):
        make_download("Program (.wash)", page.session, (), 1.0, lambda *_: None)
    assert b"33" in make_download("Recipe (YAML)", page.session, (), 1.0, lambda *_: None).content


@pytest.mark.parametrize("give_up", [Page.cancel, lambda page: page.attempt(lambda session: undone(session))])
def test_a_sketch_goes_when_its_search_is_given_up(page, monkeypatch, give_up):
    sketching, first = Sketching(monkeypatch), page.session
    page.attempt(lambda session: session.set_value(SPEED, 33))
    wait_for_sketch(page)
    give_up(page)
    assert page.session.sketch is None
    assert page.session.plan is first.run.plan
    sketching.sketched(sketching.sketches[0])  # one that comes too late
    assert page.session.sketch is None


def test_a_sketch_goes_when_the_run_fails(page, monkeypatch):
    def fail(_recipe, _board, _progress, sketched, before):
        sketched(before.plan)
        raise RecipeError("there is nothing to spray")

    monkeypatch.setattr(pages, "run_levelled", fail)
    page.attempt(lambda session: session.set_value(SPEED, 33))
    wait_for(lambda: page.client.said)
    assert page.session.sketch is None


def undone(session):
    return session.with_document(session.document.undone())


def test_a_plan_that_fails_says_why(page, monkeypatch):
    def fail(*_):
        raise RecipeError("there is nothing to spray")

    told = []
    page.on_progress(lambda what, _: told.append(what))
    monkeypatch.setattr(pages, "run_levelled", fail)
    page.attempt(lambda session: session.set_value(SPEED, 33))
    wait_for(lambda: page.client.said)
    assert "nothing to spray" in page.client.said[0]
    assert "not planned" in told


def test_a_plan_of_another_board_is_not_shown(page, monkeypatch):
    sketching = Sketching(monkeypatch)
    page.attempt(lambda session: session.set_value(SPEED, 33))
    wait_for_sketch(page)
    page.show(page.session.with_workpiece("other", replace(page.session.board, name="other")))
    sketching.go_on.set()
    wait_for(lambda: sketching.ended)
    time.sleep(0.05)
    assert page.session.run is None


def test_a_page_that_closed_while_it_was_built_shows_nothing():
    page, shown = Page(Client(), None, tiny_session()), []
    page.follow(shown.append, lambda session: session)
    ended = []
    page.on_close(lambda: ended.append(True))
    page.close()
    page.open()
    assert shown == []
    assert ended == [True]


def forever(_recipe, _board, progress, *_):
    while True:
        time.sleep(0.01)
        progress("planning", 0.5)
