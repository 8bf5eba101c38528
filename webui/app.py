"""The server: one page and one session for each browser; a session outlives a lost connection."""

import threading
from dataclasses import dataclass, field
from pathlib import Path

import viser

from boards.load import load_board
from webui.document import open_document
from webui.layout import lay_out
from webui.page import Page
from webui.project import Project
from webui.session import Session


def open_session(board: str, recipe: str) -> Session:
    """Load what a page begins with.

    Raises:
        JobError: one of them cannot be used.
    """
    document = open_document(recipe)
    return Session(board_name=board, board=load_board(Path(board)), document=document, loaded=document.read())


@dataclass(slots=True)
class _Sessions:
    """Who is connected, and what those who left were doing; a reload takes up what was left last."""

    first: Session
    pages: dict[int, Page] = field(default_factory=dict[int, Page])
    left: list[Session] = field(default_factory=list[Session])
    lock: threading.Lock = field(default_factory=threading.Lock)

    def take(self) -> Session:
        with self.lock:
            return self.left.pop() if self.left else self.first

    def leave(self, client_id: int) -> None:
        with self.lock:
            page = self.pages.pop(client_id, None)
            if page is not None:
                page.close()
                self.left.append(page.session)


def serve(first: Session, project: Project, host: str, port: int) -> viser.ViserServer:
    """Begin to serve pages; the server's threads go on until it is stopped."""
    server = viser.ViserServer(host=host, port=port, label="Washboard", verbose=False)
    sessions = _Sessions(first)

    def connect(client: viser.ClientHandle) -> None:
        page = Page(client, project, sessions.take())
        sessions.pages[client.client_id] = page
        page.open(lay_out(page))

    def disconnect(client: viser.ClientHandle) -> None:
        sessions.leave(client.client_id)

    server.on_client_connect(connect)
    server.on_client_disconnect(disconnect)
    return server
