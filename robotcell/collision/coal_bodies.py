"""Bodies as coal geometries: one each, centred, with its bounding box and sphere. Metres.

Coal is of ``washboard[robot]``; only this module and ``robotcell.collision.body_pairs`` use it.
"""

import importlib
from dataclasses import dataclass, field
from functools import cache, cached_property, lru_cache
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from boards.board import Workpiece
from geometry.arrays import Indices, Points, Triangles
from robotcell.collision.segments import Hull, TriangleTree, build_hull, build_tree
from robotcell.errors import CellError
from robotcell.robot.robot import Body, Box, Capsule, Poses, Shape, pose

Part: TypeAlias = Literal["robot", "tool", "fixture", "board"]

_METRES = 1e-3
_FLAT = 1e-12
"""m³ below which a closed mesh is a sheet and has no hull."""
_SAME_DIGITS = 8
"""Corners that agree to so many digits of a metre are one."""
_FULL = 0.95
"""Share of its hull that a closed mesh has to fill to be taken for the hull: a chamfer is lost, not a hollow."""


@dataclass(frozen=True, eq=False)
class Pieces:
    """The bodies that a solid consists of, in its frame; made for coal when they are first needed."""

    triangles: tuple[Triangles, ...] = ()

    @cached_property
    def geometries(self) -> tuple[Any, ...]:
        """Coal ``CollisionGeometry`` of each, in the solid's frame."""
        return tuple(map(_surface, self.triangles))

    @cached_property
    def whole(self) -> Any:
        """Coal ``CollisionGeometry`` of all triangles, one piece after the other."""
        return _surface(np.concatenate(self.triangles))

    @cached_property
    def boxes(self) -> NDArray[np.float64]:
        """(k, 2, 3) middle of each one's box along the solid's axes, and half its edges."""
        return np.array([_box(each.reshape(-1, 3)) for each in self.triangles]).reshape(-1, 2, 3)

    @cached_property
    def tree(self) -> TriangleTree:
        """All triangles, one piece after the other, sorted for distances to segments."""
        return build_tree(np.concatenate(self.triangles))


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """One geometry that is rigid in itself, and what carries it. Its own frame is in the middle of its box."""

    names: tuple[str, ...]
    """One name; of a board one for every body of the board."""
    owners: Indices
    """(triangles,) index of each triangle's name; empty where there is one name."""
    part: Part
    link: int
    """Link of the robot that carries it; 0 for all that stands still."""
    rigid: Any
    """A coal ``CollisionGeometry``; ``None`` of a board, whose pieces have it."""
    T_link_solid: Poses
    """(4, 4) in the link; in the cell where it is no part of the robot's chain."""
    half: NDArray[np.float64]
    """(3,) half the edges of the box that holds it, along its own axes."""
    radius: float
    """Of the ball about its middle that holds it."""
    pieces: Pieces = field(default_factory=Pieces)
    """Of a board its bodies, in the order of their names; of any other solid none."""
    rod: tuple[float, float] | None = None
    """Of a capsule half the length of its middle line, which is along z, and its radius."""
    hull: Hull | None = None
    """Of a mesh that is taken for its convex hull, in the solid's frame."""

    @property
    def geometry(self) -> Any:
        """A coal ``CollisionGeometry``; that of a board takes a while, and few robots come near one."""
        return self.pieces.whole if self.rigid is None else self.rigid

    @property
    def stands(self) -> bool:
        """Whether it never moves in the cell and is no part of the robot."""
        return self.part in ("board", "fixture")


@cache
def coal() -> Any:
    """Give the library that checks pairs of geometries.

    Raises:
        CellError: It is not installed.
    """
    try:
        return importlib.import_module("coal")
    except ImportError:
        raise CellError("checking for collisions needs `pip install washboard[robot]`") from None


def board_solid(board: Workpiece, T_cell_board: Poses) -> Solid:
    """Give the whole board as one surface, placed in the cell. Triangles keep the names of their bodies."""
    triangles = np.concatenate([body.patches for body in board.bodies]) * _METRES
    middle, half = _box(triangles.reshape(-1, 3))
    centred = triangles - middle
    counts = [len(body.patches) for body in board.bodies]
    return Solid(
        names=tuple(body.name for body in board.bodies),
        owners=np.repeat(np.arange(len(board.bodies)), counts),
        part="board",
        link=0,
        rigid=None,
        T_link_solid=T_cell_board @ pose(middle.tolist(), (0, 0, 0)),
        half=half,
        radius=_farthest(centred.reshape(-1, 3)),
        pieces=Pieces(tuple(np.split(centred, np.cumsum(counts)[:-1]))),
    )


