"""Our one way into viser: access control, limits and answer headers of the web server that it starts.

viser has no option for them. It starts its server with ``websockets.asyncio.server.serve``, whose public arguments do
all of it; for that one call the function is replaced. Uploads are counted by handlers around viser's own. What this
module relies on is checked where it is used, and refused in words where another version of viser differs.
"""

import gzip
import http
import logging
import math
import threading
import time
from collections import Counter, deque
from collections.abc import Awaitable, Callable, Generator
from contextlib import contextmanager
from typing import Any, TypeAlias

import viser
import websockets.asyncio.server
from viser._messages import (
    FileTransferPart,
    FileTransferPartAck,
    FileTransferStartUpload,
    RemoveNotificationMessage,
    ShareUrlDisconnect,
    ShareUrlRequest,
)
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from specs.errors import JobError
from webui.access.access import Access, UploadError, Uploads, answer_headers, script_sources

_LARGEST_MESSAGE = 8 * 1024 * 1024
"""Bytes; a file comes in parts of 512 KiB, and a recipe has at most 4 MB."""
_MOST_WAITING = 4
"""Messages of a connection that are read ahead."""
_MOST_CONNECTIONS = 32
"""From one address; a page has one, and a browser's are all of one address."""
_MOST_NOTIFIED = 10
"""Refused uploads that are reported in the page within a second."""
_LATE_PAGE_S = 1.0
"""After which a page that is busy has shown what it was about to."""
_TRY_LATER, _NOT_UNDERSTOOD = 1013, 1007
_HEAD = b"<head>"
_LOCK = threading.Lock()
_log = logging.getLogger(__name__)
_quiet = logging.getLogger(f"{__name__}.websockets")
"""What websockets logs of requests that are no HTTP, with a traceback each; anybody may send them."""
_quiet.addHandler(logging.NullHandler())
_quiet.propagate = False


class ViserDiffersError(JobError):
    """The installed viser is not built as the guard needs it; nothing is served."""

    def __init__(self, what: str) -> None:
        """Name what differs."""
        super().__init__(
            f"viser {viser.__version__} cannot be guarded: {what}. Install the version that Washboard names: "
            'pip install "viser>=1.1.1,<1.2".'
        )


def start_guarded(access: Access, host: str, port: int, head: str = "") -> viser.ViserServer:
    """Start viser's server so that every request and every handshake passes the access control first.

    Args:
        access: Whose requests are answered.
        host: Where it listens.
        port: The same.
        head: HTML that is added to the head of the page.

    Raises:
        ViserDiffersError: viser does not start its server as expected.
    """
    with _guarding(access, head) as started:
        server = viser.ViserServer(host=host, port=port, label="Washboard", verbose=False)
    if not started:
        server.stop()
        raise ViserDiffersError("it does not start its web server with websockets.asyncio.server.serve")
    try:
        for kind in (ShareUrlRequest, ShareUrlDisconnect):  # a tunnel to viser's makers, on request of any client
            server._websock_server.unregister_handler(kind)  # pyright: ignore[reportPrivateUsage]
    except (AttributeError, AssertionError):
        server.stop()
        raise ViserDiffersError("requests for a public tunnel cannot be turned off") from None
    return server


@contextmanager
def _guarding(access: Access, head: str) -> Generator[list[int]]:
    """Replace the function with which viser starts its server; the list has an item for each start."""
    started: list[int] = []
    page = _Page(head)
    original = websockets.asyncio.server.serve

    def serve(handler: Callable[[ServerConnection], Awaitable[None]], host: str, port: int, **options: Any) -> Any:
        started.append(port)
        own: dict[str, Any] = {
            "process_request": _checked(access, page.extended(options.get("process_request"))),
            "process_response": page.add_headers,
            "max_size": _LARGEST_MESSAGE,
            "max_queue": _MOST_WAITING,
            "server_header": None,
            "logger": _quiet,
        }
        return original(_limited(handler), host, port, **{**options, **own})

    with _LOCK:
        websockets.asyncio.server.serve = serve
        try:
            yield started
        finally:
            websockets.asyncio.server.serve = original


_Answer: TypeAlias = Callable[[ServerConnection, Request], Response | None]


class _Page:
    """The page that viser answers, with more in its head; its scripts are those that run."""

    def __init__(self, head: str) -> None:
        self._head = head
        self._made: dict[bytes, bytes] = {}
        self._scripts = ""

    def extended(self, answer: _Answer | None) -> _Answer | None:
        """Add HTML to the head of the page that is answered, before all that stands there."""
        if answer is None or not self._head:
            return answer

        def process(connection: ServerConnection, request: Request) -> Response | None:
            response = answer(connection, request)
            if response is None or not response.headers.get("Content-Type", "").startswith("text/html"):
                return response
            body = bytes(response.body)  # the same object each time
            if body not in self._made:
                self._made[body] = self._extend(body, packed=response.headers.get("Content-Encoding") == "gzip")
            response.body = self._made[body]
            del response.headers["Content-Length"]
            response.headers["Content-Length"] = str(len(response.body))
            return response

        return process

    def _extend(self, body: bytes, *, packed: bool) -> bytes:
        page = gzip.decompress(body) if packed else body
        begin, found, rest = page.partition(_HEAD)
        if not found:
            _log.error("viser %s has another page than expected: it does not start", viser.__version__)
            return body
        page = begin + found + self._head.encode() + rest
        self._scripts = script_sources(page.decode())
        return gzip.compress(page, mtime=0) if packed else page

    def add_headers(self, _: ServerConnection, request: Request, response: Response) -> None:
        """Add the header fields of every answer."""
        refused = response.status_code == http.HTTPStatus.FORBIDDEN
        host, scripts = ("", "") if refused else (request.headers["Host"], self._scripts)
        for name, value in answer_headers(host, scripts).items():
            response.headers[name] = value


