from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from webui.page.project import open_project
from webui.server.server import Server, open_session, serve


@pytest.fixture
def start_server(tmp_path: Path) -> Iterator[Callable[..., Server]]:
    """Serve a board and a recipe from an empty project folder, at a free port of this machine or the one asked for."""
    with ExitStack() as stack:

        def start(board: str, recipe: str, port: int = 0) -> Server:
            server = serve(open_session(board, recipe), open_project(tmp_path), "127.0.0.1", port)
            stack.callback(server.stop)
            return server

        yield start
