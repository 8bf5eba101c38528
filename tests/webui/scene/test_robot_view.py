from dataclasses import replace

import numpy as np
from shown_cell import shown_cell
from small_page import small_page
from tiny_session import tiny_session

from robotcell.robot.robot import flange_poses, inverse
from webui.scene.moving import RobotView, robot_bounds_mm


def nodes(page):
    return page.client.scene._handle_from_node_name


def test_the_robot_stands_where_it_is_seen_from_the_board_and_carries_one_tool():
    cell = shown_cell()
    joints = cell.home + 0.3
    with small_page(tiny_session()) as page:
        view = RobotView(page.client.scene)
        view.show_cell(cell)
        view.stand(joints, 2)
        flange = chain(nodes(page), "/cell", "/cell/robot", f"/cell/robot/link_{cell.robot.dof}")
        wanted = inverse(cell.T_cell_board) @ cell.T_cell_base @ flange_poses(cell.robot, joints[None])[0]
        np.testing.assert_allclose(flange @ cell.robot.T_link_flange, wanted, atol=1e-9)
        tools = f"/cell/robot/link_{cell.robot.dof}/tool"
        assert [nodes(page)[f"{tools}_{number}"].visible for number in (1, 2)] == [False, True]


def test_another_cell_takes_the_place_of_the_first_and_none_leaves_nothing():
    with small_page(tiny_session()) as page:
        view = RobotView(page.client.scene)
        before = set(nodes(page))
        view.show_cell(shown_cell())
        view.show_cell(replace(shown_cell(), fixtures=()))
        assert "/cell/fixtures" not in nodes(page)
        view.show_cell(None)
        view.stand(np.zeros(6), 1)
        assert set(nodes(page)) == before
        assert view.bounds_mm() is None


def test_only_groups_with_a_body_that_is_marked_are_drawn_again():
    with small_page(tiny_session()) as page:
        view = RobotView(page.client.scene)
        view.show_cell(shown_cell())
        before = dict(nodes(page))
        view.mark({"table"})
        changed = {name for name, handle in nodes(page).items() if handle is not before.get(name)}
        assert changed == {"/cell/fixtures"}
        view.mark(())
        assert nodes(page)["/cell/fixtures"] is not before["/cell/fixtures"]


def test_what_is_looked_at_holds_the_tool_and_moves_with_the_board():
    cell = shown_cell()
    low, high = robot_bounds_mm(cell, cell.home, 1)
    tip = inverse(cell.T_cell_board) @ flange_poses(cell.robot, cell.home[None])[0] @ cell.tools[0].T_flange_tcp
    assert (low <= 1000 * tip[:3, 3] + 1e-6).all()
    assert (1000 * tip[:3, 3] <= high + 1e-6).all()
    shifted = cell.T_cell_board.copy()
    shifted[:3, 3] += (0.1, 0.0, -0.2)
    moved = robot_bounds_mm(replace(cell, T_cell_board=shifted), cell.home, 1)
    np.testing.assert_allclose(moved[0], low - (100.0, 0.0, -200.0), atol=1e-6)


def chain(found, *names):
    from scipy.spatial.transform import Rotation

    result = np.eye(4)
    for name in names:
        step = np.eye(4)
        step[:3, :3] = Rotation.from_quat(found[name].wxyz, scalar_first=True).as_matrix()
        step[:3, 3] = found[name].position
        result = result @ step
    return result
