"""The camera of one page: it flies to boxes, so that one sees where they are."""

import threading
import time

import numpy as np
import viser

from geometry.arrays import Points
from webui.scene.camera_fit import Lens, Pose, between, frame_box

_M = 0.001
"""The scene is in metres."""
_FOV = float(np.radians(40))
_PANELS_PX = 2 * 364
"""What stands beside the scene takes this much of the window; the browser says so only some time later."""
_NARROWEST = 0.4
_CLEAR = 0.45
"""Share of the way from the eye to what is looked at in which nothing is shown: paths there would hide all the rest."""
_SAME = 0.1
_FLIGHT_S, _STEPS = 0.4, 12


class Camera:
    """Moves the camera of one browser."""

    def __init__(self, client: viser.ClientHandle) -> None:
        """Set the lens."""
        self._client = client
        self._lock = threading.Lock()
        self._flight = 0
        self._window_px = client.camera.image_width
        with client.atomic():
            client.camera.fov = _FOV
            client.camera.min_orbit_distance = 0.002
            client.camera.max_orbit_distance = 10.0
            client.camera.up_direction = (0.0, 0.0, 1.0)
        client.camera.on_update(lambda _: self._clear_the_way())

    def show_at_once(self, low: Points, high: Points) -> None:
        """Look at a box from above, without a flight.

        Args:
            low: (3,) lowest corner, mm.
            high: (3,) highest corner, mm.
        """
        self._take_off()
        self._stand(frame_box(low, high, self._lens()))

    def fly_to(self, low: Points, high: Points, *, from_below: bool = False) -> None:
        """Fly to where one sees a box.

        Args:
            low: (3,) lowest corner, mm.
            high: (3,) highest corner, mm.
            from_below: Look at the bottom side.
        """
        end = frame_box(low, high, self._lens(), from_below=from_below)
        threading.Thread(target=self._fly, args=(self._take_off(), end), name="flight", daemon=True).start()

    def land(self) -> None:
        """End a flight; the browser is gone."""
        self._take_off()

    def _clear_the_way(self) -> None:
        """Begin to show things nearer to the eye the nearer it is to what it looks at."""
        camera = self._client.camera
        near = _CLEAR * float(np.linalg.norm(np.array(camera.look_at) - np.array(camera.position)))
        if near > 0 and abs(camera.near / near - 1.0) > _SAME:
            camera.near = near

    def _lens(self) -> Lens:
        camera = self._client.camera
        taken = _PANELS_PX if camera.image_width == self._window_px else 0
        free = max(camera.image_width - taken, _NARROWEST * camera.image_height)
        return Lens(camera.fov, free / max(camera.image_height, 1))

    def _take_off(self) -> int:
        """End the flight that is under way."""
        with self._lock:
            self._flight += 1
            return self._flight

    def _fly(self, flight: int, end: Pose) -> None:
        camera = self._client.camera
        begin = Pose(np.array(camera.position) / _M, np.array(camera.look_at) / _M)
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
