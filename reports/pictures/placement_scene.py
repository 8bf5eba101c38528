"""A placement as a scene in binary glTF: cell, robot, workpiece, points and map. Metres, y up, as glTF has it."""

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from boards.board import Workpiece
from geometry.arrays import Points, Scalars, Triangles
from reports.pictures.placement_picture import COLOURS
from robotcell.placement.configurations import PlacementDetails
from robotcell.placement.placement_map import PlacementMap
from robotcell.robot.robot import Body, Poses, link_poses
from robotcell.robot.triangles import placed_triangles

_M_PER_MM = 1e-3
_Y_UP = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
_GREY, _ROBOT, _TOOL, _PART = (176, 182, 186), (120, 132, 140), (60, 70, 78), (205, 214, 200)
_ACCENT = (200, 68, 44)
_POINT_M, _WORST_M = 3e-3, 8e-3
_MOST_TRIANGLES = 50_000
"""Of the workpiece, and of the robot: beyond that bodies are drawn as boxes around them."""
_OCTAHEDRON = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=np.float64)
_FACES = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])


Colour: TypeAlias = tuple[int, int, int]
Colours: TypeAlias = NDArray[np.uint8]
"""(n, 4) red, green, blue, opacity."""


class Drawn(NamedTuple):
    """A mesh of the scene."""

    name: str
    triangles: Triangles
    """(n, 3, 3) in the cell's frame, m."""
    colour: Colour | Colours
    """Of all, or of each triangle."""


def placement_glb(details: PlacementDetails, workpiece: Workpiece | None, mapped: PlacementMap | None) -> bytes:
    """Write the scene, the robot at the worst point; the same placement gives the same bytes."""
    from trimesh import Scene
    from trimesh.exchange.gltf import export_glb

    scene = Scene(base_frame="cell")
    for each in scene_meshes(details, workpiece, mapped):
        scene.add_geometry(_mesh(each), node_name=each.name, geom_name=each.name)
    scene.apply_transform(_Y_UP)
    return export_glb(scene)


def _mesh(drawn: Drawn) -> Any:
    """A mesh of trimesh: of one colour corners are shared, of several each triangle has its own."""
    from trimesh import Trimesh
    from trimesh.visual import ColorVisuals, TextureVisuals
    from trimesh.visual.material import PBRMaterial

    corners = drawn.triangles.reshape(-1, 3)
    if isinstance(drawn.colour, tuple):
        material = PBRMaterial(metallicFactor=0.0, roughnessFactor=0.9, doubleSided=True)
        material.baseColorFactor = np.array([*drawn.colour, 255], dtype=np.uint8)
        kept, index = np.unique(np.round(corners, 6), axis=0, return_inverse=True)
        return Trimesh(kept, index.reshape(-1, 3), visual=TextureVisuals(material=material), process=False)
    index = np.arange(len(corners)).reshape(-1, 3)
    return Trimesh(corners, index, visual=ColorVisuals(vertex_colors=np.repeat(drawn.colour, 3, axis=0)), process=False)


def scene_meshes(details: PlacementDetails, workpiece: Workpiece | None, mapped: PlacementMap | None) -> list[Drawn]:
    """Give what is drawn: cell, robot, workpiece, points in the colours of their values, map."""
    cell, worst = details.cell, details.worst
    meshes = [Drawn(f"fixture {n} {body.name}", placed_triangles(body), _GREY) for n, body in enumerate(cell.fixtures)]
    joints = details.joints[worst]
    q = joints if np.isfinite(joints).all() else cell.home
    links = cell.T_cell_base @ link_poses(cell.robot, q[None])[0]
    tool = cell.tools[int(details.targets.tool[worst])]
    carried = [(body, links[-1] @ cell.robot.T_link_flange) for body in tool.bodies]
    arm = [(body, links[number]) for number, bodies in enumerate(cell.robot.bodies) for body in bodies]
    meshes += _placed("robot", arm, _ROBOT) + _placed("tool", carried, _TOOL)
    if workpiece is not None:
        meshes += [Drawn("workpiece", _moved(_few(workpiece), cell.T_cell_board), _PART)]
    values = details.values
    at = details.targets.T_board_tcp[:, :3, 3] @ cell.T_cell_board[:3, :3].T + cell.T_cell_board[:3, 3]
    there = np.isfinite(values)
    meshes.append(Drawn("points", _marks(at[there], _POINT_M), np.repeat(tints(values[there]), 8, axis=0)))
    meshes.append(Drawn("points not reached", _marks(at[~there], _POINT_M), _ACCENT))
    meshes.append(Drawn("worst point", _marks(at[worst : worst + 1], _WORST_M), _ACCENT))
    if mapped is not None:
        meshes.append(Drawn("map", *_map_squares(details, mapped)))
    return [each for each in meshes if len(each.triangles)]


def tints(values: Scalars) -> NDArray[np.uint8]:
    """(n, 4) colours of values, from the least to the greatest."""
    from matplotlib import colormaps

    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    share = (values - low) / max(high - low, 1e-12)
    return np.asarray(np.round(255 * np.asarray(colormaps[COLOURS](share))), dtype=np.uint8).reshape(-1, 4)


def _placed(name: str, bodies: Sequence[tuple[Body, Poses]], colour: Colour) -> list[Drawn]:
    """One mesh of bodies; boxes where they are too fine."""
    shapes = [placed_triangles(body) for body, _ in bodies]
    fine = sum(map(len, shapes)) > _MOST_TRIANGLES
    moved = [_moved(_box(each) if fine else each, pose) for each, (_, pose) in zip(shapes, bodies, strict=True)]
    return [Drawn(name, np.concatenate(moved), colour)] if moved else []


def _few(workpiece: Workpiece) -> Triangles:
    """(n, 3, 3) of a workpiece, m; boxes where its bodies are too fine."""
    shapes = [body.patches * _M_PER_MM for body in workpiece.bodies]
    fine = sum(map(len, shapes)) > _MOST_TRIANGLES
    return np.concatenate([_box(each) if fine else each for each in shapes])


def _box(triangles: Triangles) -> Triangles:
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    signs = np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)])
    corners = low + signs * (high - low)
    faces = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2],
             [2, 4, 6], [1, 3, 5], [3, 7, 5]]  # fmt: skip
    return corners[np.array(faces)]


def _moved(triangles: Triangles, pose: Poses) -> Triangles:
    return triangles @ pose[:3, :3].T + pose[:3, 3]


def _marks(at: Points, size: float) -> Triangles:
    """(8 n, 3, 3) octahedra at points."""
    return (at[:, None, None, :] + size * _OCTAHEDRON[_FACES]).reshape(-1, 3, 3)


def _map_squares(details: PlacementDetails, mapped: PlacementMap) -> tuple[Triangles, NDArray[np.uint8]]:
    """Two triangles for each node that is feasible, at the height of the cell's origin, a hair above a table there."""
    half = 0.5 * np.array([mapped.x[1] - mapped.x[0], mapped.y[1] - mapped.y[0]])
    i, j = np.nonzero(np.isfinite(mapped.highest))
    height = float(details.cell.T_cell_base[2, 3]) + 2e-3
    middle = np.column_stack([mapped.x[i], mapped.y[j], np.full(len(i), height)])
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    corners = np.repeat(middle[:, None], 4, axis=1)
    corners[:, :, :2] += signs * half
    triangles = corners[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)
    return triangles, np.repeat(tints(mapped.highest[i, j]), 2, axis=0)
