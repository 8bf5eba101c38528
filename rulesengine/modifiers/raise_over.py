"""Raise strokes over bodies in their way, along the lowest profile with slopes of 45 degrees that clears them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Scalars
from rulesengine.strokes.safe_height import Floors, Span
from rulesengine.strokes.stroke import Stroke, StrokeSet
from specs.finding import Finding
from specs.finding_rules import RAISED_OVER_BODY

_SAME_MM = 1e-6
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
