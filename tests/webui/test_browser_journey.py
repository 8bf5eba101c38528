"""The way of an engineer through the page, in a real browser."""

from pathlib import Path

import numpy as np
import pytest
from driven_page import CHROMIUM, NO_CHROMIUM, DrivenPage, open_chromium

from boards.load import load_board
from recipes.load import load_recipe
from rulesengine.commands.writing import program_bytes
from rulesengine.pipeline import run
from webui.layers.strokes import stroke_lines
from webui.picking import first_hit, strokes_at, target_of

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM),
]


def camera_of(server):
    return next(iter(server.viser.get_clients().values())).camera


def ray_to(camera, place):
    origin = np.array(camera.position) * 1000
    return origin, (place - origin) / np.linalg.norm(place - origin)


def visible_component(board, lines, camera):
    """A component whose top can be clicked: nothing stands or is drawn in front of it."""
    target = target_of(board)
    for component in sorted(board.components, key=lambda each: -each.area_mm2):
        middle = component.outline.centroid
        place = np.array([middle.x, middle.y, board.top_z_mm + component.height_mm])
        origin, direction = ray_to(camera, place)
        hit = first_hit(target, origin, direction)
        if hit is not None and hit.body == component.name and not strokes_at(lines, origin, direction, np.inf):
            return component.name, place
    raise AssertionError


def play_for_a_moment(tab):
    tab.press("Play")
    tab.wait_for_input("Time (s)", "value => Number(value) > 1")
    tab.press("Pause")


def click_a_component(tab, server, board):
    lines = stroke_lines(run(load_recipe("smt-aqueous"), board).plan)
    name, place = visible_component(board, lines, camera_of(server))
    tab.tab("Components")
    tab.click_scene(camera_of(server), place)
    tab.wait_for_input("Go to", "(value, name) => value === name", name)


def draw_a_line(tab, server, board):
    tab.tab("Paths")
    tab.press("Draw a line")
    tab.click_scene(camera_of(server), (20.0, 60.0, board.top_z_mm))
    tab.see("Click where it ends.")
    tab.click_scene(camera_of(server), (60.0, 60.0, board.top_z_mm))
    tab.press("Add to the recipe")


def save_as(tab, name):
    tab.tab("YAML")
    tab.press("Save as…")
    tab.type("File", name)
    tab.page.get_by_text("saved", exact=True).wait_for()


def download(tab):
    tab.tab("Out")
    with tab.page.expect_download() as download:
        tab.press("Download")
    return download.value.suggested_filename, Path(download.value.path()).read_bytes()


def test_from_a_board_to_a_program(start_server, tmp_path):
    server = start_server("smt-demo", "smt-aqueous")
    board = load_board(Path("smt-demo"))
    with open_chromium() as browser:
        tab = DrivenPage(browser, server.address)
        tab.dismiss_notice()
        at_first = tab.time_text
        tab.edit("around", "Speed (mm/s)", "30")
        slower = tab.wait_for_another_time(at_first)
        play_for_a_moment(tab)
        click_a_component(tab, server, board)
        draw_a_line(tab, server, board)
        tab.wait_for_another_time(slower)
        tab.tab("YAML")
        tab.press("Undo")
        tab.wait_for_time(slower)

        save_as(tab, "mine")
        saved = load_recipe(tmp_path / "mine.yaml")
        assert saved.templates["around"].speed_mm_s == 30
        tab.reload()
        assert tab.time_text == slower

        tab.tab("Compare")
        tab.choose("With", "smt-aqueous")
        assert at_first in tab.page.locator("table").filter(has_text="Total time").inner_text()
        name, content = download(tab)
        assert name == "smt-demo-mine.wash"
        assert content == program_bytes(run(saved, board))
        assert tab.errors == []
        assert tab.strangers == []
