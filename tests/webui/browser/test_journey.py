"""The way of an engineer through the page, in a real browser, on a board as large as a real one.

``WASHBOARD_BOARD=coldfire.tri`` takes a board of yours instead of the one that is made for it.
"""

import os
import shutil
from pathlib import Path

import pytest
from driven_page import (
    CHROMIUM,
    NO_CHROMIUM,
    TYPED_MS,
    DrivenPage,
    camera_of,
    open_chromium,
    visible_component,
)
from large_board import write_large_board

from boards.load import load_board
from recipes.load import load_recipe
from reports.files.write_run import program_bytes
from rulesengine.planning.pipeline import run
from webui.layers.paths.strokes import stroke_lines

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM),
]


def play_for_a_moment(tab):
    tab.press("Play")
    tab.wait_for_input("Time (s)", "value => Number(value) > 1")
    tab.press("Pause")


def go_to_the_middle(tab):
    strip = tab.page.locator(".mantine-Slider-trackContainer").first.bounding_box()
    tab.page.mouse.click(strip["x"] + strip["width"] / 2, strip["y"] + strip["height"] / 2)
    end = "Number(document.querySelector('.mantine-Slider-thumb').getAttribute('aria-valuemax'))"
    tab.wait_for_input("Time (s)", f"value => Math.abs(Number(value) / {end} - 0.5) < 0.01")


def click_a_component(tab, server, board, recipe):
    lines = stroke_lines(run(recipe, board).plan)
    name, place = visible_component(board, lines, camera_of(server))
    tab.tab("Components")
    tab.click_scene(camera_of(server), place)
    tab.wait_for_input("Go to", "(value, name) => value === name", name)


def draw_a_line(tab, server, board):
    x_min, y_min, x_max, y_max = board.outline.bounds
    tab.tab("Paths")
    tab.press("Draw a line")
    for share in (0.3, 0.7):
        place = (x_min + share * (x_max - x_min), (y_min + y_max) / 2, board.top_z_mm)
        tab.click_scene(camera_of(server), place)
        if share == 0.3:
            tab.see("Click where it ends.")
    tab.press("Add to the recipe")


def save_as(tab, name):
    tab.tab("YAML")
    tab.press("Save as…")
    tab.type("File", name)
    tab.page.get_by_text("saved", exact=True).wait_for()


def download(tab, kind):
    tab.tab("Files")
    tab.choose("File", kind)
    tab.page.wait_for_timeout(TYPED_MS)
    if kind.startswith("Playback"):
        tab.choose("Speed (x)", "50")
        tab.page.wait_for_timeout(TYPED_MS)
    with tab.page.expect_download() as download:
        tab.press("Download")
    return download.value.suggested_filename, Path(download.value.path()).read_bytes()


@pytest.mark.long
def test_from_a_board_to_a_program(start_server, tmp_path):
    file = tmp_path / "large.tri"
    given = os.environ.get("WASHBOARD_BOARD")
    file = Path(shutil.copy(given, file)) if given else write_large_board(file)
    server, board = start_server("tiny", "smt-aqueous"), load_board(file)
    with open_chromium() as browser:
        tab = DrivenPage(browser, server.address)
        tab.dismiss_notice()
        at_first = tab.time_text
        tab.tab("Board")
        tab.choose("Workpiece", "large.tri")
        unedited = tab.wait_for_another_time(at_first)

        tab.edit("around", "Speed (mm/s)", "30")
        slower = tab.wait_for_another_time(unedited)
        play_for_a_moment(tab)
        go_to_the_middle(tab)
        click_a_component(tab, server, board, load_recipe("smt-aqueous"))
        draw_a_line(tab, server, board)
        tab.wait_for_another_time(slower)
        tab.tab("YAML")
        tab.press("Undo")
        tab.wait_for_time(slower)

        save_as(tab, "mine")
        saved = load_recipe(tmp_path / "mine.yaml")
        assert saved.templates["around"].speed_mm_s == 30
        tab.edit("around", "Speed (mm/s)", "29")
        slowest = tab.wait_for_another_time(slower)
        tab.reload()
        tab.wait_for_time(slowest)
        tab.tab("YAML")
        tab.see("unsaved changes")
        tab.press("Undo")
        tab.wait_for_time(slower)

        tab.tab("Compare")
        tab.choose("With", "smt-aqueous")
        assert unedited in tab.page.locator("table").filter(has_text="Total time").inner_text()
        name, content = download(tab, "Program (.wash)")
        assert name == f"{board.name}-mine.wash"
        assert content == program_bytes(run(saved, board))
        name, content = download(tab, "Picture (PNG)")
        assert (name, content[:4]) == (f"{board.name}-mine.png", b"\x89PNG")
        name, content = download(tab, "Playback (HTML)")
        assert (name, content[:9].lower()) == (f"{board.name}-mine.html", b"<!doctype")
        assert tab.errors == []
        assert tab.strangers == []
