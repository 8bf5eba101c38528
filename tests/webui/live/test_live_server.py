"""The live view of an operation: what it gives, whom it answers, and a stop while all else hangs."""

import asyncio
import json
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from http.client import HTTPConnection

import pytest
from bare_client import as_another_user, only_root
from small_page import small_page
from tiny_session import tiny_session
from waiting import WAIT_S

from specs.errors import JobError
from webui.live.live import LiveServer

STATE = {"state": "running", "node": 7}


@contextmanager
def served(live=lambda: STATE, *, needs_token=False) -> Iterator[tuple[LiveServer, list[str]]]:
    words: list[str] = []
    server = LiveServer(live, words.append, needs_token=needs_token)
    try:
        yield server, words
    finally:
        server.close()


def ask(server: LiveServer, method: str, path: str, **headers: str) -> tuple[int, bytes]:
    connection = HTTPConnection(server.address.removeprefix("http://"), timeout=WAIT_S)
    try:
        connection.request(method, path, headers=headers)
        answer = connection.getresponse()
        return answer.status, answer.read()
    finally:
        connection.close()


def test_the_page_the_state_and_the_words_of_the_operator() -> None:
    with served() as (server, words):
        code, page = ask(server, "GET", "/")
        assert code == 200
        assert b"STOP" in page
        assert b"--wb-ink" in page
        code, state = ask(server, "GET", "/state")
        assert (code, json.loads(state)) == (200, STATE)
        for word in ("pause", "resume", "stop"):
            assert ask(server, "POST", f"/{word}")[0] == 200
        assert words == ["pause", "resume", "stop"]
        assert ask(server, "POST", "/go")[0] == ask(server, "GET", "/etc")[0] == 404


def test_what_is_no_address_is_refused_without_a_word_on_the_terminal(capfd: pytest.CaptureFixture[str]) -> None:
    for needs_token in (False, True):
        with served(needs_token=needs_token) as (server, words):
            host = server.address.removeprefix("http://").partition("/")[0]
            for request in ("GET http://[", "GET http://[/state", "POST http://[stop"):
                with socket.create_connection(("127.0.0.1", int(host.rpartition(":")[2])), WAIT_S) as asking:
                    asking.sendall(f"{request} HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\n\r\n".encode())
                    assert b" 400 " in asking.recv(100)
            assert words == []
    assert capfd.readouterr().err == ""


def test_pages_of_other_origins_and_other_names_are_refused() -> None:
    with served() as (server, words):
        own = server.address.removeprefix("http://")
        for headers in ({"Origin": "http://evil.example"}, {"Host": "evil.example"}, {"Origin": "null"}):
            assert ask(server, "POST", "/stop", **headers)[0] == 403
            assert ask(server, "GET", "/state", **headers)[0] == 403
        assert words == []
        assert ask(server, "POST", "/stop", Origin=f"http://{own}")[0] == 200


@pytest.mark.parametrize(
    "ends", ["Content-Length: {}", "Content-Length: 0\r\nContent-Length: {}", "Transfer-Encoding: chunked"]
)
@pytest.mark.parametrize("origin", ["https://evil.example", "http://{}"])
def test_the_content_of_a_request_is_no_request(origin: str, ends: str) -> None:
    """A page of another origin may send any content; as a request it would bear no origin."""
    with served() as (server, words):
        own = server.address.removeprefix("http://")
        inner = f"POST /stop HTTP/1.1\r\nHost: {own}\r\n\r\n"
        head = (
            f"POST /pause HTTP/1.1\r\nHost: {own}\r\nOrigin: {origin.format(own)}\r\n{ends.format(len(inner))}\r\n\r\n"
        )
        with socket.create_connection(("127.0.0.1", int(own.rpartition(":")[2])), WAIT_S) as asking:
            asking.sendall(f"{head}{inner}".encode())
            with suppress(ConnectionResetError):  # what was not read is thrown away with the connection
                while asking.recv(1000):
                    pass
        assert words == (["pause"] if "{}" in origin else [])


def test_without_the_token_nobody_is_answered() -> None:
    with served(needs_token=True) as (server, words):
        own, port = server.address, server.address.rpartition(":")[2]
        cookie, wrong = (f"washboard-{port}={token}" for token in (server.token, server.token[:-1]))
        for headers in ({}, {"Origin": own}, {"Cookie": wrong}, {"Cookie": cookie.replace("-", "-1")}):
            for method, path in (("GET", "/"), ("GET", "/state"), ("POST", "/stop"), ("POST", "/stop?token=x")):
                status, text = ask(server, method, path, **headers)
                assert (status, b"open the address that was printed" in text) == (403, True)
        assert words == []
        assert ask(server, "GET", server.entrance.removeprefix(own))[0] == 303
        assert b"STOP" in ask(server, "GET", "/", Cookie=cookie)[1]
        assert json.loads(ask(server, "GET", "/state", Cookie=cookie)[1]) == STATE
        assert json.loads(ask(server, "GET", f"/state?token={server.token}")[1]) == STATE
        assert ask(server, "POST", "/stop", Cookie=cookie, Origin=own)[0] == 200
        assert ask(server, "POST", "/stop", Cookie=cookie, Origin="http://evil.example")[0] == 403
        assert words == ["stop"]


