"""Marks on the paths: events as small solids, and one motion of a robot's program."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Literal, TypeAlias

import numpy as np

from geometry.arrays import Points, Scalars
from programs.motion.steps import Line, Reach
from programs.plan import Command, Dwell, Plan, SprayPass, Transfer
from specs.source import NO_SOURCE, Source
from webui.glb.glb import bars, flat_triangles_glb, triangles_glb
from webui.layers.paths.nozzle import rotation
from webui.theme.palette import INK, QUIET, Tint

Kind: TypeAlias = Literal["pause", "jet on", "jet off", "command"]

COLOURS: dict[Kind, Tint] = {
    "pause": (96, 108, 118),
    "jet on": (47, 143, 126),
    "jet off": QUIET,
    "command": (125, 90, 155),
}
_LARGEST_S = 4.0
"""Longer pauses are drawn no larger."""
_OCTAHEDRON: Points = np.array(
    [
        [(x, 0, 0), (0, y, 0), (0, 0, z)] if x * y * z > 0 else [(0, 0, z), (0, y, 0), (x, 0, 0)]
        for x, y, z in product((1.0, -1.0), repeat=3)
    ]
).reshape(-1, 3)
"""(24, 3) corners of eight triangles, counterclockwise seen from outside."""
_STEM_MM = 14.0
_WIDER = 3.0
"""Width of a marked motion, as a multiple of that of paths, which it covers."""


@dataclass(frozen=True, slots=True)
class Marker:
    """An event. Board frame, mm."""

    kind: Kind
    place_mm: tuple[float, float, float]
    seconds: float
    """Total duration; 0 for an instant."""
    made_by: Source


def find_markers(plan: Plan) -> list[Marker]:
    """Pauses, switches and commands of a plan in order; those that repeat in one place are one marker."""
    found: dict[tuple[Kind, tuple[float, float, float], Source], float] = {}
    here: tuple[float, float, float] | None = None
    spraying, maker = False, NO_SOURCE
    for item in plan.items:
        sprays = isinstance(item, SprayPass | Dwell)
        start = _place(item.tcp[0]) if isinstance(item, SprayPass | Transfer) else here
        if start is not None and sprays != spraying and not isinstance(item, Command):
            kind: Kind = "jet on" if sprays else "jet off"
            found.setdefault((kind, start, (item.made_by if sprays else maker).place), 0.0)
        if start is not None and isinstance(item, Dwell):
            key: tuple[Kind, tuple[float, float, float], Source] = ("pause", start, item.made_by.place)
            found[key] = found.get(key, 0.0) + item.duration_s
        if isinstance(item, Command) and here is not None:
            found.setdefault(("command", here, item.made_by.place), 0.0)
        if isinstance(item, SprayPass | Transfer):
            here = _place(item.tcp[-1])
        if not isinstance(item, Command):
            spraying, maker = sprays, item.made_by
    return [Marker(kind, place, seconds, made_by) for (kind, place, made_by), seconds in found.items()]


def markers_glb(markers: Sequence[Marker], size_mm: float) -> bytes:
    """Octahedra at events, larger for longer pauses.

    Args:
        markers: The events.
        size_mm: Half of the width of a marker of an instant.
    """
    places: Points = np.array([marker.place_mm for marker in markers], dtype=np.float64).reshape(-1, 3)
    seconds = np.array([marker.seconds for marker in markers], dtype=np.float64)
    corners = places[:, None] + _OCTAHEDRON[None] * marker_sizes(seconds, size_mm)[:, None, None]
    colours = np.array([COLOURS[marker.kind] for marker in markers], dtype=np.uint8).reshape(-1, 3)
    return triangles_glb(corners.reshape(-1, 3), np.repeat(colours, len(_OCTAHEDRON), axis=0))


def marker_sizes(seconds: Scalars, size_mm: float) -> Scalars:
    """(n,) half widths: the volume grows with the duration."""
    return size_mm * (0.55 + 0.8 * np.cbrt(np.minimum(seconds, _LARGEST_S)))


def _place(point: Points) -> tuple[float, float, float]:
    x, y, z = (round(float(value), 2) for value in point)
    return x, y, z


def motion_glb(move: Line | Reach | None, width_mm: float) -> bytes:
    """The path of a motion, and a stem from its end back along the jet; no bytes without a motion.

    Args:
        move: Board frame, mm.
        width_mm: Of the lines of paths.
    """
    if move is None:
        return b""
    end = np.array(move.target.position)
    segments = [[end, end - _STEM_MM * rotation(np.array(move.target.quaternion))[2]]]
    if isinstance(move, Line):
        segments.append([np.array(move.start.position), end])
    return flat_triangles_glb(*bars(np.array(segments), INK, _WIDER * width_mm))
