"""The card of the best place: what it starts, what it shows of what was found, and the cell with the work there."""

from dataclasses import replace

import numpy as np
from found_place import found_place
from small_page import find, press, small_page
from small_scene import SmallScene
from tiny_session import tiny_session
from waiting import wait_for

from robotcell.cell.load import hold_board, read_cell
from webui.cards.drawings import boxes_html, map_html
from webui.page.project import open_project
from webui.panels.robot import placement
from webui.panels.robot.placement import PlacementCard, found_html


def test_box_plots_have_a_row_for_each_configuration_with_its_quantiles():
    details = found_place().details
    html = boxes_html(details)
    assert html.count('role="img"') == sum(np.isfinite(each.box).all() for each in details.configurations)
    for each in details.configurations:
        assert each.name in html
        if np.isfinite(each.box).all():
            assert f"50 %: {each.box[2]:.4f}" in html
    assert "used" in html


def test_a_map_has_its_best_node_and_the_robots_base():
    found = found_place()
    html = map_html(found.details, found.mapped)
    assert "best node at x 400, y 300 mm" in html
    assert "4 by 3 nodes" in html
    assert "&#9632;" in html  # the base is within the map
    nowhere = replace(found.mapped, values=np.full((4, 3, 2), -1.0))
    assert "No node of the map is feasible" in map_html(found.details, nowhere)


def test_a_place_is_searched_shown_and_written(tmp_path, monkeypatch):
    asked = []

    def search(run, cell, goal, progress, *, mapped):
        asked.append((run, cell, goal, mapped))
        return found_place()

    monkeypatch.setattr(placement, "search_place", search)
    session = replace(
        tiny_session(), cell=hold_board(read_cell("ur5e-bench"), tiny_session().workpiece), cell_name="ur5e-bench"
    )
    with small_page(session, open_project(tmp_path)) as page:
        scene = SmallScene(page)
        card = PlacementCard(page, scene)
        page.open()
        checks = []
        page.check = lambda: checks.append(page.session.cell)
        assert not find(page, "Go to the worst point").visible
        press(page, "Maximise", "Joint limits")
        press(page, "Of the", "Mean")
        press(page, "Map", True)
        press(page, "Find the best place")
        wait_for(lambda: find(page, "Go to the worst point").visible)
        ((_, _, goal, mapped),) = asked
        assert (goal.metric, goal.criterion, mapped) == ("limits", "mean", True)
        assert "A better place was found" in card._facts.content
        assert "used" in card._boxes.content
        assert "best node" in card._mapped.content
        press(page, "Go to the worst point")
        details = found_place().details
        at = 1e3 * details.targets.T_board_tcp[details.worst, :3, 3]
        np.testing.assert_allclose(scene.looked[-1][0], at)
        press(page, "Hold it there")
        held = page.session.cell.cell
        np.testing.assert_allclose(held.T_cell_board, details.cell.T_cell_board, atol=2e-4)
        assert checks == [page.session.cell]
        assert find(page, "Go to the worst point").visible  # of the place where it is now
        page.attempt(lambda now: now.undone())
        assert find(page, "Go to the worst point").visible
        page.show(replace(page.session, cell=read_cell("kr6-bench")))
        assert not find(page, "Go to the worst point").visible


def test_what_was_found_is_stated():
    found = found_place()
    assert "A better place was found" in found_html(found)
    assert "296 places" in found_html(found)
    assert "stays where it is" in found_html(replace(found, tried=()))
