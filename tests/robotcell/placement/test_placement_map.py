import dataclasses

import numpy as np
import pytest
from placed_parts import chamfered_box, flat_top, lance_cell

from robotcell.cell.cell import TableBounds, room_on_table
from robotcell.collision.collision import build_collider
from robotcell.placement.evaluate import NO_ROOM, PlacementGoal, PlacementTask, evaluate, evaluate_many
from robotcell.placement.optimise import find_placements, judge_placement
from robotcell.placement.placement_map import MapGrid, map_placements, refine_map
from robotcell.robot.robot import Body, Box, pose, roll_pitch_yaw

GOAL = PlacementGoal(criterion="mean", distance=(0.15, 0.9))
BOUNDS = TableBounds((-0.35, 0.35), (-0.85, 0.0))


@pytest.mark.slow
def test_the_best_node_of_the_map_is_within_two_percent_of_the_search() -> None:
    cell, targets = lance_cell(0.15), flat_top(3, 2)
    found = map_placements(PlacementTask(cell, targets, GOAL, None), MapGrid(BOUNDS, (15, 15, 12)))
    assert found.values.shape == (15, 15, 12)
    assert found.score.value == pytest.approx(find_placements(cell, targets, GOAL)[0].value, rel=0.02)
    there = dataclasses.replace(cell, T_cell_board=found.T_cell_board)
    assert judge_placement(there, targets, GOAL).value == pytest.approx(found.score.value)
    middle = found.T_cell_board @ np.append(targets.T_board_tcp[:, :3, 3].mean(axis=0), 1.0)
    np.testing.assert_allclose(middle[:2], (found.x[found.best[0]], found.y[found.best[1]]), atol=1e-12)
    assert (found.nodes <= found.highest + 1e-12)[np.isfinite(found.nodes)].all()


def test_a_node_without_room_has_no_value() -> None:
    cell, targets = lance_cell(0.15), flat_top(2, 2)
    corners = np.array([[x, y, 0.0] for x in (0, 0.245) for y in (0, 0.11)])
    room = room_on_table(BOUNDS, corners)
    found = map_placements(PlacementTask(cell, targets, GOAL, None), MapGrid(BOUNDS, (5, 5, 2)), room)
    assert (found.values[[0, -1]] == NO_ROOM).all()  # the middle of the part is on the edge of the table there
    assert np.isnan(found.nodes[[0, -1]]).all()
    assert (found.values > NO_ROOM).any()


def test_nodes_evaluated_together_have_the_values_of_each_by_itself() -> None:
    cell, targets = lance_cell(0.15), chamfered_box(step=0.06)
    places = [pose((x, y, 0.1), (0, 0, yaw)) for x in (0.3, 0.5, 0.9) for y in (-0.2, 0.1) for yaw in (0.0, 1.0, 2.5)]
    for goal in (
        PlacementGoal(criterion="mean", floor=0.02),
        PlacementGoal("condition", "p5"),
        PlacementGoal("limits", configurations=2),
    ):
        task = PlacementTask(cell, targets, goal, None)
        expected = [evaluate(task, each).bounds[0].value for each in places]
        assert min(expected) < -1.0 < 0.0 < max(expected)
        np.testing.assert_allclose(evaluate_many(task, np.stack(places)), expected, rtol=1e-12)


def test_clearance_is_mapped_with_the_bodies() -> None:
    cell = lance_cell(0.15)
    cell = dataclasses.replace(cell, fixtures=(Body("block", Box((0.1, 0.1, 0.3)), pose((0.3, -0.5, 0.1), (0, 0, 0))),))
    task = PlacementTask(cell, flat_top(2, 1), PlacementGoal("clearance"), build_collider(cell, None))
    found = map_placements(task, MapGrid(BOUNDS, (3, 3, 1)))
    assert found.score.value == pytest.approx(found.values.max())
    assert found.score.value > 0.0


@pytest.mark.slow
def test_the_best_node_is_clear_of_bodies() -> None:
    cell, targets = lance_cell(0.15), flat_top(2, 2)
    free = map_placements(PlacementTask(cell, targets, GOAL, None), MapGrid(BOUNDS, (7, 7, 4)))
    place = (free.T_cell_board @ np.array([0.12, 0.055, 0.2, 1.0]))[:3]
    blocked = dataclasses.replace(cell, fixtures=(Body("block", Box((0.2, 0.2, 0.3)), pose(place, (0, 0, 0))),))
    found = map_placements(
        PlacementTask(blocked, targets, GOAL, build_collider(blocked, None)), MapGrid(BOUNDS, (7, 7, 4))
    )
    np.testing.assert_array_equal(found.values, free.values)  # a bound: without the bodies
    assert 0.0 < found.score.value < free.score.value


@pytest.mark.slow
def test_beside_the_best_node_is_the_best_of_the_search_among_bodies() -> None:
    """The least value has peaks narrower than a map of few nodes; a body stands where it would be best without."""
    cell, targets = lance_cell(0.15), flat_top(2, 1)
    goal = PlacementGoal(distance=(0.15, 0.9), direction=(-np.pi, np.pi))
    block = Body("block", Box((0.2, 0.2, 0.3)), pose((0.5, 0.0, 0.32), (0, 0, 0)))
    cell = dataclasses.replace(cell, fixtures=(block,))
    bounds = TableBounds((0.2, 0.9), (-0.35, 0.35))
    task = PlacementTask(cell, targets, goal, build_collider(cell, None))
    found = refine_map(task, map_placements(task, MapGrid(bounds, (9, 9, 6))))
    assert found.refined is not None
    assert 0.0 < found.score.value < 0.995 * found.refined.value
    there = dataclasses.replace(cell, T_cell_board=found.refined.T_cell_board)
    assert judge_placement(there, targets, goal, task.collider).value == found.refined.value
    assert found.refined_at is not None
    middle = found.refined.T_cell_board @ np.append(targets.T_board_tcp[:, :3, 3].mean(axis=0), 1.0)
    turn = roll_pitch_yaw(found.refined.T_cell_board)[2] - roll_pitch_yaw(cell.T_cell_board)[2]
    np.testing.assert_allclose(found.refined_at[:2], middle[:2], atol=1e-9)
    assert np.cos(found.refined_at[2] - turn) == pytest.approx(1.0)
    assert found.refined.value >= 0.995 * find_placements(cell, targets, goal, task.collider)[0].value


@pytest.mark.slow
def test_a_grid_through_a_place_has_a_node_there() -> None:
    cell, targets = lance_cell(0.15), flat_top(3, 2)
    task = PlacementTask(cell, targets, GOAL, None)
    place, wide = find_placements(cell, targets, GOAL)[0], TableBounds((-0.9, 0.9), (-0.9, 0.9))
    plain, shifted = (map_placements(task, MapGrid(wide, (6, 6, 3), each)) for each in (None, place.T_cell_board))
    assert plain.score.value < 0.999 * place.value
    assert shifted.score.value == pytest.approx(place.value, rel=1e-9)
    np.testing.assert_allclose(shifted.T_cell_board, place.T_cell_board, atol=1e-9)
    for name, spacing in (("x", 0.36), ("y", 0.36), ("yaw", 2 * np.pi / 3)):
        moved = getattr(shifted, name) - getattr(plain, name)
        np.testing.assert_allclose(moved, moved[0], atol=1e-12)
        assert abs(moved[0]) <= spacing / 2 + 1e-9
    beyond = map_placements(task, MapGrid(BOUNDS, (6, 6, 3), place.T_cell_board))
    np.testing.assert_array_equal(beyond.x, np.linspace(*BOUNDS.x, 6))
