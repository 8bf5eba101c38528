import dataclasses

import numpy as np
import pytest
from placed_parts import HEIGHT, chamfered_box, flat_top, lance_cell, ur5_manipulability

from robotcell.cell.load import CELL, read_cell
from robotcell.collision.collision import build_collider
from robotcell.kinematics.inverse import solve
from robotcell.placement.configurations import PlacementDetails, describe_placement, name_configuration
from robotcell.placement.evaluate import PlacementGoal
from robotcell.placement.reachability import Targets
from robotcell.robot.robot import Body, Box, flange_poses, inverse, pose


def test_the_values_are_those_of_the_closed_form_of_the_paper() -> None:
    details = describe_placement(lance_cell(0.15), flat_top(4, 3), PlacementGoal())
    assert len(details.configurations) == 8
    for each in details.configurations:
        there = np.isfinite(each.values)
        np.testing.assert_allclose(each.values[there], ur5_manipulability(each.joints[there]), atol=1e-12)


def test_the_configurations_have_eight_names_and_four_distinct_values() -> None:
    """Elbow and wrist mirror each other: of eight branches two each have the same manipulability."""
    details = describe_placement(lance_cell(0.15), flat_top(4, 3), PlacementGoal())
    assert len({each.name for each in details.configurations}) == 8
    assert {word for each in details.configurations for word in each.name.split(", ")} == {
        "front", "rear", "up", "down", "J5+", "J5-",
    }  # fmt: skip
    means = {round(each.score.mean, 9) for each in details.configurations if each.reached == 1.0}
    assert len(means) <= 4


HOMES = {
    "c8l-bench": "/R /A /NF",
    "cairo-bench": "front, up, J5-",
    "gp8-bench": "front, upper, J5-",
    "irb1200-bench": "cfx 0",
    "kr6-bench": "S 010",
    "lrmate-bench": "N U T",
    "rv-4frl-bench": "R, A, N",
    "tx2-60-bench": "righty, epositive, wpositive",
    "ur5-bench": "front, up, J5-",
    "ur5e-bench": "front, up, J5-",
    "vs060-bench": "righty, above, J5+",
    "gantry": "configuration 1",
}


@pytest.mark.parametrize("name", CELL.library())
def test_each_arm_of_the_library_stands_at_home_as_its_maker_names_it(name: str) -> None:
    """They all reach forth with the elbow above and the tool down."""
    cell = read_cell(name).cell
    assert name_configuration(cell, cell.home[None], 0) == HOMES[name]


@pytest.mark.parametrize("name", CELL.library())
def test_no_name_repeats_among_the_configurations_of_a_placement(name: str) -> None:
    cell = read_cell(name).cell
    home = flange_poses(cell.robot, cell.home[None])[0] @ cell.tools[0].T_flange_tcp
    shifts = [pose((x, y, 0), (0, 0, 0)) for x in (-0.05, 0.05) for y in (-0.05, 0.05)]
    poses = inverse(cell.T_cell_board) @ cell.T_cell_base @ home @ np.stack(shifts)
    targets = Targets(poses, np.zeros(4, dtype=np.int64), np.ones(4, dtype=np.bool_))
    names = [each.name for each in describe_placement(cell, targets, PlacementGoal()).configurations]
    assert len(set(names)) == len(names) >= (1 if name == "gantry" else 2)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("irb1200-bench", {"cfx 4", "cfx 5", "cfx 6", "cfx 7"}),
        ("kr6-bench", {"S 001", "S 011", "S 101", "S 111"}),
        ("lrmate-bench", {"N U B", "N D B", "F U B", "F D B"}),
    ],
)
def test_an_arm_that_reaches_behind_itself_is_named_so(name: str, words: set[str]) -> None:
    """Joint 1 half around, the arm thrown over: the wrist stays where it was."""
    cell = read_cell(name).cell
    home = flange_poses(cell.robot, cell.home[None])
    free = dataclasses.replace(cell.robot, joints=tuple(
        dataclasses.replace(each, lowest=-2 * np.pi, highest=2 * np.pi) for each in cell.robot.joints
    ))  # fmt: skip
    solved = solve(free, home).q[0]
    behind = [q for q in solved if np.isfinite(q[0]) and abs(np.sin(q[0])) < 0.1 and np.cos(q[0]) < 0.0]
    named = {name_configuration(dataclasses.replace(cell, robot=free), q[None], 0) for q in behind}
    assert named
    assert named <= words


