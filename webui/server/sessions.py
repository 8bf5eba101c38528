"""Who is connected and what each of them does; a session outlives a reload and a lost connection."""

import threading
from collections import OrderedDict
from dataclasses import dataclass, field

from webui.page.page import Page
from webui.page.session import Session

_MOST_LEFT = 8
"""Sessions kept of each browser that nobody looks at."""
_MOST_BROWSERS = 64


@dataclass(frozen=True, slots=True)
class _Tab:
    """A page that is open."""

    name: str
    page: Page


@dataclass(frozen=True, slots=True)
class _Left:
    """What a page did when it was left."""

    name: str
    session: Session


@dataclass(slots=True)
class _Browser:
    """What one browser has open, and what it left; it may have several tabs."""

    pages: dict[int, _Tab] = field(default_factory=dict[int, _Tab])
    left: list[_Left] = field(default_factory=list[_Left])
    handed_on: list[Session] = field(default_factory=list[Session])
    """What new tabs began with while others were open."""


class Sessions:
    """Which browser does what; a browser that comes again takes up what it left last."""

    def __init__(self, first: Session) -> None:
        """Begin with nobody connected; who comes for the first time sees ``first``."""
        self._first = first
        self._browsers: OrderedDict[str, _Browser] = OrderedDict()
        self._lock = threading.Lock()

    def take(self, browser: str, tab: str = "") -> Session:
        """Give a tab the session that it left; another one what its browser left last, else that of the newest tab.

        A lost connection is noticed late: the page comes again while its old connection still counts as a tab.
        """
        with self._lock:
            known = self._known(browser)
            own = [each for each in known.left if tab and each.name == tab]
            still = [client for client, each in known.pages.items() if tab and each.name == tab]
            if own or (known.left and not still):
                found = (own or known.left)[-1]
                known.left.remove(found)
                return found.session
            if known.pages:
                session = known.pages[max(still or known.pages)].page.session
                known.handed_on.append(session)
                return session
            return self._first

    def enter(self, browser: str, client_id: int, page: Page, tab: str = "") -> None:
        """Remember that a page is open."""
        with self._lock:
            self._known(browser).pages[client_id] = _Tab(tab, page)

    def leave(self, client_id: int) -> None:
        """Close a page and keep what it did for the next time, unless another tab went on with just that."""
        with self._lock:
            known = next((each for each in self._browsers.values() if client_id in each.pages), None)
            if known is None:
                return
            tab = known.pages.pop(client_id)
            if not any(tab.page.session is each for each in known.handed_on):
                known.left = [*known.left, _Left(tab.name, tab.page.session)][-_MOST_LEFT:]
            if not known.pages:
                known.handed_on.clear()
        tab.page.close()

    def pages(self) -> list[Page]:
        """All pages that are open."""
        with self._lock:
            return [tab.page for known in self._browsers.values() for tab in known.pages.values()]

    def close(self) -> None:
        """Give up what is under way on all pages."""
        for page in self.pages():
            page.close()

    def _known(self, browser: str) -> _Browser:
        """Find a browser, and forget the one that was away longest when there are too many."""
        known = self._browsers.setdefault(browser, _Browser())
        self._browsers.move_to_end(browser)
        away = [name for name, each in self._browsers.items() if not each.pages and each is not known]
        for name in away[: max(0, len(self._browsers) - _MOST_BROWSERS)]:
            del self._browsers[name]
        return known
