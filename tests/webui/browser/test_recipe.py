"""A recipe is edited in a real browser: forms, text, undo, saving, and a reload that loses nothing."""

import numpy as np
import pytest
from driven_page import CHROMIUM, FEWER_FRAMES, NO_CHROMIUM, WAIT_MS, open_chromium, with_query

from webui.page.project import Project
from webui.server.server import open_session, serve

pytestmark = pytest.mark.slow
TYPED_MS = 150  # the page sends what is typed every 50 ms
MOVED_MS = 1500  # the page sends where its camera is now and then


@pytest.fixture
def server(tmp_path):
    server = serve(open_session("tiny", "smt-aqueous"), Project(tmp_path), "127.0.0.1", 0)
    yield server
    server.stop()


class Browser:
    """What somebody does with the page."""

    def __init__(self, page, url):
        self.page = page
        self.said = []
        page.on("console", lambda message: self.said.append(f"{message.type}: {message.text}"))
        page.on("pageerror", lambda error: self.said.append(f"error: {error}"))
        page.add_init_script(FEWER_FRAMES)
        page.goto(with_query(url, "fixedDpr=0.25"), wait_until="domcontentloaded")
        self.tab("Recipe")

    def tab(self, name):
        self.page.get_by_role("tab", name=name, exact=True).click()

    def choose(self, label, value):
        self.page.get_by_label(label, exact=True).first.click()
        self.page.get_by_role("option", name=value, exact=True).click()

    def input(self, label):
        return self.page.locator(f"xpath=//label[normalize-space(.)='{label}']/../../..//input").first

    def type(self, label, value):
        self.input(label).fill(value)
        self.page.wait_for_timeout(TYPED_MS)
        self.input(label).press("Enter")

    def press(self, name):
        self.page.get_by_role("button", name=name, exact=True).last.click()

    def expect(self, script, argument=None):
        self.page.wait_for_function(script, arg=argument, timeout=WAIT_MS)

    def expect_text(self, part):
        self.tab("YAML")
        self.expect("part => document.querySelector('textarea')?.value.includes(part)", part)

    def expect_input(self, label, value):
        self.tab("Recipe")
        self.expect(
            "([label, value]) => [...document.querySelectorAll('label')].some(each => each.textContent === label && "
            "each.closest('.mantine-Flex-root').querySelector('input')?.value === value)",
            [label, value],
        )


@pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)
@pytest.mark.long
def test_a_recipe_is_edited_saved_and_found_again(server, tmp_path):
    with open_chromium() as chromium:
        page = chromium.new_page(viewport={"width": 1400, "height": 900})
        browser = Browser(page, server.address)
        browser.choose("Entry", "around")
        browser.expect_input("Speed (mm/s)", "40")
        page.wait_for_timeout(TYPED_MS)

        browser.type("Speed (mm/s)", "500")
        page.get_by_text("500 mm/s is above the maximum 120 mm/s").wait_for()
        assert browser.input("Speed (mm/s)").input_value() == "500"

        browser.type("Speed (mm/s)", "33")
        browser.expect_text("    speed_mm_s: 33\n    align: wavefront")
        browser.press("Undo")
        browser.expect_text("    speed_mm_s: 40\n    align: wavefront")
        browser.expect_input("Speed (mm/s)", "40")
        browser.tab("YAML")
        browser.press("Redo")
        browser.expect_input("Speed (mm/s)", "33")

        browser.tab("YAML")
        browser.press("Save as…")
        browser.type("File", "house")
        page.get_by_text("saved", exact=True).wait_for()
        assert "    speed_mm_s: 33\n    align: wavefront" in (tmp_path / "house.yaml").read_text()

        browser.tab("Recipe")
        browser.type("Speed (mm/s)", "34")
        browser.expect_text("    speed_mm_s: 34\n    align: wavefront")
        page.reload(wait_until="domcontentloaded")
        browser.expect_text("    speed_mm_s: 34\n    align: wavefront")
        (client,) = server.viser.get_clients().values()
        page.wait_for_timeout(MOVED_MS)
        stood = client.camera.position
        page.keyboard.press("Control+s")
        page.get_by_text("saved", exact=True).wait_for()
        assert "    speed_mm_s: 34\n" in (tmp_path / "house.yaml").read_text()
        page.locator("#wb-bar button", has_text="Save").click()
        page.keyboard.down("d")  # a key that flies through the scene, where the page does not keep it away
        page.wait_for_timeout(MOVED_MS)
        page.keyboard.up("d")
        np.testing.assert_allclose(client.camera.position, stood, atol=1e-6)
    assert [line for line in browser.said if line.startswith("error")] == []
