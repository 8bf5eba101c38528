"""The live view of an operation, and how pages find the operations that run."""

import json
import os
import re
import secrets
import sys
import threading
import time
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, fields
from functools import cache
from http import HTTPStatus
from http.client import HTTPConnection, HTTPException
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, cast
from urllib.parse import parse_qs, urlsplit

from robotcell.operate.drive import Snapshot
from robotcell.operate.nodes import Job
from specs.errors import JobError
from specs.input_file import InputFile, own_text
from specs.json import Json
from specs.output_file import OutputError, OutputFile, OutputFolder
from webui.access.access import Access, access_for, answer_headers, new_token, script_sources, split_path, with_token
from webui.theme.page_head import live_script
from webui.theme.palette import ACCENT, colour_variables, to_hex

FOLDER = Path(".washboard") / "live"
"""In the project folder; one file for each operation."""
_ADDRESS = re.compile(r"http://127\.0\.0\.1:([0-9]{1,5})")
_PLAIN = re.compile(r"[A-Za-z0-9_-]{1,100}")
_NAME = re.compile(r"([0-9]{1,5})-([0-9]{1,9})\.json")
"""Port and process."""
_LARGEST_FILE, _LARGEST_STATE = 4_000, 200_000
"""Bytes."""
_MOST = 20
_BRIEF_S = 0.2
"""Patience with each: whoever looks for operations keeps a page waiting meanwhile."""
_LAST_PORT = 65535


@dataclass(frozen=True, slots=True)
class Running:
    """An operation whose process serves its live view."""

    address: str
    """``http://127.0.0.1:PORT``."""
    token: str
    """Secret that requests carry."""
    program: str
    """Name of its file."""
    cell: str
    """Name of the cell."""
    cell_sha256: str
    """Of the cell's content."""

    @property
    def port(self) -> int:
        """Port of this machine."""
        return int(self.address.rpartition(":")[2])

    @property
    def described(self) -> str:
        """Program, cell and port, for people."""
        return f"{self.program} in {self.cell}, port {self.port}"


@contextmanager
def announced(folder: Path, running: Running) -> Generator[None]:
    """Let pages whose project folder it is find an operation, until it is over.

    Raises:
        OutputError: the file cannot be written.
    """
    OutputFolder(folder / FOLDER).make(private=True)  # the token is for pages of this user
    file = OutputFile(folder / FOLDER / f"{running.port}-{os.getpid()}.json")
    file.write(json.dumps(asdict(running)))
    try:
        yield
    finally:
        with suppress(OutputError):
            file.remove()


def running_in(folder: Path) -> list[Running]:
    """Operations that were begun in a folder and answer now, by their port; files that are none are left out.

    A process that was killed leaves its file: it has ended, and nothing is sent to whoever has its port now.
    """
    try:
        files = sorted(each for each in (folder / FOLDER).glob("*.json") if each.is_file() and not each.is_symlink())
    except OSError:
        return []
    found = [running for file in files[:_MOST] if (running := _read(file)) is not None]
    return [running for running in found if look(running, _BRIEF_S) is not None]


def look(running: Running, patience_s: float = 0.5) -> Mapping[str, Json] | None:
    """Give the state of an operation of this machine; ``None`` where it does not answer."""
    connection = HTTPConnection(HOST, running.port, timeout=patience_s)
    try:
        return look_over(connection, running.token)
    finally:
        connection.close()


def look_over(connection: HTTPConnection, token: str) -> Mapping[str, Json] | None:
    """Give the state over a connection that is kept; ``None`` where none answers, and it is closed then."""
    try:
        connection.request("GET", f"/state?token={token}")
        answer = connection.getresponse()
        content = answer.read(_LARGEST_STATE)
        state = json.loads(content) if answer.status == 200 else None
    except (OSError, HTTPException, ValueError, RecursionError):
        state = None
    if not isinstance(state, dict):
        connection.close()
        return None
    return cast("Mapping[str, Json]", state)


