"""What is wrong in a cell is said once, with file, line, YAML path and the way out."""

import re
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation
from small_cells import CELL, urdf
from step_writer import Placed, StepWriter

from robotcell.cell.load import cell_library, read_cell, read_cell_text
from robotcell.errors import CellError
from robotcell.robot.robot import Box, Capsule, Mesh


def test_a_cell_is_in_metres_and_radians() -> None:
    loaded = read_cell_text(CELL)
    cell = loaded.cell
    assert (cell.name, cell.robot.name, cell.robot.dof) == ("small", "ur5e", 6)
    np.testing.assert_allclose(cell.T_cell_base[:3, :3], np.diag([-1, -1, 1]), atol=1e-12)
    np.testing.assert_allclose(cell.T_cell_board[:3, 3], [0.4, -0.05, 0.15])
    np.testing.assert_allclose(np.degrees(cell.home), [-16, -94, 97, -93, -90, -106])
    np.testing.assert_allclose(cell.tools[0].T_flange_tcp[:3, 3], [0, 0, 0.18])
    assert cell.margin == 0.005
    assert loaded.round_nozzles == {"ring60"}


def test_a_cell_comes_from_the_library_or_from_a_file(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_bytes(b"\xef\xbb\xbf" + cell_library()["gantry"].read_bytes().replace(b"\n", b"\r\n"))
    assert read_cell(file).cell.name == read_cell("gantry").cell.name
    np.testing.assert_array_equal(read_cell(str(file)).cell.home, read_cell("gantry").cell.home)


@pytest.mark.slow
def test_a_fixture_of_step_is_a_body_for_each_solid_in_millimetres(tmp_path: Path) -> None:
    parts: list[Placed] = [("leg", "leg", (10, 20, 30), (0, 0, 0)), ("top", "top", (100, 50, 5), (40, 0, 30))]
    (tmp_path / "stand.step").write_text(StepWriter().write(parts), "utf-8")
    stand = "fixtures:\n  stand: {kind: mesh, file: stand.step, at: {xyz_mm: [500, 0, 0]}}\n"
    file = tmp_path / "a.yaml"
    file.write_text(CELL.replace("fixtures:\n", stand), "utf-8")
    leg, top, table = read_cell(file).cell.fixtures
    assert (leg.name, top.name, table.name) == ("stand", "stand", "table")
    assert isinstance(leg.shape, Mesh)
    assert isinstance(top.shape, Mesh)
    np.testing.assert_allclose(np.ptp(leg.shape.triangles, axis=(0, 1)), [0.01, 0.02, 0.03], atol=1e-6)
    corners = top.shape.triangles.reshape(-1, 3) + top.T_carrier_shape[:3, 3]
    np.testing.assert_allclose(corners.max(axis=0), [0.59, 0.025, 0.035], atol=1e-6)
    file.write_text(file.read_text("utf-8").replace("stand.step", "stand.step, mm_per_unit: 1000"), "utf-8")
    with pytest.raises(CellError, match="mm_per_unit: a STEP file states its unit; leave it out"):
        read_cell(file)


def test_a_step_fixture_that_is_none_is_refused_with_its_place(tmp_path: Path) -> None:
    (tmp_path / "a.step").write_text("solid", "utf-8")
    file = tmp_path / "a.yaml"
    file.write_text(CELL.replace("fixtures:\n", "fixtures:\n  stand: {kind: mesh, file: a.step}\n"), "utf-8")
    with pytest.raises(CellError, match=r"a\.yaml:\d+: fixtures\.stand\.file: .*is not a STEP file"):
        read_cell(file)


def test_bodies_of_every_kind(tmp_path: Path) -> None:
    trimesh.creation.box((2.0, 4.0, 6.0)).export(tmp_path / "block.stl")
    bodies = """
  post: {kind: box, size_mm: [10, 20, 30], at: {xyz_mm: [0, 0, 15]}}
  bar: {kind: cylinder, from_mm: [0, 0, 0], to_mm: [100, 0, 0], radius_mm: 5}
  rod: {kind: capsule, from_mm: [0, 0, 0], to_mm: [0, 30, 40], radius_mm: 4}
  hose: {kind: hose, along_mm: [[0, 0, 0], [0, 0, 10], [10, 0, 10]], radius_mm: 3}
  block: {kind: mesh, file: block.stl, mm_per_unit: 1000, at: {xyz_mm: [1000, 0, 0], rpy_deg: [0, 0, 90]}}
"""
    file = tmp_path / "a.yaml"
    file.write_text(CELL.replace("fixtures:\n", "fixtures:" + bodies), "utf-8")
    post, bar, rod, first, second, block, table = read_cell(file).cell.fixtures
    assert [body.name for body in (first, second, table)] == ["hose", "hose", "table"]
    assert isinstance(post.shape, Box)
    assert post.shape.size == (0.01, 0.02, 0.03)
    assert isinstance(bar.shape, Mesh)
    along = bar.shape.triangles.reshape(-1, 3) @ bar.T_carrier_shape[:3, :3].T + bar.T_carrier_shape[:3, 3]
    np.testing.assert_allclose([along[:, 0].min(), along[:, 0].max()], [0, 0.1], atol=1e-12)
    assert isinstance(rod.shape, Capsule)
    assert (rod.shape.radius, rod.shape.length) == pytest.approx((0.004, 0.05))
    np.testing.assert_allclose(rod.T_carrier_shape @ [0, 0, 0.025, 1], [0, 0.03, 0.04, 1], atol=1e-12)
    np.testing.assert_allclose(second.T_carrier_shape @ [0, 0, -0.005, 1], [0, 0, 0.01, 1], atol=1e-12)
    assert isinstance(block.shape, Mesh)
    np.testing.assert_allclose(np.ptp(block.shape.triangles, axis=(0, 1)), [2, 4, 6])


def test_a_robot_of_ones_own_with_tighter_limits(tmp_path: Path) -> None:
    (tmp_path / "two.urdf").write_text(urdf(), "utf-8")
    text = re.sub(
        r"robot: ur5e\n.*\nhome.*\n",
        "robot:\n  urdf: two.urdf\n  joints:\n    S: {acceleration_mm_s2: 900}\n    T: {acceleration_deg_s2: 90}\n"
        "joints:\n  S: {speed_mm_s: 50}\nhome_deg_mm: [100, 30]\n",
        CELL,
    )
    file = tmp_path / "a.yaml"
    file.write_text(text, "utf-8")
    cell = read_cell(file).cell
    np.testing.assert_allclose(cell.home, [0.1, np.radians(30)])
    assert [joint.speed for joint in cell.robot.joints] == pytest.approx([0.05, 2.0])
    for before, after, message in (
        ("[100, 30]", "[300, 30]", r"home_deg_mm\[0\]: S goes from -100 to 200 mm, not to 300"),
        ("[100, 30]", "[100]", r"has 1 values; two has 2 joints: S, T"),
        ("{acceleration_deg_s2: 90}", "{speed_deg_s: 90}", "joint T needs a greatest acceleration"),
        ("two.urdf", "three.urdf", r"a.yaml:3: robot.urdf: .*three.urdf: no such file"),
    ):
        file.write_text(text.replace(before, after), "utf-8")
        with pytest.raises(CellError, match=message):
            read_cell(file)


def test_every_place_of_a_cell_may_be_turned_by_degrees_about_each_axis() -> None:
    turned = "{xyz_mm: [400, -50, 150], rpy_deg: [180, 20, -35]}"
    text = CELL.replace("pose: {xyz_mm: [400, -50, 150]}", f"pose: {turned}")
    text = text.replace("tcp: {xyz_mm: [0, 0, 180]}", f"tcp: {turned}").replace(
        "at: {xyz_mm: [300, 0, -20]}", f"at: {turned}"
    )
    loaded = read_cell_text(f"{text}placements:\n  flip_to_bottom: {{pose: {turned}}}\n")
    cell, expected = loaded.cell, np.eye(4)
    expected[:3, :3] = Rotation.from_euler("xyz", [180, 20, -35], degrees=True).as_matrix()
    expected[:3, 3] = 0.4, -0.05, 0.15
    places = [cell.T_cell_board, cell.tools[0].T_flange_tcp, cell.fixtures[0].T_carrier_shape]
    for place in (*places, loaded.placements["flip_to_bottom"]):
        np.testing.assert_allclose(place, expected, atol=1e-12)


def test_a_board_that_is_turned_over_has_a_place_of_its_own() -> None:
    text = CELL + "placements:\n  flip_to_bottom: {pose: {xyz_mm: [400, 50, 150], rpy_deg: [180, 0, 0]}}\n"
    placed = read_cell_text(text).placements["flip_to_bottom"]
    np.testing.assert_allclose(placed[:3, 2], [0, 0, -1], atol=1e-12)


def test_a_robots_path_begins_at_the_cell_even_without_a_suffix(tmp_path: Path) -> None:
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / "own").write_text("robot: [\n", "utf-8")
    file = tmp_path / "cell.yaml"
    file.write_text(CELL.replace("robot: ur5e", "robot: robots/own"), "utf-8")
    with pytest.raises(CellError, match=rf"{tmp_path}/robots/own:\d+: "):
        read_cell(file)