def test_a_wrist_that_is_a_whole_turn_away_has_the_name_of_the_same_pose() -> None:
    """Joints are given as near to home as whole turns allow: joint 5 at 250 degrees is at -110."""
    cell = lance_cell(0.15)
    home = cell.home.copy()
    home[4] = 3.0
    details, turned = (
        describe_placement(each, flat_top(2, 1), PlacementGoal())
        for each in (cell, dataclasses.replace(cell, home=home))
    )
    assert any(np.nanmax(each.joints[:, 4]) > np.pi for each in turned.configurations)
    assert [each.name for each in turned.configurations] == [each.name for each in details.configurations]


def test_a_configuration_that_collides_everywhere_is_named_as_without_obstacles() -> None:
    cell, targets = lance_cell(0.15), flat_top(2, 1)
    block = Body("block", Box((2.0, 2.0, 0.3)), cell.T_cell_board @ pose((0, 0, 0.4), (0, 0, 0)))
    blocked = dataclasses.replace(cell, fixtures=(block,))
    found = describe_placement(blocked, targets, PlacementGoal(), build_collider(blocked, None)).configurations
    assert any(each.reached == 0.0 for each in found)
    assert [each.name for each in found] == [
        each.name for each in describe_placement(cell, targets, PlacementGoal()).configurations
    ]


def test_a_box_plot_lies_within_what_it_describes() -> None:
    for each in describe_placement(lance_cell(0.15), chamfered_box(step=0.03), PlacementGoal()).configurations:
        there = each.values[np.isfinite(each.values)]
        assert (np.diff(each.box) >= 0.0).all()
        assert there.min() <= each.box[0] <= np.median(there) + 1e-12
        assert np.isin(each.box, there).all()
        assert each.values[each.worst] == each.values.min()


def test_the_worst_point_is_the_least_of_the_best_configuration() -> None:
    details = describe_placement(lance_cell(0.15), flat_top(5, 3), PlacementGoal())
    assert details.values[details.worst] == details.score.least
    assert details.failing == ()


@pytest.mark.slow
def test_a_point_out_of_reach_is_named_with_how_much_nearer_it_would_have_to_be() -> None:
    cell, targets, goal = lance_cell(0.0), flat_top(5, 1), PlacementGoal()

    def at(x: float) -> PlacementDetails:
        return describe_placement(dataclasses.replace(cell, T_cell_board=pose((x, 0, 0.12), (0, 0, 0))), targets, goal)

    limit = next(x for x in np.arange(0.4, 1.2, 0.005) if at(float(x)).failing)
    for beyond in (0.02, 0.1):
        details = at(float(limit) + beyond)
        outermost = next(each for each in details.failing if each.target == 4)
        assert outermost.value == -np.inf
        # It lies almost straight away from the shoulder, so that what it is too far is what it was moved.
        assert beyond - 0.01 < outermost.missing < beyond + 0.01
        assert details.score.value == pytest.approx(-1.0 - len(details.failing) / 5)


def test_where_nothing_is_reached_every_point_fails() -> None:
    held = dataclasses.replace(lance_cell(0.0), T_cell_board=pose((3, 0, 0.12), (0, 0, 0)))
    details = describe_placement(held, flat_top(2, 2), PlacementGoal())
    assert details.configurations == ()
    assert details.score.value == -2.0
    assert [each.target for each in details.failing] == [0, 1, 2, 3]
    assert all(np.isnan(each.missing) for each in details.failing)


def test_a_point_that_only_a_body_keeps_from_being_reached_is_not_called_too_far() -> None:
    cell = lance_cell(0.15)
    place = pose((0.6, 0.055, HEIGHT + 0.25), (0, 0, 0))  # where the wrist is, wherever the arm comes from
    block = Body("block", Box((0.1, 0.3, 0.2)), place)
    blocked = dataclasses.replace(cell, fixtures=(block,))
    details = describe_placement(blocked, flat_top(5, 3), PlacementGoal(), build_collider(blocked, None))
    assert describe_placement(cell, flat_top(5, 3), PlacementGoal()).failing == ()
    assert details.failing
    assert {each.missing for each in details.failing} == {0.0}
