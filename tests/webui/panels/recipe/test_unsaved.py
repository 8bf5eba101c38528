"""Edits that nobody saved survive the end of the server, for the browser that made them."""

import pytest
from small_page import find, press, small_page, windows
from tiny_session import tiny_session
from waiting import wait_for

from webui.page.document import open_document
from webui.page.page import BrowserIdentity
from webui.page.project import open_project
from webui.panels.recipe import text as unsaved
from webui.panels.recipe.text import Drafts, UnsavedEdits

SESSION = tiny_session()
FILE = SESSION.document.file
ANNA, BERT = BrowserIdentity("anna", "1"), BrowserIdentity("bert", "1")
EDITED = SESSION.document.text.replace("tilt_deg: 35", "tilt_deg: 34")


def kept(folder):
    return sorted(path.name for path in folder.rglob("*.yaml"))


def test_a_text_is_offered_by_the_next_server_to_the_same_browser_alone(tmp_path):
    Drafts(tmp_path).keep(ANNA, FILE, EDITED)
    after = Drafts(tmp_path)
    assert after.left_by(ANNA, FILE).text == EDITED
    assert after.left_by(BrowserIdentity("anna", "another tab"), FILE).text == EDITED
    assert after.left_by(BERT, FILE) is None
    assert after.left_by(ANNA, tmp_path / "other.yaml") is None
    assert after.left_by(BrowserIdentity("", ""), FILE) is None


def test_the_same_server_does_not_offer_what_is_still_edited(tmp_path):
    drafts = Drafts(tmp_path)
    drafts.keep(ANNA, FILE, EDITED)
    assert drafts.left_by(ANNA, FILE) is None


def test_what_is_saved_or_discarded_is_gone(tmp_path):
    Drafts(tmp_path).keep(ANNA, FILE, EDITED)
    Drafts(tmp_path).forget(ANNA, FILE)
    assert kept(tmp_path) == []
    Drafts(tmp_path).keep(ANNA, FILE, EDITED)
    after = Drafts(tmp_path)
    after.discard(after.left_by(ANNA, FILE))
    assert kept(tmp_path) == []
    assert after.left_by(ANNA, FILE) is None


@pytest.mark.parametrize("name", ["../../above", "a/b", "a\0b", "", "x" * 999, "\N{SNOWMAN}", "\udcff"])
def test_no_name_leads_out_of_the_folder(tmp_path, name):
    project = tmp_path / "project"
    project.mkdir()
    visitor = BrowserIdentity(name or "nobody", name)
    Drafts(project).keep(visitor, FILE, EDITED)
    assert Drafts(project).left_by(visitor, FILE).text == EDITED
    assert [path.name for path in tmp_path.iterdir()] == ["project"]
    assert [path.parent.name for path in project.rglob("*.yaml")] == ["unsaved"]


def test_a_link_in_the_place_of_the_folder_is_not_followed(tmp_path):
    project, outside = tmp_path / "project", tmp_path / "outside"
    project.mkdir()
    outside.mkdir()
    (project / ".washboard").symlink_to(outside)
    Drafts(project).keep(ANNA, FILE, EDITED)
    assert list(outside.iterdir()) == []


def test_a_folder_that_cannot_be_written_stops_nothing(tmp_path):
    (tmp_path / ".washboard").write_text("in the way")
    drafts = Drafts(tmp_path)
    drafts.keep(ANNA, FILE, EDITED)
    drafts.forget(ANNA, FILE)
    assert drafts.left_by(ANNA, FILE) is None


def test_what_is_no_text_is_not_offered(tmp_path):
    Drafts(tmp_path).keep(ANNA, FILE, EDITED)
    next(tmp_path.rglob("*.yaml")).write_bytes(b"\xff\xfe\0")
    assert Drafts(tmp_path).left_by(ANNA, FILE) is None


def test_very_many_are_not_kept_for_ever(tmp_path, monkeypatch):
    monkeypatch.setattr(unsaved, "_MOST", 3)
    for number in range(5):
        Drafts(tmp_path).keep(BrowserIdentity(f"guest {number}", ""), FILE, EDITED)
    Drafts(tmp_path)
    assert len(kept(tmp_path)) == 3


@pytest.fixture
def page(tmp_path):
    with small_page(SESSION, open_project(tmp_path)) as page:
        yield page


def test_edits_are_kept_until_they_are_undone(page, tmp_path):
    UnsavedEdits(page, Drafts(tmp_path), ANNA)
    page.open()
    assert kept(tmp_path) == []
    page.attempt(lambda session: session.edited(EDITED))
    wait_for(lambda: kept(tmp_path))
    assert next(tmp_path.rglob("*.yaml")).read_text() == EDITED
    page.attempt(lambda session: session.with_document(session.document.undone()))
    wait_for(lambda: not kept(tmp_path))


@pytest.mark.parametrize("answer", ["Restore them", "Discard them", "Cancel"])
def test_what_was_left_behind_is_offered(page, tmp_path, answer):
    Drafts(tmp_path).keep(ANNA, FILE, EDITED)
    UnsavedEdits(page, Drafts(tmp_path), ANNA)
    page.open()
    assert page.session.document.text == SESSION.document.text
    press(page, answer)
    assert windows(page) == []
    restored = answer == "Restore them"
    assert page.session.document.text == (EDITED if restored else SESSION.document.text)
    assert page.session.document.dirty == restored
    if answer == "Discard them":
        assert kept(tmp_path) == []
    else:
        wait_for(lambda: kept(tmp_path))


def test_what_is_no_recipe_is_not_restored_and_says_why(page, tmp_path):
    Drafts(tmp_path).keep(ANNA, FILE, "recipe: [")
    UnsavedEdits(page, Drafts(tmp_path), ANNA)
    page.open()
    press(page, "Restore them")
    assert len(windows(page)) == 1
    assert page.session.document.text == open_document("smt-aqueous").text


def test_nothing_is_asked_where_nothing_was_left(page, tmp_path):
    Drafts(tmp_path).keep(ANNA, FILE, SESSION.document.text)
    UnsavedEdits(page, Drafts(tmp_path), ANNA)
    page.open()
    assert windows(page) == []
    with pytest.raises(AssertionError):
        find(page, "Restore them")
