from dataclasses import replace

from small_page import find, press, small_page
from small_scene import SmallScene
from tiny_session import tiny_session
from waiting import wait_for

from robotcell.cell.load import cell_sha256, read_cell
from rulesengine.timing.robot_pace import RobotTiming
from webui.page.project import open_project
from webui.panels.robot import robot
from webui.panels.robot.robot import RobotPanel, price_html

TIMING = RobotTiming("ur5e-bench", "ur5e", 82.7, 110.1, 113.1, 10.7, (("turning on the spot", 22.6),))


def timed(run, cell):
    origin = replace(run.program.origin, cell=cell.cell.name, cell_sha256=cell_sha256(cell))
    return replace(run, robot=TIMING, program=replace(run.program, origin=origin))


def test_the_page_plans_for_the_chosen_robot_and_shows_the_price(tmp_path, monkeypatch):
    monkeypatch.setattr(robot, "plan_at_pace", lambda run, cell, _: timed(run, cell))
    with small_page(tiny_session(), open_project(tmp_path)) as page:
        scene = SmallScene(page)
        RobotPanel(page, scene)
        page.open()
        press(page, "Cell", "ur5e-bench")
        assert find(page, "Plan for this robot").visible
        before = page.session.run
        press(page, "Plan for this robot")
        wait_for(lambda: page.session.run.robot is not None)
        assert page.session.planned
        assert page.session.run.plan is before.plan
        text = price_html(page.session)
        assert "27.4 s longer than the recipe" in text
        assert "1.027 times the planned time" in text
        assert "Another cell" not in text
        press(page, "Cell", "gantry")
        assert "Another cell than this, ur5e-bench" in price_html(page.session)
        page.close()


def test_a_program_that_was_planned_meanwhile_stays(tmp_path):
    with small_page(tiny_session(), open_project(tmp_path)) as page:
        card = robot.PaceCard(page)
        page.open()
        older = replace(page.session.run)
        card.take(older, timed(older, read_cell("ur5e-bench")))
        assert page.session.run.robot is None
        page.close()
