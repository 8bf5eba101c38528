"""Camera and light of one page, and picking by a click."""

import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Literal, TypeAlias

import numpy as np
import viser
from numpy.typing import NDArray

from boards.board import Body, Workpiece
from geometry.arrays import Points, Scalars, Triangles
from specs.source import NO_SOURCE, Source
from webui.layers.paths.strokes import StrokeLine
from webui.theme.page_head import scene_px

_M = 0.001
"""The scene is in metres."""
_FOV = float(np.radians(40))
_NARROWEST = 0.4
_CLEAR, _WHOLE = 0.45, 0.02
"""Share of the way from the eye to the target in which nothing is shown: in a close view, where paths there would hide
all the rest, and in one of the whole job."""
_CLOSE = 0.6
"""A view from less than this share of the distance of the whole job is a close one."""
_SAME = 0.1
_FLIGHT_S, _STEPS = 0.4, 12
_TOWARDS: dict[str, Points] = {"plan": np.array([0.0, -0.001, 1.0]), "iso": np.array([0.0, -0.62, 0.785])}
"""From the target towards the eye: from straight above, or from the front, so that stripes and heights both show."""
_STEEP = 0.9999
_MOST_POSES = 50
_FILLED = 0.94
"""Share of the picture's width and height that may be filled."""
_FROM_BELOW = 4.0
"""The default lights are all above."""
_AROUND, _SKY, _GROUND = 4.2, (255, 255, 255), (205, 205, 200)
"""Light from all around, as bright as the browser's own environment would be."""


View: TypeAlias = Literal["plan", "iso"] | Points
"""From straight above, from the front, or (3,) from the target towards the eye, of any length."""


@dataclass(frozen=True, slots=True, eq=False)
class Lens:
    """View of a camera."""

    fov: float
    """Vertical angle of view, radians."""
    aspect: float
    """Width of the picture divided by its height."""


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """Position and target of a camera. Board frame, mm."""

    eye: Points
    """(3,)"""
    target: Points
    """(3,)"""


def frame_box(low: Points, high: Points, lens: Lens, view: View = "iso", *, from_below: bool = False) -> Pose:
    """Nearest pose from which a box is visible as a whole.

    Every corner c, seen from the middle of the box in the camera's axes (right, up, towards the eye), must keep
    ``|right| <= share * tan(fov / 2) * aspect * (distance - towards)``, and the same upwards.

    Args:
        low: (3,) lowest corner.
        high: (3,) highest corner.
        lens: View of the camera.
        view: From where.
        from_below: Look at the bottom side.
    """
    towards = _TOWARDS[view] if isinstance(view, str) else view
    if abs(float(towards[2])) > _STEEP * float(np.linalg.norm(towards)):  # straight above there is no way up
        towards = np.array([0.0, -0.001, np.sign(towards[2])])
    towards = towards / np.linalg.norm(towards) * [1.0, 1.0, -1.0 if from_below else 1.0]
    right = np.array([-towards[1], towards[0], 0.0])
    right = right / np.linalg.norm(right)
    upward = np.cross(towards, right)
    corners = np.array(list(product(*zip(low, high, strict=True)))) - (low + high) / 2
    tall = float(np.tan(lens.fov / 2))
    depth = corners @ towards
    across = np.abs(corners @ right) / (_FILLED * tall * lens.aspect)
    height = np.abs(corners @ upward) / (_FILLED * tall)
    target = (low + high) / 2
    return Pose(target + float((np.maximum(across, height) + depth).max()) * towards, target)


def between(begin: Pose, end: Pose, share: float) -> Pose:
    """Pose on the way from one to another, with smooth start and end."""
    eased = share * share * (3.0 - 2.0 * share)
    return Pose(begin.eye + eased * (end.eye - begin.eye), begin.target + eased * (end.target - begin.target))


