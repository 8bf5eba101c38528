"""Plane polygons: shadows of meshes, closed gaps, and rings whose beginning depends on the shape, not the library.

Everything here is the same for the same numbers; to be the same for a moved shape, work on a ``GridFrame``.
"""

from collections.abc import Iterable, Sequence
from typing import TypeAlias

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from geometry.arrays import Points2, Triangles

Region: TypeAlias = Polygon | MultiPolygon

GRID_MM = 2.0**-17
"""Spacing of the grid on which shapes are joined. A decimal fraction never lies half-way between two of its points,
so the last bits of a number that a person typed cannot decide to which of them it goes."""

_ANCHOR_MM = 16.0 * GRID_MM
_LEAST_AREA_MM2 = 1e-9
_HAIR_MM = 1e-3
_TRIANGLE = 3
_SURE = 1.01
_BLUNT = 0.5
"""Cosine of 60 degrees: an offset with mitres cuts corners off from 39 degrees down."""


def to_grid(values: Points2) -> Points2:
    """Round coordinates to the grid."""
    return np.round(values / GRID_MM) * GRID_MM


def project(patches: Triangles) -> Region:
    """Project triangles on the plane z = 0: the union of all of them, whichever way they are wound.

    Args:
        patches: (n, 3, 3) triangles, mm; open or closed, overlapping as they like.

    Returns:
        The region in their shadow; empty where every triangle is upright.
    """
    from manifold3d import CrossSection, FillRule  # late: only readers of boards need it

    corners = to_grid(patches[:, :, :2])
    side, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    doubled = side[:, 0] * other[:, 1] - side[:, 1] * other[:, 0]
    corners = np.where((doubled < 0.0)[:, None, None], corners[:, ::-1], corners)
    corners = corners[np.abs(doubled) > _LEAST_AREA_MM2]
    if not len(corners):
        return Polygon()
    shadow = CrossSection(list(corners), FillRule.NonZero)
    pieces = [shadow] if shadow.num_contour() <= 1 else shadow.decompose()
    polygons: list[Polygon] = []
    for piece in pieces:
        rings: list[Points2] = [np.asarray(ring, dtype=np.float64) for ring in piece.to_polygons()]  # pyright: ignore
        outer = max(range(len(rings)), key=lambda place: abs(signed_area(rings[place])))
        polygons.append(Polygon(rings[outer], [ring for place, ring in enumerate(rings) if place != outer]))
    polygons = [polygon for polygon in polygons if polygon.area > _LEAST_AREA_MM2]
    region = shapely.union_all(polygons) if len(polygons) > 1 else polygons[0] if polygons else Polygon()
    return _areas_only(region)


def signed_area(ring: Points2) -> float:
    """Area inside a ring, positive when it runs counter-clockwise; the first point need not be repeated."""
    moved = ring - ring[0]
    after = np.concatenate((moved[1:], moved[:1]))  # a third of the time of np.roll on the few corners of a part
    return float(np.sum(moved[:, 0] * after[:, 1] - moved[:, 1] * after[:, 0]) / 2.0)


def _areas_only(shape: BaseGeometry) -> Region:
    """Make a shape valid and drop the lines and points that come of it."""
    valid = shape if shape.is_valid else shapely.make_valid(shape, method="structure", keep_collapsed=False)
    pieces = [piece for piece in polygons_of(valid) if piece.area > _LEAST_AREA_MM2]
    if len(pieces) == 1:
        return pieces[0]
    return MultiPolygon(pieces) if pieces else Polygon()


def polygons_of(shape: BaseGeometry) -> list[Polygon]:
    """Return the polygons in a shape, in its order."""
    return [part for part in shapely.get_parts(shape).tolist() if isinstance(part, Polygon) and not part.is_empty]


def close_gaps(region: Region, gap_mm: float) -> Region:
    """Fill notches, slots and distances that are narrower than ``gap_mm``; straight corners stay as they are."""
    reach = gap_mm / 2.0
    wide = region.buffer(reach, join_style="mitre", mitre_limit=3.0)
    closed = wide.buffer(-reach, join_style="mitre", mitre_limit=3.0)
    return _areas_only(shapely.union(closed, region, grid_size=GRID_MM))


def without_gaps(polygon: Polygon, simple_mm: float) -> Polygon | None:
    """Polygon with its points on the grid if ``close_gaps`` and simplifying change nothing else; ``None`` if they may.

    That is so where it is convex, each point stands off the line through its neighbours by more than the tolerance, and
    no corner is so pointed that an offset would cut it off.

    Args:
        polygon: ``canonical``, as most parts seen from above are: four corners.
        simple_mm: Tolerance of simplifying.
    """
    if polygon.interiors:
        return None
    ring = to_grid(shapely.get_coordinates(polygon)[:-1])
    back, on = np.concatenate((ring[-1:], ring[:-1])) - ring, np.concatenate((ring[1:], ring[:1])) - ring
    chord = on - back
    doubled = on[:, 0] * back[:, 1] - on[:, 1] * back[:, 0]  # area of the corner, positive where it is convex
    far = doubled > _SURE * simple_mm * np.hypot(chord[:, 0], chord[:, 1])
    blunt = (on * back).sum(axis=1) < _BLUNT * np.hypot(on[:, 0], on[:, 1]) * np.hypot(back[:, 0], back[:, 1])
    return Polygon(ring) if (far & blunt).all() else None


WIDEST_GAP_MM = 4.0
"""Between pieces that are joined as if there were none."""
_BRIDGE_MM = 0.05
"""Width: wider than what outlines are simplified by, and next to no area."""


