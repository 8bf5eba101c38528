"""See that the parts of a sample neither touch each other nor leave the board."""

from collections.abc import Sequence

import numpy as np
import shapely
from sample_boards.shapes import Ring
from shapely import Polygon, STRtree

from boards.board import Body

SMALLEST_GAP_MM = 0.2


def check_inside(body: Body, overhang_mm: float, outline: Ring, holes: Sequence[Ring]) -> None:
    """Raise ValueError when a part reaches over the edge, further than it may, or over a hole of the board."""
    shadow = _shadow(body, -np.inf, np.inf)
    if not Polygon(outline).buffer(overhang_mm).contains(shadow):
        raise ValueError(f"{body.name} reaches over the edge of the board")
    for hole in holes:
        if Polygon(hole).distance(shadow) < SMALLEST_GAP_MM:
            raise ValueError(f"{body.name} lies over a hole of the board")


def check_holes(outline: Ring, holes: Sequence[Ring]) -> None:
    """Raise ValueError when holes come nearer than 0.2 mm to each other or to the edge of the board."""
    edges = [shapely.linearrings(ring) for ring in (outline, *holes)]
    near = STRtree(edges).query(edges, predicate="dwithin", distance=SMALLEST_GAP_MM)
    if near.shape[1] > len(edges) or not Polygon(outline, holes).is_valid:
        raise ValueError("two holes, or a hole and the edge of the board, are too near to each other")


def check_apart(bodies: Sequence[Body], bottom: float, top: float) -> None:
    """Raise ValueError when two parts come nearer than 0.2 mm above the top or below the bottom of the board."""
    for low, high in ((top, np.inf), (-np.inf, bottom)):
        shadows = [_shadow(body, low, high) for body in bodies]
        tree = STRtree(shadows)
        pairs = tree.query(shadows, predicate="dwithin", distance=SMALLEST_GAP_MM - 1e-6)
        for one, other in pairs.T:
            if one < other:
                raise ValueError(f"{bodies[one].name} and {bodies[other].name} are too near to each other")


def _shadow(body: Body, low: float, high: float) -> shapely.Geometry:
    """Project what a body has between two heights."""
    z = body.patches[:, :, 2]
    seen = body.patches[(z.max(axis=1) > low + 1e-6) & (z.min(axis=1) < high - 1e-6)]
    return shapely.union_all(shapely.convex_hull(shapely.linestrings(seen[:, :, :2])))