class Camera:
    """Moves the camera of one browser."""

    def __init__(self, client: viser.ClientHandle) -> None:
        """Set the lens."""
        self._client = client
        self._lock = threading.Lock()
        self._flight = 0
        self._window_px = client.camera.image_width
        self._whole_m = np.inf
        """From the eye to the target where the whole job is shown."""
        self._poses: list[Pose] = []
        """Views that were left, the last one last."""
        with client.atomic():
            client.camera.fov = _FOV
            client.camera.min_orbit_distance = 0.002
            client.camera.max_orbit_distance = 10.0
            client.camera.up_direction = (0.0, 0.0, 1.0)
        client.camera.on_update(lambda _: self._clear_the_way())

    def show_whole(self, low: Points, high: Points, view: View = "plan") -> None:
        """Show the box of the whole job at once.

        Args:
            low: (3,) lowest corner, mm.
            high: (3,) highest corner, mm.
            view: From where.
        """
        self.stop()
        self._poses.clear()
        pose = frame_box(low, high, self._lens(), view)
        self._whole_m = float(np.linalg.norm(pose.eye - pose.target)) * _M
        self._stand(pose)

    def fly_to(self, low: Points, high: Points, view: View = "iso", *, from_below: bool = False) -> None:
        """Move smoothly to a view of a box; ``fly_back`` returns from it.

        Args:
            low: (3,) lowest corner, mm.
            high: (3,) highest corner, mm.
            view: From where.
            from_below: Show the bottom side.
        """
        self._poses = [*self._poses, self._pose()][-_MOST_POSES:]
        self._start(frame_box(low, high, self._lens(), view, from_below=from_below))

    def fly_back(self) -> None:
        """Return to the view that was left last; stay where there is none."""
        if self._poses:
            self._start(self._poses.pop())

    def _start(self, end: Pose) -> None:
        threading.Thread(target=self._fly, args=(self.stop(), end), name="flight", daemon=True).start()

    def _pose(self) -> Pose:
        camera = self._client.camera
        return Pose(np.array(camera.position) / _M, np.array(camera.look_at) / _M)

    def _clear_the_way(self) -> None:
        """Set the near plane in proportion to the distance of the target."""
        camera = self._client.camera
        away = float(np.linalg.norm(np.array(camera.look_at) - np.array(camera.position)))
        near = (_CLEAR if away < _CLOSE * self._whole_m else _WHOLE) * away
        if near > 0 and abs(camera.near / near - 1.0) > _SAME:
            camera.near = near

    def _lens(self) -> Lens:
        camera = self._client.camera
        width, height = camera.image_width, camera.image_height
        if width == self._window_px:  # the browser reports the scene's size some time after the panels are docked
            width, height = scene_px((width, height))
        return Lens(camera.fov, max(width / max(height, 1), _NARROWEST))

    def stop(self) -> int:
        """Stop the move that is under way; return the number of the next one."""
        with self._lock:
            self._flight += 1
            return self._flight

    def _fly(self, flight: int, end: Pose) -> None:
        begin = self._pose()
        for step in range(1, _STEPS + 1):
            with self._lock:
                if flight != self._flight:
                    return
                self._stand(between(begin, end, step / _STEPS))
            time.sleep(_FLIGHT_S / _STEPS)

    def _stand(self, pose: Pose) -> None:
        with self._client.atomic():
            self._client.camera.position = pose.eye * _M
            self._client.camera.look_at = pose.target * _M
            self._clear_the_way()


def light_scene(api: viser.SceneApi) -> None:
    """Light a scene from both sides, without shadows and without an environment map.

    Without a graphics card shadows cost as much time as all the rest, reflections of an environment forty times that.
    """
    api.set_up_direction("+z")
    api.configure_environment_map(None)
    api.configure_default_lights(cast_shadow=False)
    api.add_light_hemisphere("/sky", sky_color=_SKY, ground_color=_GROUND, intensity=_AROUND)
    api.add_light_directional("/light", intensity=_FROM_BELOW, position=(0.0, -0.4, -1.0))


_PARALLEL = 1e-12
_ROUNDING_MM = 1e-6
"""Boxes are a little larger than bodies, so that a ray along a face meets both."""
_NEAR = 0.005
"""Tolerance of a click on a stroke, as a share of its distance from the eye: about 6 pixels."""


@dataclass(frozen=True, slots=True, eq=False)
class Hit:
    """First intersection of a ray with a body."""

    body: str
    point: Points
    """(3,)"""
    distance_mm: float


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """A workpiece arranged for many rays."""

    bodies: tuple[Body, ...]
    low: Points
    """(n, 3) lowest corner of the box around each body."""
    high: Points


def target_of(workpiece: Workpiece) -> Target:
    """Arrange a workpiece for rays."""
    bodies = tuple(body for body in workpiece.pickable_bodies if len(body.patches))
    low = [body.patches.min(axis=(0, 1)) - _ROUNDING_MM for body in bodies]
    high = [body.patches.max(axis=(0, 1)) + _ROUNDING_MM for body in bodies]
    return Target(bodies, np.array(low).reshape(-1, 3), np.array(high).reshape(-1, 3))


