"""The library's robots agree with the makers' data sheets."""

import re
from pathlib import Path

import numpy as np
import pytest
import trimesh
from small_cells import urdf

from robotcell.cell.robot_library import load_robot, robot_library
from robotcell.errors import CellError
from robotcell.robot.robot import Mesh, Robot, flange_poses, link_poses

LIBRARY = Path(__file__).parents[3] / "robotcell" / "library"


def denavit_hartenberg(rows: list[tuple[float, float, float]], q: np.ndarray) -> np.ndarray:
    """T_base_flange by the classic table of (alpha, a, d); every step Rz(q) Tz(d) Tx(a) Rx(alpha)."""
    pose = np.eye(4)
    for (alpha, a, d), angle in zip(rows, q, strict=True):
        c, s, ca, sa = np.cos(angle), np.sin(angle), np.cos(alpha), np.sin(alpha)
        pose = pose @ np.array([[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]])
    return pose


H = np.pi / 2
TABLES = {
    "ur5": [(H, 0, 0.089159), (0, -0.425, 0), (0, -0.39225, 0), (H, 0, 0.10915), (-H, 0, 0.09465), (0, 0, 0.0823)],
    "ur5e": [(H, 0, 0.1625), (0, -0.425, 0), (0, -0.3922, 0), (H, 0, 0.1333), (-H, 0, 0.0997), (0, 0, 0.0996)],
    "cairo": [(-H, 0, 0.4), (0, 0.45, 0), (0, 0.4, 0), (H, 0.1, 0), (-H, 0, 0), (0, 0, 0.1)],
}


@pytest.mark.parametrize("name", TABLES)
def test_arms_move_as_their_denavit_hartenberg_table_says(name: str) -> None:
    robot = load_robot(name)
    for q in np.random.default_rng(2).uniform(-np.pi, np.pi, (50, 6)):
        np.testing.assert_allclose(flange_poses(robot, q[None])[0], denavit_hartenberg(TABLES[name], q), atol=1e-12)


def test_the_cairo_arm_keeps_the_papers_relation_between_approach_and_wrist() -> None:
    """C5 = a_y C1 - a_x S1, and the tip is d6 along the approach from a point at a4 of the wrist."""
    for q in np.random.default_rng(3).uniform(-np.pi, np.pi, (20, 6)):
        a = flange_poses(load_robot("cairo"), q[None])[0, :3, 2]
        assert np.cos(q[4]) == pytest.approx(a[1] * np.cos(q[0]) - a[0] * np.sin(q[0]), abs=1e-12)


def test_the_kuka_reaches_as_far_as_its_name_says_and_turns_as_the_maker_counts() -> None:
    robot = load_robot("kr6-r900")
    pose = link_poses(robot, np.zeros((1, 6)))[0]
    wrist = pose[5, :3, 3]
    np.testing.assert_allclose(wrist, [0.025 + 0.455 + 0.420, 0, 0.435])
    assert np.hypot(0.420, 0.035) + 0.455 + 0.025 == pytest.approx(0.9015, abs=5e-4)  # R900: 901.5 mm to the wrist
    turned = flange_poses(robot, np.array([[np.radians(90), 0, 0, 0, 0, 0]]))[0]
    assert turned[1, 3] < -0.9  # A1 counts clockwise as seen from above


def test_the_gantrys_tool_tilts_across_its_reference() -> None:
    robot = load_robot("gantry")
    home = np.array([0.1, -0.05, 0.02, 0.7, 0.0])
    straight, tilted = flange_poses(robot, np.array([home, [*home[:4], 0.5]]))
    np.testing.assert_allclose(straight[:3, 2], [0, 0, -1], atol=1e-12)
    np.testing.assert_allclose(straight[:3, 3], [0.1, -0.05, 0.31], atol=1e-12)
    np.testing.assert_allclose(tilted[:3, 0], straight[:3, 0], atol=1e-12)
    assert np.degrees(np.arccos(-tilted[2, 2])) == pytest.approx(np.degrees(0.5))


