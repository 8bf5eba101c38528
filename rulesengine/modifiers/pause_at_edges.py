"""Pause wherever the jet's axis crosses the edge of a component."""

from dataclasses import dataclass, replace

import numpy as np
import shapely
from shapely import LineString, STRtree, get_parts, intersection

from geometry.arrays import Scalars
from geometry.gridframe import GridFrame
from recipes.paths import StepFunction, for_class
from rulesengine.strokes.board_grid import into_frame, own_frame
from rulesengine.strokes.stroke import Site, Stroke

_GRAZE_MM = 0.05  # an outline touched over less than this is not crossed; outlines are no more exact than that


@dataclass(frozen=True, slots=True, eq=False)
class Edges:
    """Outlines of the served components on the grid of the board's own frame, and how long to pause at each."""

    frame: GridFrame
    tree: STRtree
    names: tuple[str, ...]
    delays_s: Scalars


def edges_of(spec: StepFunction, site: Site) -> Edges:
    """Collect the outlines that a step function looks at."""
    components = [component for component in site.board.components if component.name in site.served]
    frame = own_frame(site.board)
    return Edges(
        frame=frame,
        tree=STRtree([into_frame(component.outline, frame) for component in components]),
        names=tuple(component.name for component in components),
        delays_s=np.array([for_class(spec.delay_s, site.classes[component.name]) for component in components]),
    )


def pause_at_edges(stroke: Stroke, edges: Edges) -> Stroke:
    """Add a point with a pause to an open stroke for each edge that the jet's axis crosses, in order.

    The stroke keeps one direction of the jet; its height may change, and the place that the axis meets with it.
    """
    axis = edges.frame.to_frame(stroke.tcp[:, :2] - stroke.tcp[:, 2:] * stroke.approach[:, :2] / stroke.approach[:, 2:])
    steps = np.linalg.norm(np.diff(axis, axis=0), axis=1)
    crossings = _crossings(LineString(axis), edges)
    if not crossings:
        return stroke
    reached = np.concatenate([[0.0], np.cumsum(steps)])
    distance = np.array([each for each, _ in crossings])
    which = np.array([component for _, component in crossings])
    segment = np.searchsorted(reached, distance, side="right") - 1
    share = (distance - reached[segment]) / steps[segment]
    order = np.argsort(np.concatenate([np.arange(len(axis)), segment + share]), kind="stable")
    places = stroke.tcp[segment] + share[:, None] * (stroke.tcp[segment + 1] - stroke.tcp[segment])
    count = len(order)
    return replace(
        stroke,
        tcp=np.vstack([stroke.tcp, places])[order],
        approach=np.tile(stroke.approach[0], (count, 1)),
        azimuth=np.tile(stroke.azimuth[0], (count, 1)),
        delays=np.concatenate([stroke.delays, edges.delays_s[which]])[order],
        pauses=tuple(edges.names[which[index - len(axis)]] if index >= len(axis) else "" for index in order.tolist()),
    )


def _crossings(axis: LineString, edges: Edges) -> list[tuple[float, int]]:
    """Distance along the axis and number of the component for each edge, in order."""
    found: list[tuple[float, int]] = []
    for index in sorted(int(i) for i in edges.tree.query(axis, predicate="intersects")):
        within = shapely.line_merge(intersection(axis, edges.tree.geometries[index]))
        for piece in get_parts(within):
            if piece.length >= _GRAZE_MM:
                spans = shapely.line_locate_point(axis, shapely.points(piece.coords))
                ends = (float(spans.min()), float(spans.max()))
                found += [(end, index) for end in ends if _GRAZE_MM < end < axis.length - _GRAZE_MM]
    return sorted(found, key=lambda crossing: (round(crossing[0], 4), crossing[1]))
