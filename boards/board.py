"""Workpieces: the bodies of a file, and what was understood of them as a circuit board, or as a part with faces."""

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from boards.errors import BoardError
from geometry.arrays import Directions, Indices, Points, Points2, Triangles
from specs.finding import Finding
from specs.rows import Rows

if TYPE_CHECKING:
    from geometry.rays import RayScene

Role: TypeAlias = Literal["board", "component", "fixture", "part"]
Side: TypeAlias = Literal["top", "bottom"]

NOMINAL_HEIGHT = "x-height"
"""Key of the extra attribute of a body whose height is not drawn: its source. A parts table may replace the height."""

SCORES = "x-scores"
"""Key of the extra attribute of a board: lines ``x,y,x,y;…`` in mm along which it is broken into several."""

UNFITTED = "x-not-fitted"
"""Key of the extra attribute of a board: names ``R1;R2`` of the components that its file states not to be fitted."""

STATED_HEIGHT = "stated"
"""Source of a height that the board file states or draws."""

NEAREST_MM = 15.0
"""Half width of the closest view of a place: smaller ones are looked at with their neighbours."""

_ROOM = 3.0
"""Width of the view of a component, as a multiple of its size."""
_OVER_MM = 2.0
_FROM_ABOVE = 0.45
"""Of the view of an upright face: how far the eye is raised, so that what it stands on is seen too."""
_WHOLE_MM = 1e9


@dataclass(frozen=True, slots=True)
class Surface:
    """A named run of patches inside a body."""

    name: str
    patches: int


@dataclass(frozen=True, slots=True)
class Pad:
    """One piece of copper on the board's surface to which a component is soldered flat. Board frame, mm."""

    x_mm: float
    y_mm: float
    length_mm: float
    """Along x before it is turned; the diameter if it is round."""
    width_mm: float
    turn_rad: float = 0.0
    """Anticlockwise as seen from the top, on both sides."""
    round: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """One object of the board file, exactly as it was read. Board frame, millimetres.

    ``None`` means that the file does not state the attribute.
    """

    name: str
    """Reference designator of a component; unique in the file."""
    role: Role
    patches: Triangles
    """(n, 3, 3) triangular patches, surface after surface."""
    normals: Directions
    """(n, 3) outward unit normals as stated, or from the winding."""
    surfaces: tuple[Surface, ...]
    package: str | None = None
    part: str | None = None
    value: str | None = None
    pins: int | None = None
    side: Side | None = None
    gap_height_mm: float | None = None
    extra: tuple[tuple[str, str], ...] = ()
    """The ``x-…`` attributes, kept in order and not interpreted."""
    pads: tuple[Pad, ...] = ()
    """What it is soldered to on its own side, in file order; empty where the file states none."""


@dataclass(frozen=True, slots=True, eq=False)
class Component:
    """One component, as understood. Coordinates of both sides are as seen from the top."""

    name: str
    package: str
    """Empty where no file states it."""
    part: str
    value: str
    pins: int
    pins_source: str
    """``"stated"``, or how it was assumed (package name or family)."""
    side: Side
    footprint: Polygon
    """True projection onto the board plane, simplified within 0.05 mm; a component in several pieces is joined."""
    outline: Polygon
    """The footprint with the gaps between pins closed and holes filled: what a path follows and a step counts."""
    height_mm: float
    """Highest point above the surface of the component's own side."""
    area_mm2: float
    """Plan area of the footprint."""
    gap_height_mm: float | None
    """Gap between board and the underside of the body; ``None`` where neither file nor family knows it."""
    gap_height_source: str
    """``"stated"``, ``"family SOIC (JEDEC MS-012)"``, or ``"unknown"``."""
    neighbours: tuple[tuple[str, float], ...]
    """The nearest components of the same side and their distance between outlines, nearest first (at most 6)."""
    height_source: str = STATED_HEIGHT
    """``"stated"`` by the file, or of a height that it does not state: ``"name states D6.5mm"``, ``"assumed tall"``."""

    @property
    def neighbour_mm(self) -> float:
        """Distance to the nearest component of the same side; infinite when alone."""
        return self.neighbours[0][1] if self.neighbours else float("inf")


def assumed_heights(components: Iterable[Component]) -> list[tuple[str, tuple[Component, ...]]]:
    """Components whose height nothing states, by package, or by name without one.

    Those come first that keep the nozzle out of most space: what their heights are matters most.
    """
    found: dict[str, list[Component]] = {}
    for each in components:
        if each.height_source.startswith("assumed"):
            found.setdefault(each.package or each.name, []).append(each)
    space = {key: sum(each.height_mm * each.area_mm2 for each in own) for key, own in found.items()}
    return [(key, tuple(found[key])) for key in sorted(found, key=lambda key: (-round(space[key], 3), key))]


@dataclass(frozen=True, slots=True, eq=False)
class Obstacle:
    """A prism that holds everything of one body above one side's surface: what the nozzle must stay away from."""

    name: str
    outline: Polygon
    """Projection of the whole body, mm, as seen from the top."""
    height_mm: float
    """Highest point above that side's surface."""


@dataclass(frozen=True, slots=True, eq=False)
class Face:
    """One face of a part: a plane region, or a curved one without sharp edges. The part's frame, mm."""

    name: str
    """Unique in the part, such as ``"face-3"``, or as the ``.tri`` file calls its surface."""
    patches: Indices
    """(k,) its patches, numbered over the part's own bodies in their order (``Part.patches``)."""
    normal: tuple[float, float, float]
    """Unit vector: the mean over the area, outwards. Of a face that goes all the way around, any one of its normals."""
    area_mm2: float
    flat: bool
    """Whether it lies in one plane."""
    serve: bool
    """Whether it is to be sprayed."""


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


@dataclass(frozen=True, slots=True, eq=False)
class AimedPlane:
    """The plane that a jet is aimed at, seen from the orifice."""

    distance_mm: float
    """Of the orifice from the plane."""
    axes: Directions
    """(3, 3) rows: two axes in the plane, and the normal towards the orifice."""


@dataclass(frozen=True, slots=True, eq=False)
class Workpiece(ABC):
    """What lies or stands in the cell to be cleaned, with its fixtures: a board, or a part (``boards.part``).

    Its own frame, millimetres. What is judged on it is its components or its faces; a stage that handles both reads
    these, or what is stated here, and not which kind of workpiece it is.
    """

    name: str
    sha256: str
    """Of the canonical ``.tri`` text, so that one workpiece from two containers has one fingerprint."""
    bodies: tuple[Body, ...]
    findings: tuple[Finding, ...]
    components: tuple[Component, ...] = field(default=(), kw_only=True)
    """In the natural order of their names: U2 before U10; a part has none."""
    faces: tuple[Face, ...] = field(default=(), kw_only=True)
    """In the order of their first patches; a board has none."""

    def __post_init__(self) -> None:
        """Have components and faces show themselves as tables."""
        for name in ("components", "faces"):
            object.__setattr__(self, name, Rows(getattr(self, name)))

    @property
    def box(self) -> tuple[Points, Points]:
        """Lowest and highest corner, (3,) each, of what is cleaned: without fixtures."""
        own = np.concatenate([body.patches.reshape(-1, 3) for body in self.bodies if body.role != "fixture"])
        return own.min(axis=0), own.max(axis=0)

    @property
    def held_z_mm(self) -> float:
        """Z of the level at which a cell holds it: a part stands on its lowest point."""
        return float(self.box[0][2])

    @property
    def place_names(self) -> tuple[str, ...]:
        """Names of what is judged and can be chosen: components or faces."""
        return tuple(each.name for each in (*self.components, *self.faces))

    @property
    def pickable_bodies(self) -> tuple[Body, ...]:
        """Bodies that a click meets: those of the file."""
        return self.bodies

    @abstractmethod
    def find_place(self, name: str) -> Place | None:
        """Where a component or a face is looked at; ``None`` if there is none of that name."""

    @abstractmethod
    def room(self, side: Side, above_mm: float) -> tuple[Points, Points]:
        """Lowest and highest corner, (3,) each, of what is seen from a side, with space for a nozzle above a board."""

    @abstractmethod
    def aimed_plane(self, tcp: Points, approach: Directions, reference: Directions) -> AimedPlane | None:
        """The plane that a jet at an orifice (3,) is aimed at; ``None`` where it points at nothing.

        Args:
            tcp: (3,) orifice.
            approach: (3,) unit vector along the jet.
            reference: (3,) unit vector, tool +X.
        """

    def require_board(self, job: str) -> "Board":
        """Return the workpiece as a board, for what is done with boards alone.

        Args:
            job: What is to be done, as the subject of a sentence.

        Raises:
            BoardError: it is none.
        """
        raise BoardError(f"{job} is for boards, and {self.name} is a part.")

    def require_part(self, job: str) -> "Part":
        """Return the workpiece as a part, for what is done with parts alone.

        Args:
            job: What is to be done, as the subject of a sentence.

        Raises:
            BoardError: it is none.
        """
        raise BoardError(f"{job} is for parts, and {self.name} is a board.")


@dataclass(frozen=True, slots=True)
class SourceFile:
    """One file of an order: what it is, and what it states of the board."""

    name: str
    kind: str
    """Such as ``"parts table"``; ``"not read"`` of what is left out."""
    states: str


