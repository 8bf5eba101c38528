"""Component perimeter: along the edges of each component, or of components that stand close together."""

from fnmatch import fnmatchcase

import numpy as np
from shapely import Polygon, STRtree

from boards.board import Component
from geometry.arrays import Points2
from recipes.footprint import core_footprint, mean_angle
from recipes.paths import ComponentPerimeter
from rulesengine.paths.closed_path import Lean, RingRule, leans, offset_rings, ring_stroke
from rulesengine.strokes.board_grid import own_frame
from rulesengine.strokes.outline_groups import Demand, Group, demand, grouped
from rulesengine.strokes.stroke import Site, Stroke, StrokeSet, reference_axes, tilted
from specs.finding import Finding
from specs.finding_rules import NARROW_CORRIDOR, NO_PATH_INSIDE, NOT_CIRCLED, WAVEFRONT_BEHIND_NOZZLE

_LEANS: dict[str, Lean] = {
    "component": "inside",
    "away": "outside",
    "travel": "travel",
    "against_travel": "against_travel",
}
_DIRECTIONS = 8
_AS_NARROW_MM = 1e-3


def plan_component_perimeter(spec: ComponentPerimeter, site: Site) -> StrokeSet:
    """Follow every served component as often as its class says; the order of the rings is free."""
    components = [each for each in site.board.components if each.name in site.served and _wanted(each, spec, site)]
    strokes: list[Stroke] = []
    findings: list[Finding] = []
    offsets: dict[Demand, float] = {}
    frame = own_frame(site.board)
    groups = grouped(components, spec.merge_gap_mm, frame)
    for group in groups:
        asked = demand(group, spec, site.classes)
        if asked.passes == 0:
            continue
        made_by = f"{site.made_by}/{group.name}"
        if asked not in offsets:
            offsets[asked] = ring_offset_mm(spec, asked, site)
        offset = offsets[asked]
        if offset < 0 and spec.align == "wavefront" and spec.toward == "component":
            findings.append(_too_upright(asked, site, made_by))
            offset = max(asked.distance_mm, 0.0)
        rings = offset_rings(group.outline, offset, frame)
        if not rings:
            findings.append(_no_ring(group, offset, made_by))
            rings = offset_rings(group.outline, 0.0, frame)
        findings += _beside(group, rings[0], made_by)
        ring = rings[0] if spec.direction != "clockwise" else rings[0][::-1]
        strokes.append(ring_stroke(ring, _rule(spec, asked), site, made_by))
    findings += _narrow_corridors(groups, spec, site)
    return StrokeSet(tuple(strokes), "free", findings=tuple(findings))


def ring_offset_mm(spec: ComponentPerimeter, asked: Demand, site: Site) -> float:
    """Plan distance of the orifice outside the outline (+), so that wave front or axis lies where it is asked.

    A cone of half angle a tilted by b towards the component has its near wave front at H tan(b - a) from the foot
    of the orifice, its axis at H tan(b); leaning along the edge, it is the cone's flank that is put on the edge.
    """
    tangent = float(np.tan(np.radians(asked.tilt_deg)))
    match spec.toward:
        case "component":
            reach = _front(asked, site, spec.toward) if spec.align == "wavefront" else asked.height_mm * tangent
        case "away":
            reach = -_front(asked, site, spec.toward) if spec.align == "wavefront" else -asked.height_mm * tangent
        case "travel" | "against_travel":
            reach = _front(asked, site, spec.toward) if spec.align == "wavefront" else 0.0
    return asked.distance_mm + reach


def _front(asked: Demand, site: Site, toward: str) -> float:
    """Plan distance from the foot of the orifice to its wave front, mm; the mean over the directions of travel.

    The directions begin with the board's longest edge, so that a ring that is not round is measured the same wherever
    the board lies. Leaning to or from the component it is the near front along the lean, else the flank on the
    component's side.
    """
    x, y = site.board.axis
    angles = np.arctan2(y, x) + np.arange(_DIRECTIONS) * (2 * np.pi / _DIRECTIONS)
    travel = np.column_stack([np.cos(angles), np.sin(angles)])
    lean = leans(travel, _LEANS[toward], 1.0)
    approach = tilted(lean, asked.tilt_deg)
    reference = reference_axes(approach, site.azimuths(travel))
    reaches: list[float] = []
    for index in range(_DIRECTIONS):
        outline = core_footprint(site.nozzle, asked.height_mm, approach[index], reference[index])
        inward = np.array([-travel[index, 1], travel[index, 0]])
        across = toward in ("component", "away")
        reaches.append(float((outline @ lean[index]).min() if across else (outline @ inward).max()))
    return float(np.mean(reaches))


