"""Raise a stroke over what stands in its way."""

from dataclasses import replace

import numpy as np

from geometry.arrays import Scalars
from rulesengine.modifiers.slopes import Needed, needed_heights
from rulesengine.strokes.safe_height import Floors, Span
from rulesengine.strokes.stroke import Stroke
from specs.finding import Finding
from specs.finding_rules import RAISED_OVER_BODY

_SAME_MM = 1e-6
_APART_MM = 1e-5
_SAME_SLOPE = 1e-3


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
    needed = needed_heights(_around(spans, float(at[-1])) if stroke.closed else spans, floors.corner_mm)
    lifted = _inserted(loop, at, _stops(needed, at, loop))
    heights = np.maximum(lifted.tcp[:, 2], needed.at(_lengths(lifted)))
    raised = replace(lifted, tcp=np.column_stack([lifted.tcp[:, :2], heights]))
    return (_opened(raised, stroke), (_finding(raised, lifted, stroke),))


def _around(spans: list[Span], lap: float) -> list[Span]:
    """Repeat the spans of a ring a lap before and a lap after: what comes next may already ask for a slope."""
    return [(start + shift, end + shift, floor) for shift in (-lap, 0.0, lap) for start, end, floor in spans]


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


def _stops(needed: Needed, at: Scalars, loop: Stroke) -> Scalars:
    """Lengths strictly between the stroke's own points at which its height changes its slope."""
    marks = np.unique(np.round(needed.bends(float(loop.tcp[:, 2].min())), 6))
    marks = marks[(marks > 0) & (marks < at[-1])]
    nearest = np.searchsorted(at, marks)
    marks = marks[np.minimum(marks - at[nearest - 1], at[nearest] - marks) > _APART_MM]
    both = np.sort(np.concatenate([at, marks]))
    heights = np.maximum(np.interp(both, at, loop.tcp[:, 2]), needed.at(both))
    with np.errstate(divide="ignore", invalid="ignore"):  # turns on the spot have no length
        slopes = np.diff(heights) / np.diff(both)
    inner = both[1:-1][np.abs(np.diff(slopes)) > _SAME_SLOPE]
    return np.setdiff1d(inner, at)


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
    lift = np.round(raised.tcp[:, 2] - level.tcp[:, 2], 4)
    worst = int(np.argmax(lift))
    x, y, z = np.round(raised.tcp[worst], 4)
    message = (
        f"Raised by up to {lift[worst]:.1f} mm, to {z:.1f} mm above the board, to clear what stands there; the jet "
        "spreads wider on the board. Raise height_mm, or mask the component."
    )
    return Finding(RAISED_OVER_BODY, message, stroke.made_by, (float(x), float(y), float(z)))
