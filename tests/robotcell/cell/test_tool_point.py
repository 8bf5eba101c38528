"""Machines whose G-code has tool points: pivot length, zeros and signs from the cell, and what is refused."""

import math
from pathlib import Path

import numpy as np
import pytest

from robotcell.cell.load import cell_library, read_cell, read_cell_text
from robotcell.errors import CellError
from robotcell.robot.robot import flange_poses

GANTRY = cell_library()["gantry"].read_text("utf-8")


def test_tool_points_are_those_of_the_forward_kinematics() -> None:
    loaded = read_cell("gantry")
    machine = loaded.cell.tool_point
    assert machine is not None
    assert machine.pivot_mm == pytest.approx(180.0)
    rows = np.random.default_rng(3).uniform(-1.0, 1.0, (20, 5)) * [0.3, 0.3, 0.2, 3.0, 1.0]
    tips = flange_poses(loaded.cell.robot, rows) @ loaded.cell.tools[0].T_flange_tcp
    axes = machine.axes(rows * [1e3, 1e3, 1e3, 1.0, 1.0])
    np.testing.assert_allclose(axes[:, :3], 1e3 * tips[:, :3, 3] + machine.base, atol=1e-6)
    jets = np.column_stack((np.sin(axes[:, 4]) * np.cos(axes[:, 3]), np.sin(axes[:, 4]) * np.sin(axes[:, 3])))
    np.testing.assert_allclose(jets, tips[:, :2, 2], atol=1e-9)
    np.testing.assert_allclose(machine.joints(axes), rows * [1e3, 1e3, 1e3, 1.0, 1.0], atol=1e-9)


def test_a_tool_that_is_mounted_at_an_angle_shifts_the_zero_of_b() -> None:
    # 120 mm from the flange, 30 degrees about the axis of B, on the line through that axis
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    place = f"{{xyz_mm: [0, {-100 * s:.9f}, {100 * c - 60:.9f}], rpy_deg: [30, 0, 0]}}"
    machine = read_cell_text(GANTRY.replace("{xyz_mm: [0, 0, 120]}", place)).cell.tool_point
    assert machine is not None
    assert (machine.pivot_mm, abs(math.degrees(machine.tilt_zero))) == pytest.approx((100.0, 30.0))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("{xyz_mm: [0, 0, 120]}                # +x", "{xyz_mm: [0, 0, 90]}  # +x", "180 and 150 mm"),
        ("{xyz_mm: [0, 0, 120]}", "{xyz_mm: [0, 5, 120]}", "is no machine of 5axiskins"),
        ("robot: gantry\n", "robot: kr6-r900\n", "has A1, A2"),
    ],
)
def test_another_machine_is_refused_at_its_line(old: str, new: str, message: str) -> None:
    text = GANTRY.replace(old, new)
    if "kr6" in new:
        text = text.replace("home_deg_mm: [0, 0, 30, -90, 0]", "home_deg_mm: [0, -90, 90, 0, 0, 0]")
        text = text.replace("tool_change_deg_mm: [-240, -200, 30, -90, 0]", "")
    assert text != GANTRY
    with pytest.raises(CellError, match=message) as caught:
        read_cell_text(text, file=Path("mine.yaml"))
    line = next(number for number, each in enumerate(text.splitlines(), 1) if each.startswith("kinematics:"))
    assert f"mine.yaml:{line}" in str(caught.value)


@pytest.mark.parametrize("word", ["xyzbc-trt", "xyzbc-trt-kins"])
def test_a_table_that_tilts_the_board_is_refused_in_a_sentence(word: str) -> None:
    with pytest.raises(CellError, match="a table that tilts the board is no cell") as caught:
        read_cell_text(GANTRY.replace("kinematics: 5axiskins", f"kinematics: {word}"), file=Path("mine.yaml"))
    line = next(number for number, each in enumerate(GANTRY.splitlines(), 1) if each.startswith("kinematics:"))
    assert f"mine.yaml:{line}" in str(caught.value)
    assert str(caught.value).count("kinematics") == 1
