"""The live view of an operation: a page of its own, served by the operating process in threads of their own.

The stop does not go through the server of `washboard ui`, nor through its event loop, nor through whatever shows the
operation: each request has a thread, which sets what the drive reads before every order to the controller. Where the
drive itself hangs, no orders are sent, and the controller's watchdog shuts the valves.
"""

import json
import re
import secrets
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
from urllib.parse import parse_qs, urlsplit

from robotcell.operate.drive import Snapshot
from robotcell.operate.nodes import Job
from specs.errors import JobError
from specs.json import Json
from webui.access.access import Access, answer_headers
from webui.theme.page_head import live_script
from webui.theme.palette import ACCENT, colour_variables, to_hex

HOST = "127.0.0.1"
"""A robot is operated from the machine that is beside it; other machines do not reach the view."""
_WORDS = ("stop", "pause", "resume")
_PATIENCE_S = 5.0
"""Longest wait for the rest of a request."""
_RECENT_S, _LAST_LOOK_S = 1.0, 0.3
"""Of whoever requested the state so recently, the end waits so long until it is seen."""
_LOOK_S = 0.01
_BESIDE = re.compile(r"http://(127\.0\.0\.1|localhost|\[::1\]):[0-9]{1,5}")
"""Origins of the pages of other servers on this machine."""


class LiveServer:
    """Serves the live view of one operation at a port of this machine, in daemon threads."""

    def __init__(
        self, live: Callable[[], Mapping[str, Json]], act: Callable[[str], None], port: int = 0, token: str = ""
    ) -> None:
        """Begin to serve.

        Args:
            live: Gives the operation as it is now, as in ``live_data``; called in the thread of a request.
            act: Takes ``stop``, ``pause`` or ``resume``; called in the thread of a request.
            port: 0 takes any.
            token: Secret with which pages of other servers on this machine are answered too; none are without.

        Raises:
            JobError: the port is in use, or not allowed.
        """
        try:
            self._server = _Server(live, act, port, token)
        except OSError as error:
            raise JobError(f"the live view cannot be served at port {port} ({error.strerror}): name another.") from None
        threading.Thread(target=self._server.serve_forever, args=(0.05,), name="live view", daemon=True).start()

    @property
    def address(self) -> str:
        """URL for a browser on this machine."""
        return f"http://{HOST}:{self._server.server_port}"

    def close(self) -> None:
        """Take no more requests; whoever looks at the view sees the state at the end first."""
        until = (begun := time.monotonic()) + _LAST_LOOK_S
        while time.monotonic() < until and self._server.are_waiting(begun):
            time.sleep(_LOOK_S)
        self._server.is_over = True
        self._server.shutdown()
        self._server.server_close()


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    block_on_close = False
    """A request that hangs keeps nobody waiting."""
    is_over = False
    """Whether connections that are kept are answered no more."""

    def __init__(
        self, live: Callable[[], Mapping[str, Json]], act: Callable[[str], None], port: int, token: str
    ) -> None:
        self.live, self.act, self.token = live, act, token
        self._looks: dict[object, float] = {}
        """When the state was given last, by the other end of the connection."""
        super().__init__((HOST, port), _Handler)

    def note_look(self, client: object) -> None:
        """Note that the state was given just now."""
        now = time.monotonic()
        recent = {each: at for each, at in self._looks.copy().items() if now - at < _RECENT_S}
        self._looks = {**recent, client: now}

    def are_waiting(self, since: float) -> bool:
        """Whether somebody looked just before a moment, and not again after it."""
        return any(since - _RECENT_S < at < since for at in self._looks.copy().values())

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
        match urlsplit(self.path).path:
            case "/":
                self._answer(HTTPStatus.OK, "text/html", live_page().encode())
            case "/state":
                self._answer(HTTPStatus.OK, "application/json", json.dumps(server.live()).encode())
                server.note_look(self.client_address)
            case _:
                self._answer(HTTPStatus.NOT_FOUND, "text/plain", b"there is the page, and /state")

    def do_POST(self) -> None:
        """Take a word of the operator."""
        if self._is_refused():
            return
        word = urlsplit(self.path).path.removeprefix("/")
        if word not in _WORDS:
            self._answer(HTTPStatus.NOT_FOUND, "text/plain", b"there are /stop, /pause and /resume")
            return
        cast("_Server", self.server).act(word)
        self._answer(HTTPStatus.OK, "application/json", json.dumps({"taken": word}).encode())

    def _is_refused(self) -> bool:
        if cast("_Server", self.server).is_over:
            self.close_connection = True
            self._answer(HTTPStatus.SERVICE_UNAVAILABLE, "text/plain", b"the operation is over")
            return True
        address, port = self.request.getsockname()[:2]
        reason = Access(HOST).refusal(self.path, _Fields(self.headers, without=self._beside()), address, port)
        if reason:
            self._answer(HTTPStatus.FORBIDDEN, "text/plain", reason.encode())
        return bool(reason)

    def _beside(self) -> str:
        """Origin of another server's page on this machine that carries the token; empty for any other request."""
        origins, token = self.headers.get_all("Origin", []), cast("_Server", self.server).token
        if not token or len(origins) != 1 or not _BESIDE.fullmatch(origins[0].lower()):
            return ""
        stated = parse_qs(urlsplit(self.path).query).get("token", [""])
        return origins[0] if secrets.compare_digest(stated[-1].encode(errors="replace"), token.encode()) else ""

    def _answer(self, code: HTTPStatus, kind: str, content: bytes) -> None:
        self.send_response(code)
        for name, value in answer_headers(self.headers.get("Host", "")).items():
            self.send_header(name, value)
        if origin := self._beside():
            self.send_header("Access-Control-Allow-Origin", origin)
        self.send_header("Vary", "Origin")
        self.send_header("Content-Type", f"{kind}; charset=utf-8")
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, format: str, *args: Any) -> None:  # noqa: A002 - as in the base class
        """Requests are not logged: the terminal shows the operation."""


class _Fields:
    """Header fields of a request, by name in any case; of the values one may be left out."""

    def __init__(self, headers: Message, without: str) -> None:
        self._headers, self._without = headers, without

    def get_all(self, key: str) -> list[str]:
        """Values of all fields of that name."""
        return [value for value in self._headers.get_all(key, []) if not self._without or value != self._without]


@cache
def live_page() -> str:
    """HTML of the live view, with style and script in it; it takes ``/state`` ten times a second."""
    light, dark = (colour_variables(dark=each) for each in (False, True))
    variables = f":root{{{light}--wb-brand:{to_hex(ACCENT)};color-scheme:light dark}}"
    variables += f"@media (prefers-color-scheme: dark){{:root{{{dark}}}}}"
    page = (Path(__file__).parent / "live.html").read_text("utf-8").replace("/* colours */", variables)
    return page.replace("/* script */", live_script())


def live_data(shown: Snapshot, job: Job) -> dict[str, Json]:
    """Give state, node, joints, conditions, quantities, valves and tool, and how old they are, ms."""
    return {
        "state": shown.state,
        "reason": shown.reason,
        "node": shown.node.number if shown.node is not None else 0,
        "nodes": len(job.nodes),
        "joints": {name: round(value, 3) for name, value in zip(job.joints, shown.joints, strict=False)},
        "conditions": dict(shown.conditions),
        "quantities": {key: round(value, 4) for key, value in shown.quantities.items()},
        "jets": list(shown.jets),
        "tool": job.tool_at(shown.node.number if shown.node is not None else 0),
        "seconds": round(shown.seconds, 3),
        "age_ms": round(min(1e3 * shown.age_s, 1e9), 1),
    }
