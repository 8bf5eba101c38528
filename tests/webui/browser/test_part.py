"""The F-shaped part in a real browser: opened, planned, analysed, its faces seen."""

import pytest
from driven_page import CHROMIUM, NO_CHROMIUM, DrivenPage, open_chromium

pytestmark = [pytest.mark.slow, pytest.mark.long, pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)]


def test_from_a_part_to_the_verdicts_on_its_faces(start_server):
    server = start_server("f-bracket", "part-degrease")
    with open_chromium() as browser:
        tab = DrivenPage(browser, server.address)
        assert "11 of 11" in tab.page.locator("[data-status=sprayed]").inner_text()
        tab.tab("Board")
        tab.see("12, 11 of them sprayed")
        assert not tab.page.get_by_role("button", name="Join parts table").is_visible()
        tab.tab("Components")
        tab.choose("Go to", "face-10")
        tab.see("1.00, 0.00, 0.00")
        tab.tab("Cleaning")
        assert not tab.page.get_by_label("Parameters", exact=True).is_visible()
        tab.press("Analyse")
        tab.see("Held for the required time")
        session = server.sessions.pages()[0].session
        verdicts = session.face_analysis.verdicts
        clean = sum(each.verdict == "clean" for each in verdicts)
        assert clean == len(verdicts) == 11
        tab.page.get_by_text("11 clean").first.wait_for()
        assert "all clean" in tab.page.locator("[data-status=cleaning]").inner_text()
        tab.press("Play")
        tab.wait_for_input("Time (s)", "value => Number(value) > 1")
        assert tab.errors == []
        assert tab.strangers == []