def join_pieces(region: Region) -> Polygon:
    """Make one polygon of a region: close gaps that grow until it is one, or else take its convex hull."""
    joined = _closed(region)
    if joined is not None:
        return joined
    hull = region.convex_hull
    return hull if isinstance(hull, Polygon) else Polygon()


def _closed(region: Region, widest_mm: float = WIDEST_GAP_MM) -> Polygon | None:
    """The polygon that a region is once its gaps are closed, narrow ones first; ``None`` where wider ones are left."""
    if len(pieces := polygons_of(region)) == 1:
        return pieces[0]
    for gap in (each for each in (0.02, 0.1, 0.25, 0.5, 1.0, 2.0, WIDEST_GAP_MM) if each <= widest_mm):
        closed = polygons_of(close_gaps(region, gap))
        if len(closed) == 1:
            return closed[0]
    return None


def bridge_pieces(region: Region, widest_mm: float = WIDEST_GAP_MM) -> Polygon:
    """Make one polygon of a region as ``join_pieces`` does, but lead hair-thin bridges over gaps that stay open.

    Args:
        region: Of one piece or several.
        widest_mm: Wider gaps stay open.
    """
    if (closed := _closed(region, widest_mm)) is not None:
        return closed
    hull = region.convex_hull
    pieces = polygons_of(region)
    joined, rest = pieces[:1], pieces[1:]
    while rest:
        whole = shapely.union_all(joined)
        near = min(range(len(rest)), key=lambda place: round(float(shapely.distance(whole, rest[place])), 6))
        piece = rest.pop(near)
        bridge = shapely.shortest_line(whole, piece).buffer(_BRIDGE_MM / 2.0, cap_style="square")
        joined += [piece, bridge.intersection(hull)]
    return join_pieces(_areas_only(shapely.union_all(joined, grid_size=GRID_MM)))


def fill_holes(polygon: Polygon) -> Polygon:
    """Return what is inside a polygon's outer ring."""
    return Polygon(polygon.exterior)


def simplify_within(polygon: Polygon, tolerance_mm: float) -> Polygon:
    """Leave out points that are no farther than the tolerance from what remains; holes stay holes."""
    simple = shapely.simplify(polygon, tolerance_mm, preserve_topology=True)
    return simple if simple.is_valid and not simple.is_empty else polygon


def fill_notches(polygon: Polygon, depth_mm: float) -> Polygon:
    """Cut off points that lie no deeper than ``depth_mm`` inside the line between their neighbours, shallowest first.

    The outer ring only grows and ends with fewer points: teeth and steps become straight edges; holes are left out.
    """
    ring = _ring(polygon.exterior.coords, ccw=True)
    while len(ring) > _TRIANGLE:
        before, after = np.concatenate((ring[-1:], ring[:-1])), np.concatenate((ring[1:], ring[:1]))
        chord, inner = after - before, ring - before
        length = np.hypot(chord[:, 0], chord[:, 1])
        deep = (chord[:, 0] * inner[:, 1] - chord[:, 1] * inner[:, 0]) / np.maximum(length, _HAIR_MM)
        depth = np.where(deep > _HAIR_MM, np.round(deep / _ANCHOR_MM) * _ANCHOR_MM, np.inf)
        shallowest = int(np.argmin(depth))
        if depth[shallowest] > depth_mm:
            break
        ring = np.delete(ring, shallowest, axis=0)
    filled = Polygon(ring)
    return filled if filled.is_valid else polygon


def drop_collinear(polygon: Polygon) -> Polygon:
    """Leave out points that lie within a micrometre of the straight line through their neighbours."""
    return simplify_within(polygon, _HAIR_MM)


def canonical(polygon: Polygon, anchors: Points2) -> Polygon:
    """Make the order of points a property of the shape: outer ring counter-clockwise, holes clockwise.

    Each ring begins at the point nearest to the first anchor (to 0.0001 mm; the next anchors decide ties), and
    holes are ordered by the same distances.

    Args:
        polygon: Any valid polygon.
        anchors: (k, 2) points that move with the shape, such as the vertices of its mesh in file order.
    """
    outer = _begin(_ring(polygon.exterior.coords, ccw=True), anchors)
    holes = [_begin(_ring(hole.coords, ccw=False), anchors) for hole in polygon.interiors]
    if len(holes) > 1:
        starts = np.array([hole[0] for hole in holes])
        # Distances to the first three anchors that are not in line identify a point.
        reference, away = anchors[:1], np.flatnonzero(_quantised(anchors, anchors[0]) > 0)
        if len(away):
            x, y = anchors[away[0]] - anchors[0]
            across = np.abs((anchors - anchors[0]) @ (np.array([-y, x]) / np.linalg.norm((x, y))))
            third = np.flatnonzero(across > _ANCHOR_MM)[:1]
            reference = np.vstack([anchors[0], anchors[away[0]], *anchors[third]])
        keys = [_quantised(starts, anchor) for anchor in reference]
        holes = [holes[place] for place in np.lexsort(keys[::-1]).tolist()]
    return Polygon(outer, holes)


def _ring(coords: Iterable[Sequence[float]], *, ccw: bool) -> Points2:
    ring = np.asarray(coords, dtype=np.float64)[:-1, :2]
    return ring if (signed_area(ring) > 0.0) == ccw else ring[::-1]


def _begin(ring: Points2, anchors: Points2) -> Points2:
    first = np.arange(len(ring))
    for anchor in anchors:
        distance = _quantised(ring[first], anchor)
        first = first[distance == distance.min()]
        if len(first) == 1:
            break
    return np.concatenate((ring[first[0] :], ring[: first[0]]))


def _quantised(points: Points2, anchor: Points2) -> Points2:
    return np.round(np.hypot(points[:, 0] - anchor[0], points[:, 1] - anchor[1]) / _ANCHOR_MM)
