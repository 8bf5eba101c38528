import pytest
from driven_page import CHROMIUM, NO_CHROMIUM, open_chromium
from tiny_session import tiny_session

from webui.downloads.recording import record

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)]


def test_a_recording_plays_from_a_file_without_a_network(tmp_path):
    file = tmp_path / "playback.html"
    file.write_text(record(tiny_session().run, 10.0))
    said: list[str] = []
    asked: list[str] = []
    with open_chromium() as browser:
        page = browser.new_page(viewport={"width": 800, "height": 600})
        page.on("console", lambda message: said.append(f"{message.type}: {message.text}"))
        page.on("pageerror", lambda error: said.append(f"error: {error}"))
        page.on("request", lambda request: asked.append(request.url))
        page.goto(file.as_uri(), wait_until="domcontentloaded")
        page.wait_for_selector("canvas")
        page.wait_for_function("[...document.querySelectorAll('input')].some(input => Number(input.value) > 0.5)")
    assert any("Embedded data loaded" in line for line in said)
    assert [line for line in said if line.startswith("error")] == []
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []
