import time
from contextlib import contextmanager
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hostile_cells import hostile_text
from made_findings import made_finding
from small_page import find, press, small_page
from small_scene import SmallScene
from tiny_session import tiny_session
from waiting import wait_for

from programs.program import MoveTo
from reports.cards.robot import check_facts
from robotcell.cell.load import read_cell
from robotcell.collision.body_pairs import Touch
from robotcell.collision.clearance import Clearance
from robotcell.errors import CellError
from robotcell.robot.robot import Body, Box, flange_poses, inverse, pose
from robotcell.track import Nearness
from specs.errors import JobError
from webui.downloads.recording import record
from webui.layers.robot.robot import Near, near_at, near_glb, nearest_of
from webui.page.evaluations import check_program
from webui.page.project import open_project
from webui.panels.robot import check
from webui.panels.robot.check import state_html, when
from webui.panels.robot.robot import RobotPanel
from webui.panels.widgets.job import APPLY, remedy_html
from webui.scene.reach_colours import METRICS, paint_reach


def quiet(_what, _done):
    pass


@cache
def tried(cell="ur5e-bench"):
    return check_program(tiny_session().run, read_cell(cell), quiet)


def finding_only(*findings):
    done = tried()
    return replace(done, report=replace(done.report, findings=findings))


def walled():
    """The cell with a wall through the board."""
    cell = read_cell("ur5e-bench")
    wall = Body("wall", Box((0.4, 0.01, 0.4)), cell.cell.T_cell_board @ pose((0.015, 0.01, 0.2), (0, 0, 0)))
    return replace(cell, cell=replace(cell.cell, fixtures=(*cell.cell.fixtures, wall)))


def checked_session():
    done = tried()
    return replace(replace(tiny_session(), run=done.run, cell=done.cell, cell_name="ur5e-bench"), checked=done)


@pytest.mark.slow
def test_a_robot_that_can_do_it_goes_where_the_nozzle_goes():
    done = tried()
    cell = done.cell.cell
    moves = [item for item in done.program.instructions if isinstance(item, MoveTo)]
    picked = range(0, len(moves), 97)
    for index in picked:
        q = done.motion.joints[index : index + 1]
        tips = [flange_poses(cell.robot, q)[0] @ tool.T_flange_tcp for tool in cell.tools]
        onto = inverse(cell.T_cell_board) @ cell.T_cell_base
        away = [np.linalg.norm(1000 * (onto @ tip)[:3, 3] - moves[index].position) for tip in tips]
        assert min(away) < 0.01
    facts = dict(check_facts(done.report))
    assert "w at least" in facts["singular"]
    assert "programmed" in facts["time"]


@pytest.mark.slow
def test_a_check_counts_for_its_program_and_its_cell_alone():
    session = checked_session()
    assert session.check is session.checked
    assert session.played.program is session.checked.program
    assert "(ur5e): can be done<" in state_html(session)
    newer = replace(session, run=replace(session.run))
    assert newer.check is None
    assert newer.played is newer.run
    assert "changed since" in state_html(newer)
    assert replace(session, cell=read_cell("gantry")).check is None
    assert replace(session, cell_name="", cell=None).check is None
    assert session.with_workpiece("other", session.board).checked is None
    assert "Not checked" in state_html(replace(session, checked=None))


@pytest.mark.slow
def test_an_error_is_said_at_one_glance():
    wrong = finding_only(made_finding("collision", "error", "wall"))
    session = replace(replace(tiny_session(), cell=wrong.cell), checked=wrong)
    assert "cannot be done as it is" in state_html(session)
    stuck = replace(wrong, report=replace(wrong.report, joints=wrong.report.joints[:0]))
    assert "cannot be done<" in state_html(replace(session, checked=stuck))


