"""Components that are followed as one outline, and how each group is to be followed."""

from collections.abc import Callable
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
from recipes.paths import ComponentPerimeter, Near, for_class
from rulesengine.strokes.board_grid import into_frame, out_of_frame

_TOUCH_MM = 1e-4  # outlines are exact to about this; nearer is as good as touching
_OUTLINE_MM = 0.05
_NOTCH_GAPS = 3  # between parts followed as one, notches up to so many merge gaps are passed over
_RECTANGLE, _HULL_OF_ONE, _HULL_OF_MANY = 1.12, 1.1, 1.25  # how much larger than the outline each may be


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """Components that stand closer than the gap of the template, in file order."""

    members: tuple[Component, ...]
    outline: Polygon

    @property
    def name(self) -> str:
        """Names of the members, joined by ``+``."""
        return "+".join(member.name for member in self.members)


@dataclass(frozen=True, slots=True)
class Demand:
    """What the classes and the neighbours of a group's members ask for; the most demanding member decides."""

    height_mm: float
    speed_mm_s: float
    tilt_deg: float
    distance_mm: float
    passes: int
    edge_delay_s: float


def grouped(components: list[Component], gap_mm: float, frame: GridFrame) -> list[Group]:
    """Join components that are closer than the gap, directly or by way of others; groups by their first member.

    Outlines are joined and made plain on the grid of the frame, which moves with the board. The last answers are
    remembered: most edits of a recipe group the same components.
    """
    return list(_remembered(tuple(components), gap_mm, frame))


@lru_cache(maxsize=8)
def _remembered(components: tuple[Component, ...], gap_mm: float, frame: GridFrame) -> tuple[Group, ...]:
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
    return tuple(_group(members, gap_mm, frame) for members in groups.values())


def _group(members: list[Component], gap_mm: float, frame: GridFrame) -> Group:
    followed = _outline([into_frame(member.outline, frame) for member in members], gap_mm)
    on_grid = transform(followed, to_grid)
    return Group(tuple(members), out_of_frame(on_grid if on_grid.is_valid else followed, frame))


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


def demand(group: Group, spec: ComponentPerimeter, classes: dict[str, str]) -> Demand:
    """Ask every member; the slowest speed, the most passes, the longest pause win, the largest member sets the tilt."""
    near = [member for member in group.members if spec.near and member.neighbour_mm <= spec.near.within_mm]
    largest = max(group.members, key=lambda member: round(member.area_mm2, 3))

    def of(member: Component, value: float | int | dict[str, float] | dict[str, int], key: str) -> float:
        instead = _instead(spec.near, key) if member in near else None
        return float(for_class(value, classes[member.name])) if instead is None else instead

    def over(value: float | int | dict[str, float] | dict[str, int], key: str, pick: Callable[..., float]) -> float:
        return pick(of(member, value, key) for member in group.members)

    return Demand(
        height_mm=over(spec.height_mm, "height_mm", max),
        speed_mm_s=over(spec.speed_mm_s, "speed_mm_s", min),
        tilt_deg=of(largest, spec.tilt_deg, "tilt_deg"),
        distance_mm=of(largest, spec.distance_mm, "distance_mm"),
        passes=int(over(spec.passes, "passes", max)),
        edge_delay_s=over(spec.edge_delay_s, "edge_delay_s", max),
    )


def _instead(near: Near | None, key: str) -> float | None:
    return getattr(near, key, None)
