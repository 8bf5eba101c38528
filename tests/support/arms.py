"""Arms to try kinematics with, and what judges them: a search from many places that knows no closed form."""

from functools import cache

import numpy as np
from numpy.typing import NDArray

from robotcell.cell.robot_library import load_robot, robot_library
from robotcell.robot.robot import Joint, Joints, Poses, Robot, flange_poses, jacobians

LIBRARY = list(robot_library())
QUARTER = np.pi / 2
UR5 = (
    (QUARTER, 0, 0.089159),
    (0, -0.425, 0),
    (0, -0.39225, 0),
    (QUARTER, 0, 0.10915),
    (-QUARTER, 0, 0.09465),
    (0, 0, 0.0823),
)


@cache
def library_robot(name: str) -> Robot:
    """Read a robot of the library."""
    return load_robot(name)


def dh_arm(name: str, *rows: tuple[float, float, float]) -> Robot:
    """Build an arm from (alpha, a, d), all joints turning twice either way."""
    joints: list[Joint] = []
    before = np.eye(4)
    for number, (alpha, a, d) in enumerate(rows, 1):
        joints.append(
            Joint(f"joint_{number}", "revolute", before, np.array([0.0, 0.0, 1.0]), -2 * np.pi, 2 * np.pi, 3.0, 10.0)
        )
        c, s = np.cos(alpha), np.sin(alpha)
        before = np.array([[1, 0, 0, a], [0, c, -s, 0], [0, s, c, d], [0, 0, 0, 1.0]])
    return Robot(name, tuple(joints), before, ((),) * (len(rows) + 1))


def cairo(a2: float, a3: float, a4: float) -> Robot:
    """The arm of the Cairo paper, with d1 = 0.3 m and d6 = 0.1 m."""
    return dh_arm("cairo", (-QUARTER, 0, 0.3), (0, a2, 0), (0, a3, 0), (QUARTER, a4, 0), (-QUARTER, 0, 0), (0, 0, 0.1))


def random_rows(robot: Robot, count: int, seed: int) -> Joints:
    """Rows anywhere within a turn, straight joints within their limits."""
    rng = np.random.default_rng(seed)
    turns = [joint.kind == "revolute" for joint in robot.joints]
    low = np.where(turns, -np.pi, [joint.lowest for joint in robot.joints])
    high = np.where(turns, np.pi, [joint.highest for joint in robot.joints])
    return rng.uniform(low, high, (count, robot.dof))


def apart(robot: Robot, one: Joints, other: Joints) -> NDArray[np.float64]:
    """The greatest difference of any joint, whole turns aside; NaN rows are infinitely far."""
    away = np.abs(one - other)
    turns = [joint.kind == "revolute" for joint in robot.joints]
    away = np.where(turns, np.abs((away + np.pi) % (2 * np.pi) - np.pi), away)
    return np.nan_to_num(np.max(away, axis=-1), nan=np.inf)


def miss(one: Poses, other: Poses) -> NDArray[np.float64]:
    """Metres and radians between poses, whichever is greater."""
    along = np.linalg.norm(one[..., :3, 3] - other[..., :3, 3], axis=-1)
    chord = np.linalg.norm(one[..., :3, :3] - other[..., :3, :3], axis=(-2, -1)) / np.sqrt(8.0)
    return np.maximum(along, 2.0 * np.arcsin(np.minimum(chord, 1.0)))


def nudged(poses: Poses, by: float, seed: int) -> Poses:
    """Poses moved and turned by no more than so much about each axis, in m and rad."""
    rng = np.random.default_rng(seed)
    moved = np.tile(np.eye(4), (len(poses), 1, 1))
    moved[:, :3, 3] = rng.uniform(-by, by, (len(poses), 3))
    x, y, z = rng.uniform(-by, by, (3, len(poses)))
    still = np.zeros(len(poses))
    small = np.array([[still, -z, y], [z, still, -x], [-y, x, still]]).transpose(2, 0, 1)
    moved[:, :3, :3] += small + small @ small / 2.0
    moved[:, :3, :3] = np.linalg.qr(moved[:, :3, :3])[0] * -1.0
    moved[:, :3, :3] *= np.sign(np.einsum("nii->ni", moved[:, :3, :3]))[:, None, :]
    return poses @ moved


def search(robot: Robot, pose: Poses, starts: int, seed: int) -> Joints:
    """Newton's steps from many places, damped; give what they find for one pose (4, 4), each configuration once."""
    q = random_rows(robot, starts, seed)
    for _ in range(40):
        here = flange_poses(robot, q)
        wanted = np.empty((starts, 6))
        wanted[:, :3] = pose[:3, 3] - here[:, :3, 3]
        wanted[:, 3:] = np.sum(np.cross(here[:, :3, :3], pose[None, :3, :3], axis=1), axis=2) / 2.0
        slopes = jacobians(robot, q)
        square = np.swapaxes(slopes, 1, 2) @ slopes + 1e-6 * np.eye(robot.dof)
        step = np.linalg.solve(square, np.swapaxes(slopes, 1, 2) @ wanted[..., None])[..., 0]
        q += step * np.minimum(1.0, 0.7 / np.max(np.abs(step), axis=1, initial=1e-9))[:, None]
    q = q[miss(flange_poses(robot, q), pose) < 1e-8]
    found: list[Joints] = []
    for row in q:
        if not found or np.min(apart(robot, np.array(found), row)) > 1e-4:
            found.append(row)
    return np.array(found).reshape(-1, robot.dof)
