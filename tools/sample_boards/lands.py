"""What a sample part is soldered to: a pad under whatever of it touches the board, or pads of its own."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from sample_boards.shape import Shape

from boards.board import Pad
from geometry.arrays import Triangles

_TOUCHES_MM = 1e-6
_LEAST_MM = 0.05
_ROUND = "balls"
_NO_JOINT = "body"


def lands_of(shape: Shape) -> Iterator[Pad]:
    """Give the pads of a part around its own origin; none for what stands in holes or touches along a line only."""
    if shape.lands:
        yield from shape.lands
        return
    for name, group in shape.solids:
        if name != _NO_JOINT:
            yield from (_rounded(pad) if name == _ROUND else pad for solid in group for pad in _under(solid))


def _under(solid: Triangles) -> Iterator[Pad]:
    corners = solid.reshape(-1, 3)
    if corners[:, 2].min() < -_TOUCHES_MM:
        return
    flat = corners[np.abs(corners[:, 2]) < _TOUCHES_MM, :2]
    if not len(flat):
        return
    (west, south), (east, north) = flat.min(axis=0).tolist(), flat.max(axis=0).tolist()
    length, width = east - west, north - south
    if min(length, width) >= _LEAST_MM:
        yield Pad((west + east) / 2, (south + north) / 2, length, width)


def _rounded(pad: Pad) -> Pad:
    return replace(pad, width_mm=pad.length_mm, round=True)
