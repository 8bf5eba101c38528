"""Hard use of a server, by pages without a browser: nothing is lost, it goes on, and words state what happened."""

import time

import pytest
from bare_client import bare_page
from waiting import wait_for

from recipes.load import load_recipe, recipe_library
from webui.page.project import open_project
from webui.panels.cleaning import analysis
from webui.panels.cleaning.tuning import TuneCard
from webui.panels.widgets.job import Job, RunButton
from webui.server.server import open_session, serve

PART = 512 * 1024


@pytest.fixture
def folder(tmp_path):
    text = recipe_library()["rinse-only"].read_text()
    (tmp_path / "mine.yaml").write_text(text.replace("recipe: rinse-only", "recipe: mine"))
    return tmp_path


@pytest.fixture
def server(folder):
    server = serve(open_session("tiny", str(folder / "mine.yaml")), open_project(folder), "127.0.0.1", 0)
    yield server
    server.stop()


def session_of(server, browser):
    return next(iter(server.sessions._browsers[browser].pages.values())).page.session


def edit(page, value):
    page.set("Speed (mm/s)", str(value))
    page.set("Apply", True, "ButtonMessage")


def edit_until(page, server, value):
    """Edit a speed again until it is there: what is sent to a form while it is drawn anew is lost."""
    page.insist(lambda: edit(page, value), lambda: speed_of(server, page.browser) == value)


def speed_of(server, browser):
    return speed_in(session_of(server, browser).recipe)


def speed_in(recipe):
    return next(iter(recipe.templates.values())).speed_mm_s


@pytest.mark.slow
def test_while_one_page_uploads_sixty_megabytes_another_one_edits(server, folder):
    size = 60_000_000
    parts = -(-size // PART)
    with bare_page(server, "anna") as anna, bare_page(server, "bert") as bert:
        anna.upload("Import CAD", "big.tri", size, parts)
        for index in range(parts):
            anna.part("Import CAD", index, b"x" * min(PART, size - index * PART))
            if index == parts // 2:
                edit_until(bert, server, 21)
        assert "big.tri" in anna.next_note()
        wait_for(lambda: session_of(server, "bert").planned)
        assert not (folder / "big.tri").exists()
        edit_until(anna, server, 22)
        assert session_of(server, "anna").workpiece_name == "tiny"


@pytest.mark.slow
def test_after_thirty_edits_a_second_the_last_one_is_planned_and_all_can_be_undone(server):
    with bare_page(server, "anna") as anna:
        first = session_of(server, "anna")
        begun = time.monotonic()
        for number in range(29):
            time.sleep(max(0.0, begun + number / 30 - time.monotonic()))
            edit(anna, 20 + number)
        edit_until(anna, server, 49)
        wait_for(lambda: session_of(server, "anna").planned)
        session = session_of(server, "anna")
        assert session.run.recipe == session.recipe
        texts = (*session.document.past, session.document.text)
        speeds = [speed_in(session.edited(text).recipe) for text in texts[1:]]
        assert speeds == sorted(set(speeds))  # those that come while one is written are written as one
        assert texts[0] == first.document.text
        while anna.receive(0.2):  # a connection whose messages nobody takes closes late
            pass
        assert anna.notes == []


@pytest.mark.slow
def test_two_browsers_on_one_file_lose_neither_what_is_saved_nor_what_is_edited(server, folder):
    with bare_page(server, "anna") as anna, bare_page(server, "bert") as bert:
        edit_until(bert, server, 63)
        edit_until(anna, server, 21)
        anna.set("File", "Save", "ButtonGroup")
        wait_for(lambda: speed_in(load_recipe(folder / "mine.yaml")) == 21)
        bert.find("Keep this text")  # the window that opens there
        assert any("mine.yaml was changed by somebody else" in text for text in bert.texts)
        bert.set("Keep this text", True, "ButtonMessage")
        wait_for(lambda: speed_of(server, "bert") == 63)
        assert speed_in(load_recipe(folder / "mine.yaml")) == 21


@pytest.mark.slow
def test_a_browser_that_leaves_during_an_analysis_ends_it_and_comes_back_to_its_edits(server, monkeypatch):
    under_way, ended = [], []

    def slow(_run, _settings, _before, progress):
        under_way.append(True)
        try:
            while True:
                time.sleep(0.01)
                progress("tracing rays", 0.5)
        finally:
            ended.append(True)

    monkeypatch.setattr(analysis, "analyse_run", slow)
    with bare_page(server, "anna") as anna:
        edit_until(anna, server, 21)
        wait_for(lambda: session_of(server, "anna").planned)
        anna.set("Analyse", True, "ButtonMessage")
        wait_for(lambda: under_way)
    wait_for(lambda: ended)
    wait_for(lambda: not server.sessions.pages())
    with bare_page(server, "anna"):
        assert speed_of(server, "anna") == 21
        assert session_of(server, "anna").analysed is None


@pytest.mark.slow
def test_everything_that_may_take_long_can_be_cancelled(server, monkeypatch):
    found, tunes = made_by(Job, monkeypatch), made_by(TuneCard, monkeypatch)
    with bare_page(server, "anna"):
        pass
    assert len(found) >= 9
    assert [job for job in found if not (isinstance(job, RunButton) or job._cancel is not None)] == [tunes[0]._job]


def made_by(kind, monkeypatch):
    """All objects of a class from now on, in the order in which they are made; tuning is cancelled in its window."""
    made, build = [], kind.__init__

    def init(self, *args, **named):
        made.append(self)
        build(self, *args, **named)

    monkeypatch.setattr(kind, "__init__", init)
    return made
