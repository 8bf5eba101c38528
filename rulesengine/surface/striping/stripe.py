"""Stripes: where the centre of the cone goes on a face: straight ones across plane faces, and contours.

Contours are rings inside the edge of a plane face, sections of a curved one; a cylinder is gone around.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from shapely import Polygon

from boards.board import Face
from geometry.arrays import Directions, Points, Points2, Scalars, Triangles
from geometry.coverage.stripes import join_spans
from geometry.polygons import Region, canonical, drop_collinear, polygons_of, project
from geometry.solids.sections import Section, cut_section, least_bent_axis, length_of, resample, surface_mesh
from recipes.paths import Surface
from rulesengine.surface.site import PartSite

_INSET = 0.125
"""Of the footprint's diameter: where a stripe begins inside the edge of its face. The cone reaches beyond it."""
_TIE = 1e-3
_UPRIGHT = 0.05
"""Sine of the angle to the normal below which a direction has no projection on a face."""
_TRIED = 12
"""Directions that are tried besides those of the face's edges, 15 degrees apart."""


@dataclass(frozen=True, slots=True, eq=False)
class Stripe:
    """One line over a face that the cone's centre follows. The part's frame, mm."""

    face: str
    targets: Points
    """(n, 3) in order, evenly spaced; a closed one ends at its first point."""
    normals: Directions
    """(n, 3) outward normals of the surface there."""
    width_mm: float
    """Width of the band that it covers."""
    closed: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """A plane face as a region, in a frame that moves with it."""

    face: Face
    origin: Points
    """(3,)"""
    axes: Directions
    """(3, 3) rows: x along a direction of the face, y across it, z the outward normal."""
    region: Region

    def lift(self, points: Points2) -> Points:
        """(n, 3) places of (n, 2) points of the face's frame."""
        return self.origin + points @ self.axes[:2]

    def turned(self, direction: Points2) -> "Plane":
        """Give the face in the frame whose x is along a direction (2,) of this one."""
        x, y = direction
        turn = np.array([[x, y], [-y, x]])
        region = shapely.transform(self.region, lambda points: points @ turn.T)
        return Plane(self.face, self.origin, np.vstack([turn @ self.axes[:2], self.axes[2:]]), region)


def plane_of(face: Face, patches: Triangles) -> Plane:
    """Lay a plane face (k, 3, 3) flat; x is along the first edge of its first patch."""
    origin = patches[0, 0]
    z = np.array(face.normal)
    x = patches[0, 1] - origin
    x -= z * (x @ z)
    x /= np.linalg.norm(x)
    axes = np.stack([x, np.cross(z, x), z])
    flat = (patches - origin) @ axes.T
    flat[:, :, 2] = 0.0
    region = project(flat)
    anchors = flat.reshape(-1, 3)[:, :2]
    pieces = [canonical(drop_collinear(piece), anchors) for piece in polygons_of(region)]
    return Plane(face, origin, axes, shapely.MultiPolygon(pieces) if len(pieces) != 1 else pieces[0])


def edge_directions(plane: Plane) -> list[tuple[Points2, float]]:
    """Directions (2,) and lengths of the straight edges of a plane face, the longest first; parallel ones once."""
    found: list[tuple[Points2, float]] = []
    for piece in polygons_of(plane.region):
        for ring in (piece.exterior, *piece.interiors):
            points = np.asarray(ring.coords)[:, :2]
            edges = np.diff(points, axis=0)
            lengths = np.hypot(edges[:, 0], edges[:, 1])
            found += [
                (edge / length, float(length)) for edge, length in zip(edges, lengths, strict=True) if length > _TIE
            ]
    found.sort(key=lambda each: -round(each[1] / 0.01))
    kept: list[tuple[Points2, float]] = []
    for direction, length in found:
        if all(abs(direction[0] * other[1] - direction[1] * other[0]) > 0.01 for other, _ in kept):
            kept.append((direction, length))
    return kept


