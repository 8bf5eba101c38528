import json
import struct
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shown_cell import shown_cell, sway
from tiny_session import tiny_session

from programs.program import Command, MoveTo, Wait
from robotcell.robot.meshes import placed_triangles
from robotcell.robot.robot import Body, Box, Capsule, Mesh, pose
from webui.layers.robot.robot import bodies_glb, joint_motion, joints_at, tool_at


def volume(triangles):
    """Of what closed triangles hold; below 0 if they are seen from inside."""
    first, second, third = np.moveaxis(triangles, 1, 0)
    return float(np.einsum("ij,ij->", first, np.cross(second, third))) / 6


@settings(max_examples=20)
@given(size=st.tuples(*[st.floats(0.01, 2.0)] * 3), turn=st.tuples(*[st.floats(-3.0, 3.0)] * 3))
def test_a_box_is_closed_seen_from_outside_and_holds_what_it_should(size, turn):
    triangles = placed_triangles(Body("box", Box(size), pose((1.0, 2.0, 3.0), turn)))
    assert volume(triangles) == pytest.approx(np.prod(size))
    np.testing.assert_allclose(triangles.reshape(-1, 3).mean(axis=0), (1.0, 2.0, 3.0), atol=1e-9)


@settings(max_examples=20)
@given(radius=st.floats(0.005, 0.3), length=st.floats(0.0, 1.0))
def test_a_capsule_has_its_ends_beyond_its_length_and_nearly_its_volume(radius, length):
    triangles = placed_triangles(Body("rod", Capsule(radius, length), np.eye(4)))
    heights = triangles[:, :, 2]
    assert (heights.min(), heights.max()) == pytest.approx((-length / 2 - radius, length / 2 + radius))
    around = np.linalg.norm(triangles.reshape(-1, 3)[:, :2], axis=1)
    assert around.max() <= radius + 1e-12
    full = np.pi * radius**2 * (length + 4 / 3 * radius)
    assert 0.96 * full < volume(triangles) < full


def test_marked_bodies_have_another_colour():
    bodies = (Body("arm", Box((1, 1, 1)), np.eye(4)), Body("hand", Mesh(np.eye(3)[None]), np.eye(4)))
    plain, marked = (bodies_glb(bodies, (200, 200, 200), names, (180, 0, 0)) for names in ((), ("hand",)))
    assert len(plain) == len(marked)
    assert tints(plain)[0] == tints(marked)[0]
    assert tints(plain)[-1] != tints(marked)[-1]
    assert bodies_glb((), (0, 0, 0)) == b""


def tints(glb):
    """Colour at each corner of a binary glTF."""
    (length,) = struct.unpack("<I", glb[12:16])
    view = json.loads(glb[20 : 20 + length])["bufferViews"][1]
    begin = 20 + length + 8 + view["byteOffset"]
    return np.frombuffer(glb[begin : begin + view["byteLength"]], np.uint8).reshape(-1, 4).tolist()


def move(time_s):
    return MoveTo(time_s, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), 0.0, "")


def test_joints_stand_while_the_program_waits_and_move_between_its_moves():
    program = SimpleNamespace(
        instructions=(
            Command(0.0, "NOZZLE", ("cone", "TOOL", "2"), ""),
            move(0.0),
            move(1.0),
            Wait(1.0, 2.0, ""),
            Command(3.0, "NOZZLE", ("knife", "TOOL", "1"), ""),
            move(4.0),
            Wait(4.0, 1.0, ""),
        )
    )
    motion = joint_motion(program, np.array([[0.0], [1.0], [3.0]]))
    times = np.array([-1.0, 0.0, 0.5, 1.0, 2.0, 3.0, 3.5, 4.0, 9.0])
    assert joints_at(motion, times)[:, 0] == pytest.approx([0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 2.0, 3.0, 3.0])
    assert [tool_at(motion, time_s) for time_s in (-1.0, 0.0, 2.9, 3.0, 9.0)] == [2, 2, 2, 1, 1]


def test_joints_at_the_moves_of_a_real_program_are_those_given():
    cell, program = shown_cell(), tiny_session().run.program
    joints = sway(cell, program)
    motion = joint_motion(program, joints)
    times = np.array([item.time_s for item in program.instructions if isinstance(item, MoveTo)])
    seen = joints_at(motion, times)
    np.testing.assert_allclose(seen, joints, atol=1e-4)
