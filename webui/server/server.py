"""The web server: one page for each browser tab."""

import errno
import socket
import threading
import warnings
from collections import OrderedDict
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace

import rich
import viser

from boards.workpiece import load_workpiece
from robotcell.cell.load import hold_board, read_cell
from specs.confinement import Confinement, confine, record_reads, release
from specs.errors import JobError
from webui.access.access import ANY_ADDRESS, Uploads, access_for, bracketed, with_token
from webui.access.viser_guard import limit_uploads, start_guarded
from webui.page.document import open_document
from webui.page.page import Page, identify
from webui.page.project import LARGEST_UPLOAD, Project, library_folders
from webui.page.session import Session
from webui.panels.board.board import BoardPanel, ComponentsPanel
from webui.panels.board.paths import PathsPanel
from webui.panels.cleaning.analysis import CleaningPanel
from webui.panels.recipe.job import JobPanel
from webui.panels.recipe.recipe import RecipePanel
from webui.panels.recipe.text import Drafts, TextPanel, UnsavedEdits
from webui.panels.results.comparison import ComparePanel, StudyPanel
from webui.panels.results.overview import FindingsPanel, OutputPanel, StatusPanel
from webui.panels.results.playback import PlaybackPanel
from webui.panels.robot.live import LivePanel, add_live_mark
from webui.panels.robot.program import ProgramPanel
from webui.panels.robot.robot import RobotPanel
from webui.scene.scene import Scene
from webui.theme.page_head import FOOT_PX, STRIP_PX, page_head, side_px
from webui.theme.palette import ACCENT

_MOST_LEFT = 8
"""Closed sessions kept of each browser."""
_MOST_BROWSERS = 64
_EVERY_S = 2.0


@dataclass(frozen=True, slots=True)
class _Tab:
    """An open page."""

    name: str
    page: Page


@dataclass(slots=True)
class _Browser:
    """Open pages and closed sessions of one browser, which may have several tabs."""

    pages: dict[int, _Tab] = field(default_factory=dict[int, _Tab])
    left: list[tuple[str, Session]] = field(default_factory=list[tuple[str, Session]])
    """Tab and session of each closed page."""
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
            own = [each for each in known.left if tab and each[0] == tab]
            still = [client for client, each in known.pages.items() if tab and each.name == tab]
            if own or (known.left and not still):
                found = (own or known.left)[-1]
                known.left.remove(found)
                return found[1]
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
                known.left = [*known.left, (tab.name, tab.page.session)][-_MOST_LEFT:]
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


_LEFT = (
    ("Job", JobPanel),
    ("Board", BoardPanel),
    ("Components", ComponentsPanel),
    ("Findings", FindingsPanel),
    ("Robot", RobotPanel),
    ("Cleaning", CleaningPanel),
)
_RIGHT = (
    ("Recipe", RecipePanel),
    ("YAML", TextPanel),
    ("Paths", PathsPanel),
    ("Compare", ComparePanel),
    ("Study", StudyPanel),
    ("Files", OutputPanel),
    ("Program", ProgramPanel),
    ("Live", LivePanel),
)
TABS = (_LEFT, _RIGHT)
"""Tabs on the left and on the right; ``webui.theme.page_head.MODES`` has those of each mode."""

_MOST_PORTS = 100
_LAST_PORT = 65535


class ServerError(JobError):
    """The server cannot listen at the requested host or port."""


@dataclass(frozen=True, slots=True)
class Server:
    """A server that runs in threads of its own."""

    viser: viser.ViserServer
    sessions: Sessions
    watch: FileWatch
    host: str
    port: int
    """The port it listens at; another one than requested if that was in use."""
    token: str
    """Secret that every request has to carry; empty where whoever uses this machine is answered."""
    confinement: Confinement
    """What may be read until it is stopped."""

    @property
    def address(self) -> str:
        """URL for a browser on this machine, with the token if there is one."""
        host = "127.0.0.1" if self.host in ANY_ADDRESS else bracketed(self.host)
        return with_token(f"http://{host}:{self.port}", self.token)

    def stop(self) -> None:
        """Stop; what is under way is cancelled."""
        self.watch.stop()
        self.sessions.close()
        self.viser.stop()
        release(self.confinement)


