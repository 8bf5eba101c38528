"""Access control: as a function of header fields, and on the real server by a client that is no browser."""

import gzip
from base64 import b64encode
from hashlib import sha256

import pytest
from bare_client import answer, as_another_user, bare_page, cookie_of, handshake, only_root
from websockets.datastructures import Headers

from webui.access.access import (
    Access,
    AccessError,
    access_for,
    answer_headers,
    cookie_name,
    is_loopback,
    script_sources,
)
from webui.page.project import open_project
from webui.server.server import open_session, serve

PORT = 8080
LOOPBACK = Access("127.0.0.1")
OWN = ("127.0.0.1:8080", "localhost:8080", "[::1]:8080", "LOCALHOST:8080", "LocalHost:8080")
FOREIGN_HOSTS = (
    "evil.example", "evil.example:8080", "localhost.evil.example:8080", "127.0.0.1.evil.example:8080",
    "localhost.:8080", "127.0.0.1.:8080", "localhost", "127.0.0.1", "127.0.0.1:80", "localhost:8081", "127.0.0.1:08080",
    "[::1]", "::1:8080", "[::2]:8080", "[0:0:0:0:0:0:0:1]:8080", "[::ffff:127.0.0.1]:8080", "127.1:8080",
    "2130706433:8080", "0.0.0.0:8080", "192.168.1.5:8080", "", " ", "127.0.0.1:8080@evil.example",
    "evil.example#127.0.0.1:8080", "127.0.0.1:8080, evil.example", "127.0.0.1:8080/", "http://127.0.0.1:8080",
    "127.0.0.1:99999",
)  # fmt: skip
FOREIGN_ORIGINS = (
    "https://evil.example", "http://evil.example:8080", "null", "NULL", "", "http://127.0.0.1", "http://127.0.0.1:8081",
    "https://127.0.0.1:8080", "ws://127.0.0.1:8080", "http://localhost.evil.example:8080", "http://localhost.:8080",
    "http://127.0.0.1:8080.evil.example", "http://127.0.0.1:8080/", "http://127.0.0.1:8080@evil.example", "file://",
    "chrome-extension://abcdefgh", "http://localhost:8080", "http://[::1]:8080", "http://127.0.0.1:8080 http://evil.example",
    "127.0.0.1:8080", "*",
)  # fmt: skip


def refusal(access, *fields, path="/", upgrade=True, address="127.0.0.1", port=PORT):
    reply = reply_to(access, *fields, path=path, upgrade=upgrade, address=address, port=port)
    return reply.text if reply is not None and reply.status == 403 else ""


def reply_to(access, *fields, path="/", upgrade=False, address="127.0.0.1", port=PORT):
    headers = Headers()
    for name, value in (*fields, *([("Upgrade", "websocket")] if upgrade else [])):
        headers[name] = value
    return access.reply(path, headers.get_all, address, port)


@pytest.mark.parametrize("host", OWN)
def test_its_own_names_are_answered(host: str) -> None:
    assert refusal(LOOPBACK, ("Host", host), ("Origin", f"http://{host}")) == ""
    assert refusal(LOOPBACK, ("Host", host), upgrade=False) == ""


@pytest.mark.parametrize("host", FOREIGN_HOSTS)
def test_foreign_hosts_are_refused_with_whatever_origin(host: str) -> None:
    for origin in (f"http://{host}", "http://127.0.0.1:8080"):
        assert "another name" in refusal(LOOPBACK, ("Host", host), ("Origin", origin))
    assert "another name" in refusal(LOOPBACK, ("Host", host), upgrade=False)


@pytest.mark.parametrize("origin", FOREIGN_ORIGINS)
def test_foreign_origins_are_refused(origin: str) -> None:
    for upgrade in (True, False):
        fields = ("Host", "127.0.0.1:8080"), ("Origin", origin)
        assert "other origins" in refusal(LOOPBACK, *fields, upgrade=upgrade)


