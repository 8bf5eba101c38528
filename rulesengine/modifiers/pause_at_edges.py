"""Pause wherever the jet's axis crosses the edge of a component."""

from dataclasses import replace

import numpy as np
import shapely
from shapely import LineString, STRtree, get_parts, intersection

from boards.board import Board
from geometry.arrays import Scalars
from geometry.gridframe import GridFrame
from rulesengine.strokes.stroke import Stroke, StrokeSet, into_frame, own_frame

_GRAZE_MM = 0.05  # an outline touched over less than this is not crossed; outlines are no more exact than that


def pause_at_edges(strokes: StrokeSet, board: Board) -> StrokeSet:
    """Add a point with a pause to open strokes for each edge that the jet's axis crosses, as their set requires.

    Strokes keep one direction of the jet; their heights may change, and with them the places that the axis meets.
    """
    if not strokes.edge_pauses:
        return strokes
    frame = own_frame(board)
    components = [component for component in board.components if component.name in strokes.edge_pauses]
    names = [component.name for component in components]
    tree = STRtree([into_frame(component.outline, frame) for component in components])
    return replace(strokes, strokes=tuple(_paused(each, strokes, names, tree, frame) for each in strokes.strokes))


def _paused(stroke: Stroke, strokes: StrokeSet, names: list[str], tree: STRtree, frame: GridFrame) -> Stroke:
    axis = frame.to_frame(stroke.tcp[:, :2] - stroke.tcp[:, 2:] * stroke.approach[:, :2] / stroke.approach[:, 2:])
    crossings = _crossings(LineString(axis), tree)
    if not crossings:
        return stroke
    steps = np.linalg.norm(np.diff(axis, axis=0), axis=1)
    reached = np.concatenate([[0.0], np.cumsum(steps)])
    distance: Scalars = np.array([each for each, _ in crossings])
    segment = np.searchsorted(reached, distance, side="right") - 1
    stopping, order = stroke.insert(segment, (distance - reached[segment]) / steps[segment])
    at_edge = ["", *(names[component] for _, component in crossings)]
    pauses = tuple(at_edge[max(0, index - len(axis) + 1)] for index in order.tolist())
    delays = stopping.delays + [strokes.edge_pauses.get(name, 0.0) for name in pauses]
    return replace(stopping, delays=delays, pauses=pauses)


def _crossings(axis: LineString, tree: STRtree) -> list[tuple[float, int]]:
    """Distance along the axis and number of the component for each edge, in order."""
    found: list[tuple[float, int]] = []
    for index in sorted(int(i) for i in tree.query(axis, predicate="intersects")):
        within = shapely.line_merge(intersection(axis, tree.geometries[index]))
        for piece in get_parts(within):
            if piece.length >= _GRAZE_MM:
                spans = shapely.line_locate_point(axis, shapely.points(piece.coords))
                ends = (float(spans.min()), float(spans.max()))
                found += [(end, index) for end in ends if _GRAZE_MM < end < axis.length - _GRAZE_MM]
    return sorted(found, key=lambda crossing: (round(crossing[0], 4), crossing[1]))