def lay_out(page: Page) -> None:
    """Build a page: status along the top, views on the left, editors on the right, playback along the bottom."""
    gui = page.client.gui
    gui.configure_theme(control_width="large", show_logo=False, show_share_button=False, brand_color=ACCENT)
    scene = Scene(page)
    StatusPanel(page, scene)
    add_live_mark(page, scene)
    width_px = page.client.camera.image_width  # of the window, as long as no panel is docked
    left, right = gui.add_panel(), gui.add_panel()
    for side, kinds in ((left, _LEFT), (right, _RIGHT)):
        for label, kind in kinds:
            with side.add_tab(label):
                kind(page, scene)
        side.set_width(side_px(width_px))
    left.dock_left()
    right.dock_right()
    gui.main_panel.float(x=0, y=0, width=width_px, height=STRIP_PX)
    below = gui.add_panel()
    with below.add_tab("Playback"):
        PlaybackPanel(page, scene)
    below.float(x=0, y=-1, width=width_px, height=FOOT_PX)


def open_session(workpiece: str, recipe: str, cell: str = "") -> Session:
    """First session of a page.

    Args:
        workpiece: File, or name of a sample board or part.
        recipe: The same.
        cell: The same; empty for no robot.

    Raises:
        JobError: one of them cannot be used.
    """
    with record_reads() as opened:
        document = open_document(recipe)
        loaded = document.read()
        session = Session(workpiece, load_workpiece(workpiece, over_faces=loaded.recipe.over_faces), document, loaded)
        if cell:
            session = replace(session, cell_name=cell, cell=hold_board(read_cell(cell), session.workpiece))
    return replace(session, opened=frozenset(opened))


def serve(first: Session, project: Project, host: str, port: int, *, needs_token: bool = True) -> Server:
    """Serve pages; the server's threads run until it is stopped, and the process reads nothing else until then.

    Raises:
        AccessError: other machines would reach it without token.
        ServerError: it cannot listen at that host or port.
        ViserDiffersError: the installed viser cannot be guarded.
    """
    access, free = access_for(host, needs_token=needs_token), free_port(host, port)
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection")  # a browser may disconnect at any time
    rich.get_console().quiet = True  # viser prints a box at the start and a line at the end
    server = start_guarded(access, host, free, page_head())
    confinement = Confinement((project.folder, *library_folders()), first.opened)
    confine(confinement)
    sessions, drafts = Sessions(first), Drafts(project.folder)
    uploads = Uploads(LARGEST_UPLOAD, str(project.folder))

    def connect(client: viser.ClientHandle) -> None:
        limit_uploads(client, uploads)
        identity = identify(client)
        if client.client_id not in server.get_clients():
            return
        page = Page(client, project, sessions.take(identity.browser, identity.tab))
        sessions.enter(identity.browser, client.client_id, page, identity.tab)
        try:
            lay_out(page)
            UnsavedEdits(page, drafts, identity)
            page.open()
        except Exception:
            if client.client_id in server.get_clients():
                raise
            # A browser that disconnects while its page is built is no defect.
        if client.client_id not in server.get_clients():  # it disconnected meanwhile
            sessions.leave(client.client_id)

    server.on_client_connect(lambda client: threading.Thread(target=connect, args=(client,), daemon=True).start())

    def disconnect(client: viser.ClientHandle) -> None:
        uploads.forget(client.client_id)
        sessions.leave(client.client_id)

    server.on_client_disconnect(disconnect)
    return Server(server, sessions, FileWatch(sessions.pages), host, server.get_port(), access.token, confinement)


def free_port(host: str, port: int) -> int:
    """First free port from the requested one on; 0 takes any.

    Raises:
        ServerError: the host is none of this machine's, or no port is free.
    """
    for candidate in range(port, min(port + _MOST_PORTS, _LAST_PORT + 1)):
        try:
            family, kind, protocol, _, address = socket.getaddrinfo(host, candidate, type=socket.SOCK_STREAM)[0]
            with socket.socket(family, kind, protocol) as tried:
                tried.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                tried.bind(address)
                tried.listen()
        except PermissionError:
            raise ServerError(f"port {candidate}: not allowed; choose one from 1024 on with --port.") from None
        except (OSError, UnicodeError) as error:
            if getattr(error, "errno", None) != errno.EADDRINUSE:
                reason = getattr(error, "strerror", None) or str(error)
                raise ServerError(f"host {host!r}: {reason}; leave out --host to listen on this machine.") from None
        else:
            return candidate
    raise ServerError(f"port {port}: in use, like those after it; choose another one with --port.")
