"""A URDF is read as the chain that it describes, or refused with its line."""

import io
import re
from pathlib import Path

import numpy as np
import pytest
import trimesh
import yourdfpy
from small_cells import JOINTS, LINKS, urdf

from robotcell.cell.robot_library import robot_library
from robotcell.errors import CellError
from robotcell.robot.robot import Box, Capsule, Mesh, flange_poses, link_poses
from robotcell.robot.urdf import read_urdf


def write(folder: Path, text: str) -> Path:
    file = folder / "robot.urdf"
    file.write_text(text, "utf-8")
    return file


def fixed(name: str, parent: str, child: str, origin: str = 'xyz="0 0 0"') -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="fixed">{ends}<origin {origin}/></joint>'


def collision(shape: str, origin: str = "", name: str = "") -> str:
    place = f"<origin {origin}/>" if origin else ""
    return f"<collision {name}>{place}<geometry>{shape}</geometry></collision>"


def test_a_chain_of_a_sliding_and_a_turning_joint(tmp_path: Path) -> None:
    robot = read_urdf(write(tmp_path, urdf()))
    slide, turn = robot.joints
    assert (robot.name, slide.kind, turn.kind) == ("two", "prismatic", "revolute")
    assert (slide.lowest, slide.highest, slide.speed, turn.speed) == (-0.1, 0.2, 0.5, 2.0)
    np.testing.assert_allclose(turn.axis, [0, 0, 1])
    (pose,) = flange_poses(robot, np.array([[0.1, 0.25]]))
    np.testing.assert_allclose(pose[:3, 3], [0.3, 0, 0.6])
    np.testing.assert_allclose(np.arctan2(pose[1, 0], pose[0, 0]), 0.75)


@pytest.mark.parametrize("name", robot_library())
def test_the_librarys_robots_move_as_another_reader_says(name: str) -> None:
    file = robot_library()[name].with_suffix(".urdf")
    robot = read_urdf(file)
    known = io.BytesIO(file.read_bytes().replace(b"<capsule", b"<cylinder"))  # it has no capsules yet
    other = yourdfpy.URDF.load(known, load_meshes=False, load_collision_meshes=False)
    highest = np.minimum([joint.highest for joint in robot.joints], 2 * np.pi)
    for q in np.random.default_rng(1).uniform(-1, 1, (20, robot.dof)) * highest:
        other.update_cfg(dict(zip([joint.name for joint in robot.joints], q, strict=True)))
        np.testing.assert_allclose(flange_poses(robot, q[None])[0], other.get_transform("flange", "base"), atol=1e-12)


def test_fixed_joints_are_folded_and_the_base_may_hang_on_the_root(tmp_path: Path) -> None:
    plain = read_urdf(write(tmp_path, urdf()))
    links = LINKS + '<link name="world"/><link name="mark"/><link name="tip"/>'
    joints = (
        JOINTS
        + fixed("a", "world", "foot", 'xyz="1 2 3" rpy="0 0 1"')
        + fixed("b", "world", "mark", 'xyz="1 2 3" rpy="0 0 1"')
        + fixed("c", "hand", "tip", 'xyz="0 0 0.1"')
    )
    folded = read_urdf(write(tmp_path, urdf(links, joints)), base_link="mark", flange_link="tip")
    q = np.array([[0.05, -0.4]])
    np.testing.assert_allclose(link_poses(folded, q), link_poses(plain, q), atol=1e-15)
    np.testing.assert_allclose(flange_poses(folded, q)[0, 2, 3], flange_poses(plain, q)[0, 2, 3] + 0.1)


def test_what_can_collide_is_carried_by_the_link_that_moves_it(tmp_path: Path) -> None:
    trimesh.creation.box((2.0, 4.0, 6.0)).export(tmp_path / "block.stl")
    shapes = {
        "foot": collision('<box size="1 2 3"/>'),
        "slide": collision('<cylinder radius="1" length="2"/>', 'xyz="0 0 1"', 'name="rail"')
        + collision('<sphere radius="0.5"/>'),
        "hand": collision('<mesh filename="package://two/block.stl" scale="0.1 0.1 0.1"/>'),
    }
    links = "".join(f'<link name="{name}">{shape}</link>' for name, shape in shapes.items())
    robot = read_urdf(write(tmp_path, urdf(links)))
    (foot,), (rail, ball), (block,) = robot.bodies
    assert [body.name for body in (foot, rail, ball, block)] == ["foot", "rail", "slide", "hand"]
    assert isinstance(foot.shape, Box)
    assert foot.shape.size == (1, 2, 3)
    assert isinstance(ball.shape, Capsule)
    assert (ball.shape.radius, ball.shape.length) == (0.5, 0)
    assert isinstance(rail.shape, Mesh)
    assert trimesh.Trimesh(**trimesh.triangles.to_kwargs(rail.shape.triangles)).volume == pytest.approx(
        2 * np.pi, rel=0.01
    )
    assert np.linalg.norm(rail.shape.triangles[..., :2], axis=-1).max() >= 1.0
    assert rail.T_carrier_shape[2, 3] == 1
    assert isinstance(block.shape, Mesh)
    np.testing.assert_allclose(np.ptp(block.shape.triangles, axis=(0, 1)), [0.2, 0.4, 0.6])


