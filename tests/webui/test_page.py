"""What a page does with edits and plans; nobody is connected to it."""

import time
from contextlib import nullcontext
from dataclasses import dataclass, field, replace

import pytest
from tiny_session import tiny_session

from recipes.errors import RecipeError
from webui import page as pages
from webui.page import Page

WAIT_S = 30.0
SPEED = ("templates", "edge", "speed_mm_s")


@dataclass
class Client:
    said: list[str] = field(default_factory=list)

    def add_notification(self, title, body, **_):
        self.said.append(f"{title}: {body}")

    def atomic(self):
        return nullcontext()


class Witness:
    """A panel that remembers what it was shown."""

    def __init__(self):
        self.shown = []

    def show(self, session, before):
        self.shown.append((session, before))


@pytest.fixture
def page():
    page = Page(Client(), None, tiny_session())
    page.open([Witness()])
    yield page
    page.close()


def witness(page):
    return page._panels[0].shown


def wait_until_planned(page):
    end = time.monotonic() + WAIT_S
    while not page.session.planned:
        assert time.monotonic() < end
        time.sleep(0.01)


def test_a_planned_session_is_shown_and_not_planned_again(page):
    assert witness(page) == [(tiny_session(), None)]
    assert page.planned_s is None


def test_an_edit_is_shown_at_once_and_then_with_its_plan(page):
    first = page.session
    assert page.attempt(lambda session: session.set_value(SPEED, 33))
    assert page.session.run is first.run
    wait_until_planned(page)
    assert page.session.run.recipe.templates["edge"].speed_mm_s == 33
    assert page.session.run.program.totals.duration_s > first.run.program.totals.duration_s
    assert page.planned_s > 0
    assert [before for _, before in witness(page)[1:]] == [session for session, _ in witness(page)[:-1]]


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
    planned = {session.run.recipe.templates["edge"].speed_mm_s for session, _ in witness(page)}
    assert page.session.run.recipe.templates["edge"].speed_mm_s == 34
    assert planned <= {80, 34}


def test_an_undone_edit_needs_no_plan(page, monkeypatch):
    monkeypatch.setattr(pages, "run", forever)
    run = page.session.run
    page.attempt(lambda session: session.set_value(SPEED, 33))
    page.attempt(lambda session: session.with_document(session.document.undone()))
    assert page.session.planned
    assert page.session.run is run


def test_a_cancelled_plan_leaves_the_last_one_in_sight_and_can_be_made_again(page, monkeypatch):
    told = []
    page.on_progress(lambda what, _: told.append(what))
    monkeypatch.setattr(pages, "run", forever)
    run = page.session.run
    page.attempt(lambda session: session.set_value(SPEED, 33))
    page.cancel()
    assert told[-1] == "cancelled"
    assert page.session.run is run
    monkeypatch.undo()
    page.plan()
    wait_until_planned(page)


def test_a_plan_that_fails_says_why(page, monkeypatch):
    def fail(*_):
        raise RecipeError("there is nothing to spray")

    told = []
    page.on_progress(lambda what, _: told.append(what))
    monkeypatch.setattr(pages, "run", fail)
    page.attempt(lambda session: session.set_value(SPEED, 33))
    end = time.monotonic() + WAIT_S
    while not page.client.said:
        assert time.monotonic() < end
        time.sleep(0.01)
    assert "nothing to spray" in page.client.said[0]
    assert "not planned" in told


def test_a_plan_of_another_board_is_not_shown(page):
    old = replace(page.session.run)
    page.show(page.session.with_board("other", replace(page.session.board, name="other")))
    page._planned(old, 0.0)
    assert page.session.run is None


def test_a_page_that_closed_while_it_was_built_shows_nothing():
    page, panel = Page(Client(), None, tiny_session()), Witness()
    ended = []
    page.on_close(lambda: ended.append(True))
    page.close()
    page.open([panel])
    assert panel.shown == []
    assert ended == [True]


def forever(_recipe, _board, tell):
    while True:
        time.sleep(0.01)
        tell("planning", 0.5)
