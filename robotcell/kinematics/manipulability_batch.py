"""How far joints are from a singular posture, in bulk: the w of ``singularity`` compiled, for many postures."""

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Scalars
from geometry.coverage.compiled import compiled
from robotcell.kinematics.chain import add_step, step_over
from robotcell.robot.robot import Joints, Poses


@compiled
def manipulability(steps: Poses, turns: NDArray[np.bool_], q: Joints) -> Scalars:
    """Give |det J| (m,) of six-axis postures (m, 6); it does not depend on where the tool's tip is.

    Yoshikawa, "Manipulability of robotic mechanisms" (1985), for a square Jacobian.
    """
    dof = len(turns)
    result = np.empty(len(q))
    pose, moved = np.eye(4), np.empty((3, 4))
    axes, places, jacobian = np.empty((dof, 3)), np.empty((dof, 3)), np.empty((6, dof))
    for row in range(len(q)):
        pose[:] = steps[0]
        for joint in range(dof):
            axes[joint], places[joint] = pose[:3, 2], pose[:3, 3]
            step_over(pose, turns[joint], q[row, joint])
            add_step(pose, steps[joint + 1], moved)
        for joint in range(dof):
            x, y, z = axes[joint]
            if turns[joint]:
                a, b, c = pose[:3, 3] - places[joint]
                jacobian[0, joint], jacobian[1, joint], jacobian[2, joint] = y * c - z * b, z * a - x * c, x * b - y * a
                jacobian[3:, joint] = axes[joint]
            else:
                jacobian[:3, joint] = axes[joint]
                jacobian[3:, joint] = 0.0
        result[row] = abs(np.linalg.det(jacobian))
    return result
