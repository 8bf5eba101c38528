"""Raise a stroke over what stands in its way."""

from dataclasses import replace

import numpy as np

from geometry.arrays import Points, Scalars
from geometry.finding import Finding
from rulesengine.clearance import Floors, Span
from rulesengine.stroke import Stroke

_SLOPE = 1.0  # the nozzle climbs at 45 degrees
_SAME_MM = 1e-6


def raise_over(stroke: Stroke, floors: Floors) -> tuple[Stroke, tuple[Finding, ...]]:
    """Lift the orifice over bodies whose clearance the stroke would enter; plan view and direction stay.

    Returns:
        The stroke, the same object if nothing was in the way, and a finding with the place of the highest lift.
    """
    loop = _closed_up(stroke)
    spans = floors.spans(loop.tcp[:, :2], float(loop.tcp[:, 2].min()))
    if not spans:
        return stroke, ()
    at = _lengths(loop)
    stops = _stops(spans, at, loop)
    lifted = _inserted(loop, at, stops)
    heights = np.maximum(lifted.tcp[:, 2], _needed(spans, _lengths(lifted), float(at[-1]) if stroke.closed else None))
    raised = replace(lifted, tcp=np.column_stack([lifted.tcp[:, :2], heights]))
    return (_opened(raised, stroke), (_finding(raised, lifted, stroke),))


def _closed_up(stroke: Stroke) -> Stroke:
    """Make an open stroke of a ring that ends where it begins."""
    if not stroke.closed or np.allclose(stroke.tcp[0], stroke.tcp[-1], atol=_SAME_MM):
        return stroke
    return replace(
        stroke,
        tcp=np.vstack([stroke.tcp, stroke.tcp[:1]]),
        approach=np.vstack([stroke.approach, stroke.approach[:1]]),
        azimuth=np.vstack([stroke.azimuth, stroke.azimuth[:1]]),
        delays=np.append(stroke.delays, stroke.delays[0]),
        pauses=(*stroke.pauses, stroke.pauses[0]) if stroke.pauses else (),
    )


def _opened(raised: Stroke, original: Stroke) -> Stroke:
    """Take the closing point away again where the ring had none."""
    if _closed_up(original) is original:
        return raised
    return replace(
        raised,
        tcp=raised.tcp[:-1],
        approach=raised.approach[:-1],
        azimuth=raised.azimuth[:-1],
        delays=raised.delays[:-1],
        pauses=raised.pauses[:-1],
    )


def _lengths(stroke: Stroke) -> Scalars:
    """Plan length from the beginning to each point."""
    steps = np.linalg.norm(np.diff(stroke.tcp[:, :2], axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _needed(spans: list[Span], at: Scalars, lap: float | None) -> Scalars:
    """Least height at each length: the floors with their slopes; around a ring the distance is the shorter way."""
    columns: Points = np.array(spans, dtype=np.float64)
    start, end, floor = columns[:, :1], columns[:, 1:2], columns[:, 2:]
    away = np.maximum(np.maximum(start - at, at - end), 0.0)
    if lap is not None:
        for shift in (-lap, lap):
            away = np.minimum(away, np.maximum(np.maximum(start + shift - at, at - end - shift), 0.0))
    return np.maximum.reduce(floor - _SLOPE * away, axis=0)


def _stops(spans: list[Span], at: Scalars, loop: Stroke) -> Scalars:
    """Lengths at which the height may change its slope."""
    base = float(loop.tcp[:, 2].min())
    columns: Points = np.array(spans, dtype=np.float64)
    start, end, floor = columns.T
    run = (floor - base) / _SLOPE
    falling, rising = end + floor / _SLOPE, start - floor / _SLOPE
    crossings = ((falling[:, None] + rising[None, :]) / 2).ravel()
    levels = np.concatenate(
        [(falling[:, None] - floor[None, :] / _SLOPE).ravel(), (rising[:, None] + floor[None, :] / _SLOPE).ravel()]
    )
    marks: Scalars = np.concatenate([start, end, start - run, end + run, crossings, levels])
    if loop.closed:
        marks = np.concatenate([marks, marks - at[-1], marks + at[-1]])
    marks = np.unique(np.round(marks[(marks > 0) & (marks < at[-1])], 6))
    return marks[np.abs(marks[:, None] - at[None, :]).min(axis=1) > 1e-5] if len(marks) else marks


def _inserted(loop: Stroke, at: Scalars, stops: Scalars) -> Stroke:
    """Add points to a stroke at lengths strictly between its own."""
    segment = np.searchsorted(at, stops, side="right") - 1
    share = ((stops - at[segment]) / (at[segment + 1] - at[segment]))[:, None]
    order = np.argsort(np.concatenate([np.arange(len(at)), segment + 0.5 + share[:, 0] / 4]), kind="stable")

    def mixed(values: Scalars) -> Scalars:
        between = values[segment] * (1 - share) + values[segment + 1] * share
        return np.vstack([values, between])[order]

    approach, azimuth = mixed(loop.approach), mixed(loop.azimuth)
    position = np.argsort(order)
    return replace(
        loop,
        tcp=mixed(loop.tcp),
        approach=approach / np.linalg.norm(approach, axis=1, keepdims=True),
        azimuth=azimuth / np.linalg.norm(azimuth, axis=1, keepdims=True),
        delays=np.concatenate([loop.delays, np.zeros(len(stops))])[order],
        entries=tuple(int(position[entry]) for entry in loop.entries),
        pauses=tuple([*loop.pauses, *([""] * len(stops))][int(i)] for i in order) if loop.pauses else (),
    )


def _finding(raised: Stroke, level: Stroke, stroke: Stroke) -> Finding:
    lift = raised.tcp[:, 2] - level.tcp[:, 2]
    worst = int(np.argmax(np.round(lift, 4)))
    x, y, z = raised.tcp[worst]
    message = (
        f"Raised by up to {lift[worst]:.1f} mm, to {z:.1f} mm above the board, to clear what stands there; the jet "
        "spreads wider on the board. Raise height_mm, or mask the component."
    )
    return Finding("raised-over-body", "warning", message, stroke.made_by, (float(x), float(y), float(z)))