def first_hit(target: Target, origin: Points, direction: Points) -> Hit | None:
    """First body along a ray; of two in one place the first of the file.

    Args:
        target: The workpiece.
        origin: (3,) start of the ray.
        direction: (3,) its direction, of any length.
    """
    along = direction / np.linalg.norm(direction)
    best: Hit | None = None
    for index in np.flatnonzero(_boxes_met(target, origin, along)):
        body = target.bodies[int(index)]
        length = _distance(body.patches, origin, along)
        if length < (np.inf if best is None else best.distance_mm):
            best = Hit(body.name, origin + length * along, length)
    return best


def strokes_at(
    lines: Sequence[StrokeLine], origin: Points, direction: Points, before_mm: float, within_mm: float = 0.0
) -> tuple[Source, ...]:
    """Strokes that a ray passes closely, in front of the body that it meets; the closest first.

    Args:
        lines: Visible strokes.
        origin: (3,) start of the ray.
        direction: (3,) its direction, of any length.
        before_mm: Strokes farther away than this are hidden.
        within_mm: Strokes so near to the ray count too, also where that is many pixels.
    """
    if not lines:
        return ()
    along = direction / np.linalg.norm(direction)
    segments = [line.segments for line in lines]
    ends = np.concatenate(segments)
    begin, run = ends[:, 0] - origin, ends[:, 1] - ends[:, 0]
    share, depth = _closest(begin, run, along)
    gap = np.linalg.norm(begin + share[:, None] * run - depth[:, None] * along, axis=1)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        reach = np.maximum(_NEAR * depth, within_mm)
        apart = np.where((depth > 0) & (depth < before_mm), gap / reach, np.inf)
    firsts = np.cumsum([0, *(len(each) for each in segments[:-1])])
    closest = np.minimum.reduceat(apart, firsts)
    order = np.argsort(np.round(closest, 3), kind="stable")
    return tuple(dict.fromkeys(lines[int(index)].made_by for index in order if closest[index] < 1.0))


def choose_stroke(makers: Sequence[Source], selected: Source) -> Source:
    """The closest stroke under a click; click after click, the next one there."""
    if selected not in makers:
        return makers[0] if makers else NO_SOURCE
    there = sorted(makers, key=str)
    return there[(there.index(selected) + 1) % len(there)]


def _boxes_met(target: Target, origin: Points, along: Points) -> NDArray[np.bool_]:
    """(n,) which boxes a ray passes through (slabs: Kay and Kajiya 1986)."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        one, other = (target.low - origin) / along, (target.high - origin) / along
        enter = np.fmax.reduce(np.fmin(one, other), axis=1)
        leave = np.fmin.reduce(np.fmax(one, other), axis=1)
    return (enter <= leave) & (leave > 0)


def _distance(patches: Triangles, origin: Points, along: Points) -> float:
    """Distance along a ray of unit direction to the first patch, else infinity (Moeller and Trumbore 1997)."""
    corner = patches[:, 0]
    first, second = patches[:, 1] - corner, patches[:, 2] - corner
    across = np.cross(along, second)
    volume = np.einsum("ij,ij->i", first, across)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        inverse = np.where(np.abs(volume) > _PARALLEL, 1.0 / volume, np.nan)
    away = origin - corner
    over = np.cross(away, first)
    u = np.einsum("ij,ij->i", away, across) * inverse
    v = over @ along * inverse
    distance = np.einsum("ij,ij->i", second, over) * inverse
    inside = (u >= 0) & (v >= 0) & (u + v <= 1) & (distance > 0)
    return float(np.min(distance, where=inside, initial=np.inf))


def _closest(begin: Points, run: Points, along: Points) -> tuple[Scalars, Scalars]:
    """(n,) shares of segments, and lengths along the ray, at the closest points of both."""
    square = np.einsum("ij,ij->i", run, run)
    mixed, shadow = run @ along, begin @ along
    cross = square - mixed**2
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        share = np.where(cross > _PARALLEL, (mixed * shadow - np.einsum("ij,ij->i", run, begin)) / cross, 0.0)
    share = np.clip(share, 0.0, 1.0)
    return share, shadow + share * mixed
