"""One motion of a robot's program, laid over the paths: where it goes, and how the tool stands at its end."""

import numpy as np

from programs.motion.steps import Line, Reach
from webui.glb.glb import flat_triangles_glb
from webui.glb.ribbons import bars
from webui.layers.paths.nozzle import rotation
from webui.theme.palette import INK

_STEM_MM = 14.0
_WIDER = 3.0


def motion_glb(move: Line | Reach | None, width_mm: float) -> bytes:
    """Draw the way of a motion, and a stem from its end back along the jet; nothing without a motion.

    Args:
        move: Board frame, mm.
        width_mm: Of the lines of paths, which are hidden inside it.
    """
    if move is None:
        return b""
    end = np.array(move.target.position)
    stem = end - _STEM_MM * rotation(np.array(move.target.quaternion))[2]
    segments = [[end, stem]]
    if isinstance(move, Line):
        segments.append([np.array(move.start.position), end])
    ways = np.array(segments)
    return flat_triangles_glb(*bars(ways, np.tile(np.array(INK, dtype=np.uint8), (len(ways), 1)), _WIDER * width_mm))
