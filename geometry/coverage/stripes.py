"""Parallel stripes across a region (Sandia 1993, section 2.1: stripes as wide as the cone's effective width)."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from shapely import MultiPolygon, Polygon, affinity, box, get_parts, intersection

from geometry.arrays import Points2

_SLIVER_MM = 1e-3  # what reaches less than this into a stripe's band needs no stripe there


@dataclass(frozen=True, slots=True, eq=False)
class Stripe:
    """One stripe: the stretches of its centreline that serve the region, in the direction of travel."""

    stretches: tuple[Points2, ...]
    """(2, 2) start and end of each, mm."""


def stripe_count(width_mm: float, pitch_mm: float) -> int:
    """Fewest stripes at most ``pitch_mm`` apart that serve ``width_mm``; at least one."""
    return max(1, int(np.ceil((width_mm - _SLIVER_MM) / pitch_mm)))


def stripes(
    region: Polygon | MultiPolygon, direction: Points2, pitch_mm: float, bridge_mm: float, spread: float = 1.0
) -> list[Stripe]:
    """Lay stripes across a region.

    Every stripe serves a band of its own; bands tile the region, all equally wide and at most ``pitch_mm``. A stripe
    runs along the middle of its band for as long as the region goes on anywhere in the band, so that slanted edges
    and corners between centrelines are served too. With a ``spread`` below 1 centrelines are drawn together about the
    region's middle; bands meet halfway between them, and the outermost reach to the region's edge.

    Args:
        region: What is to be served.
        direction: (2,) unit vector of travel.
        pitch_mm: Largest distance between neighbouring centrelines.
        bridge_mm: Gaps along a stripe up to this length are run through.
        spread: Distance of neighbouring centrelines, as a share of that of even ones; above 0, at most 1.

    Returns:
        Stripes from right to left, seen along ``direction``; stretches along it.
    """
    angle = np.degrees(np.arctan2(direction[1], direction[0]))
    level = affinity.rotate(region, -angle, origin=(0, 0))
    x_min, y_min, x_max, y_max = level.bounds
    count = stripe_count(y_max - y_min, pitch_mm)
    pitch = (y_max - y_min) / count
    sliver = min(_SLIVER_MM, spread * pitch / 4)
    middle = (y_min + y_max) / 2
    rows: list[Stripe] = []
    for row in range(count):
        low, high = y_min + row * pitch, y_min + row * pitch + pitch
        centre = low + pitch / 2
        # Not from the middle outwards: at a spread of 1 nothing is added to even places, not even rounding.
        centre += (1 - spread) * (middle - centre)
        low += (1 - spread) * (middle - low) if row > 0 else 0.0
        high += (1 - spread) * (middle - high) if row < count - 1 else 0.0
        band = intersection(level, box(x_min - 1, low + sliver, x_max + 1, high - sliver))
        spans = join_spans([piece.bounds[::2] for piece in get_parts(band) if piece.area > 0], bridge_mm)
        if spans:
            across = centre * np.array([-direction[1], direction[0]])
            rows.append(Stripe(tuple(np.outer(span, direction) + across for span in spans)))
    return rows


def join_spans(spans: Iterable[tuple[float, float]], gap: float) -> list[tuple[float, float]]:
    """Spans from and to, ascending; those no farther apart than a gap are one."""
    joined: list[tuple[float, float]] = []
    for begin, end in sorted(spans):
        if joined and begin - joined[-1][1] <= gap:
            joined[-1] = (joined[-1][0], max(joined[-1][1], end))
        else:
            joined.append((begin, end))
    return joined
