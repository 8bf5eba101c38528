"""The nozzle and its jet at one time, and marks on the paths: events, and one motion of a robot's program."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from boards.board import Workpiece
from geometry.arrays import Points, Quaternions, Scalars
from programs.motion.steps import Line, Reach
from programs.plan import Command, Dwell, Plan, SprayPass, Transfer
from programs.playback import Timeline, play
from recipes.footprint import core_footprint, footprint
from recipes.nozzles import Nozzle
from recipes.recipe import Recipe
from specs.source import NO_SOURCE, Source
from webui.glb.glb import bars, flat_triangles_glb, triangles_glb
from webui.theme.palette import INK, QUIET, Tint

_PROFILE_MM = ((0.5, 0.0), (1.4, -1.0), (4.5, -11.0), (4.5, -24.0), (0.0, -24.0))
"""Radius and place along the jet of a nozzle's body; the orifice is at 0."""
_SIDES = 24
_FARTHEST = 6.0
"""The spray is drawn no farther out than this many times the height of the orifice."""
_LIFT_MM = 0.25
"""How far the footprint is drawn above the surface, so that it is not hidden in it."""

Faces = NDArray[np.uint32]
"""(n, 3) indices of corners, counterclockwise seen from outside."""


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """State of the nozzle at one time. Board frame, mm; rims are relative to the orifice."""

    tcp: Points
    """(3,)"""
    quaternion: Quaternions
    """(4,) w, x, y, z."""
    function: str
    """Empty before the first one."""
    instruction: int
    """Index of the running instruction."""
    made_by: Source
    speed_mm_s: float
    rim: Points
    """(k, 3) edge of the spray on the surface; empty while the jet is off."""
    core: Points
    """(k, 3) middle of the wave front on the surface; empty where that is the edge."""


def moment(timeline: Timeline, recipe: Recipe, workpiece: Workpiece, time_s: float) -> Moment:
    """State of the nozzle at a time of the playback.

    Args:
        timeline: The program.
        recipe: With the nozzles of the program.
        workpiece: With the surfaces.
        time_s: Time; outside the program the nozzle stands still.
    """
    states = play(timeline, np.array([time_s]))
    tcp, quaternion = states.tcp[0], states.quaternion[0]
    nozzle = recipe.nozzles.get(states.nozzles[int(states.nozzle[0])])
    sprays = bool(states.spraying[0]) and nozzle is not None
    rim, core = spray_rims(nozzle, workpiece, tcp, quaternion) if sprays and nozzle is not None else (_NONE, _NONE)
    return Moment(
        tcp=tcp,
        quaternion=quaternion,
        function=states.functions[int(states.function[0])],
        instruction=int(states.instruction[0]),
        made_by=states.makers[int(states.made_by[0])],
        speed_mm_s=float(states.speed[0]),
        rim=rim,
        core=core,
    )


_NONE: Points = np.empty((0, 3))


def spray_rims(nozzle: Nozzle, workpiece: Workpiece, tcp: Points, quaternion: Quaternions) -> tuple[Points, Points]:
    """Edge of the spray and middle of its wave front on the surface that it is aimed at.

    Returns:
        (k, 3) each, relative to the orifice; nothing where the jet does not point at the workpiece, and no middle
        where it is the edge.
    """
    reference, _, approach = rotation(quaternion)
    plane = workpiece.aimed_plane(tcp, approach, reference)
    if plane is None:
        return _NONE, _NONE
    height, axes = plane.distance_mm, plane.axes
    rims: list[Points] = []
    for meet in (footprint, core_footprint):
        outline = meet(nozzle, height, axes @ approach, axes @ reference)
        far = np.linalg.norm(outline, axis=1, keepdims=True)
        near = outline * np.minimum(1.0, _FARTHEST * height / np.maximum(far, 1e-9))
        rims.append(np.column_stack([near, np.full(len(near), _LIFT_MM - height)]) @ axes)
    edge, core = rims
    return edge, _NONE if np.allclose(edge, core) else core


def rotation(quaternion: Quaternions) -> NDArray[np.float64]:
    """(3, 3) axes of a tool, one in each row: tool +X, +Y, +Z in the board frame."""
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
            [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
            [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def nozzle_body() -> tuple[Points, Faces]:
    """Corners and triangles of a nozzle in the tool frame, orifice at the origin, mm."""
    around = 2 * np.pi * np.arange(_SIDES) / _SIDES
    rings = [
        np.column_stack([radius * np.cos(around), radius * np.sin(around), np.full(_SIDES, along)])
        for radius, along in _PROFILE_MM
    ]
    this = np.arange(_SIDES)
    following = (this + 1) % _SIDES
    faces: list[NDArray[np.int64]] = [np.column_stack([np.zeros(_SIDES - 2), this[2:], this[1:-1]]).astype(np.int64)]
    for level in range(len(_PROFILE_MM) - 1):
        near, far = level * _SIDES, (level + 1) * _SIDES
        faces.append(np.column_stack([near + this, near + following, far + following]))
        faces.append(np.column_stack([near + this, far + following, far + this]))
    return np.concatenate(rings), np.concatenate(faces)[:, ::-1].astype(np.uint32)


def cone_of(rim: Points) -> tuple[Points, Faces]:
    """Corners and triangles of the spray from the orifice, at the origin, to its rim (k, 3)."""
    this = np.arange(len(rim))
    following = (this + 1) % max(len(rim), 1)
    faces = np.column_stack([np.zeros(len(rim), dtype=np.int64), this + 1, following + 1])
    return np.concatenate([np.zeros((1, 3)), rim]), faces.astype(np.uint32)


def outlines_of(*rims: Points) -> NDArray[np.float64]:
    """(n, 2, 3) segments around closed outlines."""
    loops = [np.stack([rim, np.roll(rim, -1, axis=0)], axis=1) for rim in rims if len(rim)]
    return np.concatenate([np.empty((0, 2, 3)), *loops])


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
