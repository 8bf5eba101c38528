"""Closed strokes around an outline, shared by board and component perimeters."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from shapely import Polygon

from geometry.arrays import Directions2, Points2
from geometry.gridframe import GridFrame
from geometry.polygons import canonical
from rulesengine.strokes.stroke import Site, Stroke, into_frame, out_of_frame, tilted
from specs.source import Source

Lean: TypeAlias = Literal["inside", "outside", "travel", "against_travel"]
_MITRE = 3.0  # corners sharper than about 39 degrees are cut off
_MOST_ENTRIES = 8  # more places to begin do not save a measurable length of air travel


@dataclass(frozen=True, slots=True)
class RingRule:
    """How an outline is to be followed."""

    height_mm: float
    speed_mm_s: float
    tilt_deg: float
    lean: Lean
    corner_deg: float
    delay_s: float
    laps: int
    lead_in_mm: float


def ring_stroke(ring: Points2, rule: RingRule, site: Site, made_by: Source) -> Stroke:
    """Follow a ring at a constant height.

    Bends of at least ``corner_deg`` are corners: there the nozzle stops, waits, and turns on the spot to the
    lean of the next edge; smaller bends are taken in passing with the direction in between.

    Args:
        ring: (n, 2) vertices in the sense of travel, the first not repeated.
        rule: Height, speed, tilt and pauses.
        site: Board and nozzle.
        made_by: Recipe path of the stroke.

    Returns:
        A closed stroke in the side frame; it leaves from the ring's first vertex, or from any of its ``entries``.
    """
    along = _units(np.roll(ring, -1, axis=0) - ring)
    before = np.roll(along, 1, axis=0)
    cross = before[:, 0] * along[:, 1] - before[:, 1] * along[:, 0]
    bends = np.degrees(np.abs(np.arctan2(cross, np.sum(before * along, axis=1))))
    corner = np.round(bends, 3) >= rule.corner_deg
    smooth = _units(along + before)
    turns_around = rule.tilt_deg > 0 or not np.allclose(site.azimuths(along), site.azimuths(before))
    vertices: list[int] = []
    travel: list[Directions2] = []
    delays: list[float] = []
    departures: list[int] = []
    for vertex in range(len(ring)):
        stops = bool(corner[vertex])
        if stops and turns_around:
            vertices.append(vertex)
            travel.append(before[vertex])
            delays.append(rule.delay_s)
        departures.append(len(vertices))
        vertices.append(vertex)
        travel.append(along[vertex] if stops else smooth[vertex])
        delays.append(rule.delay_s if stops and not turns_around else 0.0)
    order = np.roll(np.arange(len(vertices)), -departures[0])
    directions = np.array(travel)[order]
    # It may leave from its corners, thinned out evenly; a smooth ring from anywhere.
    leaving = np.array(departures)[corner] if corner.any() else np.array(departures)
    entries = tuple((leaving - departures[0])[:: -(-len(leaving) // _MOST_ENTRIES)].tolist())
    points = ring[np.array(vertices)[order]]
    return Stroke(
        tcp=np.column_stack([points, np.full(len(points), rule.height_mm)]),
        approach=tilted(leans(directions, rule.lean, _sense(ring)), rule.tilt_deg),
        azimuth=site.azimuths(directions),
        delays=np.array(delays)[order],
        speed_mm_s=rule.speed_mm_s,
        made_by=made_by,
        closed=True,
        laps=rule.laps,
        entries=entries,
        lead_in_mm=rule.lead_in_mm,
    )


def _units(vectors: Points2) -> Directions2:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _sense(ring: Points2) -> float:
    """+1 for a counterclockwise ring, -1 for a clockwise one."""
    x, y = ring.T
    return 1.0 if float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) > 0 else -1.0


def leans(travel: Directions2, lean: Lean, sense: float) -> Directions2:
    """(n, 2) plan directions of the jet along a ring; ``sense`` is +1 for a counterclockwise ring, -1 for the other."""
    left = np.column_stack([-travel[:, 1], travel[:, 0]])
    match lean:
        case "inside":
            return left * sense
        case "outside":
            return -left * sense
        case "travel":
            return travel
        case "against_travel":
            return -travel


def offset_rings(outline: Polygon, distance_mm: float, frame: GridFrame) -> list[Points2]:
    """Rings of an outline moved away from it, corners kept sharp: the outer one first, then those of its holes.

    All run counterclockwise, begin at the corner that belongs to the outline's first, and move with the outline.
    """
    own = into_frame(outline, frame)
    grown = own.buffer(distance_mm, join_style="mitre", mitre_limit=_MITRE) if distance_mm else own
    if grown.is_empty or grown.geom_type != "Polygon":
        return []
    moved = out_of_frame(canonical(grown, np.array(own.exterior.coords)), frame)
    rings = [np.array(ring.coords)[:-1] for ring in (moved.exterior, *moved.interiors)]
    return [ring if _sense(ring) > 0 else np.concatenate([ring[:1], ring[:0:-1]]) for ring in rings]
