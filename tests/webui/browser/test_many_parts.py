"""The page with a board of 600 parts, in a real browser: what it sends and draws stays bounded, and it answers."""

import pytest
from driven_page import CHROMIUM, NO_CHROMIUM, DrivenPage, camera_of, open_chromium, visible_component
from large_board import write_crowded_board

from webui.layers.paths.strokes import stroke_lines

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)]
GROUPS = 20, 15
MOST_MESSAGES, MOST_NODES, MOST_ROWS = 60, 8000, 250
"""As many as 5,000 parts have, with all tabs open."""
MOST_BYTES = 4_000_000
"""The board's triangles and the strokes grow with the parts; nothing else does."""


def test_six_hundred_parts(start_server, tmp_path):
    server = start_server(str(write_crowded_board(tmp_path / "crowded.tri", GROUPS)), "smt-aqueous")
    sizes: list[int] = []
    with open_chromium() as browser:
        page = browser.new_page(viewport={"width": 1400, "height": 900})
        page.on("websocket", lambda socket: socket.on("framereceived", lambda data: sizes.append(len(data))))
        tab = DrivenPage(browser, server.address, page)
        session = server.sessions.pages()[0]
        assert len(session.session.workpiece.components) == 600
        assert len(sizes) <= MOST_MESSAGES
        assert sum(sizes) <= MOST_BYTES
        lines = stroke_lines(session.session.run.plan)
        name, place = visible_component(session.session.workpiece, lines, camera_of(server))
        tab.click_scene(camera_of(server), place)
        tab.wait_until(lambda: session.session.selection.component == name)
        tab.tab("Components")
        tab.see("and 400 more; filter to see them")
        tab.type("Filter", "U299")
        tab.page.locator("tr[data-row='U299']").filter(visible=True).first.click()
        tab.wait_until(lambda: session.session.selection.component == "U299")
        before = tab.time_text
        tab.edit("around", "Speed (mm/s)", "20")
        tab.wait_for_another_time(before)
        assert tab.page.locator("tr").count() <= MOST_ROWS
        assert tab.page.evaluate("document.querySelectorAll('*').length") <= MOST_NODES
        assert tab.errors == []
