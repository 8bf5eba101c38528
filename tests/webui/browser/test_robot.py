"""An engineer's way from a cell to the robot's program, in a real browser."""

import io
import zipfile

import pytest
from driven_page import CHROMIUM, NO_CHROMIUM, DrivenPage, open_chromium
from found_place import found_place
from hostile_cells import hostile_text

from robotcell.cell.load import read_cell
from webui.downloads.downloads import make_program
from webui.panels.robot import placement

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)]


def quiet(_what, _done):
    pass


def test_from_a_cell_to_the_robots_program(start_server, monkeypatch):
    monkeypatch.setattr(placement, "search_place", lambda *_, **__: found_place())
    server = start_server("tiny", "rinse-only")
    with open_chromium() as browser:
        tab = DrivenPage(browser, server.address)
        tab.tab("Program")
        tab.see("Choose a cell in the tab Robot")
        tab.tab("Robot")
        tab.choose("Cell", "ur5e-bench")
        tab.see("A UR5e on a table")
        tab.press("Check")
        tab.see(": can be done")
        tab.see("shoulder_pan")
        tab.choose("Metric", "Manipulability")
        tab.see("Go to the worst")
        assert_a_place_is_found_and_its_scene_opens(tab, server)
        tab.press("Play")
        tab.wait_for_input("Time (s)", "value => Number(value) > 1")
        tab.tab("Program")
        tab.press("Write")
        tab.see("def tiny")
        with tab.page.expect_download() as waiting:
            tab.press("Download")
        written = waiting.value.path().read_bytes()
        session = server.sessions.pages()[0].session
        assert session.cell.cell.name == read_cell("ur5e-bench").cell.name
        ((name, text),) = make_program(session, "ur", quiet).written.exported.files.items()
        with zipfile.ZipFile(io.BytesIO(written)) as packed:
            assert packed.read(name) == text.encode()
            assert any(each.endswith(".commissioning.md") for each in packed.namelist())
        tab.reload()
        tab.tab("Robot")
        tab.see(": can be done")
        assert tab.errors == []
        assert tab.strangers == []


def assert_a_place_is_found_and_its_scene_opens(tab, server):
    """The map, a box plot of each configuration, and the downloaded scene read by the browser's own reader of GLB."""
    tab.page.get_by_text("Best place", exact=True).click()
    tab.press("Find the best place")
    tab.see("A better place was found")
    assert tab.page.get_by_role("img", name="Map of placements").is_visible()
    assert tab.page.get_by_role("img", name="front, up, J5-: least").count() == 1
    tab.press("Go to the worst point")
    with tab.page.expect_download() as waiting:
        tab.press("Download the scene (GLB)")
    content = waiting.value.path().read_bytes()
    (client,) = server.viser.get_clients().values()
    client.scene.add_glb("/opened", content)
    client.scene.add_glb("/broken", content[: len(content) // 2])  # it is read after the other
    tab.wait_for_log("Error loading GLB!")
    assert sum("Error loading GLB!" in line for line in tab.said) == 1


def test_a_cell_that_cannot_do_it_can_after_one_click(start_server, tmp_path):
    cell = tmp_path / "long.yaml"
    cell.write_text(hostile_text("ur5e-bench", "long-tool"))
    text = cell.read_text()
    server = start_server("tiny", "rinse-only")
    with open_chromium() as browser:
        tab = DrivenPage(browser, server.address)
        tab.tab("Robot")
        tab.choose("Cell", "long.yaml")
        tab.press("Check")
        tab.see(": cannot be done")
        tab.see("tools.1.tcp.xyz_mm: [0, 0, 700] -> [0, 0, 300]")
        tab.tab("Findings")
        tab.see("tools.1.tcp.xyz_mm: [0, 0, 700] -> [0, 0, 300]")
        tab.press("Apply the remedy")
        tab.see("long.yaml is written and checked")
        tab.tab("Robot")
        tab.see(": can be done")
        assert read_cell(cell).spec.tools[1].tcp.xyz_mm == (0, 0, 300)
        tab.tab("YAML")
        tab.press("Undo")
        tab.tab("Robot")
        tab.see("changed since it was checked")
        assert cell.read_text() == text
        assert tab.errors == []
