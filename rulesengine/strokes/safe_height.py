"""How high the orifice must be where: every body as a prism grown by the clearance."""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString, Polygon, STRtree, get_coordinates, get_parts

from boards.board import Board, Side
from geometry.arrays import Points2, Scalars
from rulesengine.strokes.stroke import into_frame, out_of_frame, own_frame

Span: TypeAlias = tuple[float, float, float]
"""From and to along a path, mm, and the least height there."""

_ROUNDING_MM = 0.02  # outlines are simplified and programs rounded; never nearer than required because of it
_OUTLINE_MM = 0.05
_CHORD_MM = 0.03  # the program cuts a rounded corner by this much more, from sample to sample
_ARC = 8
_SAME_MM = 1e-6
_HULL_SHARE = 1.5  # a clamp around the whole board must not become a lid


@dataclass(frozen=True, slots=True, eq=False)
class Floors:
    """Zones in plan and the least height of the orifice over each; side frame, mm."""

    zones: tuple[Polygon, ...]
    heights: Scalars
    tree: STRtree
    corner_mm: float = 0.0
    """How much higher than a floor a path that has a corner above it must lie, because the corner will be cut."""

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
        """Stretches of an open plan path over zones that require more than the height ``above``."""
        if self.highest <= above + _SAME_MM or not self.zones:
            return []
        lengths = np.linalg.norm(np.diff(path, axis=0), axis=1)
        starts = np.cumsum(lengths) - lengths
        ends = np.stack([path[:-1], path[1:]], axis=1)
        segments: NDArray[np.object_] = np.asarray(shapely.linestrings(ends), dtype=np.object_)
        segment, zone = self.tree.query(segments, predicate="intersects")
        higher = self.heights[zone] > above + _SAME_MM
        segment, zone = segment[higher], zone[higher]
        zones: NDArray[np.object_] = np.array(self.zones, dtype=object)
        pieces, pair = get_parts(shapely.intersection(segments[segment], zones[zone]), return_index=True)
        # A turn on the spot has no length to cross anything with, and leaves no coordinates.
        corners, piece = get_coordinates(pieces, return_index=True)
        along = np.linalg.norm(corners - path[segment[pair[piece]]], axis=1)
        _, first = np.unique(piece, return_index=True)
        if len(first) == 0:
            return []
        owner = pair[piece[first]]
        begin = starts[segment[owner]]
        low, high = np.minimum.reduceat(along, first), np.maximum.reduceat(along, first)
        spans = zip(begin + low, begin + high, self.heights[zone[owner]], strict=True)
        return [(float(start), float(end), float(floor)) for start, end, floor in spans]


def floors(board: Board, side: Side, clearance_mm: float, blend_mm: float = 0.0) -> Floors:
    """Grow every body of a side by the clearance, outwards and upwards, and outwards by what corners are cut by."""
    obstacles = board.obstacles(side)
    # An arc of chords lies inside its circle: grow by so much more that the chords touch it from outside.
    cut = blend_mm + _CHORD_MM if blend_mm else 0.0
    grown = (clearance_mm + cut) / np.cos(np.pi / (4 * _ARC)) + 2 * _OUTLINE_MM + _ROUNDING_MM
    frame = own_frame(board)
    own = [into_frame(outline, frame) for outline in (*(obstacle.outline for obstacle in obstacles), board.outline)]
    heights = np.array([obstacle.height_mm + clearance_mm + _ROUNDING_MM for obstacle in obstacles])
    # Hulls where they take little more room, because rows of pins make a buffer slow. The bare board is a body too.
    hulls = shapely.convex_hull(own[:-1])
    slim = shapely.area(hulls) <= _HULL_SHARE * shapely.area(own[:-1])
    simple = np.where(slim, hulls, shapely.simplify(own[:-1], _OUTLINE_MM))
    grounds = [*simple, own[-1]]
    zones = [out_of_frame(zone, frame) for zone in shapely.buffer(grounds, grown, quad_segs=_ARC)]
    return Floors(tuple(zones), np.append(heights, clearance_mm + _ROUNDING_MM), STRtree(zones), cut)
