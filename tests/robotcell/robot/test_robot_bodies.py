"""The bodies of the library's arms meet where the arms themselves would, and nowhere else."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from robotcell.cell.cell import Cell
from robotcell.cell.load import read_cell
from robotcell.collision.collision import build_collider, collides, first_pairs
from robotcell.robot.robot import link_poses


def alone(name: str) -> Cell:
    """A cell without anything but the robot; home is all zero, so that nothing is let off for touching there."""
    cell = read_cell(name).cell
    bare = replace(cell.tools[0], bodies=())
    return replace(cell, fixtures=(), tools=(bare,), home=np.zeros(cell.robot.dof))


def at_random(cell: Cell, count: int) -> NDArray[np.float64]:
    """Rows within the joints' limits, of one turn at most."""
    low = np.maximum([joint.lowest for joint in cell.robot.joints], -np.pi)
    high = np.minimum([joint.highest for joint in cell.robot.joints], np.pi)
    return np.random.default_rng(5).uniform(low, high, (count, cell.robot.dof))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cairo-bench", "ur5-bench", "ur5e-bench"])
def test_most_configurations_are_free(name: str) -> None:
    cell = alone(name)
    assert 0.05 < collides(build_collider(cell, None), at_random(cell, 600), 1).mean() < 0.4


def test_the_cairo_arm_is_free_wherever_it_works() -> None:
    """Elbow up, the jet straight down: shoulder, elbow and wrist turn over the whole table before the robot."""
    cell = read_cell("cairo-bench").cell
    turns = np.random.default_rng(6).uniform([-90, -100, 40, -180], [90, -20, 130, 180], (600, 4))
    pan, lift, elbow, last = turns.T
    q = np.radians(np.column_stack((pan, lift, elbow, 90.0 - lift - elbow, np.full(600, -90.0), last)))
    heights = link_poses(cell.robot, q)[:, -1, 2, 3]
    for tool in cell.tools:
        used = replace(cell, fixtures=(), home=np.zeros(6), tools=(tool,))
        touches = first_pairs(build_collider(used, None), q, tool.number)
        assert {touch and (touch.body, touch.other) for touch in touches} == {None}
    assert np.ptp(heights) > 0.5


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cairo-bench", "ur5-bench", "ur5e-bench"])
def test_the_upper_arm_passes_beside_the_base(name: str) -> None:
    """The UR5 alone has something to hit there: the plug of its cable, which stands out 110 mm from the axis."""
    cell = alone(name)
    q = np.zeros((2000, 6))
    q[:, :2] = np.random.default_rng(7).uniform(-np.pi, np.pi, (2000, 2))
    met = [
        touch
        for touch in first_pairs(build_collider(cell, None), q, 1)
        if touch is not None and touch.body == "upper_arm"
    ]
    assert {touch.other for touch in met} == ({"connector"} if name == "ur5-bench" else set())


def test_the_upper_arm_meets_the_plug_only_where_it_hangs_down_beside_it() -> None:
    cell = alone("ur5-bench")
    pan, lift = (grid.ravel() for grid in np.meshgrid(np.arange(-180, 180, 6), np.arange(-180, 180, 6)))
    q = np.zeros((pan.size, 6))
    q[:, :2] = np.radians(np.column_stack((pan, lift)))
    touches = first_pairs(build_collider(cell, None), q, 1)
    met = np.array([touch is not None and touch.other == "connector" for touch in touches])
    beside = np.abs((pan % 360) - 180) <= 45  # the plug is at +y of the base, and the arm beside the shoulder
    down = np.abs(lift - 90) <= 63
    assert met[(pan == -180) & (lift == 90)].all()
    assert not met[~(beside & down)].any()