@dataclass(frozen=True, slots=True)
class Contradiction:
    """Two statements about a component that cannot both be right."""

    component: str
    about: str
    """Such as ``"side"``."""
    taken: str
    source: str
    """Where the statement that is taken comes from: a file, ``"copper"``, ``"package"`` or ``"board"``."""
    other: str
    other_source: str


@dataclass(frozen=True, slots=True, eq=False)
class Board(Workpiece):
    """A board that has been read and understood. Board frame: x right, y back, z up out of the top; CAD origin kept."""

    outline: Polygon
    """Edge of the board with its holes and slots, as seen from the top; rings begin at a vertex that moves with it."""
    axis: tuple[float, float]
    """Unit vector along the outline's longest edge: a direction that moves with the board."""
    top_z_mm: float
    bottom_z_mm: float
    top_obstacles: tuple[Obstacle, ...]
    bottom_obstacles: tuple[Obstacle, ...]
    instances: tuple["Instance", ...] = ()
    """The boards of a panel that are cleaned; none of a single board."""
    sources: tuple[SourceFile, ...] = ()
    """The files that it was read from; none of a single one."""
    contradictions: tuple[Contradiction, ...] = ()
    """Between these files."""

    @property
    def box(self) -> tuple[Points, Points]:
        """Lowest and highest corner, (3,) each, of the bare board: without components and fixtures."""
        left, front, right, back = self.outline.bounds
        return np.array([left, front, self.bottom_z_mm]), np.array([right, back, self.top_z_mm])

    @property
    def held_z_mm(self) -> float:
        """Z of the top surface, at which a cell holds a board."""
        return self.top_z_mm

    @property
    def own_names(self) -> dict[str, str]:
        """Name of each component to that on its own board: the same but on a panel."""
        if not self.instances:
            return {component.name: component.name for component in self.components}
        pairs = ((each, component.name) for each in self.instances for component in each.board.components)
        return {each.rename(own): own for each, own in pairs}

    def surface_z_mm(self, side: Side) -> float:
        """Z of the bare surface of a side, mm."""
        return self.top_z_mm if side == "top" else self.bottom_z_mm

    def obstacles(self, side: Side) -> tuple[Obstacle, ...]:
        """Return everything that stands above a side's surface, fixtures included."""
        return self.top_obstacles if side == "top" else self.bottom_obstacles

    def require_board(self, job: str) -> "Board":
        """Return the board itself."""
        return self

    def find_place(self, name: str) -> Place | None:
        """Where a component is looked at; ``None`` if there is none of that name."""
        component = next((each for each in self.components if each.name == name), None)
        if component is None:
            return None
        x_min, y_min, x_max, y_max = component.outline.bounds
        surface, sign = self.surface_z_mm(component.side), 1.0 if component.side == "top" else -1.0
        middle = np.array([(x_min + x_max) / 2, (y_min + y_max) / 2, surface])
        around = max(NEAREST_MM, _ROOM * max(x_max - x_min, y_max - y_min) / 2, component.height_mm)
        half = np.array([around, around, 0.0])
        centre = component.outline.centroid
        label = np.array([centre.x, centre.y, surface + sign * (component.height_mm + _OVER_MM)])
        return Place(component.name, middle - half, middle + half, np.array([0.0, -0.62, 0.785 * sign]), label)

    def room(self, side: Side, above_mm: float) -> tuple[Points, Points]:
        """Lowest and highest corner, (3,) each, of the board with its components of a side.

        Above the top there is space for a nozzle of this height, where the board is no smaller than that.
        """
        (x_min, y_min, bottom), (x_max, y_max, top) = self.box
        tallest = max((each.height_mm for each in self.components if each.side == side), default=0.0)
        if side == "bottom":
            return np.array([x_min, y_min, bottom - tallest]), np.array([x_max, y_max, top])
        above = max(tallest, min(above_mm, x_max - x_min, y_max - y_min))
        return np.array([x_min, y_min, bottom]), np.array([x_max, y_max, top + above])

    def aimed_plane(self, tcp: Points, approach: Directions, reference: Directions) -> AimedPlane | None:
        """The surface of the side that a jet is aimed at; ``None`` where it points along or away from it."""
        up = -float(np.sign(approach[2]))
        # Half a turn about x makes the bottom a top, and keeps the axes right-handed.
        distance = (float(tcp[2]) - self.surface_z_mm("top" if up > 0 else "bottom")) * up
        return AimedPlane(distance, np.diag([1.0, up, up])) if up and distance > 0 else None


