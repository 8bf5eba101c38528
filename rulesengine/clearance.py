"""How high the orifice must be where: every body as a prism grown by the clearance."""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import shapely
from shapely import LineString, Polygon, STRtree, get_coordinates, get_parts

from boards.board import Board, Side
from geometry.arrays import Points2, Scalars
from rulesengine.own_frame import into_frame, out_of_frame, own_frame

Span: TypeAlias = tuple[float, float, float]
"""From and to along a path, mm, and the least height there."""

_ROUNDING_MM = 0.02  # outlines are simplified and programs rounded; never nearer than asked because of it
_OUTLINE_MM = 0.05
_ARC = 8
_SAME_MM = 1e-6
_HULL_SHARE = 1.5  # a clamp around the whole board must not become a lid


@dataclass(frozen=True, slots=True, eq=False)
class Floors:
    """Zones in plan and the least height of the orifice over each; side frame, mm."""

    zones: tuple[Polygon, ...]
    heights: Scalars
    tree: STRtree

    @property
    def highest(self) -> float:
        """Height that is free of everything; 0 on a bare board."""
        return float(self.heights.max(initial=0.0))

    def over(self, line: Points2) -> float:
        """Least height at which a straight move over (2, 2) plan points clears everything below it."""
        if not self.zones:
            return 0.0
        return float(self.heights[self.tree.query(LineString(line), predicate="intersects")].max(initial=0.0))

    def spans(self, path: Points2, above: float) -> list[Span]:
        """Stretches of an open plan path over zones that ask for more than the height ``above``."""
        if self.highest <= above + _SAME_MM or not self.zones:
            return []
        starts = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
        found: list[Span] = []
        for index in range(len(path) - 1):
            segment = LineString(path[index : index + 2])
            for zone in sorted(int(z) for z in self.tree.query(segment, predicate="intersects")):
                if self.heights[zone] > above + _SAME_MM:
                    found += self._crossed(segment, zone, float(starts[index]))
        return found

    def _crossed(self, segment: LineString, zone: int, start: float) -> list[Span]:
        origin = np.array(segment.coords[0])
        spans: list[Span] = []
        for piece in get_parts(shapely.intersection(segment, self.zones[zone])):
            along = np.linalg.norm(get_coordinates(piece) - origin, axis=1)
            if len(along) == 0:
                continue  # a turn on the spot has no length to cross anything with
            spans.append((start + float(along.min()), start + float(along.max()), float(self.heights[zone])))
        return spans


def floors(board: Board, side: Side, clearance_mm: float) -> Floors:
    """Grow every body of a side by the clearance, outwards and upwards."""
    obstacles = board.obstacles(side)
    # An arc of chords lies inside its circle: grow by so much more that the chords touch it from outside.
    grown = clearance_mm / np.cos(np.pi / (4 * _ARC)) + 2 * _OUTLINE_MM + _ROUNDING_MM
    frame = own_frame(board)
    own = [into_frame(outline, frame) for outline in (*(obstacle.outline for obstacle in obstacles), board.outline)]
    heights = np.array([obstacle.height_mm + clearance_mm + _ROUNDING_MM for obstacle in obstacles])
    # The bare board is a body too.
    grounds = [*_plain(own[:-1]), own[-1]]
    zones = [out_of_frame(zone, frame) for zone in shapely.buffer(grounds, grown, quad_segs=_ARC)]
    return Floors(tuple(zones), np.append(heights, clearance_mm + _ROUNDING_MM), STRtree(zones))


def _plain(outlines: list[Polygon]) -> list[Polygon]:
    """Replace outlines by their hulls where that takes little more room: rows of pins make a buffer slow."""
    hulls = shapely.convex_hull(outlines)
    slim = shapely.area(hulls) <= _HULL_SHARE * shapely.area(outlines)
    simple = shapely.simplify(outlines, _OUTLINE_MM)
    return list(np.where(slim, hulls, simple))
