"""How far a robot is from losing a direction of motion. Metres, radians."""

import numpy as np
from numpy.typing import NDArray

from robotcell.robot.robot import Joints, Poses, Robot, jacobians

CHARACTERISTIC_LENGTH = 0.25
"""m that count as much as a radian in the inverse condition: about the size of a board.

One length for all robots, so that they can be compared at the same work."""


def singularity(
    robot: Robot,
    q: Joints,
    T_flange_tcp: Poses | None = None,
    *,
    length: float = CHARACTERISTIC_LENGTH,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Measure how well a point of the flange can be moved in every direction.

    Args:
        robot: The robot.
        q: (n, dof) joint rows.
        T_flange_tcp: (4, 4) the point; the flange's own origin if left out.
        length: m, the characteristic length of the inverse condition.

    Returns:
        w (n,), Yoshikawa's manipulability sqrt(det(J J^T)) in m and rad, for five axes sqrt(det(J^T J)); with six axes
        it does not depend on the point. And the inverse condition (n,), between 0 where singular and 1 where all
        directions are alike, of the Jacobian with lengths divided by the characteristic length.
    """
    slopes = jacobians(robot, q, T_flange_tcp)
    if robot.dof == 6:
        w = np.abs(np.linalg.det(slopes))
    else:
        w = np.sqrt(np.maximum(0.0, np.linalg.det(np.swapaxes(slopes, 1, 2) @ slopes)))
    even = slopes.copy()
    even[:, :3] /= length
    even[:, :, [joint.kind == "prismatic" for joint in robot.joints]] *= length
    sizes = np.linalg.svd(even, compute_uv=False)
    return w, sizes[:, -1] / sizes[:, 0]
