"""Cells in which bodies can be put anywhere: a chain of three slides and three turns, and an arm in a plane."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation
from small_boards import board_of

from boards.board import Body as BoardBody
from robotcell.cell.cell import Cell, Tool
from robotcell.robot.robot import Joint, Mesh, Robot

BOX_FACES = np.array(
    [[0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2],
     [1, 3, 7], [1, 7, 5]]
)  # fmt: skip
"""Of the corners numbered 4x + 2y + z."""


def at(x=0.0, y=0.0, z=0.0, turn=(0.0, 0.0, 0.0)):
    """A pose: a place, and a rotation vector."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_rotvec(turn).as_matrix()
    pose[:3, 3] = x, y, z
    return pose


def box_triangles(size, middle=(0.0, 0.0, 0.0)):
    """(12, 3, 3) triangles of a box."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    return (corners * size + middle)[BOX_FACES]


def joint(kind, axis, parent=None, reach=10.0):
    """A joint with wide limits."""
    pose = at() if parent is None else parent
    return Joint(f"{kind}", kind, pose, np.array(axis, float), -reach, reach, 1.0, 1.0)


def flyer(bodies=()):
    """x, y, z, then turns about x, y, z: the bodies are on the last link and nothing else is."""
    axes = np.eye(3)
    joints = tuple(joint("prismatic", axis) for axis in axes) + tuple(joint("revolute", axis) for axis in axes)
    return Robot("flyer", joints, at(), ((),) * 6 + (tuple(bodies),))


def flying_poses(q):
    """(n, 4, 4) where the flyer's last link is, by another library than ours."""
    poses = np.tile(np.eye(4), (len(q), 1, 1))
    poses[:, :3, :3] = Rotation.from_euler("XYZ", q[:, 3:]).as_matrix()
    poses[:, :3, 3] = q[:, :3]
    return poses


def scattered(seed, count=60, spread=0.12):
    """Rows of the flyer near the origin, in any orientation."""
    rng = np.random.default_rng(seed)
    return np.hstack([rng.uniform(-spread, spread, (count, 3)), rng.uniform(-np.pi, np.pi, (count, 3))])


def planar_arm(*bodies, lengths=(0.5, 0.4)):
    """Turns about z in the plane z = 0, links along x; bodies[i] are those of link i."""
    joints = tuple(joint("revolute", (0, 0, 1), at(x)) for x in (0.0, *lengths))
    return Robot("planar", joints, at(), bodies)


def cell_of(robot, fixtures=(), tool=(), margin=0.0, home=None, board_at=None):
    """A cell with one tool, number 1, whose TCP is the flange."""
    return Cell(
        "test",
        robot,
        at(),
        at() if board_at is None else board_at,
        np.full(robot.dof, 9.0) if home is None else np.array(home, float),
        (Tool(1, "tool", at(), tuple(tool)),),
        tuple(fixtures),
        margin,
    )


def board_with(**triangles_mm):
    """A board whose bodies are these soups of triangles; ``board`` is the bare board."""
    bodies = tuple(
        BoardBody(name, "board" if name == "board" else "component", soup, np.zeros((len(soup), 3)), ())
        for name, soup in triangles_mm.items()
    )
    return replace(board_of(), bodies=bodies)


def mesh(triangles):
    """A mesh shape."""
    return Mesh(np.asarray(triangles, float))
