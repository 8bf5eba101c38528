"""Robots from tables of Denavit-Hartenberg parameters stand where the tables' own products put them."""

import numpy as np
import pytest
from small_cells import CELL

from robotcell.cell.load import read_cell_text
from robotcell.cell.robot_library import load_robot
from robotcell.errors import CellError
from robotcell.robot.denavit_hartenberg import DhRow, build_dh_robot
from robotcell.robot.robot import Capsule, flange_poses, link_poses, pose

UR5E = """robot:
  dh:
    name: my-arm
    convention: standard
    table:
      - {name: pan, alpha_deg: 90, d_mm: 162.5, radius_mm: 60}
      - {name: lift, a_mm: -425, radius_mm: 55}
      - {name: elbow, a_mm: -392.2, radius_mm: 45}
      - {name: wrist_1, alpha_deg: 90, d_mm: 133.3, radius_mm: 40}
      - {name: wrist_2, alpha_deg: -90, d_mm: 99.7, radius_mm: 40}
      - {name: wrist_3, d_mm: 99.6, radius_mm: 35}
  joints:
    all: {position_deg: [-360, 360], speed_deg_s: 180, acceleration_deg_s2: 800}
"""
TEXT = CELL.replace("robot: ur5e\n", UR5E)
ROWS = [(0.3, 0.4, 0.05, -1.2), (-0.2, 0.0, 0.3, 0.4), (1.0, -0.1, 0.2, 2.0)]
"""theta, d, a, alpha"""


def turn(axis: str, angle: float) -> np.ndarray:
    return pose((0, 0, 0), (angle, 0, 0) if axis == "x" else (0, 0, angle))


def way(axis: str, length: float) -> np.ndarray:
    return pose((length, 0, 0) if axis == "x" else (0, 0, length), (0, 0, 0))


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_steps_are_the_products_of_the_convention(convention: str) -> None:
    rows = [DhRow(f"j{at}", "prismatic" if at == 1 else "revolute", *row, 0.04) for at, row in enumerate(ROWS)]
    flange = pose((0.01, 0.02, 0.03), (0.1, 0.2, 0.3))
    robot = build_dh_robot("three", "modified" if convention == "modified" else "standard", rows, flange)
    for q in np.random.default_rng(7).uniform(-1, 1, (10, 3)):
        expected = np.eye(4)
        for row, value in zip(rows, q, strict=True):
            slides = row.kind == "prismatic"
            about = turn("z", row.theta + (0.0 if slides else value)) @ way("z", row.d + (value if slides else 0.0))
            across = way("x", row.a) @ turn("x", row.alpha)
            expected = expected @ (about @ across if convention == "standard" else across @ about)
        np.testing.assert_allclose(flange_poses(robot, q[None])[0], expected @ flange, atol=1e-12)


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_rods_lead_from_the_base_to_the_flange_whatever_the_joints(convention: str) -> None:
    rows = [DhRow(f"j{at}", "revolute", *row, 0.04) for at, row in enumerate(ROWS)]
    flange = pose((0.0, 0.0, 0.1), (0.0, 0.0, 0.0))
    robot = build_dh_robot("three", "modified" if convention == "modified" else "standard", rows, flange)
    for q in np.random.default_rng(8).uniform(-3, 3, (5, 3)):
        links, at = link_poses(robot, q[None])[0], np.zeros(3)
        for link, bodies in enumerate(robot.bodies):
            for body in bodies:
                assert isinstance(body.shape, Capsule)
                middle, half = links[link] @ body.T_carrier_shape, 0.5 * body.shape.length
                ends = [middle[:3, 3] + sign * half * middle[:3, 2] for sign in (-1.0, 1.0)]
                near = np.linalg.norm(np.array(ends) - at, axis=1)
                assert near.min() < 1e-9
                at = ends[int(np.argmax(near))]
        np.testing.assert_allclose(at, flange_poses(robot, q[None])[0, :3, 3], atol=1e-9)


def test_a_cell_has_a_robot_by_its_table() -> None:
    robot, library = read_cell_text(TEXT).cell.robot, load_robot("ur5e")
    assert (robot.name, [joint.name for joint in robot.joints][:2]) == ("my-arm", ["pan", "lift"])
    q = np.random.default_rng(9).uniform(-3, 3, (20, 6))
    np.testing.assert_allclose(flange_poses(robot, q), flange_poses(library, q), atol=1e-9)


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("position_deg: [-360, 360], ", "", "a table has no limits: state position_deg of pan"),
        ("speed_deg_s: 180, ", "", "state speed_deg_s of pan"),
        (", acceleration_deg_s2: 800", "", "joint pan needs a greatest acceleration"),
        ("name: lift", "name: pan", "robot.dh.table[1].name: pan is a joint above already"),
        ("  dh:\n", "  urdf: a.urdf\n  dh:\n", "give exactly one of urdf, dh"),
        ("  joints:\n", "  base_link: a\n  joints:\n", "base_link and flange_link go with urdf"),
        ("convention: standard", "convention: craig", "convention"),
    ],
)
def test_what_a_table_lacks_is_named(before: str, after: str, words: str) -> None:
    assert TEXT.count(before) == 1
    with pytest.raises(CellError) as caught:
        read_cell_text(TEXT.replace(before, after))
    assert words in str(caught.value)
