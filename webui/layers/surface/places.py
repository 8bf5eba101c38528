"""What of a workpiece can be chosen: components of a board, faces of a part; where each is looked at and named."""

from dataclasses import dataclass

import numpy as np

from boards.board import Board, Body, Component, Face, Part, Workpiece
from geometry.arrays import Points

NEAREST_MM = 15.0
"""Half width of the closest view: smaller ones are shown with their neighbours."""
_ROOM = 3.0
"""Width of the view of a component, as a multiple of its size."""
_OVER_MM = 2.0
_FROM_ABOVE = 0.45
"""Of the view of an upright face: how far the eye is raised, so that what it stands on is seen too."""


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """A component or a face: the box in which it is looked at, from where, and the point of its name. mm."""

    name: str
    low: Points
    """(3,)"""
    high: Points
    """(3,)"""
    towards: Points
    """(3,) from the box to the eye, of any length."""
    label: Points
    """(3,)"""


def place_names(workpiece: Workpiece) -> tuple[str, ...]:
    """Names of what can be chosen, in the order of the file."""
    match workpiece:
        case Board():
            return tuple(component.name for component in workpiece.components)
        case Part():
            return tuple(face.name for face in workpiece.faces)


def find_place(workpiece: Workpiece, name: str) -> Place | None:
    """The component or face of a name, if there is one."""
    match workpiece:
        case Board():
            component = next((each for each in workpiece.components if each.name == name), None)
            return None if component is None else _of_component(workpiece, component)
        case Part():
            face = next((each for each in workpiece.faces if each.name == name), None)
            return None if face is None else _of_face(workpiece, face)


def pickable_bodies(workpiece: Workpiece) -> tuple[Body, ...]:
    """Bodies that a click meets: those of the file; of a part each face is one by itself."""
    match workpiece:
        case Board():
            return workpiece.bodies
        case Part():
            patches, normals = workpiece.patches, workpiece.normals
            faces = [
                Body(face.name, "part", patches[face.patches], normals[face.patches], ()) for face in workpiece.faces
            ]
            return (*faces, *(body for body in workpiece.bodies if body.role == "fixture"))


def _of_component(board: Board, component: Component) -> Place:
    x_min, y_min, x_max, y_max = component.outline.bounds
    surface, sign = board.surface_z_mm(component.side), 1.0 if component.side == "top" else -1.0
    middle = np.array([(x_min + x_max) / 2, (y_min + y_max) / 2, surface])
    around = max(NEAREST_MM, _ROOM * max(x_max - x_min, y_max - y_min) / 2, component.height_mm)
    half = np.array([around, around, 0.0])
    centre = component.outline.centroid
    label = np.array([centre.x, centre.y, surface + sign * (component.height_mm + _OVER_MM)])
    return Place(component.name, middle - half, middle + half, np.array([0.0, -0.62, 0.785 * sign]), label)


def _of_face(part: Part, face: Face) -> Place:
    corners = part.patches[face.patches].reshape(-1, 3)
    low, high = corners.min(axis=0), corners.max(axis=0)
    normal = np.array(face.normal)
    middle = (low + high) / 2
    half = np.maximum((high - low) / 2, NEAREST_MM) + NEAREST_MM
    upright = np.sqrt(max(0.0, 1.0 - float(normal[2]) ** 2))
    towards = normal + np.array([0.0, -0.3 * (1.0 - upright), _FROM_ABOVE * upright])
    return Place(face.name, middle - half, middle + half, towards, middle + _OVER_MM * normal)
