"""Strokes: what path planners make and modifiers change before it becomes a plan, and the site that they are for."""

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias, TypeVar, cast

import numpy as np
import shapely
from shapely import Polygon

from boards.board import Board, Side
from geometry.arrays import Directions, Directions2, Indices, Points, Scalars
from geometry.gridframe import GridFrame
from geometry.polygons import join_pieces
from recipes.nozzles import AirKnife, FlatFan, Nozzle
from recipes.recipe import Limits
from specs.finding import Finding
from specs.source import Source

Sense: TypeAlias = Literal["fixed", "either"]
Freedom: TypeAlias = Literal["free", "either_end", "fixed"]
Retract: TypeAlias = Literal["corridor", "everything"]
T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class Stroke:
    """A run of nozzle points that is sprayed in one piece; where a ring begins, and at which end a line, may be open.

    Side frame: x and y as in the board frame, as seen from the top; z is the height above the bare surface of the
    side that is sprayed, for both sides; so the jet always has a negative z. Millimetres.
    """

    tcp: Points
    """(n, 3) nozzle orifice. A closed stroke ends at its first point only if it has to turn there. Equal neighbours
    with different directions turn on the spot."""
    approach: Directions
    """(n, 3) unit vectors from the orifice to the surface."""
    azimuth: Directions2
    """(n, 2) plan direction to which the nozzle's reference is turned."""
    delays: Scalars
    """(n,) seconds to hold still on arrival at each point, jet on; 0 goes through."""
    speed_mm_s: float
    made_by: Source
    closed: bool = False
    laps: int = 1
    """How often a closed stroke goes around."""
    sense: Sense = "fixed"
    """Whether the order of strokes may turn an open one around."""
    entries: tuple[int, ...] = (0,)
    """Points at which a closed stroke may begin."""
    lead_in_mm: float = 0.0
    pauses: tuple[str, ...] = ()
    """(n,) component at whose edge the delay at each point is; empty where it is the stroke's own."""

    @property
    def lap(self) -> Points:
        """(m, 3) orifices of one lap, the first one again at the end of a ring."""
        return np.vstack([self.tcp, self.tcp[:1]]) if self.closed else self.tcp

    @property
    def lap_mm(self) -> float:
        """Way of the orifice in one lap."""
        return float(np.linalg.norm(np.diff(self.lap, axis=0), axis=1).sum())

    def pick(self, index: Indices) -> "Stroke":
        """Take points by index, in that order, also repeatedly; ``entries`` and ``laps`` stay as they are."""
        return replace(
            self,
            tcp=self.tcp[index],
            approach=self.approach[index],
            azimuth=self.azimuth[index],
            delays=self.delays[index],
            pauses=tuple(self.pauses[int(i)] for i in index) if self.pauses else (),
        )

    def insert(self, segment: Indices, share: Scalars) -> tuple["Stroke", Indices]:
        """Add points without delay on segments, at shares of their lengths; the last segment of a ring closes it.

        Returns:
            The stroke, and for each of its points the index of the point that it was; added ones count on from there.
        """
        count = len(self.tcp)
        order = np.lexsort((np.concatenate([np.zeros(count), share]), np.concatenate([np.arange(count), segment])))
        after = (segment + 1) % count

        def mixed(values: Scalars) -> Scalars:
            between = values[segment] * (1 - share[:, None]) + values[after] * share[:, None]
            return np.concatenate([values, between])[order]

        approach, azimuth = mixed(self.approach), mixed(self.azimuth)
        position = np.argsort(order)
        pauses = (*self.pauses, *[""] * len(share))
        stroke = replace(
            self,
            tcp=mixed(self.tcp),
            approach=approach / np.linalg.norm(approach, axis=1, keepdims=True),
            azimuth=azimuth / np.linalg.norm(azimuth, axis=1, keepdims=True),
            delays=np.concatenate([self.delays, np.zeros(len(share))])[order],
            entries=tuple(int(position[entry]) for entry in self.entries),
            pauses=tuple(pauses[index] for index in order.tolist()) if self.pauses else (),
        )
        return stroke, order


