"""Workpieces: the bodies of a file; boards: what was understood of one that is a circuit board."""

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
import shapely
from shapely import Polygon

from geometry.arrays import Directions, Points, Points2, Triangles
from specs.finding import Finding

Role: TypeAlias = Literal["board", "component", "fixture", "part"]
Side: TypeAlias = Literal["top", "bottom"]

NOMINAL_HEIGHT = "x-height"
"""Key of the extra attribute of a body whose height is not drawn: its source. A parts table may replace the height."""

STATED_HEIGHT = "stated"
"""Source of a height that the board file states or draws."""


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


@dataclass(frozen=True, slots=True, eq=False)
class Obstacle:
    """A prism that holds everything of one body above one side's surface: what the nozzle must stay away from."""

    name: str
    outline: Polygon
    """Projection of the whole body, mm, as seen from the top."""
    height_mm: float
    """Highest point above that side's surface."""


@dataclass(frozen=True, slots=True, eq=False)
class Workpiece:
    """What lies or stands in the cell to be cleaned, with its fixtures: a board, or a part (``boards.part``).

    Its own frame, millimetres.
    """

    name: str
    sha256: str
    """Of the canonical ``.tri`` text, so that one workpiece from two containers has one fingerprint."""
    bodies: tuple[Body, ...]
    findings: tuple[Finding, ...]

    @property
    def box(self) -> tuple[Points, Points]:
        """Lowest and highest corner, (3,) each, of what is cleaned: without fixtures."""
        own = np.concatenate([body.patches.reshape(-1, 3) for body in self.bodies if body.role != "fixture"])
        return own.min(axis=0), own.max(axis=0)


@dataclass(frozen=True, slots=True, eq=False)
class Board(Workpiece):
    """A board that has been read and understood. Board frame: x right, y back, z up out of the top; CAD origin kept."""

    outline: Polygon
    """Edge of the board with its holes and slots, as seen from the top; rings begin at a vertex that moves with it."""
    axis: tuple[float, float]
    """Unit vector along the outline's longest edge: a direction that moves with the board."""
    top_z_mm: float
    bottom_z_mm: float
    components: tuple[Component, ...]
    """In file order."""
    top_obstacles: tuple[Obstacle, ...]
    bottom_obstacles: tuple[Obstacle, ...]
    instances: tuple["Instance", ...] = ()
    """The boards of a panel that are cleaned; none of a single board."""

    @property
    def box(self) -> tuple[Points, Points]:
        """Lowest and highest corner, (3,) each, of the bare board: without components and fixtures."""
        left, front, right, back = self.outline.bounds
        return np.array([left, front, self.bottom_z_mm]), np.array([right, back, self.top_z_mm])

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


@dataclass(frozen=True, slots=True, eq=False)
class Instance:
    """One board on a panel: turned in its plane, then moved. Millimetres and radians, panel frame."""

    name: str
    """Its number, from 1; components of the panel are named ``U1@2`` for U1 of the second."""
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
