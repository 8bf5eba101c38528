"""Sessions of the connected browsers, which outlive a reload and a lost connection; the watch over their files."""

import threading
from collections import OrderedDict
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from webui.page.page import Page
from webui.page.session import Session

_MOST_LEFT = 8
"""Closed sessions kept of each browser."""
_MOST_BROWSERS = 64
_EVERY_S = 2.0


@dataclass(frozen=True, slots=True)
class _Tab:
    """An open page."""

    name: str
    page: Page


@dataclass(frozen=True, slots=True)
class _Left:
    """The session of a closed page."""

    name: str
    session: Session


@dataclass(slots=True)
class _Browser:
    """Open pages and closed sessions of one browser, which may have several tabs."""

    pages: dict[int, _Tab] = field(default_factory=dict[int, _Tab])
    left: list[_Left] = field(default_factory=list[_Left])
    handed_on: list[Session] = field(default_factory=list[Session])
    """Sessions with which new tabs started while others were open."""


class Sessions:
    """Sessions by browser; one that reconnects resumes the session that it closed last."""

    def __init__(self, first: Session) -> None:
        """Start without connections; a new browser gets the session ``first``."""
        self._first = first
        self._browsers: OrderedDict[str, _Browser] = OrderedDict()
        self._lock = threading.Lock()

    def take(self, browser: str, tab: str = "") -> Session:
        """Session of a reconnecting tab; for another tab the one its browser closed last, else that of the newest tab.

        A lost connection is detected late: a page may reconnect while its old connection still counts as a tab.
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
        """Register an open page."""
        with self._lock:
            self._known(browser).pages[client_id] = _Tab(tab, page)

    def leave(self, client_id: int) -> None:
        """Close a page and keep its session, unless another tab continues it."""
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
        """All open pages."""
        with self._lock:
            return [tab.page for known in self._browsers.values() for tab in known.pages.values()]

    def close(self) -> None:
        """Cancel what is under way on all pages."""
        for page in self.pages():
            page.close()

    def _known(self, browser: str) -> _Browser:
        """Record of a browser; of too many the one away longest is dropped."""
        known = self._browsers.setdefault(browser, _Browser())
        self._browsers.move_to_end(browser)
        away = [name for name, each in self._browsers.items() if not each.pages and each is not known]
        for name in away[: max(0, len(self._browsers) - _MOST_BROWSERS)]:
            del self._browsers[name]
        return known


class FileWatch:
    """Polls the recipe files of all pages for changes, in one thread until it is stopped."""

    def __init__(self, pages: Callable[[], Iterable[Page]], every_s: float = _EVERY_S) -> None:
        """Start the thread."""
        self._pages, self._every_s = pages, every_s
        self._end = threading.Event()
        threading.Thread(target=self._run, name="washboard-watch", daemon=True).start()

    def stop(self) -> None:
        """Stop; the poll under way may still finish."""
        self._end.set()

    def _run(self) -> None:
        while not self._end.wait(self._every_s):
            for page in self._pages():
                try:
                    page.poll()
                except Exception as error:
                    page.report(error)
