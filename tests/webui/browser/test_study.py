"""A study is opened from the folder, and a combination of it leads to its board and recipe, in a real browser."""

import pytest
from driven_page import CHROMIUM, NO_CHROMIUM, DrivenPage, open_chromium
from made_study import write_made_study

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)]


def test_from_a_study_to_the_recipe_of_a_combination(start_server, tmp_path):
    write_made_study(tmp_path / "speeds")
    server = start_server("tiny", "smt-aqueous")
    with open_chromium() as browser:
        tab = DrivenPage(browser, server.address)
        total = tab.time_text
        tab.tab("Study")
        tab.press("Open a study\N{HORIZONTAL ELLIPSIS}")
        tab.choose("Study", "speeds/runs.csv")
        tab.press("Open")
        tab.page.get_by_role("img", name="8 combinations").wait_for()
        tab.choose("Combination", "1")
        tab.see("2 of 4 with deviations")
        tab.press("Open board and recipe")
        tab.wait_for_another_time(total)
        (page,) = server.sessions.pages()
        assert page.session.recipe.sequence[0].least_time_s == 300
        assert tab.errors == []
