"""Joints beneath a component from the pads that the board file states."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from boards.board import Pad
from boards.undersides.body_rectangle import Rectangle, lengthwise
from boards.undersides.joints import Joint
from geometry.gridframe import GridFrame

_SKEW_RAD = 1e-4
_LEAST_MM = 0.01
_LEAST_BODY = 0.25
_LONGEST_END = 0.3
"""Longest termination of a chip as a part of its length: 0.3 mm of 1.0 at 0402, less in larger ones (typical)."""

_LONGER = 1.1
_EDGE_MM = 3e-5
"""Places are stated in decimals; none of them is this far from an edge, so that the last bits decide nothing."""


def joints_under(pads: Sequence[Pad], rectangle: Rectangle) -> tuple[Joint, ...]:
    """Find what of the pads lies under the body: those along its edges are cut off there.

    Round pads, and those that stand askew, count as a whole if their middle is under the body.

    Args:
        pads: Of the component. Board frame, mm.
        rectangle: The underside.
    """
    joints: list[Joint] = []
    for pad in pads:
        x, y = rectangle.to_local(np.array([[pad.x_mm, pad.y_mm]]))[0].tolist()
        turn = math.remainder(pad.turn_rad - rectangle.turn_rad, math.pi)
        quarters = round(turn / (math.pi / 2.0))
        if not pad.round and abs(turn - quarters * math.pi / 2.0) < _SKEW_RAD:
            sizes = (pad.width_mm, pad.length_mm) if quarters % 2 else (pad.length_mm, pad.width_mm)
            # An upright rectangle is cut at the edges of the underside; next to nothing may remain.
            left, right = _overlap(x, sizes[0], rectangle.length_mm)
            front, back = _overlap(y, sizes[1], rectangle.width_mm)
            place = _tidy((left + right) / 2.0), _tidy((front + back) / 2.0)
            if min(right - left, back - front) >= _LEAST_MM + _EDGE_MM:
                joints.append(Joint(*place, _tidy(right - left), _tidy(back - front)))
        elif _is_amid(pad, rectangle):
            angle = 0.0 if pad.round else round(turn, 6)
            joints.append(Joint(_tidy(x), _tidy(y), _tidy(pad.length_mm), _tidy(pad.width_mm), pad.round, angle))
    return tuple(joints)


def joints_amid(pads: Sequence[Pad], rectangle: Rectangle) -> tuple[Joint, ...]:
    """Find the pads whose middle is under the body: those of leads beside it begin there, but do not reach it."""
    return joints_under([pad for pad in pads if _is_amid(pad, rectangle)], rectangle)


def joints_at_ends(pads: Sequence[Pad], rectangle: Rectangle) -> tuple[Joint, ...]:
    """Find what of a chip's pads lies under its two terminations: solder does not hold to the body between them."""
    ends: list[Joint] = []
    inner = (0.5 - _LONGEST_END) * rectangle.length_mm
    for joint in joints_under(pads, rectangle):
        near, far = abs(joint.x_mm) - joint.length_mm / 2.0, abs(joint.x_mm) + joint.length_mm / 2.0
        if far - inner < _LEAST_MM + _EDGE_MM:
            continue
        if near < inner and not joint.round and joint.turn_rad == 0.0:
            middle = math.copysign((inner + far) / 2.0, joint.x_mm)
            joint = replace(joint, x_mm=_tidy(middle), length_mm=_tidy(far - inner))
        ends.append(joint)
    return tuple(ends)


def body_between(pads: Sequence[Pad], rectangle: Rectangle, frame: GridFrame) -> Rectangle:
    """Make an outline that was drawn around the leads as narrow as the space between their pads.

    The pad of a lead is longer the way the lead goes. A heat pad in the middle may remain; where no more than one pad
    begins under the outline, it is the body's.
    """
    middle = replace(rectangle, length_mm=rectangle.length_mm / 4.0, width_mm=rectangle.width_mm / 4.0)
    leads = [pad for pad in pads if not _is_amid(pad, middle)]
    if not any(_is_amid(pad, rectangle) for pad in leads):
        return rectangle
    half = [rectangle.length_mm / 2.0, rectangle.width_mm / 2.0]
    for pad in leads:
        spot = np.abs(rectangle.to_local(np.array([[pad.x_mm, pad.y_mm]]))[0])
        turn = math.remainder(pad.turn_rad - rectangle.turn_rad, math.pi)
        sizes = (pad.length_mm, pad.width_mm) if abs(turn) < math.pi / 4.0 else (pad.width_mm, pad.length_mm)
        along = 0 if sizes[0] > sizes[1] else 1
        inner = float(spot[along]) - sizes[along] / 2.0
        if inner > _LEAST_BODY * half[along] and max(sizes) > _LONGER * min(sizes):
            half[along] = min(half[along], round(inner, 4))
    return lengthwise(replace(rectangle, length_mm=2.0 * half[0], width_mm=2.0 * half[1]), frame)


def _is_amid(pad: Pad, rectangle: Rectangle) -> bool:
    x, y = rectangle.to_local(np.array([[pad.x_mm, pad.y_mm]]))[0]
    half = rectangle.length_mm / 2.0 - _EDGE_MM, rectangle.width_mm / 2.0 - _EDGE_MM
    return bool(abs(x) < half[0] and abs(y) < half[1])


def _overlap(middle: float, size_mm: float, side_mm: float) -> tuple[float, float]:
    return max(middle - size_mm / 2.0, -side_mm / 2.0), min(middle + size_mm / 2.0, side_mm / 2.0)


def _tidy(value: float) -> float:
    return round(value, 4) + 0.0
