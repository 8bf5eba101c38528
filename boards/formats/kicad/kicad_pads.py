"""The pads of a KiCad footprint to which a component is soldered flat."""

import math
from collections.abc import Iterator

import numpy as np

from boards.board import Pad
from boards.formats.kicad.kicad_footprint import Footprint
from boards.formats.kicad.kicad_items import Item
from boards.formats.kicad.kicad_shapes import polyline
from geometry.arrays import Points2

_LEAST_MM = 1e-3


def flat_pads(footprint: Footprint) -> tuple[Pad, ...]:
    """Read the surface-mount pads on the footprint's own side, in file order. Board frame, mm.

    Plated holes, edge contacts and openings for paste alone are left out. Whatever is not round is taken for the
    rectangle around it: ovals, rounded and free shapes as well.

    Raises:
        BoardError: A number of a pad cannot be read.
    """
    copper = {"B.Cu" if footprint.side == "bottom" else "F.Cu", "*.Cu", "F&B.Cu"}
    return tuple(
        pad
        for item in footprint.pads
        if "smd" in item.atoms[1:2] and copper & set(_layers(item))
        for pad in _read(item, footprint)
    )


def _layers(pad: Item) -> tuple[str, ...]:
    layers = pad.first("layers")
    return layers.atoms if layers is not None else ()


def _read(pad: Item, footprint: Footprint) -> Iterator[Pad]:
    at = pad.first("at")
    size = pad.first("size")
    if at is None or size is None:
        raise pad.error(f"a pad of {footprint.reference} has no place or no size. Save the board in KiCad again.")
    turn = math.radians(at.number(2)) if len(at.atoms) > 2 else 0.0
    low, high = _extent(pad, np.array([size.number(0), size.number(1)]))
    length, width = (high - low).tolist()
    if min(length, width) < _LEAST_MM:
        return
    # The file states a pad's angle on the board, its place in the footprint.
    inside = turn - footprint.turn_rad
    middle = (low + high) / 2.0 + _offset(pad)
    cos, sin = math.cos(inside), math.sin(inside)
    x, y = footprint.place((at.here() + middle @ np.array([[cos, sin], [-sin, cos]]))[None, :])[0].tolist()
    shape = pad.atoms[2] if len(pad.atoms) > 2 else "rect"
    is_round = shape in ("circle", "oval") and abs(length - width) < _LEAST_MM
    yield Pad(x, y, length, width, math.remainder(turn, 2.0 * math.pi), is_round)


def _offset(pad: Item) -> Points2:
    """How far the copper lies beside the pad's place, in the pad's frame."""
    drill = pad.first("drill")
    offset = drill.first("offset") if drill is not None else None
    return offset.here() if offset is not None else np.zeros(2)


def _extent(pad: Item, size: Points2) -> tuple[Points2, Points2]:
    """Corners of the rectangle around a pad in its own frame; free shapes are drawn beside their anchor."""
    low, high = -size / 2.0, size / 2.0
    primitives = pad.first("primitives")
    lines = [polyline(item) for item in primitives.items] if primitives is not None else []
    for line in lines:
        if line is not None:
            low, high = np.minimum(low, line.min(axis=0)), np.maximum(high, line.max(axis=0))
    return low, high
