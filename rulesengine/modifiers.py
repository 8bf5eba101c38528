"""Modifiers of strokes: raised over bodies in their way, cut where they must not spray, held at edges.

They are raised along the lowest profile with slopes of 45 degrees that clears the bodies.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString, MultiPolygon, Polygon, STRtree, get_parts, intersection, unary_union

from boards.board import Board, Side
from geometry.arrays import Scalars
from geometry.gridframe import GridFrame
from recipes.classes import ComponentMasks
from recipes.footprint import footprint
from recipes.nozzles import Nozzle
from rulesengine.strokes.safe_height import Floors, Span
from rulesengine.strokes.stroke import Stroke, StrokeSet, into_frame, own_frame, reference_axes
from specs.finding import Finding
from specs.finding_rules import CUT_BY_MASK, RAISED_OVER_BODY
from specs.source import Source

_SAME_MM = 1e-6  # a rest of a stroke that differs by just that stays, however the board lies
_APART_MM = 1e-5
_SAME_SLOPE = 1e-3
_WIDER_MM = 1e-4  # a span that is only touched has a length too, and neighbours overlap
_FAR_MM = 1e9


@dataclass(frozen=True, slots=True, eq=False)
class Profile:
    """Least heights along a path: on each of k stretches the highest of a level, a fall and a rise of 45 degrees."""

    borders: Scalars
    """(k + 1,) ascending lengths between which the stretches lie, mm; the outer ones are far away."""
    level: Scalars
    """(k,) floor of each stretch; minus infinity where nothing is in the way."""
    fall: Scalars
    """(k,) height at length 0 of the line that falls from what lies before."""
    rise: Scalars
    """(k,) height at length 0 of the line that rises to what comes after."""

    def at(self, lengths: Scalars) -> Scalars:
        """Least heights at lengths along the path."""
        k = np.clip(np.searchsorted(self.borders, lengths, side="right") - 1, 0, len(self.level) - 1)
        return np.maximum(self.level[k], np.maximum(self.fall[k] - lengths, self.rise[k] + lengths))

    def bends(self, base_mm: float) -> Scalars:
        """All lengths at which the higher of the profile and a base height may change its slope, unsorted."""
        level = np.maximum(self.level, base_mm)
        with np.errstate(invalid="ignore"):  # where neither falls nor rises there is nothing to meet
            inside = [self.fall - level, level - self.rise, (self.fall - self.rise) / 2]
        kept = [marks[(marks > self.borders[:-1]) & (marks < self.borders[1:])] for marks in inside]
        return np.concatenate([self.borders[1:-1], *kept])


def lowest_profile(spans: Sequence[Span], extra_mm: float) -> Profile:
    """Lowest profile over spans, at least one, in any order, that lies ``extra_mm`` above their floors."""
    columns: Scalars = np.array(spans, dtype=np.float64)
    start, end, floor = columns[:, 0] - _WIDER_MM, columns[:, 1] + _WIDER_MM, columns[:, 2] + extra_mm
    borders = np.unique(np.concatenate([[-_FAR_MM], start, end, [_FAR_MM]]))
    level = np.full(len(borders) - 1, -np.inf)
    first, last = np.searchsorted(borders, start), np.searchsorted(borders, end)
    for a, b, height in zip(first.tolist(), last.tolist(), floor.tolist(), strict=True):
        np.maximum(level[a:b], height, out=level[a:b])
    nothing = np.array([-np.inf])
    fall = np.concatenate([nothing, np.maximum.accumulate(level + borders[1:])[:-1]])
    rise = np.concatenate([np.maximum.accumulate((level - borders[:-1])[::-1])[::-1][1:], nothing])
    return Profile(borders, level, fall, rise)


def raise_over(strokes: StrokeSet, floors: Floors) -> StrokeSet:
    """Lift the orifice over bodies whose clearance strokes would enter; plan view and direction stay.

    A stroke that is clear stays the same object; a raised one gives a finding with the place of its highest lift.
    """
    raised: list[Stroke] = []
    findings = list(strokes.findings)
    for stroke in strokes.strokes:
        # A ring becomes an open stroke that ends where it begins.
        count = len(stroke.tcp)
        opened = stroke.closed and not np.allclose(stroke.tcp[0], stroke.tcp[-1], atol=_SAME_MM)
        loop = stroke.pick(np.append(np.arange(count), 0)) if opened else stroke
        spans = floors.spans(loop.tcp[:, :2], float(loop.tcp[:, 2].min()))
        if not spans:
            raised.append(stroke)
            continue
        at = _lengths(loop)
        if stroke.closed:  # what comes after the beginning may already need a slope before it
            lap = float(at[-1])
            spans = [(a + shift, b + shift, floor) for shift in (-lap, 0.0, lap) for a, b, floor in spans]
        profile = lowest_profile(spans, floors.corner_mm)
        stops = _stops(profile, at, loop)
        segment = np.searchsorted(at, stops, side="right") - 1
        level, _ = loop.insert(segment, (stops - at[segment]) / (at[segment + 1] - at[segment]))
        heights = np.maximum(level.tcp[:, 2], profile.at(_lengths(level)))
        lifted = replace(level, tcp=np.column_stack([level.tcp[:, :2], heights]))
        lift = np.round(heights - level.tcp[:, 2], 4)
        worst = int(np.argmax(lift))
        x, y, z = np.round(lifted.tcp[worst], 4).tolist()
        message = (
            f"Raised by up to {lift[worst]:.1f} mm, to {z:.1f} mm above the board, to clear what stands there; the jet "
            "spreads wider on the board. Raise height_mm, or mask the component."
        )
        findings.append(Finding(RAISED_OVER_BODY, message, stroke.made_by, (x, y, z)))
        raised.append(lifted.pick(np.arange(len(heights) - 1)) if opened else lifted)
    return replace(strokes, strokes=tuple(raised), findings=tuple(findings))


def _lengths(stroke: Stroke) -> Scalars:
    """Plan length from the beginning to each point."""
    steps = np.linalg.norm(np.diff(stroke.tcp[:, :2], axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _stops(profile: Profile, at: Scalars, loop: Stroke) -> Scalars:
    """Lengths strictly between the stroke's own points at which its height changes its slope."""
    marks = np.unique(np.round(profile.bends(float(loop.tcp[:, 2].min())), 6))
    marks = marks[(marks > 0) & (marks < at[-1])]
    nearest = np.searchsorted(at, marks)
    marks = marks[np.minimum(marks - at[nearest - 1], at[nearest] - marks) > _APART_MM]
    both = np.sort(np.concatenate([at, marks]))
    heights = np.maximum(np.interp(both, at, loop.tcp[:, 2]), profile.at(both))
    with np.errstate(divide="ignore", invalid="ignore"):  # turns on the spot have no length
        slopes = np.diff(heights) / np.diff(both)
    inner = both[1:-1][np.abs(np.diff(slopes)) > _SAME_SLOPE]
    return np.setdiff1d(inner, at)


