"""The nearest points of two bodies and the line between them."""

import numpy as np

from webui.glb.glb import Colours, flat_triangles_glb
from webui.glb.ribbons import bars
from webui.layers.robot.proximity import Near
from webui.theme.palette import COLLIDING

_WIDE_MM, _KNOB_MM = 0.8, 3.0


def near_glb(near: Near) -> bytes:
    """Draw the line between the nearest points of two bodies, with a knob at either end, mm."""
    half = np.array([0.0, 0.0, _KNOB_MM / 2])
    knobs = np.stack([near.points - half, near.points + half], axis=1)
    line, ends = bars(near.points[None], _tints(1), _WIDE_MM), bars(knobs, _tints(2), _KNOB_MM)
    return flat_triangles_glb(np.concatenate([line[0], ends[0]]), np.concatenate([line[1], ends[1]]))


def _tints(count: int) -> Colours:
    return np.tile(np.array(COLLIDING, dtype=np.uint8), (count, 1))