@pytest.mark.parametrize(
    ("before", "after", "path", "message"),
    [
        ("robot: ur5e", "robot: ur5ee", "robot", "Did you mean 'ur5e'"),
        ("robot: ur5e", "robot: 5", "robot", "must be text (put it in quotes) or a mapping, not 5"),
        ("robot: ur5e", "robot: {urdff: a}", "robot.urdff", "did you mean 'urdf'"),
        ("home_deg_mm:", "home_deg:", "home_deg", "did you mean 'home_deg_mm'"),
        ("-106]", "-406]", "home_deg_mm[5]", "wrist_3 goes from -360 to 360 degrees, not to -406"),
        (
            "home_deg_mm:",
            "joints: {wrist_3: {position_deg: [-90, 90]}}\nhome_deg_mm:",
            "home_deg_mm[5]",
            "wrist_3 goes from -90 to 90 degrees (joints.wrist_3), not to -106",
        ),
        ("-106]", "-106, 0]", "home_deg_mm", "has 7 values; ur5e has 6 joints"),
        ("pose: {xyz_mm: [400, -50, 150]}", "{}", "board", "exactly one of pose, points, touched"),
        ("xyz_mm: [400, -50, 150]", "xyz_mm: [400, -50]", "board.pose.xyz_mm", "needs a value number 3"),
        ("xyz_mm: [400, -50, 150]", "xyz_m: [400, -50]", "board.pose.xyz_m", "did you mean 'xyz_mm'"),
        ("kind: box", "kind: bx", "fixtures.table.kind", "did you mean 'box'"),
        ("size_mm: [900, 900, 40]", "size_mm: [900, 900, 0]", "fixtures.table.size_mm[2]", "must be at least 0.001 mm"),
        ("kind: box, size_mm: [900, 900, 40]", "kind: mesh, file: no.stl", "fixtures.table.file", "no such file"),
        ("to_mm: [0, 0, 170]", "to_mm: [0, 0, 0]", "tools.1.bodies.lance", "begins where it ends"),
        ("  1:\n", "  100:\n", "tools.100", "must be at most 99"),
        ("valve: doRing,", "valve: doRng,", "nozzles.ring60.valve", "did you mean 'doRing'"),
        ("valve: doRing,", "valve: aoPressure,", "nozzles.ring60.valve", "a valve needs a digital output"),
        ("{doRing: 0}", "{doRing: 2}", "io.functions.clean.doRing", "is digital: 0 or 1, not 2"),
        ("{goSolution: 2}", "{goSolution: 2.5}", "io.solutions.di-water.goSolution", "a whole number from 0"),
        ("output: aoPressure", "output: aoPress", "io.settings.pressure_bar.output", "did you mean 'aoPressure'"),
        ("kind: group, number: 1", "kind: digital, number: 1", "io.outputs.goSolution.number", "is doRing already"),
        ("analog, number: 1", "analog, number: 1, unit: mA", "io.outputs.aoPressure.unit", "full_scale: 20"),
        ("input: diDoor", "input: diDor", "io.waits.door_closed.input", "did you mean 'diDoor'"),
        ("sensor: resistivity_mohm_cm", "sensor: resistivity", "io.waits.water.sensor", "did you mean"),
        ("diDoor: {number: 2}", "diDoor: {number: 1}", "io.inputs.diDoor.number", "is diBoard already"),
        ("input: diDoor", "input: diDoor, least: 2", "io.waits.door_closed", "sensor and least go together"),
        (
            "input: diBoard",
            "input: diBoard, sensor: x, least: 1",
            "io.waits.part_present",
            "give an input, with its state",
        ),
        ("least: 0.5", "least: 0.5, watched: true", "io.waits.water", "state and watched go with an input"),
        ("timeout_s: 5", "timeout_s: 0", "io.waits.water.timeout_s", "must be at least 1 s"),
        ("number: 3,", "number: 3, unit: mA,", "io.sensors.resistivity_mohm_cm.unit", "mA needs a full_scale too"),
        ("number: 3,", "number: 3, unit: bar,", "io.sensors.resistivity_mohm_cm.unit", "known: V, mA"),
        (
            "number: 3,",
            "number: 3, full_scale: 0,",
            "io.sensors.resistivity_mohm_cm.full_scale",
            "must be at least 0.001 V or mA",
        ),
        ("number: 3,", "number: 3, full_scale: .inf,", "io.sensors.resistivity_mohm_cm.full_scale", "number"),
        ("cell: small", "cell: 1small", "cell", "a name begins with a letter"),
    ],
)
def test_errors_name_line_path_and_the_way_out(before: str, after: str, path: str, message: str) -> None:
    assert before in CELL
    text = CELL.replace(before, after, 1)
    with pytest.raises(CellError, match=re.escape(message)) as caught:
        read_cell_text(text, file="mine.yaml")
    assert caught.value.path == path
    assert re.match(rf"mine\.yaml:\d+: {re.escape(path)}: ", str(caught.value))


def test_measured_points_that_do_not_fit_are_an_error_at_the_board() -> None:
    points = "".join(
        f"\n    - {{board_mm: {b}, cell_mm: {c}}}"
        for b, c in (([0, 0, 0], [0, 0, 0]), ([100, 0, 0], [90, 0, 0]), ([0, 50, 0], [0, 50, 0]))
    )
    text = CELL.replace("pose: {xyz_mm: [400, -50, 150]}", f"points:{points}")
    with pytest.raises(CellError, match=r"^<cell>:5: board: points 0 and 1 are 100.00 mm apart on the board but 90.00"):
        read_cell_text(text)


def test_unknown_cells_list_the_library(tmp_path: Path) -> None:
    with pytest.raises(CellError, match=r"no cell 'ur5e-bnch'\. Did you mean 'ur5e-bench'\?"):
        read_cell("ur5e-bnch")
    with pytest.raises(CellError, match="`washboard cell list` shows the library"):
        read_cell(tmp_path / "none.yaml")
    with pytest.raises(CellError, match="a cell begins with `cell: NAME`"):
        read_cell_text("")
