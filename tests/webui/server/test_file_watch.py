"""A recipe file that somebody else writes is noticed while its page is open."""

import threading

import pytest
from small_page import press, small_page, windows
from tiny_session import tiny_session
from waiting import WAIT_S

from webui.page.document import open_document
from webui.page.project import open_project
from webui.panels.recipe.text import TextPanel
from webui.server.server import FileWatch

SESSION = tiny_session()
TEXT = SESSION.document.text.replace("recipe: smt-aqueous", "recipe: mine")
OTHER = TEXT.replace("tilt_deg: 35", "tilt_deg: 34")


@pytest.fixture
def file(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text(TEXT)
    return file


@pytest.fixture
def page(file):
    session = SESSION.with_document(open_document(file))
    with small_page(session, open_project(file.parent)) as page:
        TextPanel(page, None)
        page.open()
        yield page


def test_a_file_that_stays_as_it_is_asks_nothing(page):
    page.poll()
    assert windows(page) == []


def test_a_change_is_asked_about_once_and_can_be_loaded(page, file):
    file.write_text(OTHER)
    page.poll()
    page.poll()
    assert len(windows(page)) == 1
    press(page, "Load the file")
    assert page.session.document.text == OTHER
    assert not page.session.document.dirty
    page.poll()
    assert windows(page) == []


def test_unsaved_edits_stay_if_they_are_to_be_kept_and_saving_still_asks(page, file):
    mine = TEXT.replace("tilt_deg: 35", "tilt_deg: 33")
    page.attempt(lambda session: session.edited(mine))
    file.write_text(OTHER)
    page.poll()
    press(page, "Keep this text")
    assert page.session.document.text == mine
    page.poll()
    assert windows(page) == []
    press(page, "File", "Save")
    assert len(windows(page)) == 1
    assert file.read_text() == OTHER


def test_another_change_replaces_the_question(page, file):
    file.write_text(OTHER)
    page.poll()
    file.write_text(TEXT.replace("tilt_deg: 35", "tilt_deg: 31"))
    page.poll()
    assert len(windows(page)) == 1
    press(page, "Load the file")
    assert "tilt_deg: 31" in page.session.document.text


def test_what_is_no_recipe_any_more_is_not_loaded(page, file):
    file.write_text("recipe: [")
    page.poll()
    press(page, "Load the file")
    assert page.session.document.text == TEXT
    assert len(windows(page)) == 1


def test_a_file_that_is_gone_is_left_to_saving(page, file):
    file.unlink()
    page.poll()
    assert windows(page) == []


def test_saving_here_is_no_change_by_others(page, file):
    page.attempt(lambda session: session.edited(OTHER))
    press(page, "File", "Save")
    page.poll()
    assert windows(page) == []
    assert file.read_text() == OTHER


def test_all_pages_look_again_and_again_and_one_that_fails_stops_none():
    class Looker:
        def __init__(self, fails):
            self.fails, self.looked, self.reported = fails, threading.Semaphore(0), []

        def poll(self):
            self.looked.release()
            if self.fails:
                raise OSError

        def report(self, error):
            self.reported.append(error)

    bad, good = Looker(fails=True), Looker(fails=False)
    watch = FileWatch(lambda: [bad, good], 0.01)
    for _ in range(3):
        assert good.looked.acquire(timeout=WAIT_S)
    watch.stop()
    assert bad.reported