@dataclass(frozen=True, slots=True, eq=False)
class StrokeSet:
    """Strokes of one template, and how free their order is."""

    strokes: tuple[Stroke, ...]
    freedom: Freedom
    """``free`` lets the order save air travel; ``either_end`` keeps it but may begin with the last; ``fixed`` keeps
    it (rinse water must run one way)."""
    retract: Retract = "corridor"
    """What a transfer between them must clear: the bodies in its corridor, or everything on the side."""
    findings: tuple[Finding, ...] = ()
    edge_pauses: Mapping[str, float] = field(default_factory=dict[str, float])
    """Seconds to pause where the jet's axis crosses the edge of a component, by component."""

    def for_template(self, made_by: Source) -> "StrokeSet":
        """The same strokes and findings by a template that plans alike, such as the same one in another step."""

        def own(source: Source) -> Source:
            return replace(source, step=made_by.step, template=made_by.template)

        strokes = {each: replace(each, made_by=own(each.made_by)) for each in self.strokes}  # repeats share theirs
        findings = tuple(replace(each, made_by=own(each.made_by)) for each in self.findings)
        return replace(self, strokes=tuple(strokes[each] for each in self.strokes), findings=findings)


@dataclass(frozen=True, slots=True, eq=False)
class PlanCache:
    """What was planned for a run, by all that it depends on besides the workpiece; an earlier run lends its own."""

    known: dict[Hashable, object] = field(default_factory=dict[Hashable, object])
    before: "PlanCache | None" = None

    def take(self, key: Hashable, make: Callable[[], T]) -> T:
        """What is known by a key that states its kind too, else what is made."""
        if key not in self.known:
            earlier = {} if self.before is None else self.before.known
            self.known[key] = earlier[key] if key in earlier else make()
        return cast("T", self.known[key])

    def kept(self) -> "PlanCache":
        """What this run has used, without the run before."""
        return replace(self, before=None)


@dataclass(frozen=True, slots=True, eq=False)
class Site:
    """Everything a path planner may use: the board, the nozzle, and the recipe path of the template."""

    board: Board
    side: Side
    nozzle: Nozzle
    limits: Limits
    classes: dict[str, str]
    """Component name to class name."""
    served: frozenset[str]
    """Components of this side that get passes of their own: neither avoided nor ignored."""
    made_by: Source
    """Recipe path of the template in its step, such as ``"sequence[0]/around"``."""
    cache: PlanCache = field(default_factory=PlanCache)
    """Of the board."""

    def azimuths(self, travel: Directions2) -> Directions2:
        """Give (n, 2) plan directions for the nozzle's reference at (n, 2) directions of travel.

        A flat pattern lies across the travel; a round one keeps one direction for the whole program.
        """
        if isinstance(self.nozzle, FlatFan | AirKnife):
            return np.column_stack([-travel[:, 1], travel[:, 0]])
        return np.tile(reference_azimuth(self.board, self.limits), (len(travel), 1))


def reference_azimuth(board: Board, limits: Limits) -> Directions2:
    """(2,) plan direction of a round nozzle's reference: as stated, else along the board's longest edge."""
    if limits.tool_azimuth_deg is None:
        return np.array(board.axis)
    angle = np.radians(limits.tool_azimuth_deg)
    return np.array([np.cos(angle), np.sin(angle)])


def tilted(lean: Directions2, tilt_deg: float) -> Directions:
    """(n, 3) jet directions that lean towards (n, 2) plan directions by a tilt from the normal; side frame."""
    tilt = np.radians(tilt_deg)
    return np.column_stack([np.sin(tilt) * lean, np.full(len(lean), -np.cos(tilt))])


def reference_axes(approach: Directions, azimuth: Directions2) -> Directions:
    """(n, 3) tool +X: the azimuth's plan direction brought to right angles with the jet; side frame."""
    flat = np.column_stack([azimuth, np.zeros(len(azimuth))])
    square = flat - approach * np.sum(flat * approach, axis=1, keepdims=True)
    return square / np.linalg.norm(square, axis=1, keepdims=True)


def own_frame(board: Board) -> GridFrame:
    """Frame of a board's outline: its first corner, and the direction of its longest edge.

    What is decided on its grid is decided the same wherever the board lies.
    """
    x, y = board.outline.exterior.coords[0][:2]
    return GridFrame((float(x), float(y)), board.axis)


def into_frame(outline: Polygon, frame: GridFrame) -> Polygon:
    """Transform an outline from the board frame onto the grid of a frame; pieces that this cuts off are rejoined."""
    moved = shapely.transform(outline, frame.to_frame)
    return moved if moved.is_valid else join_pieces(moved.buffer(0.0))


def out_of_frame(outline: Polygon, frame: GridFrame) -> Polygon:
    """Transform an outline back into the board frame."""
    return shapely.transform(outline, frame.from_frame)
