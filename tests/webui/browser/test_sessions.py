"""Several browsers on one server; lost connections; browsers that leave at a bad moment."""

import time
from dataclasses import replace

import pytest
from driven_page import CHROMIUM, NO_CHROMIUM, DrivenPage, open_chromium
from tiny_session import tiny_session
from waiting import wait_for

from recipes.load import recipe_library
from webui.page import page as pages
from webui.page.project import open_project
from webui.server.server import serve

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM),
]


@pytest.fixture(scope="module")
def chromium():
    with open_chromium() as chromium:
        yield chromium


@pytest.fixture
def browser(chromium):
    yield chromium
    for context in chromium.contexts:
        context.close()


def test_two_browsers_do_not_disturb_each_other_and_reload_at_once(browser, start_server):
    server = start_server("tiny", "rinse-only")
    anna, bert = DrivenPage(browser, server.address), DrivenPage(browser, server.address)
    at_first = anna.time_text
    template = tiny_session_template(server)
    anna.edit(template, "Speed (mm/s)", "21")
    hers = anna.wait_for_another_time(at_first)
    assert bert.time_text == at_first
    bert.edit(template, "Speed (mm/s)", "63")
    his = bert.wait_for_another_time(at_first)
    assert anna.time_text == hers != his
    anna.page.reload(wait_until="commit")
    bert.page.reload(wait_until="commit")
    anna.wait_for_time(hers)
    bert.wait_for_time(his)
    assert anna.errors == bert.errors == []


def test_two_tabs_of_one_browser_keep_their_own_after_a_reload_at_once_and_a_lost_connection(browser, start_server):
    server = start_server("tiny", "rinse-only")
    profile = browser.new_context(viewport={"width": 1400, "height": 900})
    one, two = (DrivenPage(browser, server.address, profile.new_page()) for _ in range(2))
    at_first = one.time_text
    template = tiny_session_template(server)
    one.edit(template, "Speed (mm/s)", "21")
    two.edit(template, "Speed (mm/s)", "63")
    times = [tab.wait_for_another_time(at_first) for tab in (one, two)]
    assert len(set(times)) == 2
    for tab in (two, one):
        tab.page.reload(wait_until="commit")
    for tab, text in zip((one, two), times, strict=True):
        tab.page.bring_to_front()  # a tab that nobody sees does nothing
        tab.wait_for_time(text)
    assert one.errors == two.errors == []
    clients = set(server.viser.get_clients())
    server.viser._websock_server.disconnect_all_clients()
    one.page.bring_to_front()
    wait_for(lambda: server.viser.get_clients() and not clients & set(server.viser.get_clients()))
    one.wait_until_planned()
    one.wait_for_time(times[0])


def test_edits_that_were_not_saved_are_offered_after_the_server_was_started_again(browser, start_server):
    server = start_server("tiny", "rinse-only")
    profile = browser.new_context(viewport={"width": 1400, "height": 900})
    tab = DrivenPage(browser, server.address, profile.new_page())
    at_first = tab.time_text
    tab.edit(tiny_session_template(server), "Speed (mm/s)", "21")
    edited = tab.wait_for_another_time(at_first)
    tab.page.close()
    server.stop()
    again = start_server("tiny", "rinse-only", server.port)  # a browser keeps what it knows for one address
    assert DrivenPage(browser, again.address).page.get_by_text("Unsaved edits").count() == 0
    tab = DrivenPage(browser, again.address, profile.new_page())
    tab.see("The server ended before your edits of rinse-only.yaml were saved.")
    assert tab.time_text == at_first
    tab.press("Restore them")
    tab.wait_for_time(edited)


def test_a_file_that_changes_on_the_disk_is_noticed(browser, start_server, tmp_path):
    file = tmp_path / "mine.yaml"
    text = recipe_library()["rinse-only"].read_text().replace("recipe: rinse-only", "recipe: mine")
    file.write_text(text)
    tab = DrivenPage(browser, start_server("tiny", str(file)).address)
    file.write_text(text.replace("recipe: mine", "# by somebody else\nrecipe: mine"))
    tab.see("mine.yaml was changed by somebody else.")
    tab.press("Load the file")
    tab.tab("YAML")
    tab.page.wait_for_function("document.querySelector('textarea')?.value.includes('# by somebody else')")
    assert tab.errors == []


def test_a_browser_that_leaves_while_it_is_planned_does_no_harm(browser, tmp_path, monkeypatch):
    begun, plan = [], pages.run_levelled

    def slow(recipe, board, progress, *more):
        begun.append(True)
        for step in range(60):
            time.sleep(0.1)
            progress("planning slowly", step / 60)
        return plan(recipe, board, progress, *more)

    monkeypatch.setattr(pages, "run_levelled", slow)
    server = serve(replace(tiny_session(), run=None), open_project(tmp_path), "127.0.0.1", 0)
    try:
        first = browser.new_page()
        first.goto(server.address, wait_until="domcontentloaded")
        first.get_by_text("Planning slowly").wait_for()
        first.get_by_role("button", name="Cancel", exact=True).first.wait_for()
        first.close()
        monkeypatch.setattr(pages, "run_levelled", plan)
        second = DrivenPage(browser, server.address)
        assert second.time_text
        assert second.errors == []
    finally:
        server.stop()
    assert begun


def test_a_long_plan_can_be_cancelled_and_the_page_answers_meanwhile(browser, tmp_path, monkeypatch):
    plan = pages.run_levelled

    def slow(recipe, board, progress, *more):
        for step in range(600):
            time.sleep(0.1)
            progress("planning slowly", step / 600)
        return plan(recipe, board, progress, *more)

    server = serve(tiny_session(), open_project(tmp_path), "127.0.0.1", 0)
    try:
        tab = DrivenPage(browser, server.address)
        before = tab.time_text
        monkeypatch.setattr(pages, "run_levelled", slow)
        tab.edit("around", "Speed (mm/s)", "21")
        tab.see("Planning slowly")
        tab.tab("YAML")
        tab.page.wait_for_function("document.querySelector('textarea')?.value.includes('speed_mm_s: 21')")
        tab.page.get_by_role("button", name="Cancel", exact=True).first.click()
        tab.see("Cancelled. The paths are those of the recipe before.")
        assert tab.time_text == before
        monkeypatch.setattr(pages, "run_levelled", plan)
        tab.press("Plan again")
        tab.wait_for_another_time(before)
        assert tab.errors == []
    finally:
        server.stop()


def tiny_session_template(server) -> str:
    return server.sessions.take("nobody").recipe.sequence[0].paths[0]
