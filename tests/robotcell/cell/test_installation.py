"""What a program sees of a cell is the cell, in millimetres."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from small_cells import CELL

from programs.export import controller_of, find_dialect
from programs.pose import Pose
from robotcell.cell.installation import installation_of
from robotcell.cell.load import cell_library, read_cell, read_cell_text
from robotcell.robot.robot import Poses
from specs.errors import JobError


def matrix(given: Pose) -> Poses:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat(given.quaternion, scalar_first=True).as_matrix()
    pose[:3, 3] = np.array(given.position) / 1e3
    return pose


@pytest.mark.parametrize("name", cell_library())
def test_frames_cancel_as_in_the_cell(name: str) -> None:
    loaded = read_cell(name)
    installation = installation_of(loaded)
    cell = loaded.cell
    np.testing.assert_allclose(cell.T_cell_base @ matrix(installation.T_base_board), cell.T_cell_board, atol=1e-12)
    for tool in cell.tools:
        np.testing.assert_allclose(matrix(installation.tools[tool.number].T_flange_tcp), tool.T_flange_tcp, atol=1e-12)
    assert (installation.cell, installation.robot) == (cell.name, cell.robot.name)
    assert [joint.name for joint in installation.joints] == [joint.name for joint in cell.robot.joints]
    assert set(installation.functions) == {"clean", "rinse", "dry", "coat"}
    assert set(installation.valves) == {"ring60", "jet30", "gun", "knife"}
    assert "resistivity_mohm_cm" in installation.sensors


def test_sliding_joints_are_in_millimetres() -> None:
    installation = installation_of(read_cell("gantry"))
    assert [joint.kind for joint in installation.joints] == ["prismatic"] * 3 + ["revolute"] * 2
    assert installation.home == pytest.approx((0, 0, 30, -np.pi / 2, 0))


def test_channels_are_told_by_name_and_number() -> None:
    text = CELL.replace("  sensors:", "  grip:\n    open: {doRing: 1}\n    close: {doRing: 0}\n  sensors:")
    text += "placements:\n  flip_to_bottom: {pose: {xyz_mm: [400, 50, 150], rpy_deg: [180, 0, 0]}}\n"
    installation = installation_of(read_cell_text(text))
    valve = installation.valves["ring60"]
    assert (valve.channel.kind, valve.channel.name, valve.channel.number) == ("digital", "doRing", 1)
    assert (valve.open_lag_s, valve.close_lag_s, valve.min_pulse_s) == (0.04, 0.02, 0.0)
    (choice,) = installation.solutions["di-water"]
    assert (choice.channel.kind, choice.channel.name, choice.value) == ("group", "goSolution", 2)
    setting = installation.settings["pressure_bar"]
    assert (setting.channel.name, setting.scale, setting.offset) == ("aoPressure", 0.5, 0.0)
    assert (setting.channel.full_scale, setting.channel.unit) == (10.0, "V")
    sensor = installation.sensors["resistivity_mohm_cm"]
    assert (sensor.name, sensor.number, sensor.scale) == ("aiRes", 3, 2.0)
    assert [installation.grips[state][0].value for state in ("open", "close")] == [1, 0]
    assert (sensor.full_scale, sensor.unit) == (10.0, "V")
    np.testing.assert_allclose(matrix(installation.placements["flip_to_bottom"])[:3, 2], [0, 0, -1], atol=1e-12)


def test_channels_of_current_keep_their_full_scale() -> None:
    text = CELL.replace("analog, number: 1}", "analog, number: 1, full_scale: 20, unit: mA}")
    text = text.replace("number: 3, scale", "number: 3, full_scale: 24, unit: mA, counts: 4096, scale")
    installation = installation_of(read_cell_text(text))
    channel, sensor = installation.settings["pressure_bar"].channel, installation.sensors["resistivity_mohm_cm"]
    assert (channel.full_scale, channel.unit) == (20.0, "mA")
    assert (sensor.full_scale, sensor.unit, sensor.counts) == (24.0, "mA", 4096)


def test_numbers_of_the_controller_are_those_of_the_cell() -> None:
    text = CELL
    assert installation_of(read_cell_text(text)).controller == {}
    text += "controller: {acceleration_mm_s2: 800, look_ahead: 5, source: a stopwatch}\n"
    installation = installation_of(read_cell_text(text))
    assert installation.controller == {"acceleration_mm_s2": 800.0, "look_ahead": 5}
    assert installation.controller_source == "a stopwatch"
    model = controller_of(find_dialect("ur"), installation)
    assert model is not None
    assert (model.acceleration_mm_s2, model.look_ahead) == (800.0, 5)
    assert model.source("look_ahead") == "a stopwatch"
    assert model.source("settle_s") == "assumed"


@pytest.mark.parametrize("line", ["look_ahead: 0", "most_positions: 3", "settle_s: -1", "speed: 3"])
def test_numbers_of_a_controller_are_bounded(line: str) -> None:
    with pytest.raises(JobError, match=r"controller"):
        read_cell_text(f"{CELL}controller: {{{line}}}\n")


def test_waits_have_the_channels_that_show_them() -> None:
    part, door, water = installation_of(read_cell_text(CELL)).waits
    assert part.contact is not None
    assert (part.contact.name, part.contact.number, part.state, part.watched) == ("diBoard", 1, True, False)
    assert door.contact is not None
    assert (door.contact.number, door.state, door.watched, door.shown) == (2, False, True, "no door closed")
    assert water.sensor is not None
    assert (water.contact, water.sensor.number, water.least, water.timeout_s) == (None, 3, 0.5, 5.0)
