from typing import cast

import pytest

from webui.page.page import Page
from webui.page.session import Session
from webui.server.server import Sessions, open_session


class Tab:
    """As much of a page as sessions are kept of."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.closed = False

    def close(self) -> None:
        self.closed = True


@pytest.fixture(scope="module")
def first() -> Session:
    return open_session("smt-demo", "smt-aqueous")


def speed_set(session: Session, speed: int) -> Session:
    return session.set_value(("templates", "edge", "speed_mm_s"), speed)


def enter(sessions: Sessions, browser: str, client_id: int, name: str = "") -> Tab:
    tab = Tab(sessions.take(browser, name))
    sessions.enter(browser, client_id, cast("Page", tab), name)
    return tab


@pytest.mark.slow
def test_a_reload_takes_up_what_was_left(first: Session) -> None:
    sessions = Sessions(first)
    tab = enter(sessions, "anna", 1)
    assert tab.session is first
    tab.session = speed_set(first, 41)
    sessions.leave(1)
    assert tab.closed
    assert enter(sessions, "anna", 2).session is tab.session


def test_two_browsers_that_reload_at_once_get_back_their_own(first: Session) -> None:
    sessions = Sessions(first)
    anna, bert = enter(sessions, "anna", 1), enter(sessions, "bert", 2)
    anna.session, bert.session = speed_set(first, 41), speed_set(first, 42)
    sessions.leave(1)
    sessions.leave(2)
    assert enter(sessions, "anna", 3).session is anna.session
    assert enter(sessions, "bert", 4).session is bert.session


def test_a_lost_connection_that_nobody_has_noticed_yet_loses_no_edit(first: Session) -> None:
    sessions = Sessions(first)
    before = enter(sessions, "anna", 1)
    before.session = speed_set(first, 41)
    again = enter(sessions, "anna", 2)
    assert again.session is before.session
    again.session = speed_set(again.session, 42)
    sessions.leave(1)
    sessions.leave(2)
    assert enter(sessions, "anna", 3).session is again.session


def test_tabs_of_one_browser_go_their_own_ways(first: Session) -> None:
    sessions = Sessions(first)
    one, two = enter(sessions, "anna", 1), enter(sessions, "anna", 2)
    one.session, two.session = speed_set(first, 41), speed_set(first, 42)
    sessions.leave(1)
    sessions.leave(2)
    back = {id(enter(sessions, "anna", client).session) for client in (3, 4)}
    assert back == {id(one.session), id(two.session)}


@pytest.mark.parametrize("order", [("one", "two"), ("two", "one")])
def test_tabs_that_reload_at_once_get_back_their_own(first: Session, order: tuple[str, str]) -> None:
    sessions = Sessions(first)
    tabs = {name: enter(sessions, "anna", client, name) for client, name in enumerate(("one", "two"))}
    tabs["one"].session, tabs["two"].session = speed_set(first, 41), speed_set(first, 42)
    sessions.leave(0)
    sessions.leave(1)
    for client, name in enumerate(order, 3):
        assert enter(sessions, "anna", client, name).session is tabs[name].session


def test_a_tab_whose_old_connection_still_counts_goes_on_with_its_own(first: Session) -> None:
    sessions = Sessions(first)
    one, two, three = (enter(sessions, "anna", client, name) for client, name in enumerate(("one", "two", "three")))
    one.session, two.session, three.session = (speed_set(first, speed) for speed in (41, 42, 43))
    sessions.leave(2)
    assert enter(sessions, "anna", 4, "one").session is one.session


def test_a_new_tab_takes_up_what_a_closed_one_left(first: Session) -> None:
    sessions = Sessions(first)
    closed = enter(sessions, "anna", 1, "one")
    closed.session = speed_set(first, 41)
    sessions.leave(1)
    assert enter(sessions, "anna", 2, "two").session is closed.session


def test_a_stranger_sees_nothing_of_others(first: Session) -> None:
    sessions = Sessions(first)
    anna = enter(sessions, "anna", 1)
    anna.session = speed_set(first, 41)
    assert enter(sessions, "bert", 2).session is first
    sessions.leave(1)
    assert enter(sessions, "carl", 3).session is first


@pytest.mark.slow
def test_browsers_that_are_long_away_are_forgotten_and_those_that_are_here_are_not(first: Session) -> None:
    sessions = Sessions(first)
    here = enter(sessions, "here", 0)
    here.session = speed_set(first, 41)
    for client in range(1, 101):
        enter(sessions, f"guest {client}", client).session = speed_set(first, 42)
        sessions.leave(client)
    sessions.leave(0)
    assert enter(sessions, "here", 200).session is here.session
    assert enter(sessions, "guest 1", 201).session is first
    assert enter(sessions, "guest 100", 202).session is not first


def test_leaving_twice_is_leaving_once(first: Session) -> None:
    sessions = Sessions(first)
    tab = enter(sessions, "anna", 1)
    sessions.leave(1)
    sessions.leave(1)
    sessions.leave(99)
    assert enter(sessions, "anna", 2).session is tab.session


def test_the_end_of_the_server_closes_all_pages(first: Session) -> None:
    sessions = Sessions(first)
    tabs = [enter(sessions, name, number) for number, name in enumerate(("anna", "bert"))]
    sessions.close()
    assert all(tab.closed for tab in tabs)