def stripes_along(site: PartSite, plane: Plane) -> list[Stripe]:
    """Stripes along the x axis of a plane face's frame: bands of equal width, each as long as the face is in it."""
    x_low, y_low, x_high, y_high = plane.region.bounds
    count = max(1, int(np.ceil((y_high - y_low) / site.width_mm - _TIE)))
    width = (y_high - y_low) / count
    stripes: list[Stripe] = []
    for number in range(count):
        low = y_low + number * width
        band = shapely.intersection(plane.region, shapely.box(x_low - 1, low, x_high + 1, low + width))
        bounds = [(piece.bounds[0], piece.bounds[2]) for piece in polygons_of(band)]
        for begin, end in join_spans(bounds, site.diameter_mm / 4.0):
            inset = min(_INSET * site.diameter_mm, width / 2, (end - begin) / 2)
            first, last = begin + inset, end - inset
            places = int(np.ceil((last - first) / site.step_mm - _TIE)) + 1 if last - first > _TIE else 1
            row = np.column_stack([np.linspace(first, last, places), np.full(places, low + width / 2)])
            stripes.append(flat_stripe(plane, row, width))
    return stripes


def flat_stripe(plane: Plane, points: Points2, width: float, *, closed: bool = False) -> Stripe:
    """Give the stripe along (n, 2) points of a plane face's frame."""
    normals = np.tile(plane.axes[2], (len(points), 1))
    return Stripe(plane.face.name, plane.lift(points), normals, width, closed=closed)


def rings_of(polygons: Sequence[Polygon]) -> list[Points2]:
    """All rings of polygons, (k, 2) each, without the repeated first point."""
    return [np.asarray(ring.coords)[:-1, :2] for polygon in polygons for ring in (polygon.exterior, *polygon.interiors)]


def stripe_longest_edge(site: PartSite, plane: Plane) -> list[Stripe]:
    """Stripes along the longest edge of a plane face."""
    return stripes_along(site, plane.turned(edge_directions(plane)[0][0]))


def stripe_along(site: PartSite, plane: Plane) -> list[Stripe]:
    """Stripes along the projection of ``along`` on a plane face; along its longest edge where it has none."""
    spec = site.spec
    assert isinstance(spec, Surface)
    direction = np.array(spec.along) / max(float(np.linalg.norm(spec.along)), 1e-12)
    flat = plane.axes[:2] @ direction
    length = float(np.linalg.norm(flat))
    return stripe_longest_edge(site, plane) if length < _UPRIGHT else stripes_along(site, plane.turned(flat / length))


def stripe_fewest(site: PartSite, plane: Plane) -> list[Stripe]:
    """Stripes along an edge or one of twelve directions: the fewest, of as many the shortest together."""
    longest = edge_directions(plane)
    x, y = longest[0][0]
    angles = np.arange(_TRIED) * np.pi / _TRIED
    turned = [np.array([x * np.cos(a) - y * np.sin(a), x * np.sin(a) + y * np.cos(a)]) for a in angles]
    tried = [stripes_along(site, plane.turned(each)) for each in (*(way for way, _ in longest[:_TRIED]), *turned)]
    lengths = [sum(float(np.linalg.norm(np.diff(each.targets, axis=0), axis=1).sum()) for each in one) for one in tried]
    best = min(range(len(tried)), key=lambda at: (len(tried[at]), round(lengths[at], 1)))
    return tried[best]


_LEVELS = 400
_STEEPEST = 12.0
"""Millimetres over the surface for one along the axis, at most: where a surface closes over its axis."""
SHORT = 0.1
"""Of the footprint's diameter: shorter pieces of a section are left to their neighbours."""


def stripe_contour(site: PartSite, plane: Plane) -> list[Stripe]:
    """Rings at equal distances inside the edge of a plane face, the outermost first.

    A face narrower than a stripe has no ring: it gets stripes along its longest edge.
    """
    depth, high = 0.0, float(np.sqrt(plane.region.area))  # greatest distance of a point from the edge, mm
    for _ in range(30):
        middle = (depth + high) / 2
        depth, high = (depth, middle) if shapely.buffer(plane.region, -middle).is_empty else (middle, high)
    count = max(1, int(np.ceil(depth / site.width_mm - 1e-3)))
    width = depth / count
    stripes: list[Stripe] = []
    for number in range(count):
        inside = shapely.buffer(plane.region, -(number + 0.5) * width, join_style="mitre")
        for ring in rings_of(polygons_of(inside)):
            section = resample(Section(_flat(ring), _flat(ring), closed=True), site.step_mm)
            points = np.vstack([section.points, section.points[:1]])[:, :2]
            stripes.append(flat_stripe(plane, points, width, closed=True))
    return stripes or stripe_longest_edge(site, plane)


