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


# Modified DH (Craig): alpha and a before the joint, then d, the angle at zero, and how the maker counts: degrees, mm.
COUNTED = {
    "irb1200-7": [(0, 0, 399.1, 0, 1), (-90, 0, 0, -90, 1), (0, 350, 0, 0, 1), (-90, 42, 351, 0, 1), (90, 0, 0, 0, 1),
                  (-90, 0, 82, 180, 1)],
    "kr6-r900": [(0, 0, 400, 0, -1), (-90, 25, 0, 0, 1), (0, 455, 0, -90, 1), (-90, 35, 420, 0, -1), (90, 0, 0, 0, 1),
                 (-90, 0, 80, 180, -1)],
    "lrmate-200id": [(0, 0, 0, 0, 1), (-90, 50, 0, -90, 1), (0, 330, 0, 0, -1), (-90, 35, 335, 0, -1),
                     (90, 0, 0, 0, -1), (-90, 0, 80, 0, -1)],
    "gp8": [(0, 0, 0, 0, 1), (-90, 40, 0, -90, 1), (0, 345, 0, 0, -1), (-90, 40, 340, 0, -1), (90, 0, 0, 0, -1),
            (-90, 0, 80, 0, -1)],
    "tx2-60": [(0, 0, 0, 0, 1), (-90, 0, 20, -90, 1), (0, 290, 0, 90, 1), (90, 0, 310, 0, 1), (-90, 0, 0, 0, 1),
               (90, 0, 70, 0, 1)],
    "vs060": [(0, 0, 345, 0, 1), (-90, 0, 0, -90, 1), (0, 305, 0, 90, 1), (90, -10, 300, 0, 1), (-90, 0, 0, 0, 1),
              (90, 0, 70, 0, 1)],
    "c8l": [(0, 0, 472, 90, 1), (-90, 100, 0, -90, -1), (0, 400, 0, 0, -1), (-90, 30, 400, 0, -1), (90, 0, 0, 0, -1),
            (-90, 0, 80, 0, -1)],
    "rv-4frl": [(0, 0, 350, 0, 1), (-90, 0, 0, -90, 1), (0, 310, 0, 90, 1), (90, -50, 335, 0, 1), (-90, 0, 0, 0, 1),
                (90, 0, 85, 0, 1)],
}  # fmt: skip
REACH_MM = {
    "irb1200-7": 703, "kr6-r900": 901.5, "lrmate-200id": 717, "gp8": 727, "tx2-60": 670 - 70, "vs060": 605, "c8l": 901,
    "rv-4frl": 649,
}  # fmt: skip
"""Published: from axis 1 to the wrist's centre, the arm level; Staubli's counts to the flange."""
RANGES_DEG = {
    "irb1200-7": [(-170, 170), (-100, 135), (-200, 70), (-270, 270), (-130, 130), (-360, 360)],
    "lrmate-200id": [(-170, 170), (-100, 145), (-140, 280), (-190, 190), (-125, 125), (-360, 360)],
    "gp8": [(-170, 170), (-65, 145), (-70, 190), (-190, 190), (-135, 135), (-360, 360)],
    "tx2-60": [(-180, 180), (-127.5, 127.5), (-152.5, 152.5), (-270, 270), (-121, 132.5), (-270, 270)],
    "vs060": [(-170, 170), (-120, 120), (-125, 155), (-270, 270), (-120, 120), (-360, 360)],
    "c8l": [(-240, 240), (-158, 65), (-61, 202), (-200, 200), (-135, 135), (-360, 360)],
    "rv-4frl": [(-240, 240), (-120, 120), (0, 164), (-200, 200), (-120, 120), (-360, 360)],
}
SPEEDS_DEG_S = {
    "irb1200-7": (288, 240, 300, 400, 405, 600),
    "lrmate-200id": (450, 380, 520, 550, 545, 1000),
    "gp8": (455, 385, 520, 550, 550, 1000),
    "tx2-60": (435, 385, 500, 995, 1065, 1445),
    "vs060": (213.75, 142.5, 155.58, 213.75, 164.47, 342),
    "c8l": (294, 300, 360, 450, 450, 720),
    "rv-4frl": (420, 336, 250, 540, 623, 720),
}


def modified_denavit_hartenberg(rows: list[tuple[float, ...]], counted: tuple[float, ...]) -> np.ndarray:
    """T_base_wrist6 by Craig's table; every step Rx(alpha) Tx(a) Rz(theta) Tz(d), theta as the controller counts."""
    pose = np.eye(4)
    for (alpha, a, d, zero, sign), value in zip(rows, counted, strict=True):
        (ca, sa), angle = (np.cos(np.radians(alpha)), np.sin(np.radians(alpha))), np.radians(zero + sign * value)
        c, s = np.cos(angle), np.sin(angle)
        step = [[c, -s, 0, a], [s * ca, c * ca, -sa, -d * sa], [s * sa, c * sa, ca, d * ca], [0, 0, 0, 1]]
        pose = pose @ np.array(step)
    return pose