def _wanted(component: Component, spec: ComponentPerimeter, site: Site) -> bool:
    return not spec.only or any(fnmatchcase(site.classes[component.name], pattern) for pattern in spec.only)


def _rule(spec: ComponentPerimeter, asked: Demand) -> RingRule:
    return RingRule(
        height_mm=asked.height_mm,
        speed_mm_s=asked.speed_mm_s,
        tilt_deg=asked.tilt_deg,
        lean=_LEANS[spec.toward],
        corner_deg=spec.corner_deg,
        delay_s=asked.edge_delay_s,
        laps=asked.passes,
        lead_in_mm=spec.lead_in_mm,
    )


def _too_upright(asked: Demand, site: Site, made_by: str) -> Finding:
    angle = np.degrees(mean_angle(site.nozzle))
    message = (
        f"A tilt of {asked.tilt_deg:g} deg is less than the cone's half angle of {angle:.1f} deg: its near wave front "
        f"lies behind the nozzle and cannot be put on the edge from outside. The nozzle itself follows the edge "
        f"instead. Raise tilt_deg to {np.ceil(angle):g} or write align: axis."
    )
    return Finding(WAVEFRONT_BEHIND_NOZZLE, message, made_by)


def _no_ring(group: Group, offset: float, made_by: str) -> Finding:
    place = group.outline.centroid
    message = (
        f"A path {-offset:.2f} mm inside the outline of {group.name} does not exist; the outline itself is followed. "
        "Raise distance_mm."
    )
    return Finding(NO_PATH_INSIDE, message, made_by, (place.x, place.y, 0.0))


def _beside(group: Group, ring: Points2, made_by: str) -> list[Finding]:
    """Members whose middle a path inside the outline leaves outside: it does not go around them."""
    inside = Polygon(ring)
    names = [each.name for each in group.members if not inside.covers(each.outline.centroid)]
    if not names or inside.covers(group.outline):
        return []
    place = group.outline.centroid
    message = f"The path inside the outline does not go around {', '.join(names)}. Raise distance_mm or merge_gap_mm."
    return [Finding(NOT_CIRCLED, message, made_by, (place.x, place.y, 0.0))]


def _narrow_corridors(groups: list[Group], spec: ComponentPerimeter, site: Site) -> list[Finding]:
    """One finding for all corridors between followed outlines that are narrower than the cone."""
    if len(groups) < 2:
        return []
    outlines = [group.outline for group in groups]
    width = 2 * max(demand(group, spec, site.classes).height_mm for group in groups) * np.tan(mean_angle(site.nozzle))
    tree = STRtree(outlines)
    first, second = tree.query(outlines, predicate="dwithin", distance=width)
    pairs = [(int(a), int(b)) for a, b in zip(first, second, strict=True) if a < b]
    if not pairs:
        return []
    gaps = [round(outlines[a].distance(outlines[b]), 6) for a, b in pairs]
    narrowest = int(np.argmax(np.array(gaps) < min(gaps) + _AS_NARROW_MM))
    a, b = pairs[narrowest]
    place = outlines[a].centroid
    message = (
        f"{len(pairs)} corridors between followed outlines are narrower than the cone ({width:.1f} mm on the board): "
        f"their edges are sprayed from both sides at once. Narrowest {gaps[narrowest]:.2f} mm, between "
        f"{groups[a].name} and {groups[b].name}. Lower height_mm if they must be served apart."
    )
    return [Finding(NARROW_CORRIDOR, message, site.made_by, (place.x, place.y, site.board.top_z_mm))]