def _flat(points: Points2) -> Points:
    return np.column_stack([points, np.zeros(len(points))])


def stripe_curved(site: PartSite, face: Face) -> list[Stripe]:
    """Sections of a curved face across the direction that its normals are least along; spaced over the surface."""
    patches = site.patches_of(face)
    mesh = surface_mesh(patches)
    axis = least_bent_axis(mesh.facing, mesh.areas_mm2, patches[0, 1] - patches[0, 0])
    heights = mesh.points @ axis
    levels, width = surface_levels(heights[mesh.corners], mesh.facing @ axis, mesh.areas_mm2, site.width_mm)
    return [
        curve_stripe(site, face, section, width)
        for level in levels
        for section in cut_section(mesh, heights, float(level))
        if length_of(section) > SHORT * site.diameter_mm
    ]


def curve_stripe(site: PartSite, face: Face, section: Section, width: float) -> Stripe:
    """Give the stripe along a curve on a face."""
    even = resample(section, site.step_mm)
    points, normals = even.points, even.normals
    if section.closed:
        points, normals = np.vstack([points, points[:1]]), np.vstack([normals, normals[:1]])
    return Stripe(face.name, points, normals, width, closed=section.closed)


def run_on(stripe: Stripe, overshoot_mm: float, step_mm: float) -> Stripe:
    """Extend an open stripe straight on past both of its ends, in steps of at most ``step_mm``."""
    if stripe.closed or not overshoot_mm or len(stripe.targets) < 2:
        return stripe
    count = int(np.ceil(overshoot_mm / step_mm))
    far = overshoot_mm * np.arange(1, count + 1)[:, None] / count
    first, last = stripe.targets[0] - stripe.targets[1], stripe.targets[-1] - stripe.targets[-2]
    before = stripe.targets[0] + far[::-1] * first / np.linalg.norm(first)
    after = stripe.targets[-1] + far * last / np.linalg.norm(last)
    normals = [np.repeat(stripe.normals[[at]], count, axis=0) for at in (0, -1)]
    return replace(
        stripe,
        targets=np.vstack([before, stripe.targets, after]),
        normals=np.vstack([normals[0], stripe.normals, normals[1]]),
    )


def surface_levels(
    heights: Scalars, slopes: Scalars, areas: Scalars, width_mm: float, count: int | None = None
) -> tuple[Scalars, float]:
    """Levels of sections that are equally far apart over the surface, and that distance.

    Args:
        heights: (n, 3) of the corners of the patches along the axis.
        slopes: (n,) cosine between each patch's normal and the axis.
        areas: (n,) of the patches.
        width_mm: Largest distance.
        count: Number of levels, whatever their distance; as many as ``width_mm`` needs where it is left out.
    """
    low, high = heights.min(), heights.max()
    edges = np.linspace(low, high, _LEVELS + 1)
    stretch = np.minimum(1.0 / np.sqrt(np.maximum(1.0 - slopes**2, 1e-6)), _STEEPEST)
    first = np.clip(np.searchsorted(edges, heights.min(axis=1), side="right") - 1, 0, _LEVELS - 1)
    last = np.clip(np.searchsorted(edges, heights.max(axis=1), side="left") - 1, first, _LEVELS - 1)
    share = areas / (last - first + 1)
    weights, sums = np.zeros(_LEVELS + 1), np.zeros(_LEVELS + 1)
    for values, into in ((share, weights), (share * stretch, sums)):
        np.add.at(into, first, values)
        np.subtract.at(into, last + 1, values)
    weights, sums = np.cumsum(weights)[:-1], np.cumsum(sums)[:-1]
    mean = np.where(weights > 1e-12, sums / np.maximum(weights, 1e-12), 1.0)
    along = np.concatenate([[0.0], np.cumsum(mean * np.diff(edges))])
    count = count or max(1, int(np.ceil(along[-1] / width_mm - 1e-3)))
    places = (np.arange(count) + 0.5) * along[-1] / count
    return np.interp(places, along, edges), float(along[-1] / count)
