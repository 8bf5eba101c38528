"""The live view of an operation: a page of its own, served by the operating process in threads of their own.

The stop does not go through the page of `washboard ui`, nor through its event loop, nor through whatever shows the
operation: each request has a thread, which sets what the drive reads before every order to the controller. Where the
drive itself hangs, no orders are sent, and the controller's watchdog shuts the valves.
"""

import json
import sys
import threading
import time
from collections.abc import Callable, Mapping
from email.message import Message
from functools import cache
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, cast

from specs.errors import JobError
from specs.json import Json
from webui.access.access import Access, answer_headers
from webui.theme.palette import ACCENT, colour_variables, to_hex

HOST = "127.0.0.1"
"""A robot is operated from the machine that is beside it; other machines do not reach the view."""
_WORDS = ("stop", "pause", "resume")
_PATIENCE_S = 5.0
"""Longest wait for the rest of a request."""
_RECENT_S, _LAST_LOOK_S = 1.0, 0.3
"""Where the state was requested so recently, the end waits so long until it is seen."""


class LiveServer:
    """Serves the live view of one operation at a port of this machine, in daemon threads."""

    def __init__(self, live: Callable[[], Mapping[str, Json]], act: Callable[[str], None], port: int = 0) -> None:
        """Begin to serve.

        Args:
            live: Gives the operation as it is now, as in ``live_data``; called in the thread of a request.
            act: Takes ``stop``, ``pause`` or ``resume``; called in the thread of a request.
            port: 0 takes any.

        Raises:
            JobError: the port is in use, or not allowed.
        """
        try:
            self._server = _Server(live, act, port)
        except OSError as error:
            raise JobError(f"the live view cannot be served at port {port} ({error.strerror}): name another.") from None
        threading.Thread(target=self._server.serve_forever, args=(0.05,), name="live view", daemon=True).start()

    @property
    def address(self) -> str:
        """URL for a browser on this machine."""
        return f"http://{HOST}:{self._server.server_port}"

    def close(self) -> None:
        """Take no more requests; whoever looks at the view sees the state at the end first."""
        if time.monotonic() - self._server.seen_at < _RECENT_S:
            self._server.seen.clear()
            self._server.seen.wait(_LAST_LOOK_S)
        self._server.shutdown()
        self._server.server_close()


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    block_on_close = False
    """A request that hangs keeps nobody waiting."""
    seen_at = -float("inf")
    """When the state was given last."""

    def __init__(self, live: Callable[[], Mapping[str, Json]], act: Callable[[str], None], port: int) -> None:
        self.live, self.act = live, act
        self.seen = threading.Event()
        super().__init__((HOST, port), _Handler)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Print a defect of ours; a browser that leaves in the middle of a request is none."""
        if not isinstance(sys.exception(), OSError):
            super().handle_error(request, client_address)


class _Handler(BaseHTTPRequestHandler):
    """One request: the page, the state, or a word of the operator."""

    timeout = _PATIENCE_S
    protocol_version = "HTTP/1.1"

    def do_GET(self) -> None:
        """Give the page or the state."""
        if self._is_refused():
            return
        server = cast("_Server", self.server)
        match self.path:
            case "/":
                self._answer(HTTPStatus.OK, "text/html", live_page().encode())
            case "/state":
                self._answer(HTTPStatus.OK, "application/json", json.dumps(server.live()).encode())
                server.seen_at = time.monotonic()
                server.seen.set()
            case _:
                self._answer(HTTPStatus.NOT_FOUND, "text/plain", b"there is the page, and /state")

    def do_POST(self) -> None:
        """Take a word of the operator."""
        if self._is_refused():
            return
        word = self.path.removeprefix("/")
        if word not in _WORDS:
            self._answer(HTTPStatus.NOT_FOUND, "text/plain", b"there are /stop, /pause and /resume")
            return
        cast("_Server", self.server).act(word)
        self._answer(HTTPStatus.OK, "application/json", json.dumps({"taken": word}).encode())

    def _is_refused(self) -> bool:
        address, port = self.request.getsockname()[:2]
        reason = Access(HOST).refusal(self.path, _Fields(self.headers), address, port)
        if reason:
            self._answer(HTTPStatus.FORBIDDEN, "text/plain", reason.encode())
        return bool(reason)

    def _answer(self, code: HTTPStatus, kind: str, content: bytes) -> None:
        self.send_response(code)
        for name, value in answer_headers(self.headers.get("Host", "")).items():
            self.send_header(name, value)
        self.send_header("Content-Type", f"{kind}; charset=utf-8")
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, format: str, *args: Any) -> None:  # noqa: A002 - as in the base class
        """Requests are not logged: the terminal shows the operation."""


class _Fields:
    """Header fields of a request, by name in any case."""

    def __init__(self, headers: Message) -> None:
        self._headers = headers

    def get_all(self, key: str) -> list[str]:
        """Values of all fields of that name."""
        return self._headers.get_all(key, [])


@cache
def live_page() -> str:
    """HTML of the live view, with style and script in it; it takes ``/state`` ten times a second."""
    light, dark = (colour_variables(dark=each) for each in (False, True))
    variables = f":root{{{light}--wb-brand:{to_hex(ACCENT)};color-scheme:light dark}}"
    variables += f"@media (prefers-color-scheme: dark){{:root{{{dark}}}}}"
    return (Path(__file__).parent / "live.html").read_text("utf-8").replace("/* colours */", variables)
