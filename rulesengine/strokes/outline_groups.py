"""Groups of components that are followed as one outline, and the values of a template for each."""

from dataclasses import dataclass
from functools import lru_cache
from typing import cast

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from shapely import Polygon, STRtree, transform, union_all

from boards.board import Component
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
from recipes.paths import ComponentPerimeter, for_class
from rulesengine.strokes.stroke import into_frame, out_of_frame

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
