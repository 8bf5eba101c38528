"""The page without a mouse, by name, in both colours and on a phone: axe-core, keys, words when there is no server."""

import pytest
from axe_playwright_python.sync_playwright import Axe
from driven_page import CHROMIUM, NO_CHROMIUM, DrivenPage, open_chromium

from webui.server.server import TABS
from webui.theme.page_head import KEYS, MODES

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM),
]
RULES = {"runOnly": ["wcag2a", "wcag2aa", "wcag21aa", "wcag22aa"], "resultTypes": ["violations"]}
SETTLED = """() => [...document.querySelectorAll('body input:not([type=hidden]), body textarea')].every(each =>
    !each.getClientRects().length || each.getAttribute('aria-label') ||
    document.querySelector(`label[for="${CSS.escape(each.id)}"]`))"""
REACHABLE = """() => [...document.querySelectorAll(
    'button, input, textarea, [role=tab], [role=slider], [role=button]')].filter(each =>
    each.tabIndex >= 0 && !each.disabled && each.type !== 'hidden' && each.getClientRects().length &&
    getComputedStyle(each).visibility === 'visible' && !each.closest('dialog:not([open])'))"""
PANEL = """tab => {
    let panel = tab.closest("[role=tablist]");
    while (panel.getBoundingClientRect().height < 200) panel = panel.parentElement;
    return panel;
}"""
WATCH = """() => {
    window.seen ?? document.addEventListener('focusin', event => window.seen.add(event.target));
    window.seen = new Set();
}"""


@pytest.fixture(scope="module")
def chromium():
    with open_chromium() as chromium:
        yield chromium


def opened(chromium, server, width=1280, height=720, colours="light"):
    context = chromium.new_context(viewport={"width": width, "height": height}, color_scheme=colours)
    tab = DrivenPage(chromium, server.address, context.new_page())
    tab.dismiss_notice()
    return tab


def serious(tab):
    """Violations that axe-core finds, as ``rule: element``."""
    tab.page.wait_for_function(SETTLED)
    if not tab.page.evaluate("'axe' in window"):
        tab.page.evaluate(Axe().axe_script)
    found = tab.page.evaluate("rules => axe.run(rules).then(found => found.violations)", RULES)
    return [
        f"{each['id']}: {node['html'][:200]}"
        for each in found
        if each["impact"] in ("serious", "critical")
        for node in each["nodes"]
    ]


@pytest.mark.parametrize("colours", ["light", "dark"])
def test_axe_finds_nothing_serious_in_any_tab(chromium, start_server, colours):
    tab = opened(chromium, start_server("tiny", "rinse-only"), colours=colours)
    assert tab.page.locator("html").get_attribute("data-mantine-color-scheme") == colours
    # Two are open at a time, one on each side; in the other colours fewer, since the colours alone differ.
    every = (("Job", "Recipe"), ("Board", "YAML"), ("Components", "Paths"), ("Findings", ""), ("Robot", "Program"),
             ("Cleaning", ""), ("Files", "Compare"))  # fmt: skip
    for names in every if colours == "light" else (("Findings", "Paths"), ("Cleaning", "")):
        for name in filter(None, names):
            tab.tab(name)
        assert serious(tab) == [], names
    tab.tab("YAML")
    tab.press("Save as…")
    window = tab.page.locator(".mantine-Modal-content")
    window.wait_for()
    assert serious(tab) == []
    tab.page.keyboard.press("Escape")
    window.wait_for(state="detached")
    assert tab.errors == []
    tab.page.context.close()


def test_every_control_is_reached_by_the_tab_key_and_those_of_a_tab_from_it(chromium, start_server):
    tab = opened(chromium, start_server("tiny", "rinse-only"))
    for mode in ("Plan", "Robot"):
        tab.page.locator(f"#wb-bar [data-to={mode}]").click()
        tab.page.wait_for_function(SETTLED)
        count = tab.page.evaluate(f"({REACHABLE})().length")
        assert count > 25
        tab.page.evaluate(WATCH)
        unseen = f"({REACHABLE})().filter(each => !window.seen.has(each)).map(each => each.outerHTML.slice(0, 200))"
        for _ in range(3):  # once around is enough unless the page is drawn anew meanwhile
            for _ in range(count + 3):
                tab.page.keyboard.press("Tab")
            if not tab.page.evaluate(unseen):
                break
        assert tab.page.evaluate(unseen) == [], mode
    for name in dict.fromkeys(each for tabs in MODES.values() for each in tabs):
        tab.tab(name)
        tab.page.wait_for_function(SETTLED)
        # A panel may be drawn anew while the keys go through it: the keys go through its new controls again.
        missed = not_reached(tab, name) and not_reached(tab, name) and not_reached(tab, name)
        assert not missed, (name, missed)
    tab.page.context.close()


def not_reached(tab, name):
    """Controls of a tab that the Tab key does not come to from it."""
    panel = tab.page.get_by_role("tab", name=name, exact=True).evaluate_handle(PANEL)
    controls = f"panel => ({REACHABLE})().filter(each => panel.contains(each) && each.role !== 'tab')"
    count = panel.evaluate(f"panel => ({controls})(panel).length")
    assert count >= 1, name
    tab.page.get_by_role("tab", name=name, exact=True).focus()
    tab.page.evaluate(WATCH)
    for _ in range(count + 3):
        tab.page.keyboard.press("Tab")
    unseen = f"({controls})(panel).filter(each => !window.seen.has(each))"
    return panel.evaluate(f"panel => {unseen}.map(each => each.outerHTML.slice(0, 200))")