def test_a_capsules_length_is_that_between_the_centres_of_its_ends(tmp_path: Path) -> None:
    foot = '<link name="foot">' + collision('<capsule radius="0.2" length="0.5"/>', 'xyz="0 0 1"') + "</link>"
    ((rod,), *_) = read_urdf(write(tmp_path, urdf(foot + LINKS.replace('<link name="foot"/>', "")))).bodies
    assert isinstance(rod.shape, Capsule)
    assert (rod.shape.radius, rod.shape.length) == (0.2, 0.5)
    assert rod.T_carrier_shape[2, 3] == 1


def test_a_cylinder_is_never_thinner_than_it_is(tmp_path: Path) -> None:
    foot = '<link name="foot">' + collision('<cylinder radius="2" length="3"/>') + "</link>"
    links = LINKS.replace('<link name="foot"/>', foot)
    (body,) = read_urdf(write(tmp_path, urdf(links))).bodies[0]
    assert isinstance(body.shape, Mesh)
    prism = trimesh.Trimesh(**trimesh.triangles.to_kwargs(body.shape.triangles))
    angle = np.linspace(0, 7, 500)
    rim = np.column_stack([1.9999 * np.cos(angle), 1.9999 * np.sin(angle), np.full(500, 1.4999)])
    assert prism.is_watertight
    assert np.all(
        prism.triangles_cross[:, :] @ rim.T
        <= np.einsum("ij,ij->i", prism.triangles_cross, prism.triangles[:, 0])[:, None] + 1e-9
    )


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("<robot", "<!DOCTYPE a [<!ENTITY b 'c'>]><robot", "DOCTYPE"),
        ("</robot>", "", "not valid XML"),
        ("<robot", "<machine", "not valid XML"),
        ('velocity="0.5"', "", "has no velocity"),
        ('velocity="0.5"', 'velocity="fast"', "takes 1 finite number"),
        ('velocity="0.5"', 'velocity="0"', "the greatest speed is above 0"),
        ('upper="0.2"', 'upper="-0.1"', "not below upper"),
        ('axis xyz="0 0 1"', 'axis xyz="0 0 0"', "an axis without direction"),
        ('axis xyz="0 0 1"', 'axis xyz="0 nan 1"', "takes 3 finite numbers"),
        (
            'axis xyz="0 0 1"',
            'axis xyz="0 1e308 0"',
            "xyz='0 1e308 0'; it takes 3 finite numbers from -1,000,000 to 1,000,000",
        ),
        ('axis xyz="0 0 1"', 'axis xyz="0 0 1e999"', "takes 3 finite numbers"),
        ('xyz="0 0 0.5"', 'xyz="0 1e30 0.5"', "takes 3 finite numbers from -100 to 100"),
        ('xyz="0 0 0.5"', 'xyz="0 0 0.5" rpy="0 1e9 0"', "rpy='0 1e9 0'; it takes 3 finite numbers"),
        ('lower="-0.1"', 'lower="-1e300"', "lower='-1e300'; it takes 1 finite number from"),
        ('velocity="0.5"', 'velocity="1e300"', "velocity='1e300'; it takes 1 finite number from"),
        ('<parent link="foot"/>', '<parent link="feet"/>', "'feet' that is not there"),
        ('<parent link="foot"/>', "", "has no <parent>"),
        ('<link name="hand"/>', '<link name="hand"/><link name="hand"/>', "2 links named 'hand'"),
        ('<parent link="foot"/>', '<parent link="hand"/>', "circle"),
        ('<link name="hand"/>', '<link name="hand"/><link name="lost"/>', "exactly one root link"),
        ('<limit lower="-1"', '<mimic joint="S"/><limit lower="-1"', "mimics"),
        ('type="revolute"', 'type="floating"', "is not moved"),
    ],
)
def test_what_is_broken_is_refused_with_its_line(tmp_path: Path, before: str, after: str, message: str) -> None:
    assert before in urdf()
    text = urdf().replace(before, after, 1)
    if after == 'type="floating"':
        text = text.replace('type="prismatic"', after)
    with pytest.raises(CellError, match=re.escape(message)) as caught:
        read_urdf(write(tmp_path, text))
    assert re.match(rf"{re.escape(str(tmp_path))}/robot\.urdf:\d+: ", str(caught.value))


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        ('<box size="1 2 1e200"/>', "takes 3 finite numbers from -100 to 100"),
        ('<sphere radius="1e200"/>', "takes 1 finite number from -100 to 100"),
        ('<mesh filename="block.stl" scale="1 1 1e300"/>', "takes 3 finite numbers"),
        ('<mesh filename="block.stl" scale="1 1 1000"/>', "reaches farther than 100 m"),
    ],
)
def test_sizes_beyond_any_robot_are_refused_before_they_are_computed_with(
    tmp_path: Path, shape: str, message: str
) -> None:
    trimesh.creation.box((2.0, 4.0, 6.0)).export(tmp_path / "block.stl")
    text = urdf().replace('<link name="foot"/>', f'<link name="foot">{collision(shape)}</link>')
    with pytest.raises(CellError, match=re.escape(message)):
        read_urdf(write(tmp_path, text))


