"""Parts to be placed as in the Maribor paper: a UR5 above a table, a lance of some length, points of a part.

The tool is a frame without bodies; sizes of the box's chamfers are chosen, the paper gives none.
"""

import numpy as np

from robotcell.cell.cell import Cell, Tool
from robotcell.cell.load import read_cell
from robotcell.cell.robot_library import load_robot
from robotcell.placement.reachability import Targets, jet_frames
from robotcell.robot.robot import Joints, pose

HOME = np.array([0.0, -1.5, 1.5, -1.5, -1.5, 0.0])
LENGTH, WIDTH, HEIGHT = 0.245, 0.11, 0.12
UR5_A2, UR5_A3, UR5_D5 = -0.425, -0.39225, 0.09465


def lance_cell(tool: float, robot: str = "ur5", base: tuple[float, float, float] = (0, 0, 0)) -> Cell:
    lance = Tool(1, "lance", pose((0, 0, tool), (0, 0, 0)), ())
    place = pose((0.5, 0, HEIGHT), (0, 0, 0))
    return Cell("lance", load_robot(robot), pose((0, 0, 0), base), place, HOME, (lance,), (), 0.0)


def as_targets(points: np.ndarray, normals: np.ndarray) -> Targets:
    count = len(points)
    return Targets(jet_frames(points, normals), np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.bool_))


def flat_top(columns: int = 8, rows: int = 5) -> Targets:
    """The top of the paper's part, the jet straight down."""
    x, y = np.meshgrid(np.linspace(0, LENGTH, columns), np.linspace(0, WIDTH, rows))
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    return as_targets(points, np.tile([0.0, 0.0, 1.0], (x.size, 1)))


def chamfered_box(chamfer: float = 0.03, step: float = 0.0125) -> Targets:
    """The top of a box and its four chamfers of 45 degrees."""
    half, points, normals = np.sqrt(0.5), list[np.ndarray](), list[np.ndarray]()
    inner, along, across = np.array([chamfer, chamfer, 0.0]), LENGTH - 2 * chamfer, WIDTH - 2 * chamfer
    faces = [
        (inner, (along, 0, 0), (0, across, 0), (0, 0, 1)),
        (np.array([chamfer, 0, -chamfer]), (along, 0, 0), (0, chamfer, chamfer), (0, -half, half)),
        (np.array([chamfer, WIDTH, -chamfer]), (along, 0, 0), (0, -chamfer, chamfer), (0, half, half)),
        (np.array([0, chamfer, -chamfer]), (0, across, 0), (chamfer, 0, chamfer), (-half, 0, half)),
        (np.array([LENGTH, chamfer, -chamfer]), (0, across, 0), (-chamfer, 0, chamfer), (half, 0, half)),
    ]
    for corner, first, second, normal in faces:
        one, other = (max(int(np.ceil(np.linalg.norm(each) / step)), 1) for each in (first, second))
        for a, b in np.ndindex(one, other):
            points.append(corner + (a + 0.5) / one * np.array(first) + (b + 0.5) / other * np.array(second))
            normals.append(np.array(normal, dtype=np.float64))
    return as_targets(np.array(points), np.array(normals))


def dome(radius: float, count: int, steepest: float) -> Targets:
    """Points of a sphere's cap, spread by the golden angle; ``steepest`` is the normal's largest angle from upright."""
    share = (np.arange(count) + 0.5) / count
    z = 1.0 - share * (1.0 - np.cos(steepest))
    around = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
    flat = np.sqrt(1.0 - z * z)
    normals = np.column_stack([flat * np.cos(around), flat * np.sin(around), z])
    return as_targets(radius * normals - np.array([0, 0, radius]), normals)


def ur5_manipulability(q: Joints) -> np.ndarray:
    """|det J| of the UR5 in closed form, by the checked equation of the paper; (n,) of (n, 6)."""
    _, s3, s5 = np.sin(q[:, 1]), np.sin(q[:, 2]), np.sin(q[:, 4])
    c2, c23 = np.cos(q[:, 1]), np.cos(q[:, 1] + q[:, 2])
    s234 = np.sin(q[:, 1] + q[:, 2] + q[:, 3])
    return np.abs(UR5_A2 * UR5_A3 * s3 * s5 * (UR5_A2 * c2 + UR5_A3 * c23 + UR5_D5 * s234))


def ur5e_bench() -> Cell:
    return read_cell("ur5e-bench").cell