def test_header_fields_that_are_missing_or_doubled_are_refused() -> None:
    host, origin = ("Host", "127.0.0.1:8080"), ("Origin", "http://127.0.0.1:8080")
    assert refusal(LOOPBACK, host, origin) == ""
    assert "another name" in refusal(LOOPBACK, origin)
    assert "another name" in refusal(LOOPBACK, host, host, origin)
    assert "another name" in refusal(LOOPBACK, host, ("Host", "evil.example"), origin)
    assert "other origins" in refusal(LOOPBACK, host)
    assert "other origins" in refusal(LOOPBACK, host, origin, origin)
    assert "other origins" in refusal(LOOPBACK, host, origin, ("Origin", "https://evil.example"))


def test_on_this_machine_the_page_may_connect_to_operations_and_elsewhere_to_its_server_alone() -> None:
    for host, own in (*((each, True) for each in OWN), ("bench.example:8080", False), ("192.168.1.5", False)):
        policy = answer_headers(host)["Content-Security-Policy"]
        assert ("http://127.0.0.1:*" in policy) == own


def test_scripts_run_by_their_hash_and_nothing_is_compiled_but_webassembly() -> None:
    page = """<head><script data-x="a>b">one</script><script type='module'>two
</script><script src="/x.js"></script>"""
    hashes = [f"'sha256-{b64encode(sha256(text).digest()).decode()}'" for text in (b"one", b"two\n", b"")]
    assert script_sources(page).split() == hashes
    sources = [
        each.split() for each in answer_headers("127.0.0.1:1", "'sha256-x'")["Content-Security-Policy"].split(";")
    ]
    assert ["script-src", "'sha256-x'", "'strict-dynamic'", "'wasm-unsafe-eval'"] in sources
    assert ["script-src", "'none'"] in [
        each.split() for each in answer_headers("")["Content-Security-Policy"].split(";")
    ]


def test_the_policy_of_the_page_has_exactly_its_scripts(server) -> None:
    for packed in ("gzip", "identity"):
        own = f"Host: 127.0.0.1:{server.port}", cookie_of(server), f"Accept-Encoding: {packed}"
        _, headers, body = answer(server.port, *own)
        page = gzip.decompress(body) if packed == "gzip" else body
        assert page.count(b"</script>") == 2
        assert f"script-src {script_sources(page.decode())} 'strict-dynamic'" in headers["content-security-policy"]


def test_the_port_of_http_may_be_left_out() -> None:
    assert refusal(LOOPBACK, ("Host", "localhost"), ("Origin", "http://localhost"), port=80) == ""
    assert refusal(LOOPBACK, ("Host", "localhost:80"), ("Origin", "http://localhost:80"), port=80) == ""


@pytest.mark.parametrize(
    ("host", "name"), [("127.0.0.5", "127.0.0.5"), ("::1", "[::1]"), ("localhost", "localhost"), ("::1", "localhost")]
)
def test_a_server_on_loopback_has_the_name_it_was_started_with(host: str, name: str) -> None:
    own = f"{name}:{PORT}"
    access = access_for(host, needs_token=False)
    assert refusal(access, ("Host", own), ("Origin", f"http://{own}"), address=host) == ""


@pytest.mark.parametrize(
    "query", ["websocket=ws://evil.example", "playbackPath=x", "fixedDpr=1&web%73ocket=ws://evil.example", "websocket"]
)
def test_a_link_cannot_have_the_page_show_what_another_server_sends(query: str) -> None:
    assert "elsewhere" in refusal(LOOPBACK, ("Host", "127.0.0.1:8080"), path=f"/?{query}", upgrade=False)