def _checked(access: Access, answer: _Answer | None) -> Any:
    """Check requests before they are answered."""

    def process(connection: ServerConnection, request: Request) -> Response | None:
        address, port = connection.local_address[:2]
        reply = access.reply(request.path, request.headers.get_all, address, port)
        if reply is None:
            return None if answer is None else answer(connection, request)
        body = reply.text.encode()
        fields = {"Content-Type": "text/plain; charset=utf-8", "Content-Length": str(len(body)), **reply.fields}
        return Response(reply.status, reply.status.phrase, Headers(fields), body)

    return process


def _limited(handler: Callable[[ServerConnection], Awaitable[None]]) -> Callable[[ServerConnection], Awaitable[None]]:
    """Limit the connections from one address, and close one that sends what is no message."""
    counts: Counter[str] = Counter()

    async def handle(connection: ServerConnection) -> None:
        address = str(connection.remote_address[0])
        if counts[address] >= _MOST_CONNECTIONS:
            await connection.close(_TRY_LATER, f"{_MOST_CONNECTIONS} pages are open; close some of them")
            return
        counts[address] += 1
        try:
            await handler(connection)
        except Exception as error:  # viser decodes whatever it receives
            _log.warning("a connection from %s was closed: %s", address, type(error).__name__)
            await connection.close(_NOT_UNDERSTOOD, "not a message of the page")
        finally:
            counts[address] -= 1

    return handle


def limit_uploads(client: viser.ClientHandle, uploads: Uploads) -> None:
    """Count a client's uploads while they arrive; one that breaks a limit is dropped and reported in the page.

    Raises:
        ViserDiffersError: viser does not take uploads as expected.
    """
    try:
        gui = client.gui
        connection = gui._websock_interface  # pyright: ignore[reportPrivateUsage]
        start, take = gui._handle_file_transfer_start, gui._handle_file_transfer_part  # pyright: ignore[reportPrivateUsage]
        states = gui._current_file_upload_states  # pyright: ignore[reportPrivateUsage]
        connection.unregister_handler(FileTransferStartUpload, start)
        connection.unregister_handler(FileTransferPart, take)
    except (AttributeError, AssertionError, ValueError):
        raise ViserDiffersError("its uploads cannot be counted while they arrive") from None
    own, reported = client.client_id, deque([-math.inf] * _MOST_NOTIFIED, _MOST_NOTIFIED)

    def refuse(message: FileTransferStartUpload | FileTransferPart, error: UploadError) -> None:
        states.pop(message.transfer_uuid, None)
        uploads.keep(own, states)
        # Ends the progress in the page, whose button is disabled meanwhile. A busy page may show it only after it was
        # removed, and would then report success.
        gone = RemoveNotificationMessage(f"upload-{message.transfer_uuid}")
        connection.queue_message(gone)
        connection.queue_message(FileTransferPartAck(message.source_component_uuid, message.transfer_uuid, 1, 1))
        if (now := time.monotonic()) - reported[0] >= 1.0:
            reported.append(now)
            later = threading.Timer(_LATE_PAGE_S, connection.queue_message, [gone])
            later.daemon = True
            later.start()
            client.add_notification("Not done", str(error), color="red", auto_close_seconds=12.0)

    def begin(client_id: Any, message: FileTransferStartUpload) -> None:
        if not isinstance(message.transfer_uuid, str):  # pyright: ignore[reportUnnecessaryIsInstance]  # viser does not check
            return
        try:
            uploads.begin(own, message.transfer_uuid, message.filename, message.size_bytes, message.part_count)
        except UploadError as error:
            refuse(message, error)
            return
        start(client_id, message)
        uploads.keep(own, states)

    def receive(client_id: Any, message: FileTransferPart) -> None:
        if not isinstance(message.transfer_uuid, str) or message.transfer_uuid not in states:  # pyright: ignore[reportUnnecessaryIsInstance]
            return
        try:
            uploads.receive(own, message.transfer_uuid, message.part_index, message.content)
        except UploadError as error:
            refuse(message, error)
            return
        take(client_id, message)
        uploads.keep(own, states)

    connection.register_handler(FileTransferStartUpload, begin)
    connection.register_handler(FileTransferPart, receive)