_MUCH = 0.1  # of the way of a template that a mask takes away: parts beside it may stay dirty
_STEP_MM = 0.5
_SHORTEST_MM = 1.0  # a rest of a stroke shorter than this is not worth opening the valve
_SLIVER_MM = 0.01  # less beyond an edge is how two outlines were drawn


def avoided_zone(board: Board, side: Side, masks: ComponentMasks) -> Polygon | MultiPolygon:
    """Outlines of what must not be sprayed on a side, grown by their margins.

    Of a component on the other side it is what the board does not shield: where that hangs over the edge or a hole.
    """
    margins = dict(masks.avoided)
    zones: list[Polygon | MultiPolygon] = []
    for component in board.components:
        if component.name not in margins:
            continue
        grown_mm = margins[component.name] + _STEP_MM
        if component.side == side:
            zones.append(component.outline.buffer(grown_mm))
        else:
            zones.append(component.outline.difference(board.outline).buffer(-_SLIVER_MM).buffer(_SLIVER_MM + grown_mm))
    zone = unary_union(zones)
    return zone if isinstance(zone, Polygon | MultiPolygon) else Polygon()


def keep_out(strokes: StrokeSet, zone: Polygon | MultiPolygon, nozzle: Nozzle, made_by: Source) -> StrokeSet:
    """Cut strokes where the footprint would meet the zone.

    A ring that loses a part becomes open strokes, once for each lap. The zone is grown by the spacing of the places
    that are looked at, so that nothing between two of them touches it.
    """
    if zone.is_empty:
        return strokes
    kept: list[Stroke] = []
    cut: list[str] = []
    lost: list[str] = []
    for stroke in strokes.strokes:
        pieces = _allowed(stroke, zone, nozzle)
        if pieces is None:
            kept.append(stroke)
            continue
        kept += pieces * stroke.laps
        (cut if pieces else lost).append("+".join(stroke.made_by.components) or str(stroke.made_by))
    if not cut and not lost:
        return strokes
    planned_mm, left_mm = (sum(each.laps * each.lap_mm for each in some) for some in (strokes.strokes, kept))
    share = 1.0 - left_mm / planned_mm if planned_mm > 0.0 else 1.0
    sentences = [
        f"Strokes cut to keep the wave front off what is avoided: {len(cut) + len(lost)}; {share:.0%} of the way is "
        "left out."
    ]
    if lost:
        sentences.append(f"Left out altogether: {', '.join(lost)}.")
    if around := [name for name in cut if name != str(made_by)]:
        sentences.append(f"Not followed all around: {', '.join(around)}.")
    severity = "warning" if lost or share > _MUCH else "info"
    finding = Finding(CUT_BY_MASK, " ".join(sentences), made_by, override=severity)
    return replace(strokes, strokes=tuple(kept), findings=(*strokes.findings, finding))