def test_a_xacro_is_refused_with_the_commands_that_expand_it(tmp_path: Path) -> None:
    file = tmp_path / "arm.urdf.xacro"
    macro = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="a"/>\n<xacro:arm prefix="b"/></robot>'
    file.write_text(macro, "utf-8")
    with pytest.raises(CellError) as caught:
        read_urdf(file)
    assert str(caught.value) == (
        f"{file}:2: <xacro:arm> is xacro, from which a URDF is made first: `xacro arm.urdf.xacro -o arm.urdf` of ROS, "
        "or `pipx run xacrodoc arm.urdf.xacro -o arm.urdf` without it; then name arm.urdf"
    )


def test_several_ends_have_to_be_told_apart(tmp_path: Path) -> None:
    links = LINKS + '<link name="a"/><link name="b"/>'
    text = urdf(links, JOINTS + fixed("f", "hand", "a") + fixed("g", "hand", "b"))
    with pytest.raises(CellError, match="state flange_link, one of a, b"):
        read_urdf(write(tmp_path, text))
    assert read_urdf(write(tmp_path, text), flange_link="b").dof == 2
    with pytest.raises(CellError, match="has no link 'c'"):
        read_urdf(write(tmp_path, text), flange_link="c")
    with pytest.raises(CellError, match="a base stands still"):
        read_urdf(write(tmp_path, text), base_link="slide", flange_link="b")


@pytest.mark.parametrize(
    ("filename", "message"),
    [
        ("missing.stl", "not there"),
        ("../outside.stl", "outside the URDF's folder"),
        ("/etc/hostname", "give a path from the URDF's folder"),
        ("http://example.org/a.stl", "give a path from the URDF's folder"),
        ("robot.urdf", "a mesh is read from"),
        ("empty.stl", "is not an STL file"),
    ],
)
def test_meshes_stay_in_the_folder_and_are_meshes(tmp_path: Path, filename: str, message: str) -> None:
    folder = tmp_path / "inside"
    folder.mkdir()
    trimesh.creation.box().export(tmp_path / "outside.stl")
    (folder / "empty.stl").write_bytes(b"")
    shape = f'<link name="foot"><collision><geometry><mesh filename="{filename}"/></geometry></collision></link>'
    with pytest.raises(CellError, match=message):
        read_urdf(write(folder, urdf(LINKS.replace('<link name="foot"/>', shape))))


def test_files_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(CellError, match="no such file"):
        read_urdf(tmp_path / "none.urdf")
    with pytest.raises(CellError, match="is a directory"):
        read_urdf(tmp_path)
    with pytest.raises(CellError, match="deep"):
        read_urdf(write(tmp_path, "<robot>" + "<a>" * 200 + "</a>" * 200 + "</robot>"))


@pytest.mark.parametrize("encoding", ["x", "utf-7", "shift_jis", "rot13", "idna", "\u00e9"])
def test_encodings_that_are_not_read_are_refused(encoding: str, tmp_path: Path) -> None:
    file = tmp_path / "a.urdf"
    file.write_text(f'<?xml version="1.0" encoding="{encoding}"?><robot name="a"/>', "utf-8")
    with pytest.raises(CellError, match=r"a\.urdf:1: "):
        read_urdf(file)
