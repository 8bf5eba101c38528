"""The way into viser: what it relies on, and what clients may send."""

import inspect
import resource
import time
from types import SimpleNamespace

import pytest
import viser
import websockets
import websockets.asyncio.server
from bare_client import BarePage, bare_link, bare_page
from viser import _gui_api, _messages
from viser.infra import _infra
from waiting import WAIT_S
from websockets.exceptions import ConnectionClosed

from boards.load import board_library
from webui.access import viser_guard
from webui.access.access import Access
from webui.access.viser_guard import ViserDiffersError, start_guarded
from webui.page.project import open_project
from webui.server.server import open_session, serve

PART = 512 * 1024


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("project")


@pytest.fixture(scope="module")
def server(folder):
    server = serve(open_session("tiny", "rinse-only"), open_project(folder), "127.0.0.1", 0)
    yield server
    server.stop()


@pytest.fixture(scope="module")
def page(server):
    with bare_page(server) as page:
        page.find("Import CAD")
        yield page


def peak_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def test_viser_is_built_as_the_guard_needs_it() -> None:
    changed = "viser changed: adapt webui/access/viser_guard.py, then this test"
    source = inspect.getsource(_infra.WebsockServer)
    assert source.count("websockets.asyncio.server.serve(") == 1, f"{changed} (it starts its server in another way)"
    assert "process_request=" in source, f"{changed} (it answers requests in another way)"
    options = inspect.signature(websockets.asyncio.server.serve).parameters
    needed = {"process_request", "process_response", "max_size", "max_queue", "server_header", "logger"}
    assert needed <= set(options), f"websockets changed: it has no {needed - set(options)} (see viser_guard.py)"
    for name in ("_handle_file_transfer_start", "_handle_file_transfer_part"):
        assert hasattr(_gui_api.GuiApi, name), f"{changed} (uploads: {name})"
    fields = {
        "FileTransferStartUpload": {"source_component_uuid", "transfer_uuid", "filename", "part_count", "size_bytes"},
        "FileTransferPart": {"source_component_uuid", "transfer_uuid", "part_index", "content"},
    }
    for name, known in fields.items():
        assert known <= set(getattr(_messages, name).__annotations__), f"{changed} (fields of {name})"
    handlers = inspect.getsource(viser.ViserServer.__init__)
    assert "ShareUrlRequest" in handlers, f"{changed} (requests for a public tunnel)"


def test_another_viser_is_refused_in_words(monkeypatch) -> None:
    own = SimpleNamespace(**vars(websockets))  # found elsewhere than where the guard replaces it
    own.asyncio = SimpleNamespace(server=SimpleNamespace(**vars(websockets.asyncio.server)))
    monkeypatch.setattr(_infra, "websockets", own)
    with pytest.raises(ViserDiffersError, match=r"viser .* cannot be guarded: .*websockets.*pip install"):
        start_guarded(Access("127.0.0.1"), "127.0.0.1", 0)


def test_nobody_can_request_a_public_tunnel(server) -> None:
    for kind in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
        assert kind not in server.viser._websock_server._incoming_handlers


@pytest.mark.slow
@pytest.mark.parametrize(("size", "parts"), [(10**12, 2_000_000), (2**62, 2**40), (10**9, 1)])
def test_a_client_that_announces_too_much_is_refused_at_once(page: BarePage, size: int, parts: int) -> None:
    before = peak_mb()
    page.upload("Import CAD", "big.step", size, parts)
    assert "MB are too many to upload" in page.next_note()
    for index in range(40):
        page.part("Import CAD", index, b"x" * PART)
    assert_alive(page)
    assert peak_mb() - before < 15
    assert page.notes == []


@pytest.mark.slow
def test_more_than_was_announced_is_dropped_while_it_arrives(page: BarePage) -> None:
    page.upload("Import CAD", "small.step", 1000, 1)
    page.part("Import CAD", 0, b"x" * 1001)
    assert "more than the announced 1,000 bytes" in page.next_note()
    page.upload("Import CAD", "parts.step", 1000, 1, "u")
    page.part("Import CAD", 1, b"x", "u")
    assert "more than the announced" in page.next_note()
    assert_alive(page)


