"""The regions hold at the sizes of desktops: nothing covers the scene; all strokes are in the first picture."""

import numpy as np
import pytest
from driven_page import CHROMIUM, NO_CHROMIUM, DrivenPage, open_chromium

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM),
]
SIZES = ((1280, 720, 0.39), (1440, 900, 0.45), (1920, 1080, 0.50))
"""Width and height of a window, and the least share of it that the scene has."""
BOXES = """() => {
  const box = each => { const r = each.getBoundingClientRect(); return [r.left, r.top, r.right, r.bottom]; };
  const of = selector => [...document.querySelectorAll(selector)].map(box);
  return {scene: of('[data-dock-root] > div > canvas'), panels: of('[data-dock-region], [data-floating-window]'),
          status: of('[data-status]'), controls: of('[data-floating-window] input, [data-floating-window] button')};
}"""
PX = 1.0


@pytest.fixture(scope="module")
def chromium():
    with open_chromium() as chromium:
        yield chromium


def area(box):
    return max(box[2] - box[0], 0) * max(box[3] - box[1], 0)


def overlap(one, two):
    return area([max(one[0], two[0]), max(one[1], two[1]), min(one[2], two[2]), min(one[3], two[3])])


def inside(box, window, margin=PX):
    return box[0] >= -margin and box[1] >= -margin and box[2] <= window[0] + margin and box[3] <= window[1] + margin


def test_the_scene_has_its_share_nothing_covers_it_and_a_cell_of_the_strip_opens_its_tab(chromium, start_server):
    server = start_server("tiny", "rinse-only")
    tab = DrivenPage(chromium, server.address)
    tab.dismiss_notice()
    tab.page.wait_for_function("() => document.querySelectorAll('[data-status]').length === 4")
    for width, height, share in SIZES:
        tab.page.set_viewport_size({"width": width, "height": height})
        tab.page.wait_for_timeout(500)
        scene_has_its_share_and_nothing_covers_it(tab.page, width, height, share)
    for status, name in (("robot", "Robot"), ("findings", "Findings"), ("cleaning", "Cleaning")):
        tab.page.locator(f"[data-status={status}]").click()
        tab.page.get_by_role("tab", name=name, exact=True, selected=True).wait_for()
    tab.page.close()


def scene_has_its_share_and_nothing_covers_it(page, width, height, share):
    boxes = page.evaluate(BOXES)
    (scene,) = boxes["scene"]
    assert area(scene) >= share * width * height
    assert len(boxes["panels"]) == 4
    for panel in boxes["panels"]:
        assert overlap(scene, panel) < PX * max(width, height)
        assert inside(panel, (width, height))
    for one in range(4):
        for two in range(one):
            assert overlap(boxes["panels"][one], boxes["panels"][two]) < PX * max(width, height)
    assert all(inside(each, (width, height)) for each in boxes["status"] + boxes["controls"])


@pytest.mark.parametrize("board", ["tiny", "two-sided"])
def test_all_strokes_are_in_the_first_picture(chromium, start_server, board):
    server = start_server(board, "smt-aqueous")
    tab = DrivenPage(chromium, server.address)
    page = tab.page
    page.wait_for_timeout(1500)
    camera = next(iter(server.viser.get_clients().values())).camera
    (shown,) = server.sessions.pages()
    room = page.locator("canvas").first.bounding_box()
    points = np.concatenate(
        [item.tcp for item in shown.session.run.plan.items if hasattr(item, "jet") and hasattr(item, "tcp")]
    )
    low, high = points.min(axis=0), points.max(axis=0)
    for corner in np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T:
        x, y = tab.pixel_of(camera, corner)
        assert room["x"] <= x <= room["x"] + room["width"]
        assert room["y"] <= y <= room["y"] + room["height"]
    page.close()
