"""The clock of a playback: runs at a chosen speed and stops at the end."""

import threading
import time
from collections.abc import Callable

_FRAME_S = 1 / 22


class Player:
    """Clock of a program; its thread exists only while it runs."""

    def __init__(self, draw: Callable[[float], None]) -> None:
        """Start at the beginning of an empty program.

        Args:
            draw: Is called with each time to show, s; one call at a time.
        """
        self._draw = draw
        self._lock = threading.RLock()
        self._drawing = threading.Lock()
        self._stop = threading.Event()
        self._end_s = 0.0
        self._now_s = 0.0
        self._playing = False
        self.rate = 1.0
        """Seconds of the program in a second."""

    @property
    def now_s(self) -> float:
        """The moment that is shown."""
        return self._now_s

    @property
    def playing(self) -> bool:
        """Whether the time runs."""
        return self._playing

    def load(self, end_s: float) -> None:
        """Stop, and take a program of another length; the time stays if it is still inside."""
        with self._lock:
            self.pause()
            self._end_s = end_s
            self._now_s = self._now_s if self._now_s <= end_s else 0.0
        self._show()

    def play(self) -> None:
        """Let the time run; from the beginning if it is at the end."""
        with self._lock:
            if self._playing or self._end_s <= 0:
                return
            if self._now_s >= self._end_s:
                self._now_s = 0.0
            self._playing = True
            self._stop = threading.Event()
            threading.Thread(target=self._run, args=(self._stop,), name="washboard-player", daemon=True).start()

    def pause(self) -> None:
        """Stop the time where it is; the thread ends."""
        with self._lock:
            self._playing = False
            self._stop.set()

    def seek(self, time_s: float) -> None:
        """Go to a moment, inside the program; whether the time runs stays as it is."""
        with self._lock:
            self._now_s = min(max(time_s, 0.0), self._end_s)
        self._show()

    def _run(self, stop: threading.Event) -> None:
        last = time.monotonic()
        while not stop.wait(_FRAME_S):
            now = time.monotonic()
            with self._lock:
                if stop.is_set():
                    return
                self._now_s = min(self._now_s + (now - last) * self.rate, self._end_s)
                if self._now_s >= self._end_s:
                    self.pause()
            last = now
            self._show()

    def _show(self) -> None:
        with self._drawing:
            self._draw(self._now_s)
