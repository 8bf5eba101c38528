"""Contours: rings inside the edge of a plane face, sections of a curved one; a cylinder is gone around."""

import numpy as np
import shapely

from boards.board import Face
from geometry.arrays import Points, Points2, Scalars
from geometry.polygons import polygons_of
from geometry.solids.sections import Section, cut_section, least_bent_axis, length_of, resample, surface_mesh
from rulesengine.surface.site import PartSite
from rulesengine.surface.striping.stripe import Plane, Stripe, flat_stripe, rings_of, stripe_longest_edge

_LEVELS = 400
_STEEPEST = 12.0
"""Millimetres over the surface for one along the axis, at most: where a surface closes over its axis."""
SHORT = 0.1
"""Of the footprint's diameter: shorter pieces of a section are left to their neighbours."""


def stripe_contour(site: PartSite, plane: Plane) -> list[Stripe]:
    """Rings at equal distances inside the edge of a plane face, the outermost first.

    A face narrower than a stripe has no ring: it gets stripes along its longest edge.
    """
    depth = _depth(plane)
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


def _depth(plane: Plane) -> float:
    """Greatest distance of a point of a face from its edge, mm."""
    low, high = 0.0, float(np.sqrt(plane.region.area))
    for _ in range(30):
        middle = (low + high) / 2
        low, high = (low, middle) if shapely.buffer(plane.region, -middle).is_empty else (middle, high)
    return low


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


def surface_levels(heights: Scalars, slopes: Scalars, areas: Scalars, width_mm: float) -> tuple[Scalars, float]:
    """Levels of sections that are equally far apart over the surface, and that distance.

    Args:
        heights: (n, 3) of the corners of the patches along the axis.
        slopes: (n,) cosine between each patch's normal and the axis.
        areas: (n,) of the patches.
        width_mm: Largest distance.
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
    count = max(1, int(np.ceil(along[-1] / width_mm - 1e-3)))
    places = (np.arange(count) + 0.5) * along[-1] / count
    return np.interp(places, along, edges), float(along[-1] / count)
