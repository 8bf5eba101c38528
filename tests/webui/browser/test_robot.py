"""An engineer's way from a cell to the robot's program, in a real browser."""

import pytest
from driven_page import CHROMIUM, NO_CHROMIUM, DrivenPage, open_chromium
from hostile_cells import hostile_text

from robotcell.cell.load import read_cell
from webui.downloads.downloads import make_program

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)]


def quiet(_what, _done):
    pass


def test_from_a_cell_to_the_robots_program(start_server):
    server = start_server("tiny", "rinse-only")
    with open_chromium() as browser:
        tab = DrivenPage(browser, server.address)
        tab.tab("Program")
        tab.see("Choose a cell in the tab Robot")
        tab.tab("Robot")
        tab.choose("Cell", "ur5e-bench")
        tab.see("A UR5e on a table")
        tab.press("Check")
        tab.see("The robot can do it")
        tab.see("shoulder_pan")
        tab.choose("Metric", "Manipulability")
        tab.see("Go to the worst")
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
        assert written == make_program(session, "ur", quiet).written.exported.files["tiny.script"].encode()
        tab.reload()
        tab.tab("Robot")
        tab.see("The robot can do it")
        assert tab.errors == []
        assert tab.strangers == []


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
        tab.see("The robot cannot do it")
        tab.see("tools.1.tcp.xyz_mm: [0, 0, 700] -> [0, 0, 300]")
        tab.tab("Findings")
        tab.see("tools.1.tcp.xyz_mm: [0, 0, 700] -> [0, 0, 300]")
        tab.press("Apply the remedy")
        tab.see("long.yaml is written and checked")
        tab.tab("Robot")
        tab.see("The robot can do it.")
        assert read_cell(cell).spec.tools[1].tcp.xyz_mm == (0, 0, 300)
        tab.tab("YAML")
        tab.press("Undo")
        tab.tab("Robot")
        tab.see("changed since it was checked")
        assert cell.read_text() == text
        assert tab.errors == []