def test_keys_go_through_the_tabs_change_the_mode_and_play_and_are_listed(chromium, start_server):
    tab = opened(chromium, start_server("tiny", "rinse-only"))
    arrows_go_through_the_tabs_that_are_shown(tab)
    tab.page.evaluate("document.activeElement.blur()")
    keys_change_the_mode_play_and_are_listed(tab)
    assert tab.errors == []
    tab.page.context.close()


def arrows_go_through_the_tabs_that_are_shown(tab):
    shown = [each for each in TABS[0] if each[0] in MODES["Plan"]]
    names = [name for name, _ in shown]
    tab.tab(names[0])
    tab.page.get_by_role("tab", name=names[0], exact=True).focus()
    for key, wanted in [
        *(("ArrowRight", name) for name in (*names[1:], names[0])),
        ("ArrowLeft", names[-1]),
        ("Home", names[0]),
    ]:
        tab.page.keyboard.press(key)
        tab.page.get_by_role("tab", name=wanted, exact=True, selected=True).wait_for()
        assert tab.page.evaluate("document.activeElement.title") == wanted
    thumb = tab.page.locator(".mantine-Slider-thumb").first  # keys of other controls stay theirs
    for key, wanted in (("ArrowRight", "value => Number(value) > 0"), ("Home", "value => Number(value) === 0")):
        thumb.press(key)
        tab.wait_for_input("Time (s)", wanted)
    field = tab.input("Speed (mm/s)")
    field.press("Home")
    tab.page.keyboard.type("7")
    assert field.input_value().startswith("7")


def keys_change_the_mode_play_and_are_listed(tab):
    page = tab.page
    for number, mode in enumerate(MODES, start=1):
        page.keyboard.press(str(number))
        page.locator(f"#wb-bar [data-to={mode}][aria-pressed=true]").wait_for()
        page.get_by_role("tab", name=MODES[mode][0], exact=True, selected=True).wait_for()
    page.keyboard.press("?")
    listed = page.locator("#wb-keys").inner_text()
    assert all(key in listed and what in listed for key, what in KEYS)
    page.keyboard.press("Escape")
    page.locator("#wb-keys").wait_for(state="hidden")
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("Space")
    page.get_by_role("button", name="Pause", exact=True).wait_for()
    page.keyboard.press("Space")
    page.get_by_role("button", name="Play", exact=True).wait_for()
    page.keyboard.press("1")
    tab.input("Speed (mm/s)").press("Control+a")
    page.keyboard.type("2?")  # is typed, and changes nothing
    assert tab.input("Speed (mm/s)").input_value() == "2?"
    assert page.locator("#wb-bar [data-to=Plan][aria-pressed=true]").count() == 1


def test_a_mode_brings_back_the_tab_that_was_open_and_outlives_a_reload(chromium, start_server):
    tab = opened(chromium, start_server("tiny", "rinse-only"))
    tab.tab("Paths")
    tab.tab("Findings")
    tab.tab("Robot")
    tab.page.locator("#wb-bar [data-to=Plan]").click()
    for name in ("Paths", "Findings"):
        tab.page.get_by_role("tab", name=name, exact=True, selected=True).wait_for()
    tab.tab("Compare")
    tab.reload()
    tab.page.locator("#wb-bar [data-to=Export][aria-pressed=true]").wait_for()
    assert not tab.page.get_by_role("tab", name="YAML", exact=True).is_visible()
    tab.page.context.close()


def test_undo_and_colours_are_in_the_bar(chromium, start_server):
    tab = opened(chromium, start_server("tiny", "rinse-only"))
    before = tab.time_text
    tab.edit("edge", "Speed (mm/s)", "11")
    after = tab.wait_for_another_time(before)
    tab.page.get_by_role("button", name="Undo (Ctrl+Z)", exact=True).click()
    tab.wait_for_time(before)
    tab.page.get_by_role("button", name="Redo (Ctrl+Shift+Z)", exact=True).click()
    tab.wait_for_time(after)
    tab.page.get_by_role("button", name="Dark colours", exact=True).click()
    tab.page.locator("html[data-mantine-color-scheme=dark][data-ready]").wait_for()
    tab.wait_for_time(after)  # the edit is there after the page was made anew
    assert tab.errors == []
    tab.page.context.close()


def test_on_a_phone_nothing_is_wider_than_the_window_and_the_board_is_above_the_sheet(chromium, start_server):
    tab = opened(chromium, start_server("tiny", "rinse-only"), 390, 844, "dark")
    page = tab.page
    page.wait_for_function("() => document.querySelectorAll('[data-status]').length === 4")
    sheet = page.locator(".mantine-Paper-root:has([data-job])").first.bounding_box()
    scene = page.locator("canvas").last.bounding_box()
    assert (sheet["x"], sheet["width"]) == (0, 390)
    assert scene["y"] + scene["height"] <= sheet["y"] + 1
    for each in page.locator("[data-status]").all():
        box = each.bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= 390
    assert serious(tab) == []
    page.context.close()


def test_words_while_it_loads_and_when_the_server_is_gone(chromium, start_server):
    server = start_server("tiny", "rinse-only")
    tab = opened(chromium, server)
    assert tab.page.locator("#wb-veil").text_content().startswith("Washboard is loading")
    assert not tab.page.locator("#wb-veil").is_visible()
    assert not tab.page.locator("#wb-gone").is_visible()
    server.stop()
    tab.see("The server does not answer. Your edits are kept; reconnecting")
    tab.page.context.close()
