"""What happens on the way, as small solid marks: pauses, switches of the jet, commands."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from geometry.arrays import Points, Scalars
from programs.plan import Command, Dwell, Plan, SprayPass, Transfer
from webui.glb.glb import triangles_glb
from webui.layers.paths.strokes import Tint, place_of
from webui.theme.palette import QUIET

Kind: TypeAlias = Literal["pause", "jet on", "jet off", "command"]

COLOURS: dict[Kind, Tint] = {
    "pause": (96, 108, 118),
    "jet on": (47, 143, 126),
    "jet off": QUIET,
    "command": (125, 90, 155),
}
_LARGEST_S = 4.0
"""Longer pauses are drawn no larger."""


@dataclass(frozen=True, slots=True)
class Marker:
    """Something that happens in one place. Board frame, mm."""

    kind: Kind
    place_mm: tuple[float, float, float]
    seconds: float
    """How long it lasts altogether; 0 for what takes no time."""
    made_by: str


def find_markers(plan: Plan) -> list[Marker]:
    """Collect pauses, switches and commands of a plan in order; what repeats in one place is one marker."""
    found: dict[tuple[Kind, tuple[float, float, float], str], float] = {}
    here: tuple[float, float, float] | None = None
    spraying, maker = False, ""
    for item in plan.items:
        sprays = isinstance(item, SprayPass | Dwell)
        start = _place(item.tcp[0]) if isinstance(item, SprayPass | Transfer) else here
        if start is not None and sprays != spraying and not isinstance(item, Command):
            kind: Kind = "jet on" if sprays else "jet off"
            found.setdefault((kind, start, place_of(item.made_by if sprays else maker)), 0.0)
        if start is not None and isinstance(item, Dwell):
            key: tuple[Kind, tuple[float, float, float], str] = ("pause", start, place_of(item.made_by))
            found[key] = found.get(key, 0.0) + item.duration_s
        if isinstance(item, Command) and here is not None:
            found.setdefault(("command", here, place_of(item.made_by)), 0.0)
        if isinstance(item, SprayPass | Transfer):
            here = _place(item.tcp[-1])
        if not isinstance(item, Command):
            spraying, maker = sprays, item.made_by
    return [Marker(kind, place, seconds, made_by) for (kind, place, made_by), seconds in found.items()]


def markers_glb(markers: Sequence[Marker], size_mm: float) -> bytes:
    """Draw markers as octahedra; pauses the larger the longer they take.

    Args:
        markers: What to draw.
        size_mm: Half of the width of a marker that takes no time.
    """
    places: Points = np.array([marker.place_mm for marker in markers], dtype=np.float64).reshape(-1, 3)
    seconds = np.array([marker.seconds for marker in markers], dtype=np.float64)
    corners = places[:, None] + _OCTAHEDRON[None] * marker_sizes(seconds, size_mm)[:, None, None]
    colours = np.array([COLOURS[marker.kind] for marker in markers], dtype=np.uint8).reshape(-1, 3)
    return triangles_glb(corners.reshape(-1, 3), np.repeat(colours, len(_OCTAHEDRON), axis=0))


def marker_sizes(seconds: Scalars, size_mm: float) -> Scalars:
    """(n,) half widths: the volume grows with the time."""
    return size_mm * (0.55 + 0.8 * np.cbrt(np.minimum(seconds, _LARGEST_S)))


def _place(point: Points) -> tuple[float, float, float]:
    x, y, z = (round(float(value), 2) for value in point)
    return x, y, z


def _octahedron() -> Points:
    """(24, 3) corners of eight triangles, counterclockwise seen from outside."""
    faces: list[list[list[float]]] = []
    for x in (1.0, -1.0):
        for y in (1.0, -1.0):
            for z in (1.0, -1.0):
                corners = [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]]
                faces.append(corners if x * y * z > 0 else corners[::-1])
    return np.array(faces).reshape(-1, 3)


_OCTAHEDRON = _octahedron()