@pytest.mark.slow
def test_bodies_that_touch_are_named_with_their_nearest_points():
    done = tried()
    free = near_at(done.cell.cell, done.run.board, done.motion, 20.0)
    assert free is None or free.distance_mm > 0
    wall = near_at(walled().cell, done.run.board, done.motion, 20.0)
    assert wall is not None
    assert "wall" in (wall.body, wall.other)
    assert wall.distance_mm == pytest.approx(0.0, abs=0.1)
    assert np.isfinite(wall.points).all()
    assert len(near_glb(wall)) > 1000
    touches = (None, Touch("lance", "table", 0.007, np.zeros((2, 3))), Touch("lance", "J1", 0.004, np.zeros((2, 3))))
    measured = Clearance(np.array([0.02, 0.007, 0.004]), touches)
    report = replace(done.report, nearness=Nearness(lambda: measured), clearance_at=np.array([0, 5, 9]))
    nearest = nearest_of(report, done.motion)
    assert (nearest.other, nearest.time_s) == ("J1", done.motion.times[9])
    np.testing.assert_allclose(nearest.points, 1000 * np.tile(inverse(done.cell.cell.T_cell_board)[:3, 3], (2, 1)))


@pytest.mark.slow
def test_a_place_is_found_at_the_moment_of_its_own_stroke():
    done = tried()
    moves = [item for item in done.program.instructions if isinstance(item, MoveTo)]
    picked = moves[len(moves) // 2]
    found = when(made_finding("r", "info", "m", picked.made_by, picked.position), done)
    there = [move.time_s for move in moves if move.position == picked.position and move.made_by == picked.made_by]
    assert found in there
    assert when(made_finding("r", "info", "m"), done) == 0.0


@pytest.mark.slow
def test_every_metric_colours_the_paths_and_names_a_worst_place():
    done = tried()
    for metric in METRICS.values():
        painted = paint_reach(metric, done, 0.5)
        assert len(painted.glb) > 1000
        if metric == "clearance":
            assert list(painted.legend)[-1].endswith(" or more")
        assert 0 <= painted.worst[1] <= done.program.totals.duration_s
    assert paint_reach("limits", replace(done, motion=None), 0.5).glb == b""


@pytest.mark.slow
def test_a_recording_shows_the_robot_and_stays_small():
    done = tried()
    run = replace(done.run, program=done.program)
    alone, along = (len(record(run, 50.0, checked=each)) for each in (None, done))
    assert alone + 50_000 < along < alone + 3_000_000


@contextmanager
def opened(session, folder):
    with small_page(session, open_project(folder)) as page:
        scene = SmallScene(page)
        panel = RobotPanel(page, scene)
        page.open()
        yield page, scene, panel.check
        page.close()


@pytest.mark.slow
def test_check_tells_how_far_it_is_and_what_came_of_it(tmp_path, monkeypatch):
    done = tried()
    monkeypatch.setattr(check, "check_program", lambda run, cell, *_: replace(done, run=run, cell=cell))
    with opened(tiny_session(), tmp_path) as (page, scene, _):
        press(page, "Cell", "ur5e-bench")
        assert not find(page, "Go to").visible
        press(page, "Check")
        wait_for(lambda: page.session.check is not None)
        wait_for(lambda: find(page, "Go to").visible)
        names = find(page, "Go to").options
        assert len(names) == 1 + len(done.findings)
        press(page, "Go to", names[1])
        assert scene.sought == [when(done.findings[0], done)]
        assert str(page.session.selection.made_by) == str(done.findings[0].made_by)
        press(page, "Metric", "Joint limits")
        wait_for(lambda: len(scene.layers.get("/reach", b"")) > 0)
        press(page, "Cell", "gantry")
        assert scene.layers["/reach"] == b""
        assert page.session.check is None


@pytest.mark.slow
def test_a_collision_shows_the_pair_in_red(tmp_path, monkeypatch):
    done = tried()
    place = next(item.position for item in done.program.instructions if isinstance(item, MoveTo))
    finding = made_finding("collision", "error", "lance collides with J1", "sequence[0]/edge", place)
    near = Near(1.0, "lance", "J1", 0.0, np.array([[1.0, 2.0, 3.0], [1.0, 2.0, 4.0]]))
    wrong = finding_only(finding)
    monkeypatch.setattr(check, "check_program", lambda run, cell, *_: replace(wrong, run=run, cell=cell))
    monkeypatch.setattr(check, "near_at", lambda *_: near)
    with opened(tiny_session(), tmp_path) as (page, scene, _):
        press(page, "Cell", "ur5e-bench")
        press(page, "Check")
        wait_for(lambda: find(page, "Go to").visible)
        press(page, "Go to", find(page, "Go to").options[1])
        assert page.session.selection.component == "J1"
        assert len(scene.layers["/near"]) > 0
        assert scene.looked[-1][0] == (1.0, 2.0, 3.5)
        press(page, "Go to", "\N{EN DASH}")
        assert scene.layers["/near"] == b""


def test_what_is_out_of_reach_is_looked_at_with_the_robot(tmp_path, monkeypatch):
    far = replace(
        finding_only(made_finding("out-of-reach", "error", "too far", "sequence[0]/edge", (1.0, 2.0, 3.0))), motion=None
    )
    monkeypatch.setattr(check, "check_program", lambda run, cell, *_: replace(far, run=run, cell=cell))
    with opened(tiny_session(), tmp_path) as (page, scene, _):
        press(page, "Cell", "ur5e-bench")
        press(page, "Check")
        wait_for(lambda: find(page, "Go to").visible)
        press(page, "Step", "Next")
        assert scene.looked == ["cell", "cell"]
        assert scene.sought == []
        assert str(page.session.selection.made_by) == "sequence[0]/edge"


def test_what_is_missing_or_wrong_is_said_in_the_tab(tmp_path, monkeypatch):
    def fail(*_):
        raise CellError("checking for collisions needs `pip install washboard[robot]`")

    monkeypatch.setattr(check, "check_program", fail)
    with opened(tiny_session(), tmp_path) as (page, _, card):
        press(page, "Cell", "ur5e-bench")
        press(page, "Check")
        wait_for(lambda: "washboard[robot]" in card._run._line.content)
        assert find(page, "Check").label == "Check"
        assert page.client.said == []


def test_a_check_that_is_given_up_leaves_nothing(tmp_path, monkeypatch):
    begun = []

    def slow(_run, _cell, progress, _lean):
        begun.append(True)
        while True:
            time.sleep(0.01)
            progress("searching", 0.5)

    monkeypatch.setattr(check, "check_program", slow)
    with opened(tiny_session(), tmp_path) as (page, _, card):
        press(page, "Cell", "ur5e-bench")
        press(page, "Check")
        wait_for(lambda: "Searching" in card._run._line.content)
        press(page, "Cancel", at=0)
        assert find(page, "Check").label == "Check"
        assert page.session.checked is None
        assert begun == [True]


def test_a_tool_that_the_cell_lacks_is_refused():
    cell = read_cell("ur5e-bench")
    bare = replace(cell, cell=replace(cell.cell, tools=cell.cell.tools[:1]))
    with pytest.raises(JobError, match="tool 2"):
        check_program(tiny_session().run, bare, quiet)


@pytest.mark.slow
def test_the_remedy_is_applied_by_a_button_saved_checked_and_undone(tmp_path):
    file = tmp_path / "far.yaml"
    file.write_text(hostile_text("ur5e-bench", "far"))
    text = file.read_text()
    with opened(tiny_session(), tmp_path) as (page, _, _):
        press(page, "Cell", "far.yaml")
        assert not find(page, APPLY).visible
        press(page, "Check")
        wait_for(lambda: page.session.check is not None and find(page, APPLY).visible)
        assert "board.pose: " in remedy_html(page.session)
        refused = page.session.check
        press(page, APPLY)
        assert file.read_text() != text
        assert page.client.said[-1].startswith("Remedy applied: far.yaml is written")
        assert page.session.check is None
        wait_for(lambda: page.session.check is not None)
        assert page.session.check.motion is not None
        assert not any(finding.severity == "error" for finding in page.session.check.findings)
        assert not find(page, APPLY).visible
        page.attempt(lambda session: session.undone())
        assert file.read_text() == text
        assert page.session.cell.spec == refused.cell.spec
        assert page.session.check is None


def test_a_remedy_without_edits_has_no_button():
    assert remedy_html(tiny_session()) == ""
