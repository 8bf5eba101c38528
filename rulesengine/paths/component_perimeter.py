"""Component perimeter: along the edges of each component, or of components that stand close together.

Those are followed as one outline, with values of the template for the group.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from functools import lru_cache
from typing import cast

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from shapely import Polygon, STRtree, transform, union_all

from boards.board import Component
from geometry.arrays import Points2
from geometry.gridframe import GridFrame
from geometry.polygons import (
    Region,
    canonical,
    close_gaps,
    fill_holes,
    fill_notches,
    join_pieces,
    simplify_within,
    to_grid,
)
from recipes.footprint import core_footprint, mean_angle
from recipes.paths import ComponentPerimeter, for_class
from rulesengine.paths.closed_path import Lean, RingRule, leans, offset_rings, ring_stroke
from rulesengine.strokes.stroke import (
    Site,
    Stroke,
    StrokeSet,
    into_frame,
    out_of_frame,
    own_frame,
    reference_axes,
    tilted,
)
from specs.finding import Finding
from specs.finding_rules import NARROW_CORRIDOR, NO_PATH_INSIDE, NOT_CIRCLED, WAVEFRONT_BEHIND_NOZZLE
from specs.source import Source

_TOUCH_MM = 1e-4  # outlines are exact to about this; nearer is as good as touching
_OUTLINE_MM = 0.05
_NOTCH_GAPS = 3  # between parts followed as one, notches up to so many merge gaps are passed over
_RECTANGLE, _HULL_OF_ONE, _HULL_OF_MANY = 1.12, 1.1, 1.25  # how much larger than the outline each may be


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """Components that stand closer than the gap of the template, in the order of the board."""

    members: tuple[Component, ...]
    outline: Polygon

    @property
    def name(self) -> str:
        """Names of the members, joined by ``+``."""
        return "+".join(member.name for member in self.members)


@dataclass(frozen=True, slots=True)
class GroupValues:
    """Values of a template for a group, by the classes and neighbours of its members; the most demanding decides."""

    height_mm: float
    speed_mm_s: float
    tilt_deg: float
    distance_mm: float
    passes: int
    edge_delay_s: float


@lru_cache(maxsize=8)
def group_outlines(components: tuple[Component, ...], gap_mm: float, frame: GridFrame) -> tuple[Group, ...]:
    """Join components that are closer than the gap, directly or by way of others; groups by their first member.

    Outlines are joined and simplified on the grid of the frame, which moves with the board. The last results are
    kept: most edits of a recipe group the same components.
    """
    if not components:
        return ()
    outlines = [component.outline for component in components]
    first, second = STRtree(outlines).query(outlines, predicate="dwithin", distance=max(gap_mm - _TOUCH_MM, 0.0))
    count = len(components)
    links = coo_array((np.ones(len(first)), (first, second)), shape=(count, count))
    _, labels = connected_components(links, directed=False)
    groups: dict[int, list[Component]] = {}
    for component, label in zip(components, labels, strict=True):
        groups.setdefault(int(label), []).append(component)
    found: list[Group] = []
    for members in groups.values():
        followed = _outline([into_frame(member.outline, frame) for member in members], gap_mm)
        on_grid = transform(followed, to_grid)
        found.append(Group(tuple(members), out_of_frame(on_grid if on_grid.is_valid else followed, frame)))
    return tuple(found)


def _outline(outlines: list[Polygon], gap_mm: float) -> Polygon:
    if len(outlines) == 1:
        return _plain(outlines[0], _HULL_OF_ONE)
    anchors = np.concatenate([np.array(outline.exterior.coords) for outline in outlines])
    apart = cast(Region, union_all(outlines))
    joined = fill_holes(join_pieces(close_gaps(apart, gap_mm + 2 * _OUTLINE_MM)))
    smooth = fill_holes(join_pieces(close_gaps(joined, _NOTCH_GAPS * gap_mm)))
    plain = fill_notches(_plain(smooth, _HULL_OF_MANY), gap_mm)
    return simplify_within(canonical(plain, anchors), _OUTLINE_MM)


def _plain(outline: Polygon, hull_share: float) -> Polygon:
    """Leave out notches that no wave front could follow: a rectangle or the hull, where it is hardly larger.

    Every corner of a perimeter is a stop; the cut corners of a quad flat pack would be twelve of them.
    """
    anchors = np.array(outline.exterior.coords)
    for simpler, share in ((outline.minimum_rotated_rectangle, _RECTANGLE), (outline.convex_hull, hull_share)):
        if isinstance(simpler, Polygon) and simpler.area <= share * outline.area:
            return canonical(simpler, anchors)
    return outline


def group_values(group: Group, spec: ComponentPerimeter, classes: dict[str, str]) -> GroupValues:
    """Values of a group: slowest speed, most passes, longest pause; tilt and distance of the largest member."""
    largest = max(group.members, key=lambda member: round(member.area_mm2, 3))

    def of(member: Component, key: str) -> float:
        near = spec.near is not None and member.neighbour_mm <= spec.near.within_mm
        instead: float | None = getattr(spec.near, key, None) if near else None
        return float(for_class(getattr(spec, key), classes[member.name])) if instead is None else instead

    return GroupValues(
        height_mm=max(of(member, "height_mm") for member in group.members),
        speed_mm_s=min(of(member, "speed_mm_s") for member in group.members),
        tilt_deg=of(largest, "tilt_deg"),
        distance_mm=of(largest, "distance_mm"),
        passes=int(max(of(member, "passes") for member in group.members)),
        edge_delay_s=max(of(member, "edge_delay_s") for member in group.members),
    )


_LEANS: dict[str, Lean] = {
    "component": "inside",
    "away": "outside",
    "travel": "travel",
    "against_travel": "against_travel",
}
_DIRECTIONS = 8
_AS_NARROW_MM = 1e-3


def plan_component_perimeter(spec: ComponentPerimeter, site: Site) -> StrokeSet:
    """Follow every served component as often as its class requires; the order of the rings is free."""
    components = tuple(
        each
        for each in site.board.components
        if each.name in site.served
        and (not spec.only or any(fnmatchcase(site.classes[each.name], pattern) for pattern in spec.only))
    )
    strokes: list[Stroke] = []
    findings: list[Finding] = []
    offsets: dict[GroupValues, float] = {}
    groups = group_outlines(components, spec.merge_gap_mm, own_frame(site.board))
    for group in groups:
        values = group_values(group, spec, site.classes)
        if values.passes == 0:
            continue
        made_by = replace(site.made_by, components=tuple(member.name for member in group.members))
        if values not in offsets:
            offsets[values] = ring_offset_mm(spec, values, site)
        ring, noticed = _ring(group, (spec, values, offsets[values]), site, made_by)
        findings += noticed
        rule = RingRule(
            height_mm=values.height_mm,
            speed_mm_s=values.speed_mm_s,
            tilt_deg=values.tilt_deg,
            lean=_LEANS[spec.toward],
            corner_deg=spec.corner_deg,
            delay_s=values.edge_delay_s,
            laps=values.passes,
            lead_in_mm=spec.lead_in_mm,
        )
        strokes.append(ring_stroke(ring if spec.direction != "clockwise" else ring[::-1], rule, site, made_by))
    findings += _narrow_corridors(groups, spec, site)
    return StrokeSet(tuple(strokes), "free", findings=tuple(findings))


def _ring(
    group: Group, by: tuple[ComponentPerimeter, GroupValues, float], site: Site, made_by: Source
) -> tuple[Points2, list[Finding]]:
    """Ring of the orifice around a group, with findings where it cannot lie at its offset or misses members."""
    spec, values, offset = by
    findings: list[Finding] = []
    frame, place = own_frame(site.board), group.outline.centroid
    where = (place.x, place.y, 0.0)
    if offset < 0 and spec.align == "wavefront" and spec.toward == "component":
        angle = np.degrees(mean_angle(site.nozzle))
        message = (
            f"A tilt of {values.tilt_deg:g} deg is less than the cone's half angle of {angle:.1f} deg: its near wave "
            f"front lies behind the nozzle and cannot be put on the edge from outside. The nozzle itself follows the "
            f"edge instead. Raise tilt_deg to {np.ceil(angle):g} or write align: axis."
        )
        findings.append(Finding(WAVEFRONT_BEHIND_NOZZLE, message, made_by))
        offset = max(values.distance_mm, 0.0)
    rings = offset_rings(group.outline, offset, frame)
    if not rings:
        message = (
            f"A path {-offset:.2f} mm inside the outline of {group.name} does not exist; the outline itself is "
            "followed. Raise distance_mm."
        )
        findings.append(Finding(NO_PATH_INSIDE, message, made_by, where))
        rings = offset_rings(group.outline, 0.0, frame)
    inside = Polygon(rings[0])
    missed = [each.name for each in group.members if not inside.covers(each.outline.centroid)]
    if missed and not inside.covers(group.outline):
        message = (
            f"The path inside the outline does not go around {', '.join(missed)}. Raise distance_mm or merge_gap_mm."
        )
        findings.append(Finding(NOT_CIRCLED, message, made_by, where))
    return rings[0], findings


def ring_offset_mm(spec: ComponentPerimeter, values: GroupValues, site: Site) -> float:
    """Plan distance of the orifice outside the outline (+), so that wave front or axis lies where it is values.

    A cone of half angle a tilted by b towards the component has its near wave front at H tan(b - a) from the foot
    of the orifice, its axis at H tan(b); leaning along the edge, it is the cone's flank that is put on the edge.
    """
    sense = {"component": 1.0, "away": -1.0}.get(spec.toward, 0.0)
    if spec.align == "wavefront":
        reach = _front(values, site, spec.toward) * (sense or 1.0)
    else:
        reach = values.height_mm * float(np.tan(np.radians(values.tilt_deg))) * sense
    return values.distance_mm + reach


def _front(values: GroupValues, site: Site, toward: str) -> float:
    """Plan distance from the foot of the orifice to its wave front, mm; the mean over the directions of travel.

    The directions begin with the board's longest edge, so that a ring that is not round is measured the same wherever
    the board lies. Leaning to or from the component it is the near front along the lean, else the flank on the
    component's side.
    """
    x, y = site.board.axis
    angles = np.arctan2(y, x) + np.arange(_DIRECTIONS) * (2 * np.pi / _DIRECTIONS)
    travel = np.column_stack([np.cos(angles), np.sin(angles)])
    lean = leans(travel, _LEANS[toward], 1.0)
    approach = tilted(lean, values.tilt_deg)
    reference = reference_axes(approach, site.azimuths(travel))
    reaches: list[float] = []
    for index in range(_DIRECTIONS):
        outline = core_footprint(site.nozzle, values.height_mm, approach[index], reference[index])
        inward = np.array([-travel[index, 1], travel[index, 0]])
        across = toward in ("component", "away")
        reaches.append(float((outline @ lean[index]).min() if across else (outline @ inward).max()))
    return float(np.mean(reaches))


def _narrow_corridors(groups: Sequence[Group], spec: ComponentPerimeter, site: Site) -> list[Finding]:
    """One finding for all corridors between followed outlines that are narrower than the cone."""
    if len(groups) < 2:
        return []
    outlines = [group.outline for group in groups]
    width = (
        2 * max(group_values(group, spec, site.classes).height_mm for group in groups) * np.tan(mean_angle(site.nozzle))
    )
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