@pytest.mark.slow
def test_many_uploads_at_once_get_few_notifications(server) -> None:
    before = peak_mb()
    with bare_page(server) as page:
        for number in range(2000):
            page.upload("Import CAD", "a.step", 100_000_000, 200, f"t{number}")
        assert "4 uploads are under way" in page.next_note()
        assert_alive(page)
        assert peak_mb() - before < 15
        assert len(page.notes) < 100


@pytest.mark.slow
def test_names_and_identifiers_that_are_none_are_dropped(page: BarePage) -> None:
    uuid = page.find("Import CAD")
    good = {"source_component_uuid": uuid, "mime_type": "", "part_count": 1, "size_bytes": 1, "filename": "a.tri"}
    for transfer in (None, 5, [], {}):
        page.send(type="FileTransferStartUpload", transfer_uuid=transfer, **good)
        page.send(
            type="FileTransferPart", source_component_uuid=uuid, transfer_uuid=transfer, part_index=0, content=b""
        )
    page.send(type="FileTransferStartUpload", transfer_uuid="t", **{**good, "filename": 5})
    assert "without a name" in page.next_note()
    assert_alive(page)


@pytest.mark.slow
def test_a_good_upload_is_kept(page: BarePage, folder) -> None:
    content = board_library()["tiny"].read_bytes()
    page.upload("Import CAD", "mine.tri", len(content), 1)
    page.part("Import CAD", 0, content)
    page.wait_for(lambda: (folder / "mine.tri").exists(), "the file")
    assert_alive(page)


@pytest.mark.slow
def test_uploads_of_a_page_that_was_closed_are_forgotten(server) -> None:
    for _ in range(2):
        with bare_page(server) as page:
            for number in range(4):
                page.upload("Import CAD", "a.step", 100_000_000, 200, f"t{number}")
                page.part("Import CAD", 0, b"x" * PART, f"t{number}")
            assert_alive(page)
            assert page.notes == []


NO_MESSAGES = {
    "empty": b"",
    "no MessagePack": b"\xc1",
    "no type": b"\x80",
    "unknown": b"\x81\xa4type\xa7Nothing",
    "a list": b"\x93\x01\x02\x03",
    "text": "text",
    "deep": b"\x91" * 100_000,
    "too long": b"\x00" * 9_000_000,
}


@pytest.mark.parametrize("raw", NO_MESSAGES.values(), ids=NO_MESSAGES)
def test_what_is_no_message_closes_its_connection_alone(server, page: BarePage, capfd, raw) -> None:
    with bare_link(server) as other:
        other.send(raw)
        assert closing_code(other) in (1007, 1009)
    assert_alive(page)
    assert "Traceback" not in capfd.readouterr().err


def test_one_address_has_at_most_so_many_connections(server, page: BarePage, monkeypatch) -> None:
    monkeypatch.setattr(viser_guard, "_MOST_CONNECTIONS", 2)
    with bare_link(server):
        with bare_link(server) as third:
            assert closing_code(third) == 1013
        assert_alive(page)
    end = time.monotonic() + WAIT_S
    while time.monotonic() < end:  # a connection counts until it is torn down
        with bare_link(server) as again:
            try:
                again.recv(timeout=0.5)
            except TimeoutError:
                return
            except ConnectionClosed:
                continue
            return
    pytest.fail("closed connections still count")


def closing_code(link) -> int:
    """Code with which the server closes a connection."""
    while True:
        try:
            link.recv(timeout=WAIT_S)
        except ConnectionClosed as closed:
            return closed.rcvd.code


def assert_alive(page: BarePage) -> None:
    """The page still answers: a name that cannot be is refused."""
    page.notes.clear()
    page.insist(
        lambda: page.set("Workpiece", "../0.tri"),
        lambda: any("outside the project folder" in note for note in page.notes),
        "an answer",
    )
    page.notes.clear()