@only_root
def test_another_user_of_this_machine_needs_the_printed_address() -> None:
    with served(needs_token=True) as (server, words):
        entrance = server.entrance.removeprefix(server.address)
        cookie = f"washboard-{server.address.rpartition(':')[2]}={server.token}"
        requests = ("GET", "/"), ("GET", "/state"), ("POST", "/stop"), ("POST", "/stop?token=x")

        def refused() -> list[int]:
            foreign = ({"Origin": "http://evil.example"}, {"Host": "evil.example"})
            return [
                *(ask(server, *each)[0] for each in requests),
                *(ask(server, "POST", f"/stop?token={server.token}", **fields)[0] for fields in foreign),
            ]

        assert as_another_user(refused) == [403] * 6
        assert words == []
        assert as_another_user(lambda: ask(server, "GET", entrance)[0]) == 303
        assert as_another_user(lambda: ask(server, "POST", "/stop", Cookie=cookie)[0]) == 200
        assert words == ["stop"]


@pytest.mark.parametrize("needs_token", [True, False])
def test_a_page_of_another_server_of_this_machine_needs_the_token(needs_token: bool) -> None:
    beside = ("http://127.0.0.1:8080", "http://localhost:8080", "http://[::1]:9")
    with served(needs_token=needs_token) as (server, words):
        secret = server.token
        for origin in beside:
            for path in ("/stop", "/stop?token=", f"/stop?token={secret[:-1]}", f"/stop?token={secret}&token=other"):
                assert ask(server, "POST", path, Origin=origin)[0] == 403
        for origin in (
            "http://evil.example",
            "https://127.0.0.1:8080",
            "http://127.0.0.1",
            "null",
            "http://127.0.0.1:80@e",
        ):
            assert ask(server, "POST", f"/stop?token={secret}", Origin=origin)[0] == 403
        assert ask(server, "POST", f"/stop?token={secret}", Origin=beside[0], Host="evil.example")[0] == 403
        assert words == []
        for origin in beside:
            assert ask(server, "POST", f"/stop?token={secret}", Origin=origin)[0] == 200
            assert json.loads(ask(server, "GET", f"/state?token={secret}", Origin=origin)[1]) == STATE
        assert words == ["stop"] * 3


def test_the_answer_names_the_page_that_may_read_it_and_no_other() -> None:
    with served() as (server, _):
        for token, allowed in ((server.token, "http://127.0.0.1:8080"), ("wrong", None)):
            connection = HTTPConnection(server.address.removeprefix("http://"), timeout=WAIT_S)
            connection.request("GET", f"/state?token={token}", headers={"Origin": "http://127.0.0.1:8080"})
            answer = connection.getresponse()
            assert (answer.headers["Access-Control-Allow-Origin"], answer.headers["Vary"]) == (allowed, "Origin")
            connection.close()


def test_the_stop_is_taken_while_all_other_requests_hang() -> None:
    hangs, asked = threading.Event(), threading.Event()

    def live() -> dict[str, str]:
        asked.set()
        assert hangs.wait(WAIT_S)
        return {}

    with served(live) as (server, words):
        waiting = [threading.Thread(target=ask, args=(server, "GET", "/state")) for _ in range(8)]
        for each in waiting:
            each.start()
        half = socket.create_connection(("127.0.0.1", int(server.address.rpartition(":")[2])))
        half.sendall(b"POST /stop HTTP/1.1\r\nHost: ")  # it never ends
        assert asked.wait(WAIT_S)
        assert ask(server, "POST", "/stop")[0] == 200
        assert words == ["stop"]
        assert not hangs.is_set()
        assert all(each.is_alive() for each in waiting)
        hangs.set()
        for each in waiting:
            each.join()
        half.close()


def test_the_stop_is_taken_while_the_event_loop_of_the_page_hangs() -> None:
    hangs = threading.Event()
    with served() as (server, words), small_page(tiny_session()) as page:
        loop = page.client.gui._event_loop  # of the server that browsers are connected to
        loop.call_soon_threadsafe(hangs.wait, WAIT_S)
        later = asyncio.run_coroutine_threadsafe(asyncio.sleep(0), loop)
        try:
            assert ask(server, "POST", "/stop")[0] == 200
            assert words == ["stop"]
            assert not later.done()
        finally:
            hangs.set()
        later.result(WAIT_S)


def test_a_port_that_is_in_use_is_one_sentence() -> None:
    with served() as (server, _), pytest.raises(JobError, match=r"^the live view cannot be served at port \d+ \("):
        LiveServer(lambda: {}, print, int(server.address.rpartition(":")[2]))
