"""Collision bodies from their specifications: millimetres and degrees in, metres out."""

from itertools import pairwise
from pathlib import Path
from typing import assert_never

import numpy as np

from geometry.arrays import Triangles
from robotcell.cell.spec import BodySpec, BoxSpec, CapsuleSpec, CylinderSpec, HoseSpec, MeshSpec, Place, Point
from robotcell.errors import CellError, error_at
from robotcell.robot.meshes import STEP_ENDINGS, cylinder_triangles, read_mesh, read_step_solids
from robotcell.robot.robot import Body, Box, Capsule, Mesh, Poses, pose
from specs.yaml.located import Located, YamlPath

_MM = 1e-3


def place_pose(place: Place) -> Poses:
    """Convert a pose as written to (4, 4), metres."""
    return pose([_MM * value for value in place.xyz_mm], np.radians(place.rpy_deg).tolist())


def build_bodies(specs: dict[str, BodySpec], root: Located, path: YamlPath) -> tuple[Body, ...]:
    """Build the bodies of a tool or of the cell's fixtures.

    A hose becomes one rod for each of its pieces, a STEP file one mesh for each of its solids.

    Args:
        specs: By name.
        root: The file they stand in; the path of a mesh begins at the folder of the file that names it.
        path: Where in that file.

    Raises:
        CellError: a mesh cannot be read, or a rod has no length.
    """
    bodies: list[Body] = []
    for name, spec in specs.items():
        match spec:
            case BoxSpec():
                x, y, z = (_MM * value for value in spec.size_mm)
                bodies.append(Body(name, Box((x, y, z)), place_pose(spec.at)))
            case CapsuleSpec():
                length, middle = _along(spec.from_mm, spec.to_mm, root, (*path, name))
                bodies.append(Body(name, Capsule(_MM * spec.radius_mm, length), middle))
            case CylinderSpec():
                length, middle = _along(spec.from_mm, spec.to_mm, root, (*path, name))
                bodies.append(Body(name, Mesh(cylinder_triangles(_MM * spec.radius_mm, length)), middle))
            case HoseSpec():
                for start, end in pairwise(spec.along_mm):
                    length, middle = _along(start, end, root, (*path, name))
                    bodies.append(Body(name, Capsule(_MM * spec.radius_mm, length), middle))
            case MeshSpec():
                solids = _read_solids(spec, root, (*path, name))
                bodies += [Body(name, Mesh(triangles), place_pose(spec.at)) for triangles in solids]
            case _:
                assert_never(spec)
    return tuple(bodies)


def _read_solids(spec: MeshSpec, root: Located, path: YamlPath) -> tuple[Triangles, ...]:
    """Read the triangles (n, 3, 3) of each solid that a file has: one but for STEP, metres."""
    file = Path(root.at((*path, "file")).mark.file).parent / spec.file
    try:
        if file.suffix.lower() not in STEP_ENDINGS:
            return (_MM * spec.mm_per_unit * read_mesh(file),)
        if spec.mm_per_unit != 1.0:
            raise error_at(root, (*path, "mm_per_unit"), "a STEP file states its unit; leave it out")
        return read_step_solids(file)
    except CellError as error:
        if error.path:
            raise
        raise error_at(root, (*path, "file"), str(error)) from None


def _along(start_mm: Point, end_mm: Point, root: Located, path: YamlPath) -> tuple[float, Poses]:
    """Give the length of a rod and the (4, 4) pose of its middle, z along it; its x is level with the x-y plane."""
    start, end = np.array(start_mm), np.array(end_mm)
    length = float(np.linalg.norm(end - start))
    if length < 1e-6:
        raise error_at(root, path, "begins where it ends; a rod has a length")
    x, y, z = (end - start) / length
    pitch, yaw = float(np.arctan2(np.hypot(x, y), z)), float(np.arctan2(y, x))
    return _MM * length, pose((0.5 * _MM * (start + end)).tolist(), (0.0, pitch, yaw))
