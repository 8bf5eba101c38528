"""A client that is no browser: raw requests and handshakes, and the messages of the page without its scripts."""

import base64
import json
import os
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager

import msgspec.msgpack
import pytest
import viser
import zstandard
from waiting import WAIT_S
from websockets.sync.client import ClientConnection, connect

AGAIN_S = 4.0
NOBODY = 65534
only_root = pytest.mark.skipif(os.geteuid() != 0, reason="only root can become another user of the machine")
HANDSHAKE = (
    "Upgrade: websocket",
    "Connection: Upgrade",
    f"Sec-WebSocket-Key: {base64.b64encode(b'0123456789abcdef').decode()}",
    "Sec-WebSocket-Version: 13",
    f"Sec-WebSocket-Protocol: viser-v{viser.__version__}",
)


def answer(port, *fields, path="/", host="127.0.0.1", method="GET"):
    """Status, header fields (lower case) and body of the answer to a request with these header fields."""
    with socket.create_connection((host, port), timeout=WAIT_S) as link:
        link.sendall("\r\n".join([f"{method} {path} HTTP/1.1", *fields, "", ""]).encode("latin-1"))
        received = b""
        while b"\r\n\r\n" not in received:
            more = link.recv(65536)
            if not more:
                break
            received += more
        head, _, body = received.partition(b"\r\n\r\n")
        status, *lines = head.decode("latin-1").split("\r\n")
        headers = {name.lower(): value.strip() for name, _, value in (line.partition(":") for line in lines)}
        length = int(headers.get("content-length", "0"))
        while len(body) < length:
            body += link.recv(65536)
    return (int(status.split()[1]) if status else 0), headers, body


def handshake(port, *fields, path="/", host="127.0.0.1"):
    """Status of the answer to a websocket handshake with these header fields."""
    return answer(port, *HANDSHAKE, *fields, path=path, host=host)[0]


def as_another_user(action):
    """Result of a function, as JSON keeps it, in a process of another user of this machine."""
    content = os.memfd_create("result")
    child = os.fork()
    if child == 0:
        try:
            os.setgroups([])
            os.setgid(NOBODY)
            os.setuid(NOBODY)
            os.write(content, json.dumps([os.geteuid(), action()]).encode())
        finally:
            os._exit(0)
    os.waitpid(child, 0)
    user, result = json.loads(os.pread(content, 1 << 20, 0))
    os.close(content)
    assert user == NOBODY
    return result


