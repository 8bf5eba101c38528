"""Stripes: where the centre of the cone goes on a face; plane faces as polygons, and straight stripes across them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely import Polygon

from boards.board import Face
from geometry.arrays import Directions, Points, Points2, Triangles
from geometry.coverage.stripes import join_spans
from geometry.polygons import Region, canonical, drop_collinear, polygons_of, project
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
    return min(tried, key=lambda stripes: (len(stripes), round(sum(_length(each) for each in stripes), 1)))


def _length(stripe: Stripe) -> float:
    return float(np.linalg.norm(np.diff(stripe.targets, axis=0), axis=1).sum())
