"""Targets on the surface of a part: points spread over position and normal, the jet along the inward normal."""

import numpy as np

from boards.board import Part
from boards.part.cells import served_cells
from geometry.arrays import Directions, Points
from robotcell.placement.reachability import Targets, thinned
from robotcell.robot.robot import Poses

_MM = 1e-3
_UPRIGHT = 1e-6


def surface_targets(part: Part, standoff_mm: float, most: int, tool: int = 0) -> Targets:
    """Choose targets on the faces of a part that are sprayed, farthest first; each counts for the area around it.

    Args:
        part: The part.
        standoff_mm: From the surface to the orifice, along the normal.
        most: How many targets at most.
        tool: Index into the cell's tools.

    Returns:
        Targets in the part's frame, m; the azimuth about the jet is free.
    """
    cells = served_cells(part).cells
    points, normals = cells.points * _MM, cells.normals
    poses = jet_frames(points + standoff_mm * _MM * normals, normals)
    every = Targets(poses, np.full(len(points), tool), np.ones(len(points), dtype=np.bool_), cells.areas_mm2)
    return thinned(every, most)


def jet_frames(points: Points, normals: Directions) -> Poses:
    """Give frames (n, 4, 4) at points whose +Z is opposite to normals, +X the tangent n x z of Maribor's section 3.1.

    Where the normal is upright that product vanishes; the tangent is the frame's own x then.
    """
    tangent = np.cross(normals, np.array([0.0, 0.0, 1.0]))
    length = np.linalg.norm(tangent, axis=1, keepdims=True)
    flat = length[:, 0] < _UPRIGHT
    tangent = np.where(flat[:, None], np.array([1.0, 0.0, 0.0]), tangent / np.where(flat[:, None], 1.0, length))
    frames = np.tile(np.eye(4), (len(points), 1, 1))
    frames[:, :3, 0], frames[:, :3, 2] = tangent, -normals
    frames[:, :3, 1] = np.cross(-normals, tangent)
    frames[:, :3, 3] = points
    return frames
