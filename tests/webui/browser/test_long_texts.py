"""Long texts pasted into the recipe: ten thousand lines are taken, a hundred thousand refused in words."""

import pytest
from driven_page import CHROMIUM, NO_CHROMIUM, DrivenPage, open_chromium

from webui.theme.page_head import MOST_LINES

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM),
]
PASTE = """text => {
    const area = document.querySelector('textarea'), given = new DataTransfer();
    area.focus();
    area.setSelectionRange(area.value.length, area.value.length);
    given.setData('text/plain', text);
    const event = new ClipboardEvent('paste', {clipboardData: given, bubbles: true, cancelable: true});
    if (area.dispatchEvent(event)) document.execCommand('insertText', false, text);
}"""


def comments(count):
    return "".join(f"# line {number}\n" for number in range(count))


def test_ten_thousand_lines_are_taken_and_a_hundred_thousand_refused_in_words(start_server):
    server = start_server("tiny", "rinse-only")
    with open_chromium() as browser:
        tab = DrivenPage(browser, server.address)
        tab.dismiss_notice()
        (shown,) = server.sessions.pages()
        before = shown.session.document.text
        tab.tab("YAML")
        tab.page.locator("textarea").first.wait_for()
        tab.page.evaluate(PASTE, comments(10_000))
        tab.see("Not applied yet: press Apply text")
        tab.press("Apply text")
        tab.page.get_by_text("Not applied yet: press Apply text").wait_for(state="detached")
        assert shown.session.document.text == before + comments(10_000)
        tab.page.evaluate(PASTE, comments(100_000))
        tab.see(f"at most {MOST_LINES:,}")
        assert tab.page.locator("textarea").first.input_value() == before + comments(10_000)
        tab.press("Undo")
        tab.page.wait_for_function(
            "most => document.querySelector('textarea').value.length < most", arg=len(before) + 1
        )
        assert shown.session.document.text == before
        assert tab.errors == []