HERE = ("Host", "127.0.0.1:8080"), ("Origin", "http://127.0.0.1:8080")
BEYOND = ("Host", "bench.example:8080"), ("Origin", "http://bench.example:8080")
COOKIE = "washboard-8080=secret; Path=/; HttpOnly; SameSite=Strict"


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.1.5", "bench", "127.0.0.1", "localhost", "::1"])
def test_every_server_has_a_token_of_its_own(host: str) -> None:
    tokens = {access_for(host).token for _ in range(3)}
    assert len(tokens) == 3
    assert min(map(len, tokens)) >= 32


def test_only_on_loopback_it_can_be_left_out() -> None:
    assert {access_for(host, needs_token=False).token for host in ("127.0.0.1", "localhost", "::1")} == {""}
    for host in ("0.0.0.0", "::", "192.168.1.5", "bench", ""):
        with pytest.raises(AccessError, match="--no-token: other machines reach"):
            access_for(host, needs_token=False)


@pytest.mark.parametrize(
    ("host", "own", "address"), [("127.0.0.1", HERE, "127.0.0.1"), ("0.0.0.0", BEYOND, "192.168.1.5")]
)
class TestToken:
    """On loopback and beyond."""

    @pytest.fixture(autouse=True)
    def _started(self, host, own, address):
        self.access, self.own, self.address = Access(host, "secret"), own, address

    def refusal(self, *fields, path="/"):
        return refusal(self.access, *self.own, *fields, path=path, address=self.address)

    def reply(self, path, *fields):
        return reply_to(self.access, *self.own, *fields, path=path, address=self.address)

    @pytest.mark.parametrize(
        ("path", "place"),
        [
            ("/?token=secret", "/"), ("/?fixedDpr=1&token=secret", "/?fixedDpr=1"), ("/?token=%73ecret&a=", "/?a="),
            ("/?token=secret&b=%0d%0aX:y", "/?b=%0D%0AX%3Ay"),
        ],
    )  # fmt: skip
    def test_it_comes_in_the_query_and_leaves_the_address(self, path: str, place: str) -> None:
        assert self.refusal(path=path) == ""
        direct = self.reply(path, ("Sec-Fetch-Site", "none"))
        assert (direct.status, direct.fields) == (303, {"Set-Cookie": COOKIE, "Location": place})
        linked = self.reply(path, ("Sec-Fetch-Site", "cross-site"))
        assert (linked.status, linked.fields) == (200, {"Set-Cookie": COOKIE, "Refresh": f"0; url={place}"})
        assert ("Location" in self.reply(path).fields) == (self.address == "127.0.0.1")

    def test_a_handshake_and_other_addresses_are_not_led_away(self) -> None:
        for path in ("/state?token=secret", "//evil.example?token=secret"):
            assert self.reply(path) is None
        assert reply_to(self.access, *self.own, path="/?token=secret", upgrade=True, address=self.address) is None

    @pytest.mark.parametrize("cookie", ["washboard-8080=secret", "a=b; washboard-8080=secret;c=d"])
    def test_it_comes_in_the_cookie(self, cookie: str) -> None:
        assert self.refusal(("Cookie", cookie)) == ""
        assert self.refusal(("Cookie", "a=b"), ("Cookie", cookie)) == ""

    @pytest.mark.parametrize(
        ("path", "cookie"),
        [
            ("/", ""), ("/?token=", ""), ("/?token=secre", ""), ("/?token=secretx", ""), ("/?token=SECRET", ""),
            ("/?Token=secret", ""), ("/secret", ""), ("/#token=secret", ""), ("/", "washboard-8081=secret"),
            ("/", "washboard-8080="), ("/", "washboard-8080"), ("/", "secret"), ("/", "x-washboard-8080=secret"),
            ("/?token=\u00e9", ""),
        ],
    )  # fmt: skip
    def test_without_it_everything_is_refused(self, path: str, cookie: str) -> None:
        assert "token" in self.refusal(*([("Cookie", cookie)] if cookie else []), path=path)
        refused = self.reply(path, *([("Cookie", cookie)] if cookie else []))
        assert (refused.status, refused.fields) == (403, {})
        assert "open the address that was printed" in refused.text

    def test_it_does_not_replace_the_origin(self) -> None:
        for origin in ("https://evil.example", "null", "http://bench.example"):
            fields = self.own[0], ("Origin", origin)
            for more in ({"path": "/?token=secret"}, {"path": "/"}):
                cookie = ("Cookie", "washboard-8080=secret")
                assert "other origins" in refusal(self.access, *fields, cookie, address=self.address, **more)
        assert "other origins" in refusal(self.access, self.own[0], path="/?token=secret", address=self.address)