@dataclass(frozen=True, slots=True, eq=False)
class Instance:
    """One board on a panel: turned in its plane, then moved. Millimetres and radians, panel frame."""

    name: str
    """Its number, from 1, row by row from the front left: ``U1@2`` is U1 of the second."""
    board: Board
    """As it lies: where it was turned over, its top is the side that faces the panel's top."""
    turn_rad: float
    x_mm: float
    y_mm: float

    def points(self, points: Points2) -> Points2:
        """Bring (n, 2) points of the board onto the panel."""
        return self.directions(points) + np.array([self.x_mm, self.y_mm])

    def directions(self, directions: Points2) -> Points2:
        """Turn (n, 2) directions of the board as it is turned on the panel."""
        cos, sin = math.cos(self.turn_rad), math.sin(self.turn_rad)
        return directions @ np.array([[cos, sin], [-sin, cos]])

    def rename(self, component: str) -> str:
        """Name on the panel of a component of the board."""
        return f"{component}@{self.name}"

    def move(self, outline: Polygon) -> Polygon:
        """Bring an outline onto the panel."""
        return shapely.transform(outline, self.points)


@dataclass(frozen=True, slots=True, eq=False)
class Part(Workpiece):
    """A part that has been read and understood, with its fixtures; the origin of its file is kept."""

    @property
    def own_bodies(self) -> tuple[Body, ...]:
        """The bodies that are cleaned, without the fixtures."""
        return tuple(body for body in self.bodies if body.role == "part")

    @property
    def patches(self) -> Triangles:
        """(n, 3, 3) patches of the part itself, body after body, wound so that their normals point outwards."""
        return np.concatenate([body.patches for body in self.own_bodies])

    @property
    def normals(self) -> Directions:
        """(n, 3) outward unit normals of them."""
        return np.concatenate([body.normals for body in self.own_bodies])

    @property
    def served(self) -> tuple[Face, ...]:
        """The faces that are to be sprayed."""
        return tuple(face for face in self.faces if face.serve)

    def owner_of_patches(self) -> NDArray[np.int64]:
        """(all,) index into ``bodies`` of every patch, body after body, fixtures included."""
        return np.repeat(np.arange(len(self.bodies)), [len(body.patches) for body in self.bodies])

    def require_part(self, job: str) -> "Part":
        """Return the part itself."""
        return self

    @property
    def pickable_bodies(self) -> tuple[Body, ...]:
        """Bodies that a click meets: each face is one by itself, and the fixtures."""
        patches, normals = self.patches, self.normals
        faces = [Body(face.name, "part", patches[face.patches], normals[face.patches], ()) for face in self.faces]
        return (*faces, *(body for body in self.bodies if body.role == "fixture"))

    def find_place(self, name: str) -> Place | None:
        """Where a face is looked at; ``None`` if there is none of that name."""
        face = next((each for each in self.faces if each.name == name), None)
        if face is None:
            return None
        corners = self.patches[face.patches].reshape(-1, 3)
        low, high = corners.min(axis=0), corners.max(axis=0)
        normal = np.array(face.normal)
        middle = (low + high) / 2
        half = np.maximum((high - low) / 2, NEAREST_MM) + NEAREST_MM
        upright = np.sqrt(max(0.0, 1.0 - float(normal[2]) ** 2))
        towards = normal + np.array([0.0, -0.3 * (1.0 - upright), _FROM_ABOVE * upright])
        return Place(face.name, middle - half, middle + half, towards, middle + _OVER_MM * normal)

    def room(self, side: Side, above_mm: float) -> tuple[Points, Points]:
        """Lowest and highest corner, (3,) each, of the part: a nozzle comes from anywhere."""
        return self.box

    def aimed_plane(self, tcp: Points, approach: Directions, reference: Directions) -> AimedPlane | None:
        """The plane across a jet where its axis meets the part or a fixture first."""
        from geometry.rays import cast

        faces, distances = cast(_rays_of(self), tcp[None], approach[None])
        if faces[0] < 0 or distances[0] <= 0:
            return None
        return AimedPlane(float(distances[0]), np.stack([reference, np.cross(-approach, reference), -approach]))


def scene_of(part: Part) -> "RayScene":
    """Make all bodies of a part ready for rays; its ``body`` is the index into ``part.bodies``."""
    from geometry.rays import build_ray_scene  # late: a board needs no rays to be read and planned

    patches = np.concatenate([body.patches for body in part.bodies])
    normals = np.concatenate([body.normals for body in part.bodies])
    return build_ray_scene(patches, normals, part.owner_of_patches(), _WHOLE_MM)


@lru_cache(4)
def _rays_of(part: Part) -> "RayScene":
    """A part ready for rays; the last few are kept for the moments of a playback."""
    return scene_of(part)
