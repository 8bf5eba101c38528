"""Robots from tables of Denavit-Hartenberg parameters stand where the tables' own products put them."""

import numpy as np
import pytest
from small_cells import CELL

from robotcell.cell.cell import place_pose
from robotcell.cell.load import read_cell_text
from robotcell.cell.robot_library import build_dh_robot, load_robot
from robotcell.cell.spec import DhSpec, Place
from robotcell.errors import CellError
from robotcell.robot.robot import Capsule, Robot, flange_poses, link_poses, pose

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


def three_joints(convention: str, flange: Place, slides: int = -1) -> Robot:
    """A robot of the table above; one joint may slide."""
    table = [
        {"name": f"j{at}", "kind": "prismatic" if at == slides else "revolute", "radius_mm": 40, "d_mm": 1e3 * d,
         "a_mm": 1e3 * a, "theta_deg": np.degrees(theta), "alpha_deg": np.degrees(alpha)}
        for at, (theta, d, a, alpha) in enumerate(ROWS)
    ]  # fmt: skip
    return build_dh_robot(DhSpec.model_validate({"convention": convention, "table": table, "flange": flange}))


def way(axis: str, length: float) -> np.ndarray:
    return pose((length, 0, 0) if axis == "x" else (0, 0, length), (0, 0, 0))


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_steps_are_the_products_of_the_convention(convention: str) -> None:
    place = Place(xyz_mm=(10, 20, 30), rpy_deg=(5, 10, 15))
    robot, flange = three_joints(convention, place, slides=1), place_pose(place)
    for q in np.random.default_rng(7).uniform(-1, 1, (10, 3)):
        expected = np.eye(4)
        for joint, (theta, d, a, alpha), value in zip(robot.joints, ROWS, q, strict=True):
            slides = joint.kind == "prismatic"
            about = turn("z", theta + (0.0 if slides else value)) @ way("z", d + (value if slides else 0.0))
            across = way("x", a) @ turn("x", alpha)
            expected = expected @ (about @ across if convention == "standard" else across @ about)
        np.testing.assert_allclose(flange_poses(robot, q[None])[0], expected @ flange, atol=1e-12)


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_rods_lead_from_the_base_to_the_flange_whatever_the_joints(convention: str) -> None:
    robot = three_joints(convention, Place(xyz_mm=(0, 0, 100)))
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
