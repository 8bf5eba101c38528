"""Who is connected and what each of them does; a session outlives a reload and a lost connection."""

import threading
from collections import OrderedDict
from dataclasses import dataclass, field

from webui.page import Page
from webui.session import Session

_MOST_LEFT = 8
"""Sessions kept of each browser that nobody looks at."""
_MOST_BROWSERS = 64


@dataclass(slots=True)
class _Browser:
    """What one browser has open, and what it left; it may have several tabs."""

    pages: dict[int, Page] = field(default_factory=dict[int, Page])
    left: list[Session] = field(default_factory=list[Session])
    handed_on: list[Session] = field(default_factory=list[Session])
    """What new tabs began with while others were open."""


class Sessions:
    """Which browser does what; a browser that comes again takes up what it left last."""

    def __init__(self, first: Session) -> None:
        """Begin with nobody connected; who comes for the first time sees ``first``."""
        self._first = first
        self._browsers: OrderedDict[str, _Browser] = OrderedDict()
        self._lock = threading.Lock()

    def take(self, browser: str) -> Session:
        """Give a browser the session that it left last, else that of its newest tab, else the first one.

        A lost connection is noticed late: the page comes again while its old connection still counts as a tab.
        """
        with self._lock:
            known = self._known(browser)
            if known.left:
                return known.left.pop()
            if known.pages:
                session = known.pages[max(known.pages)].session
                known.handed_on.append(session)
                return session
            return self._first

    def enter(self, browser: str, client_id: int, page: Page) -> None:
        """Remember that a page is open."""
        with self._lock:
            self._known(browser).pages[client_id] = page

    def leave(self, client_id: int) -> None:
        """Close a page and keep what it did for the next time, unless another tab went on with just that."""
        with self._lock:
            known = next((each for each in self._browsers.values() if client_id in each.pages), None)
            if known is None:
                return
            page = known.pages.pop(client_id)
            if not any(page.session is each for each in known.handed_on):
                known.left = [*known.left, page.session][-_MOST_LEFT:]
            if not known.pages:
                known.handed_on.clear()
        page.close()

    def close(self) -> None:
        """Give up what is under way on all pages."""
        with self._lock:
            pages = [page for known in self._browsers.values() for page in known.pages.values()]
        for page in pages:
            page.close()

    def _known(self, browser: str) -> _Browser:
        """Find a browser, and forget the one that was away longest when there are too many."""
        known = self._browsers.setdefault(browser, _Browser())
        self._browsers.move_to_end(browser)
        away = [name for name, each in self._browsers.items() if not each.pages and each is not known]
        for name in away[: max(0, len(self._browsers) - _MOST_BROWSERS)]:
            del self._browsers[name]
        return known