class TestTokenBeyondLoopback:
    access = Access("0.0.0.0", "secret")

    def test_a_proxy_with_tls_may_stand_in_front(self) -> None:
        host, origin = ("Host", "bench.example:8080"), ("Origin", "https://bench.example:8080")
        assert refusal(self.access, host, origin, path="/?token=secret") == ""
        own = ("Host", "127.0.0.1:8080"), ("Origin", "https://127.0.0.1:8080")
        assert "other origins" in refusal(Access("127.0.0.1", "secret"), *own, path="/?token=secret")

    def test_a_server_at_one_address_has_its_names_only(self) -> None:
        access = Access("bench", "secret")
        for name, known in (("bench", True), ("192.168.1.5", True), ("localhost", False), ("evil.example", False)):
            host = f"{name}:{PORT}"
            fields = ("Host", host), ("Origin", f"http://{host}")
            found = refusal(access, *fields, path="/?token=secret", address="192.168.1.5")
            assert (found == "") == known

    @pytest.mark.parametrize("host", ["a b:8080", "x;y", "a'b", "[::1", "x" * 10 + "\u00e9", "a:b:8080"])
    def test_a_name_that_is_none_is_refused(self, host: str) -> None:
        fields = ("Host", host), ("Origin", f"http://{host}")
        assert "another name" in refusal(self.access, *fields, path="/?token=secret")
        assert host not in answer_headers(host)["Content-Security-Policy"]


def test_cookies_of_two_servers_on_one_host_do_not_meet() -> None:
    assert cookie_name(8080) != cookie_name(8081)


@pytest.mark.parametrize(
    ("host", "only_here"),
    [("127.0.0.1", True), ("localhost", True), ("::1", True), ("0.0.0.0", False), ("::", False), ("10.0.0.4", False)],
)
def test_only_loopback_is_closed_to_others(host: str, only_here: bool) -> None:
    assert is_loopback(host) == only_here


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    folder = tmp_path_factory.mktemp("project")
    server = serve(open_session("tiny", "rinse-only"), open_project(folder), "127.0.0.1", 0)
    yield server
    server.stop()


def on(port: int, text: str) -> str:
    return text.replace("8080", str(port))


def test_the_real_server_refuses_foreign_hosts(server) -> None:
    for host in (*FOREIGN_HOSTS, "l\u043ecalhost:8080"):
        sent = f"Host: {on(server.port, host)}".encode().decode("latin-1")
        assert answer(server.port, sent, cookie_of(server))[0] == 403, host
        origin = f"Origin: http://127.0.0.1:{server.port}"
        assert handshake(server.port, sent, origin, cookie_of(server)) == 403, host
    assert server.sessions.pages() == []


def test_the_real_server_refuses_foreign_origins(server) -> None:
    own, cookie = f"Host: 127.0.0.1:{server.port}", cookie_of(server)
    for origin in FOREIGN_ORIGINS:
        assert handshake(server.port, own, f"Origin: {on(server.port, origin)}", cookie) == 403, origin
    assert handshake(server.port, own, cookie) == 403
    twice = f"Origin: http://127.0.0.1:{server.port}"
    assert handshake(server.port, own, twice, twice, cookie) == 403
    assert handshake(server.port, own, own, twice, cookie) == 403
    assert handshake(server.port, twice, cookie) == 403
    assert handshake(server.port, own, twice, cookie) == 101
    assert handshake(server.port, own.lower(), twice.lower(), cookie) == 101
    assert server.sessions.pages() == []