def body_solid(body: Body, part: Part, link: int, T_link_carrier: Poses) -> Solid:
    """Give a body of robot, tool or fixture, in its link's frame; a fixture in the cell's, with link 0."""
    (geometry, hull), middle, half, radius = _geometry(body.shape)
    placed = T_link_carrier @ body.T_carrier_shape @ pose(middle.tolist(), (0, 0, 0))
    rod = (body.shape.length / 2, body.shape.radius) if isinstance(body.shape, Capsule) else None
    return Solid((body.name,), np.zeros(0, np.int64), part, link, geometry, placed, half, radius, rod=rod, hull=hull)


@lru_cache(maxsize=512)
def _geometry(shape: Shape) -> tuple[tuple[Any, Hull | None], NDArray[np.float64], NDArray[np.float64], float]:
    """Give a shape's geometry and hull, middle and half the edges of its box, and radius; the last ones are kept."""
    match shape:
        case Box():
            half = np.array(shape.size) / 2
            return (coal().Box(*shape.size), None), np.zeros(3), half, float(np.linalg.norm(half))
        case Capsule():
            half = np.array([shape.radius, shape.radius, shape.radius + shape.length / 2])
            return (coal().Capsule(shape.radius, shape.length), None), np.zeros(3), half, float(half[2])
        case _:
            middle, half = _box(shape.triangles.reshape(-1, 3))
            centred = shape.triangles - middle
            return _mesh(centred), middle, half, _farthest(centred.reshape(-1, 3))


def _mesh(triangles: Triangles) -> tuple[Any, Hull | None]:
    """Take a closed mesh that fills its convex hull for the hull, which is solid; any other for its surface."""
    from scipy.spatial import ConvexHull

    rounded, number = np.unique(np.round(triangles.reshape(-1, 3), _SAME_DIGITS), axis=0, return_inverse=True)
    corners = number.reshape(-1, 3)
    edges = np.sort(np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]]), axis=1)
    is_closed = (
        np.unique(edges, axis=0, return_counts=True)[1] == 2
    ).all()  # every edge is one of exactly two triangles
    volume = abs(float(np.einsum("ij,ij->i", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2])).sum())) / 6.0
    if not is_closed or volume < _FLAT:
        return _surface(triangles), None
    hull = ConvexHull(rounded)
    if volume < _FULL * hull.volume:
        return _surface(triangles), None
    points, faces = coal().StdVec_Vec3s(), coal().StdVec_Triangle()
    for vertex in rounded[np.sort(hull.vertices)]:
        points.append(vertex)
    sides = np.searchsorted(np.sort(hull.vertices), hull.simplices)
    ends = rounded[hull.simplices]
    turned = np.einsum("ij,ij->i", np.cross(ends[:, 1] - ends[:, 0], ends[:, 2] - ends[:, 0]), hull.equations[:, :3])
    for face in np.where(turned[:, None] < 0.0, sides[:, ::-1], sides).tolist():
        faces.append(coal().Triangle(*face))
    return coal().Convex(points, faces), build_hull(rounded[np.sort(hull.vertices)], hull.equations)


def _surface(triangles: Triangles) -> Any:
    """Build a tree of boxes over triangles that need not be closed, nor share corners.

    Of coal's two trees the one of boxes alone: 2 to 50 times as quick as OBBRSS for a yes-or-no check, and
    ``robotcell.collision.clearance`` needs no more than that.
    """
    model = coal().BVHModelOBB()
    model.beginModel(len(triangles), 3 * len(triangles))
    model.addVertices(np.ascontiguousarray(triangles.reshape(-1, 3)))
    model.addTriangles(np.arange(3 * len(triangles), dtype=np.int64).reshape(-1, 3))
    model.endModel()
    return model


def _box(points: Points) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    lowest, highest = points.min(axis=0), points.max(axis=0)
    return (lowest + highest) / 2, (highest - lowest) / 2


def _farthest(points: Points) -> float:
    return float(np.sqrt((points**2).sum(axis=1).max()))
