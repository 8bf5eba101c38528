"""The head of the page: modes that have all tabs, and a script that stays inside its element."""

import re

from webui.server.server import TABS
from webui.theme.page_head import KEYS, MODES, page_head


def test_every_tab_is_in_a_mode_and_every_mode_has_tabs_on_both_sides():
    left, right = ({label for label, _ in side} for side in TABS)
    assert {tab for tabs in MODES.values() for tab in tabs} == left | right
    for tabs in MODES.values():
        assert left & {*tabs}
        assert right & {*tabs}


def test_the_head_is_one_style_and_one_script():
    head = page_head()
    assert re.findall(r"</?(?:style|script)", head) == ["<style", "</style", "<script", "</script"]
    assert all(key in head for key, _ in KEYS if key.isascii())
    assert '[data-mode="Plan"] [role=tab][title="Robot"]' in head
    assert '[data-mode="Robot"] [role=tab][title="Robot"]' not in head


def test_the_head_is_the_same_each_time():
    assert page_head() == page_head()
