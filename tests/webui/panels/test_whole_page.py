"""All panels of a page side by side: what is shown for a board and for a part, with and without a plan and a cell."""

from contextlib import contextmanager
from dataclasses import replace
from types import SimpleNamespace

import pytest
from cleaning_report import small_report
from made_findings import made_finding
from part_session import part_session
from small_page import find, folder_of, html_in, inputs, press, small_page
from small_scene import SmallScene
from tiny_session import tiny_session

from robotcell.cell.load import hold_board, read_cell
from webui.page.evaluations import Analysed
from webui.page.project import open_project
from webui.panels.results.overview import OutputPanel, StatusPanel, forbidden_html
from webui.server.server import TABS

BOARD_ONLY = {"Join parts table", "Draw a line", "Parameters", "Effort", "How sure", "Tune\N{HORIZONTAL ELLIPSIS}"}
PART_ONLY = {"Stripes", "Lance"}
OF_CELL = {"Check", "Tilt band (\N{DEGREE SIGN})", "Maximise", "Show the robot", "Plan for this robot"}
OF_ANALYSIS = {"Part", "Colours", "Paths too"}
ERROR = made_finding("not-served", "error", "U1 must be cleaned.", "masks")


@contextmanager
def opened(session, folder):
    with small_page(session, open_project(folder)) as page:
        scene = SmallScene(page)
        scene.legends = {}
        for _, kind in (*TABS[0], *TABS[1]):
            kind(page, scene)
        page.open()
        yield page, scene
        page.close()


def visible(page):
    """Labels of the inputs that can be seen: they, and all folders that they are in."""
    folders = page.client.gui._container_handle_from_uuid
    seen = set()
    for handle in inputs(page):
        shown, at = handle.visible, handle._impl.parent_container_id
        while at in folders and hasattr(folders[at], "_impl"):
            shown, at = shown and getattr(folders[at], "visible", True), folders[at]._impl.parent_container_id
        if shown:
            seen.add(handle.label)
    return seen


def with_cell(session):
    return replace(session, cell_name="ur5e-bench", cell=hold_board(read_cell("ur5e-bench"), session.workpiece))


@pytest.mark.slow
def test_a_board_and_a_part_are_shown_with_what_is_for_them(tmp_path):
    with opened(tiny_session(), tmp_path) as (page, _):
        assert visible(page) >= BOARD_ONLY
        assert not visible(page) & (PART_ONLY | OF_CELL | OF_ANALYSIS)
        page.show(part_session())
        assert visible(page) >= PART_ONLY
        assert not visible(page) & (BOARD_ONLY | OF_CELL | OF_ANALYSIS)
        page.show(tiny_session())
        assert visible(page) >= BOARD_ONLY
        assert not visible(page) & PART_ONLY


@pytest.mark.slow
@pytest.mark.parametrize("session", [tiny_session, part_session])
def test_a_cell_brings_its_controls_and_takes_them_away(tmp_path, session):
    with opened(with_cell(session()), tmp_path) as (page, _):
        assert visible(page) >= OF_CELL
        assert "ur5e" in html_in(page, "Frames") or "base" in html_in(page, "Frames").lower()
        page.show(page.session.with_cell("", None))
        assert not visible(page) & OF_CELL
        assert html_in(page, "Frames") == ""


@pytest.mark.slow
def test_nothing_is_lost_where_nothing_is_planned(tmp_path):
    with opened(replace(tiny_session(), run=None), tmp_path) as (page, _):
        assert visible(page) >= BOARD_ONLY
        for act in ("Analyse", "Download"):
            press(page, act)
            assert act == "Download" or "not planned yet" in page.client.said[-1]


@pytest.mark.slow
def test_an_analysis_brings_its_cards_and_an_edit_of_its_parameters_takes_them_away(tmp_path):
    session = tiny_session()
    analysed = replace(session, analysed=Analysed(session.run.program, "default", small_report()))
    with opened(analysed, tmp_path) as (page, _):
        assert visible(page) >= {"Part"}
        assert "bare board" in html_in(page, "Why")
        page.select(component="U1")
        assert "bare board" not in html_in(page, "Why")
        page.remember(lambda now: replace(now, parameters_name="other"))
        assert "Part" not in visible(page)
        assert not folder_of(page, "Why").visible


def test_errors_of_plan_and_robot_forbid_what_they_belong_to(tmp_path):
    session = tiny_session()
    wrong = replace(session, run=replace(session.run, findings=(ERROR,)))
    with small_page(wrong, open_project(tmp_path)) as page:
        OutputPanel(page, None)
        page.open()
        assert "forbid the program: not-served (1)" in forbidden_html(page.session)
        assert find(page, "not-served").visible
        assert not find(page, "Speed (x)").visible
        press(page, "File", "Playback (HTML)")
        assert find(page, "Speed (x)").visible
        press(page, "File", "Recipe (YAML)")
        assert not find(page, "Speed (x)").visible
        page.show(session)
        assert forbidden_html(page.session) == ""
        assert not folder_of(page, "In spite of errors").visible
        page.close()
    checked = SimpleNamespace(findings=(ERROR, ERROR))
    robot = SimpleNamespace(run=SimpleNamespace(findings=()), check=checked)
    assert "forbid the robot&#x27;s program: not-served (2)" in forbidden_html(robot).replace("'", "&#x27;")


def test_buttons_of_the_view_look_and_planning_is_given_up_and_begun_again():
    looked = []
    scene = SimpleNamespace(look_at_job=looked.append, look_back=lambda: looked.append("back"))
    with small_page(tiny_session()) as page:
        asked = []
        page.cancel, page.plan = lambda: asked.append("cancel"), lambda: asked.append("plan")
        StatusPanel(page, scene)
        page.open()
        for name in ("Plan", "Iso"):
            press(page, "View", name)
        assert looked == ["plan", "iso"]
        press(page, "Cancel")
        page._report_progress("cancelled", 1.0)
        press(page, "Plan again")
        assert asked == ["cancel", "plan"]
        page.close()


@pytest.mark.slow
def test_two_sessions_do_not_share_what_they_show(tmp_path):
    with opened(tiny_session(), tmp_path) as (one, _), opened(part_session(), tmp_path) as (other, _):
        name = part_session().workpiece.faces[0].name
        other.select(component=name)
        assert (one.session.selection.component, other.session.selection.component) == ("", name)
        assert visible(one) >= BOARD_ONLY
        assert not visible(other) & BOARD_ONLY
