"""A robot's program is opened from the folder and by upload, played, and closed again, in a real browser."""

import pytest
from driven_page import CHROMIUM, NO_CHROMIUM, DrivenPage, open_chromium

from programs.export import export
from robotcell.cell.installation import installation_of
from robotcell.cell.load import read_cell
from rulesengine.planning.pipeline import run
from webui.downloads.program_text import zip_bytes
from webui.server.server import open_session

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)]


def test_a_program_is_opened_played_and_closed(start_server, tmp_path):
    session = open_session("tiny", "rinse-only")
    done = run(session.recipe, session.board)
    files = export(done.program, installation_of(read_cell("kr6-bench")), "kuka").files
    (tmp_path / "line 3").mkdir()
    for name, text in files.items():
        (tmp_path / "line 3" / name).write_text(text)
    server = start_server("tiny", "rinse-only")
    with open_chromium() as browser:
        tab = DrivenPage(browser, server.address)
        total = tab.time_text
        tab.tab("Program")
        tab.press("Open a program\N{HORIZONTAL ELLIPSIS}")
        tab.choose("Program", "line 3/")
        tab.press("Open")
        tab.see("Read from KUKA KRL")
        tab.press("Play")
        tab.wait_for_input("Time (s)", "value => Number(value) > 1")
        tab.tab("Recipe")
        tab.see("A robot's program is shown")
        tab.tab("Program")
        tab.press("Close the program")
        tab.wait_for_time(total)
        tab.see("Planned")
        packed = zip_bytes({name: text.encode() for name, text in files.items()})
        with tab.page.expect_file_chooser() as chooser:
            tab.press("Upload a program")
        chooser.value.set_files(
            [
                {
                    "name": "p.zip",
                    "mimeType": "application/zip",
                    "buffer": packed,
                }
            ]
        )
        tab.see("Read from KUKA KRL")
        tab.press("Close the program")
        tab.wait_for_time(total)
        assert tab.errors == []