@pytest.mark.parametrize("name", COUNTED)
def test_arms_stand_where_their_controllers_counts_say(name: str) -> None:
    """The flange by a table with the maker's signs and zeros, from the values that the controller shows."""
    robot = load_robot(name)
    for q in np.random.default_rng(4).uniform(-np.pi, np.pi, (20, 6)):
        counted = tuple(np.degrees(q).tolist())
        if robot.convention is not None:
            counted = robot.convention.count(counted)
            np.testing.assert_allclose(robot.convention.recover(counted), np.degrees(q), atol=1e-9)
        if name == "lrmate-200id":  # J3 is counted from level: the table, whose links count from one another, adds J2
            counted = (*counted[:2], counted[2] + counted[1], *counted[3:])
        flange, table = flange_poses(robot, q[None])[0], modified_denavit_hartenberg(COUNTED[name], counted)
        np.testing.assert_allclose(1e3 * flange[:3, 3], table[:3, 3], atol=1e-6)
        np.testing.assert_allclose(flange[:3, :3], table[:3, :3], atol=1e-9)


def test_a_fanuc_counts_its_third_joint_from_level() -> None:
    """The forearm's elevation is J3 whatever J2 is."""
    robot = load_robot("lrmate-200id")
    assert robot.convention is not None
    for q2, q3 in ((0.3, 0.4), (-0.7, 0.4), (1.1, -0.2)):
        poses = link_poses(robot, np.array([[0, q2, q3, 0, 0, 0]]))[0]
        along = poses[5, :3, 3] - poses[4, :3, 3]
        counted = robot.convention.count(tuple(np.degrees([0, q2, q3, 0, 0, 0]).tolist()))
        assert counted[2] == pytest.approx(np.degrees(np.arctan2(along[2], along[0])))


@pytest.mark.parametrize("name", REACH_MM)
def test_arms_reach_as_far_as_published(name: str) -> None:
    robot = load_robot(name)
    bends = np.linspace(robot.lowest[2], robot.highest[2], 4001)
    rows = np.zeros((len(bends), 6))
    rows[:, 2] = bends
    poses = link_poses(robot, rows)
    ways = (poses[:, 5, :3, 3] - poses[:, 2, :3, 3]) @ poses[0, 2, :3, :3]
    at = int(np.argmax(np.linalg.norm(ways, axis=1)))
    leans = np.linspace(robot.lowest[1], robot.highest[1], 4001)
    rows = np.zeros((len(leans), 6))
    rows[:, 1], rows[:, 2] = leans, bends[at]
    wrists = link_poses(robot, rows)[:, 5, :3, 3]
    assert 1e3 * np.hypot(wrists[:, 0], wrists[:, 1]).max() == pytest.approx(REACH_MM[name], abs=1.0)


@pytest.mark.parametrize("name", RANGES_DEG)
def test_ranges_and_speeds_are_the_published_ones(name: str) -> None:
    robot = load_robot(name)
    np.testing.assert_allclose(np.degrees(np.stack((robot.lowest, robot.highest), axis=1)), RANGES_DEG[name], atol=1e-6)
    np.testing.assert_allclose(np.degrees(robot.speed), SPEEDS_DEG_S[name], atol=1e-6)


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
        assert joint.lowest <= 0 < joint.highest
    text = robot_library()[name].read_text("utf-8")
    assert re.search("assumed|chosen", text)
    assert robot.maker is not None


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


def test_a_controllers_counts_are_read_beside_the_urdf(tmp_path: Path) -> None:
    (tmp_path / "two.urdf").write_text(urdf(), "utf-8")
    file = tmp_path / "two.yaml"
    limits = "{S: {acceleration_mm_s2: 1000}, T: {acceleration_deg_s2: 90}}"
    counts = "{S: {sign: -1, zero_mm: 250}, T: {zero_deg: 90}}"
    text = f"robot: two\nurdf: two.urdf\nmaker: abb\ncontroller_joints: {counts}\njoints: {limits}\n"
    file.write_text(text, "utf-8")
    robot = load_robot(file)
    assert robot.maker == "abb"
    assert robot.convention is not None
    assert robot.convention.count((10.0, 20.0)) == pytest.approx((240.0, 110.0))
    assert robot.convention.recover((240.0, 110.0)) == pytest.approx((10.0, 20.0))


@pytest.mark.parametrize(
    ("stated", "message"),
    [
        ("maker: fanuc", "maker goes with controller_joints: same"),
        ("controller_joints: same", "controller_joints goes with maker"),
        ("maker: acme\ncontroller_joints: same", "maker"),
        ("maker: abb\ncontroller_joints: {U: {}}", "no joint of two; known: S, T"),
        ("maker: abb\ncontroller_joints: {T: {plus: {T: 1}}}", "no other joint of two"),
        ("maker: abb\ncontroller_joints: {T: {plus: {S: 1}}}", "S and T do not both turn or both slide"),
        ("maker: abb\ncontroller_joints: {T: {zero_mm: 5}}", "T takes zero_deg"),
        ("maker: abb\ncontroller_joints: {T: {sign: 2}}", "sign"),
        ("maker: abb\ncontroller_joints: {T: {zero_deg: .inf}}", "zero_deg"),
    ],
)
def test_counts_that_do_not_fit_are_refused(tmp_path: Path, stated: str, message: str) -> None:
    (tmp_path / "two.urdf").write_text(urdf(), "utf-8")
    file = tmp_path / "two.yaml"
    file.write_text(f"robot: two\nurdf: two.urdf\n{stated}\njoints: {{all: {{acceleration_deg_s2: 9}}}}\n", "utf-8")
    with pytest.raises(CellError, match=message) as caught:
        load_robot(file)
    assert str(caught.value).startswith(str(file))
    assert "\n" not in str(caught.value)


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
