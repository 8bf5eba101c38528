"""Looks now and then whether recipe files were changed by somebody else, for all pages in one thread."""

import threading
from collections.abc import Callable, Iterable

from webui.page.page import Page

_EVERY_S = 2.0


class Watch:
    """Has all pages look at the disk, again and again until it is stopped."""

    def __init__(self, pages: Callable[[], Iterable[Page]], every_s: float = _EVERY_S) -> None:
        """Begin."""
        self._pages, self._every_s = pages, every_s
        self._end = threading.Event()
        threading.Thread(target=self._live, name="washboard-watch", daemon=True).start()

    def stop(self) -> None:
        """End it; it may still finish one look."""
        self._end.set()

    def _live(self) -> None:
        while not self._end.wait(self._every_s):
            for page in self._pages():
                try:
                    page.look()
                except Exception as error:
                    page.report(error)