def _read(file: Path) -> Running | None:
    """Read a file; ``None`` where it is not what ``announced`` writes, or a process of this user that lives."""
    name = _NAME.fullmatch(file.name)
    if name is None or not _lives(int(name[2])):
        return None
    try:
        stated = json.loads(InputFile(file).head(_LARGEST_FILE))
    except (ValueError, RecursionError, JobError):
        return None
    names = [each.name for each in fields(Running)]
    if not isinstance(stated, dict) or set(cast("dict[str, object]", stated)) != {*names}:
        return None
    values = [cast("dict[str, object]", stated)[name] for name in names]
    if not all(isinstance(value, str) and value.isprintable() for value in values):
        return None
    running = Running(*cast("list[str]", values))
    address = _ADDRESS.fullmatch(running.address)
    is_own = address is not None and address[1] == name[1] and 0 < int(address[1]) <= _LAST_PORT
    is_own = is_own and _PLAIN.fullmatch(running.token) is not None
    return running if is_own else None


def _lives(process: int) -> bool:
    """Whether there is a process of this user with a number."""
    try:
        os.kill(process, 0)
    except (OSError, OverflowError):
        return False
    return True


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
        self,
        live: Callable[[], Mapping[str, Json]],
        act: Callable[[str], None],
        port: int = 0,
        *,
        needs_token: bool = True,
    ) -> None:
        """Begin to serve, with a token that is new.

        Args:
            live: Gives the operation as it is now, as in ``live_data``; called in the thread of a request.
            act: Takes ``stop``, ``pause`` or ``resume``; called in the thread of a request.
            port: 0 takes any.
            needs_token: Whether its own page needs the token too; pages of other servers on this machine always do.

        Raises:
            JobError: the port is in use, or not allowed.
        """
        try:
            self._server = _Server(live, act, port, access_for(HOST, needs_token=needs_token))
        except OSError as error:
            raise JobError(f"the live view cannot be served at port {port} ({error.strerror}): name another.") from None
        threading.Thread(target=self._server.serve_forever, args=(0.05,), name="live view", daemon=True).start()

    @property
    def address(self) -> str:
        """``http://127.0.0.1:PORT``."""
        return f"http://{HOST}:{self._server.server_port}"

    @property
    def token(self) -> str:
        """Secret that requests carry."""
        return self._server.token

    @property
    def entrance(self) -> str:
        """URL for a browser on this machine, with the token if its page needs it."""
        return with_token(self.address, self._server.access.token)

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
        self, live: Callable[[], Mapping[str, Json]], act: Callable[[str], None], port: int, access: Access
    ) -> None:
        self.live, self.act, self.access = live, act, access
        self.token = access.token or new_token()
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
        beside = self._beside()

        def values(key: str) -> list[str]:
            return [value for value in self.headers.get_all(key, []) if not beside or value != beside]

        reply = cast("_Server", self.server).access.reply(self.path, values, address, port)
        if reply is not None:
            self._answer(reply.status, "text/plain", reply.text.encode(), reply.fields)
        return reply is not None

    def _beside(self) -> str:
        """Origin of another server's page on this machine that carries the token; empty for any other request."""
        origins, token = self.headers.get_all("Origin", []), cast("_Server", self.server).token
        if len(origins) != 1 or not _BESIDE.fullmatch(origins[0].lower()):
            return ""
        split = split_path(self.path)
        stated = parse_qs("" if split is None else split.query).get("token", [""])
        return origins[0] if secrets.compare_digest(stated[-1].encode(errors="replace"), token.encode()) else ""

    def _answer(self, code: HTTPStatus, kind: str, content: bytes, more: Mapping[str, str] | None = None) -> None:
        self.send_response(code)
        # A content is not read: the connection ends, or it would be taken for the next request, of whatever origin.
        has_content = any(each.strip() != "0" for each in self.headers.get_all("Content-Length", []))
        if code >= HTTPStatus.BAD_REQUEST or has_content or "Transfer-Encoding" in self.headers:
            self.send_header("Connection", "close")
        headers = answer_headers(self.headers.get("Host", ""), script_sources(live_page()))
        for name, value in {**headers, **(more or {})}.items():
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


@cache
def live_page() -> str:
    """HTML of the live view, with style and script in it; it takes ``/state`` ten times a second."""
    light, dark = (colour_variables(dark=each) for each in (False, True))
    variables = f":root{{{light}--wb-brand:{to_hex(ACCENT)};color-scheme:light dark}}"
    variables += f"@media (prefers-color-scheme: dark){{:root{{{dark}}}}}"
    page = own_text("webui.live", "live.html").replace("/* colours */", variables)
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
