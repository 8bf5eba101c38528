"""An engineer's way from a poor recipe to a better one, in a real browser."""

import pytest
from driven_page import CHROMIUM, NO_CHROMIUM, DrivenPage, open_chromium

from webui.panels.cleaning.parts import APPLY, SUGGEST
from webui.panels.cleaning.tuning import APPLY as TAKE
from webui.panels.cleaning.tuning import CLOSE, START

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)]

POOR = """# Too fast, and nothing goes around the parts.
recipe: poor
extends: smt-aqueous
templates:
  sweep: {speed_mm_s: 110}  # in a hurry
sequence:
  - {function: clean, nozzle: ring60, paths: [sweep]}
  - {function: rinse, nozzle: ring60, paths: [sweep]}
"""


@pytest.fixture
def server(start_server, tmp_path):
    (tmp_path / "poor.yaml").write_text(POOR)
    return start_server("tiny", str(tmp_path / "poor.yaml"))


def session_of(server):
    return server.sessions.pages()[0].session


def text_of(tab):
    return tab.page.locator("textarea").first.input_value()


def wait_for(tab, condition):
    for _ in range(900):
        if condition():
            return
        tab.page.wait_for_timeout(100)
    raise AssertionError("it did not come about")


def test_a_failing_part_is_helped_by_one_change_and_that_can_be_undone(server):
    with open_chromium() as browser:
        tab = DrivenPage(browser, server.address)
        tab.tab("Cleaning")
        tab.tab("YAML")
        tab.press("Analyse")
        tab.see("no proof of cleanliness")
        tab.press("Worst")
        tab.insist(SUGGEST, tab.page.get_by_role("button", name=APPLY, exact=True).first)
        tab.see("Open requirements")
        before = tab.time_text
        tab.page.get_by_role("button", name=APPLY, exact=True).first.click()
        tab.see("changed since it was analysed")
        tab.wait_until_planned()
        changed = session_of(server)
        assert changed.document.undone().text == POOR
        assert changed.document.text != POOR
        assert "# in a hurry" in changed.document.text
        tab.page.wait_for_function(
            "text => document.querySelector('textarea').value === text", arg=changed.document.text
        )
        tab.press("Undo")
        tab.page.wait_for_function("text => document.querySelector('textarea').value === text", arg=POOR)
        tab.wait_for_time(before)
        tab.press("Analyse")
        tab.see("no proof of cleanliness")
        tab.tab("Findings")
        tab.choose("Source", "Cleaning")
        tab.choose("Go to", next(name for name in tab.choices("Go to") if name.endswith("U1")))
        wait_for(tab, lambda: session_of(server).selection.component == "U1")
        tab.page.wait_for_timeout(1000)  # the camera is there
        assert tab.errors == []
        assert tab.strangers == []


def test_a_tuned_recipe_waits_through_a_reload_and_is_applied_as_one_edit(server):
    with open_chromium() as browser:
        tab = DrivenPage(browser, server.address)
        tab.tab("Cleaning")
        tab.tab("YAML")
        tab.press("Tune…")
        tab.type("Analyses at most", "4")
        tab.press(START)
        tab.page.locator("[data-diff]").wait_for()
        tab.see("Not met yet, and why")
        tab.press(CLOSE)
        tab.see("Tuned, not applied")
        assert text_of(tab) == POOR
        proposed = session_of(server).proposal.text
        tab.reload()
        tab.tab("Cleaning")
        tab.tab("YAML")
        tab.see("Tuned, not applied")
        tab.press("Tune…")
        tab.press(TAKE)
        tab.page.wait_for_function("text => document.querySelector('textarea').value === text", arg=proposed)
        assert "# in a hurry" in proposed
        assert session_of(server).document.past == (POOR,)
        assert session_of(server).document.file.read_text() == POOR
        tab.press("Undo")
        tab.page.wait_for_function("text => document.querySelector('textarea').value === text", arg=POOR)
        assert tab.errors == []
        assert tab.strangers == []