def _allowed(stroke: Stroke, zone: Polygon | MultiPolygon, nozzle: Nozzle) -> list[Stroke] | None:
    """Open strokes that are left of one; None if nothing is touched."""
    # Points at most one step apart; vertices are those that were there before.
    ahead = np.roll(stroke.tcp, -1, axis=0) if stroke.closed else np.vstack([stroke.tcp[1:], stroke.tcp[-1:]])
    counts = np.maximum(1, np.ceil(np.round(np.linalg.norm(ahead - stroke.tcp, axis=1) / _STEP_MM, 6))).astype(int)
    segment = np.repeat(np.arange(len(counts)), counts - 1)
    first = np.cumsum(counts - 1) - (counts - 1)
    dense, order = stroke.insert(segment, (np.arange(len(segment)) - first[segment] + 1) / counts[segment])
    vertex = order < len(counts)
    free = ~_touches(dense, zone, nozzle)
    if free.all():
        return None
    if stroke.closed:
        order = np.roll(np.arange(len(free)), -int(np.argmin(free)))
        dense, free, vertex = dense.pick(order), free[order], vertex[order]
    edges = np.diff(np.concatenate([[0], free.astype(np.int8), [0]]))
    pieces: list[Stroke] = []
    for start, stop in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True):
        kept = np.arange(start, stop)
        piece = dense.pick(kept[vertex[kept] | (kept == start) | (kept == stop - 1)])
        if np.linalg.norm(np.diff(piece.tcp, axis=0), axis=1).sum() >= _SHORTEST_MM - _SAME_MM:
            pieces.append(replace(piece, closed=False, laps=1, entries=(0,)))
    return pieces


def _touches(dense: Stroke, zone: Polygon | MultiPolygon, nozzle: Nozzle) -> NDArray[np.bool_]:
    pose = np.round(np.hstack([dense.approach, dense.azimuth, dense.tcp[:, 2:]]), 6)
    poses, which = np.unique(pose, axis=0, return_inverse=True)
    references = reference_axes(poses[:, :3], poses[:, 3:5])
    outlines = np.array(
        [footprint(nozzle, float(row[5]), row[:3], axis) for row, axis in zip(poses, references, strict=True)]
    )
    shapely.prepare(zone)
    sprayed = shapely.polygons(outlines[which.ravel()] + dense.tcp[:, None, :2])
    return np.asarray(shapely.intersects(zone, sprayed), dtype=np.bool_)


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