def test_the_real_server_answers_nobody_without_its_token(server) -> None:
    own = f"Host: 127.0.0.1:{server.port}", f"Origin: http://127.0.0.1:{server.port}"
    wrong = f"Cookie: washboard-{server.port}={server.token[:-1]}x"
    for path in ("/", "/nothing", "/?token=", "/?token=x", f"/?token={server.token[:-1]}"):
        for more in ((), (wrong,)):
            status, headers, body = answer(server.port, *own, *more, path=path)
            assert (status, "set-cookie" in headers) == (403, False)
            assert b"open the address that was printed" in body
            assert handshake(server.port, *own, *more, path=path) == 403
    assert server.sessions.pages() == []
    path = server.address.removeprefix(f"http://127.0.0.1:{server.port}")
    assert handshake(server.port, *own, path=path) == 101
    status, headers, _ = answer(server.port, *own, path=path)
    assert (status, headers["location"]) == (303, "/")
    assert f"Cookie: {headers['set-cookie'].partition(';')[0]}" == cookie_of(server)
    assert answer(server.port, *own, cookie_of(server))[0] == 200


@only_root
def test_another_user_of_this_machine_needs_the_printed_address(server) -> None:
    own = f"Host: 127.0.0.1:{server.port}", f"Origin: http://127.0.0.1:{server.port}"
    foreign = ("Host: evil.example", own[1]), (own[0], "Origin: http://evil.example")
    path = server.address.removeprefix(f"http://127.0.0.1:{server.port}")

    def refused() -> list[int]:
        return [
            *(answer(server.port, *own, path=each)[0] for each in ("/", "/?token=x", path[:-1])),
            *(handshake(server.port, *own, path=each) for each in ("/", "/?token=x", path[:-1])),
            *(handshake(server.port, *fields, path=path) for fields in foreign),
            answer(server.port, *foreign[0], path=path)[0],
        ]

    def with_address() -> list[int]:
        cookie = f"Cookie: {answer(server.port, *own, path=path)[1]['set-cookie'].partition(';')[0]}"
        return [
            answer(server.port, *own, path=path)[0], handshake(server.port, *own, path=path),
            answer(server.port, *own, cookie)[0], handshake(server.port, *own, cookie),
        ]  # fmt: skip

    assert as_another_user(refused) == [403] * 9
    assert server.sessions.pages() == []
    assert as_another_user(with_address) == [303, 101, 200, 101]


@pytest.mark.parametrize(
    "path", ["/", "/nothing", "/../../etc/passwd", "/%2e%2e/etc/passwd", "/?websocket=x", "/?token=x"]
)
def test_every_answer_has_the_headers(server, path: str) -> None:
    for host in (f"127.0.0.1:{server.port}", "evil.example"):
        status, headers, body = answer(server.port, f"Host: {host}", cookie_of(server), path=path)
        assert status in ((403,) if host == "evil.example" else (200, 403, 404))
        policy = headers["content-security-policy"]
        assert "frame-ancestors 'none'" in policy
        assert "evil" not in policy
        assert headers["x-frame-options"] == "DENY"
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["referrer-policy"] == "no-referrer"
        assert b"root:x:" not in body
        assert "set-cookie" not in headers


@pytest.mark.parametrize("method", ["POST", "OPTIONS", "CONNECT", "\x16\x03\x01"])
def test_what_is_no_request_for_the_page_is_not_answered_with_it(server, capfd, method: str) -> None:
    status, _, body = answer(server.port, f"Host: 127.0.0.1:{server.port}", cookie_of(server), method=method)
    assert status != 200
    assert b"<html" not in body
    assert capfd.readouterr().err == ""


@pytest.mark.slow
def test_a_page_opens_with_its_own_origin(server) -> None:
    with bare_page(server) as page:
        assert page.find("Workpiece")
