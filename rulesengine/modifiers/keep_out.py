"""Close the jet wherever the wave front would touch what must not be sprayed."""

from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon, unary_union

from boards.board import Board, Side
from recipes.classes import ComponentMasks
from recipes.footprint import footprint
from recipes.nozzles import Nozzle
from rulesengine.strokes.stroke import Stroke, StrokeSet, reference_axes
from specs.finding import Finding
from specs.finding_rules import CUT_BY_MASK
from specs.source import Source

_MUCH = 0.1  # of the way of a template that a mask takes away: parts beside it may stay dirty
_STEP_MM = 0.5
_SHORTEST_MM = 1.0  # a rest of a stroke shorter than this is not worth opening the valve
_SLIVER_MM = 0.01  # less beyond an edge is how two outlines were drawn
_SAME_MM = 1e-6  # a rest of just that length stays, however the board lies


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