class BarePage:
    """A page as its messages: inputs by label, notifications, downloads."""

    def __init__(self, link: ClientConnection, browser: str = "bare") -> None:
        self.link, self.browser = link, browser
        self.inputs: dict[str, dict] = {}
        self.notes: list[str] = []
        self.texts: list[str] = []
        """Contents of HTML elements as they were shown, with their tags."""
        self.send(
            type="ViewerCameraMessage", wxyz=[1, 0, 0, 0], position=[0, 0, 1], image_height=9, image_width=9, fov=0.8,
            near=0.01, far=100.0, look_at=[0, 0, 0], up_direction=[0, 1, 0],
        )  # fmt: skip

    def send(self, **message) -> None:
        self.link.send(msgspec.msgpack.encode(message))

    def receive(self, timeout_s=WAIT_S) -> list[dict]:
        """Next messages of the server; none where there are none in that time."""
        try:
            raw = self.link.recv(timeout=timeout_s)
        except TimeoutError:
            return []
        packed = int.from_bytes(raw[8:16], "little")
        messages = msgspec.msgpack.decode(zstandard.ZstdDecompressor().decompress(raw[16 : 16 + packed]))["messages"]
        for message in messages:
            self._take(message)
        return messages

    def wait_for(self, found, what="it", timeout_s=WAIT_S):
        """Receive until a function returns something."""
        end = time.monotonic() + timeout_s
        while not (result := found()):
            assert time.monotonic() < end, f"waited for {what}; notifications: {self.notes}"
            self.receive(0.2)
        return result

    def insist(self, act, found, what="it"):
        """Do something every few seconds until a function returns something: a panel drawn anew has new inputs."""
        end = time.monotonic() + WAIT_S
        while True:
            act()
            again = min(time.monotonic() + AGAIN_S, end)
            while not (result := found()) and time.monotonic() < again:
                self.receive(0.2)
            if result:
                return result
            assert time.monotonic() < end, f"waited for {what}; notifications: {self.notes}"

    def find(self, label, kind=""):
        """Identifier of the newest input of a label, of a kind of message if one is given."""

        def newest():
            found = [uuid for uuid, each in self.inputs.items() if each["props"]["label"] == label]
            return [uuid for uuid in found if kind in self.inputs[uuid]["type"]]

        return self.wait_for(newest, f"the input {label!r}")[-1]

    def set(self, label, value, kind="") -> None:
        """Write a value, or press a button."""
        self.send(type="GuiUpdateMessage", uuid=self.find(label, kind), updates={"value": value})

    def submit(self, label, value, button) -> None:
        """Write the value of a dialog's input and press its button; wait until the dialog is there first."""
        for kind in ("TextMessage", "Dropdown"):
            if any(kind in each["type"] and each["props"]["label"] == label for each in self.inputs.values()):
                self.set(label, value, kind)
                break
        self.set(button, True, "GuiButtonMessage")

    def next_note(self, timeout_s=WAIT_S):
        """Wait for the next notification."""
        self.wait_for(lambda: self.notes, "a notification", timeout_s)
        return self.notes.pop(0)

    def upload(self, label, name, size, parts, transfer="t") -> None:
        """Announce an upload."""
        self.send(
            type="FileTransferStartUpload", source_component_uuid=self.find(label), transfer_uuid=transfer,
            filename=name, mime_type="", part_count=parts, size_bytes=size,
        )  # fmt: skip

    def part(self, label, index, content, transfer="t") -> None:
        self.send(
            type="FileTransferPart", source_component_uuid=self.find(label), transfer_uuid=transfer, part_index=index,
            content=content,
        )  # fmt: skip

    def _take(self, message) -> None:
        props = message.get("props") or {}
        kind, uuid = message["type"], message.get("uuid", "")
        if kind == "NotificationShowMessage":
            self.notes.append(f"{props['title']}: {props['body']}")
        if isinstance(props.get("label"), str):
            self.inputs[uuid] = message
        if kind == "GuiRemoveMessage":
            self.inputs.pop(uuid, None)
        updates = message.get("updates") or {}
        if "label" in updates and uuid in self.inputs:
            self.inputs[uuid]["props"]["label"] = updates["label"]
        for found in (props, updates):
            if isinstance(found.get("content"), str):
                self.texts.append(found["content"])
        if kind == "LocalStorageGetItemRequestMessage":
            answered = {"request_uuid": message["request_uuid"], "value": self.browser, "error": None}
            self.send(type="LocalStorageGetItemResponseMessage", **answered)


def cookie_of(server) -> str:
    """Header field with which a browser that was at the entrance of a server comes back."""
    return f"Cookie: washboard-{server.port}={server.token}"


def bare_link(server) -> ClientConnection:
    """Open a connection to a server as its page does, but with the token in the address."""
    return connect(
        f"ws://127.0.0.1:{server.port}/?token={server.token}", origin=f"http://127.0.0.1:{server.port}",
        compression=None, max_size=None, subprotocols=[f"viser-v{viser.__version__}"],
    )  # fmt: skip


@contextmanager
def bare_page(server, browser: str = "bare") -> Iterator[BarePage]:
    """Open a page of a server, and wait until it shows its plan."""
    with bare_link(server) as link:
        page = BarePage(link, browser)
        page.wait_for(lambda: any("Planned" in text for text in page.texts), "the plan")
        yield page
