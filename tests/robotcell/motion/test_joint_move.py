"""Joint moves of a machine whose controller takes tool points: straight in those, within the joints' limits."""

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tracked import line_program

from robotcell.cell.load import read_cell
from robotcell.motion.cell_queries import SHARE, Lifting, build_queries, find_move, straight_way, time_move
from robotcell.robot.robot import Joints

CELL = read_cell("gantry").cell
UNITS = np.array([1e3, 1e3, 1e3, 1.0, 1.0])
WOUND = np.array([0.02, -0.05, -0.11, np.radians(540.0), np.radians(-55.0)])


def axes_of(rows: Joints) -> Joints:
    """Tool points, mm, with C and B."""
    assert CELL.tool_point is not None
    return CELL.tool_point.axes(rows * UNITS)


def random_ends(count: int) -> Iterator[tuple[Joints, Joints]]:
    rng = np.random.default_rng(5)
    least, most = np.array([-0.2, -0.2, -0.2, -9.0, -1.0]), np.array([0.2, 0.2, 0.0, 9.0, 1.0])
    for _ in range(count):
        begin, end = rng.uniform(least, most, (2, 5))
        yield begin, end


def test_a_leg_goes_straight_in_tool_points() -> None:
    for begin, end in random_ends(20):
        rows = straight_way(CELL.tool_point, begin, end)
        np.testing.assert_array_equal(rows[[0, -1]], [begin, end])
        shares = np.linspace(0.0, 1.0, len(rows))[:, None]
        ends = axes_of(np.stack((begin, end)))
        np.testing.assert_allclose(axes_of(rows), ends[0] + shares * (ends[1] - ends[0]), atol=1e-9)
        middle = axes_of(0.5 * (rows[1:] + rows[:-1]))  # the joints go evenly between rows
        assert np.abs(middle - 0.5 * (axes_of(rows)[1:] + axes_of(rows)[:-1]))[:, :3].max() < 0.1


def test_where_each_joint_is_an_axis_or_the_tool_is_upright_a_leg_is_one_piece() -> None:
    begin, end = next(random_ends(1))
    np.testing.assert_array_equal(straight_way(None, begin, end), [begin, end])
    begin[4] = end[4] = 0.0
    np.testing.assert_array_equal(straight_way(CELL.tool_point, begin, end), [begin, end])


def test_a_leg_keeps_to_half_of_what_the_joints_can() -> None:
    most = np.array([[joint.speed, joint.acceleration] for joint in CELL.robot.joints]).T * SHARE
    for begin, end in random_ends(20):
        times, rows = time_move(CELL.robot, np.stack((begin, end)), CELL.tool_point)
        np.testing.assert_allclose(rows[[0, -1]], [begin, end], atol=1e-12)
        rates = np.diff(rows, axis=0) / np.diff(times)[:, None]
        assert (np.abs(rates) <= 1.001 * most[0]).all()
        between = 0.5 * (times[2:] - times[:-2])[:, None]
        assert (np.abs(np.diff(rates, axis=0) / between) <= 1.05 * most[1]).all()


def test_a_tool_that_leans_is_tilted_about_its_orifice_before_it_unwinds() -> None:
    queries: Any = SimpleNamespace(cell=CELL, is_blocked=lambda *_: False)
    found = find_move(queries, Lifting(WOUND[None]), Lifting(CELL.home[None]), (0, 0), (0, 0))
    assert found is not None
    way, _ = found
    tilted, upright, home = axes_of(way)
    assert tilted[4] != pytest.approx(0.0)
    assert upright == pytest.approx([*tilted[:4], 0.0], abs=1e-9)
    assert home == pytest.approx(axes_of(CELL.home[None])[0])


@pytest.mark.parametrize(("orifice_mm", "blocked"), [(280.0, False), (320.0, True)])
def test_a_tilt_that_takes_the_carriage_out_of_its_travel_is_blocked(orifice_mm: float, blocked: bool) -> None:
    machine = CELL.tool_point
    assert machine is not None
    ends = np.zeros((2, 5))  # the orifice rests, the tool leans by 55 degrees along Y and is upright then
    ends[:, 1], ends[:, 3], ends[0, 4] = orifice_mm, np.radians(90.0), np.radians(55.0)
    leans, upright = machine.joints(ends) / UNITS
    assert abs(leans[1]) < 0.18  # within a travel of 300 mm
    queries = build_queries(line_program(), CELL, None, [CELL.T_cell_board])
    assert queries.is_blocked(leans, upright, 0, 0) == blocked
