"""A running operation in a real browser: joints, node and sensors, and a stop past a server that hangs."""

import asyncio
import re
import threading
import time

import numpy as np
import pytest
from driven_page import CHROMIUM, NO_CHROMIUM, DrivenPage, open_chromium
from operated import write_cell
from playwright.sync_api import expect

from robotcell.cell.load import cell_sha256, read_cell
from webui.live.live import LiveServer, Running, announced
from webui.scene.scene import Scene
from webui.server import server as servers

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)]

STATE = {
    "state": "running", "reason": "", "node": 7, "nodes": 40, "tool": 1, "age_ms": 20.0,
    "jets": ["doRing"],
    "joints": {f"axis_{number}_deg": 10.0 * number for number in range(1, 7)},
    "conditions": {"door_closed": True, "part_present": False}, "quantities": {"conductivity": 4.5},
}  # fmt: skip


def test_an_operation_is_watched_and_stopped_while_the_server_of_the_page_hangs(start_server, tmp_path, monkeypatch):
    scenes = []
    monkeypatch.setattr(servers, "Scene", lambda page: scenes.append(Scene(page)) or scenes[-1])
    cell = read_cell(write_cell(tmp_path, "{kind: modbus, host: 127.0.0.1}"))
    words, state, hangs = [], dict(STATE), threading.Event()
    begun = time.monotonic()
    live = LiveServer(lambda: state | {"seconds": time.monotonic() - begun}, words.append)
    running = Running(live.address, live.token, "demo.wash", "small", cell_sha256(cell))
    server = start_server("tiny", "rinse-only")
    with announced(tmp_path, running), open_chromium() as browser:
        tab = DrivenPage(browser, server.address)
        band = tab.page.locator("#wb-live")
        assert not band.is_visible()
        tab.tab("Robot")
        tab.choose("Cell", "small.yaml")
        tab.tab("Live")
        tab.press("Watch")
        tab.see("node 7 of 40")
        expect(band.locator("b")).to_have_text("running")
        expect(tab.page.locator("[data-live-tables]")).to_contain_text(
            re.compile(r"axis_3\s*30\.00\u00b0.*not met.*doRing", re.S)
        )
        expect(tab.page.locator("#wb-live-scene")).to_contain_text("scene")
        stood = scenes[0].robot._pose[0]
        np.testing.assert_allclose(stood, np.radians(list(STATE["joints"].values())))
        tab.tab("Job")  # the band stays in every mode
        state.update(age_ms=5000.0)
        expect(band).to_contain_text("not live: 5.")
        expect(tab.page.locator("html")).to_have_attribute("data-live-is", "stale")
        state.update(age_ms=20.0, node=8)
        expect(band).to_contain_text("node 8 of 40")
        loop = server.sessions.pages()[0].client.gui._event_loop
        loop.call_soon_threadsafe(hangs.wait, 60)
        later = asyncio.run_coroutine_threadsafe(asyncio.sleep(0), loop)
        try:
            state.update(node=9)
            expect(band).to_contain_text("node 9 of 40")
            band.get_by_role("button", name="STOP").click()
            expect(band.get_by_role("button", name="Stopping")).to_be_visible()
            expect(band).to_contain_text("scene not live")
            assert words == ["stop"]
            assert not later.done()
        finally:
            hangs.set()
        state.update(state="idle", node=9)
        expect(band.get_by_role("button", name="Stopped")).to_be_disabled()
        state.update(state="running")
        expect(band).to_contain_text("running")
        live.close()
        expect(band).to_contain_text("not live")
        assert [line for line in tab.errors if "ERR_CONNECTION_REFUSED" not in line] == []
        assert tab.strangers == []


def test_the_live_views_own_page_opens_by_its_token_shows_and_stops_the_operation():
    words, said, state = [], [], dict(STATE)
    begun = time.monotonic()
    live = LiveServer(lambda: state | {"seconds": time.monotonic() - begun}, words.append)
    with open_chromium() as browser:
        context = browser.new_context()
        page = context.new_page()
        page.on("console", lambda message: said.append(message.text))
        assert page.goto(live.address).status == 403
        page.goto(live.entrance)
        assert page.url == f"{live.address}/"
        said.clear()
        for _ in range(2):
            expect(page.locator("[data-live=node]")).to_have_text("node 7 of 40")
            page.reload()
        other = context.new_page()
        other.goto(live.address)
        expect(other.locator("[data-live=state]")).to_have_text("running")
        other.get_by_role("button", name="STOP").click()
        expect(other.get_by_role("button", name="Stopping")).to_be_visible()
        assert words == ["stop"]
        assert said == []
    live.close()