@pytest.mark.parametrize("name", robot_library())
def test_every_robot_has_all_its_limits_and_says_where_they_come_from(name: str) -> None:
    robot = load_robot(name)
    assert robot.name == name
    for joint in robot.joints:
        endless = (name, joint.name) == ("gantry", "C")  # laps around a component with the jet on wind it up
        assert np.isfinite([joint.lowest, joint.highest]).all() != endless
        assert np.isfinite([joint.speed, joint.acceleration]).all()
        assert joint.lowest < 0 < joint.highest
    text = robot_library()[name].read_text("utf-8")
    assert re.search("assumed|chosen", text)


@pytest.mark.parametrize("name", robot_library())
def test_bodies_are_closed_convex_and_lie_along_the_arm(name: str) -> None:
    robot = load_robot(name)
    assert all(robot.bodies)
    for body in (body for bodies in robot.bodies for body in bodies):
        if isinstance(body.shape, Mesh):
            solid = trimesh.Trimesh(**trimesh.triangles.to_kwargs(body.shape.triangles))
            assert solid.is_watertight
            assert solid.volume / solid.convex_hull.volume == pytest.approx(1.0, abs=1e-4)
    assert longest_gap(robot) < 0.06


def longest_gap(robot: Robot) -> float:
    """How far the flange is from the points of the bodies of the last two links, at zero."""
    poses = link_poses(robot, np.zeros((1, robot.dof)))[0]
    flange = flange_poses(robot, np.zeros((1, robot.dof)))[0, :3, 3]
    points = []
    for index in (-2, -1):
        for body in robot.bodies[index]:
            here = poses[index] @ body.T_carrier_shape
            corners = body.shape.triangles.reshape(-1, 3) if isinstance(body.shape, Mesh) else np.zeros((1, 3))
            points.append(corners @ here[:3, :3].T + here[:3, 3])
    return float(np.linalg.norm(np.concatenate(points) - flange, axis=1).min())


def test_the_library_is_small_and_its_licences_are_recorded() -> None:
    files = [file for file in LIBRARY.rglob("*") if file.is_file()]
    assert sum(file.stat().st_size for file in files) < 2_000_000
    text = (LIBRARY / "LICENCES.md").read_text("utf-8")
    for folder in {file.parent.name for file in files if file.suffix == ".stl"}:
        assert f"robots/{folder}/*.stl" in text


def test_limits_beside_a_urdf_are_set_in_its_units(tmp_path: Path) -> None:
    (tmp_path / "two.urdf").write_text(urdf(), "utf-8")
    file = tmp_path / "two.yaml"
    limits = "S: {position_mm: [-50, 60], speed_mm_s: 100, acceleration_mm_s2: 1000}, T: {acceleration_deg_s2: 90}"
    file.write_text(f"robot: two\nurdf: two.urdf\njoints: {{{limits}}}\n", "utf-8")
    slide, turn = load_robot(file).joints
    assert (slide.lowest, slide.highest, slide.speed, slide.acceleration) == pytest.approx((-0.05, 0.06, 0.1, 1.0))
    assert (turn.lowest, turn.speed, turn.acceleration) == pytest.approx((-1, 2, H))


@pytest.mark.parametrize(
    ("joints", "message"),
    [
        ("{all: {acceleration_mm_s2: 5}}", "joint T needs a greatest acceleration; state acceleration_deg_s2"),
        ("{S: {speed_deg_s: 5}}", "S slides; state mm"),
        ("{T: {position_mm: [0, 5]}}", "T turns; state degrees"),
        ("{U: {speed_deg_s: 5}}", "no joint of two; known: S, T, all"),
        ("{T: {position_deg: [5, 4]}}", "the lowest position first"),
        ("{T: {speed_deg: 5}}", "did you mean 'speed_deg_s'"),
    ],
)
def test_limits_that_do_not_fit_are_refused(tmp_path: Path, joints: str, message: str) -> None:
    (tmp_path / "two.urdf").write_text(urdf(), "utf-8")
    file = tmp_path / "two.yaml"
    file.write_text(f"robot: two\nurdf: two.urdf\njoints: {joints}\n", "utf-8")
    with pytest.raises(CellError, match=message) as caught:
        load_robot(file)
    assert str(caught.value).startswith(f"{file}:3: joints")


def test_unknown_robots_list_the_library() -> None:
    with pytest.raises(CellError, match="Did you mean 'ur5e'"):
        load_robot("ur5ee")
