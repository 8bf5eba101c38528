"""Access control: which requests the server answers, and what uploads may hold."""

import ipaddress
import re
import secrets
import threading
from base64 import b64encode
from collections.abc import Callable, Container, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import lru_cache
from hashlib import sha256
from http import HTTPStatus
from urllib.parse import SplitResult, parse_qsl, urlencode, urlsplit

from specs.errors import JobError

ANY_ADDRESS = ("0.0.0.0", "::")
"""Hosts that stand for every address of the machine."""
_HTTP_PORT = 80
_HOST = re.compile(r"[a-z0-9_.-]+(:[0-9]{1,5})?|\[[0-9a-f:.]+\](:[0-9]{1,5})?")
_SCRIPT = re.compile(r"""<script(?:[^>"']|"[^"]*"|'[^']*')*>(.*?)</script>""", re.DOTALL)
_ELSEWHERE = frozenset({"websocket", "playbackPath"})
"""Queries by which viser's page takes what it shows, scripts included, from another server."""
_FOREIGN_HOST = "this server has another name; open the address that was printed when it started, with its port."
_FOREIGN_ORIGIN = "pages of other origins cannot use this server; open the address that was printed when it started."
_NO_TOKEN = "the token is missing or wrong; open the address that was printed when this server started, with its token."


@dataclass(frozen=True, slots=True)
class Reply:
    """Answer of the access control itself."""

    status: HTTPStatus
    fields: dict[str, str]
    """Header fields, beside those of every answer."""
    text: str = ""


@dataclass(frozen=True, slots=True)
class Access:
    """Whose requests are answered by a server that was started at a host."""

    host: str
    """Name or address as it was started with."""
    token: str = ""
    """Secret that every request has to carry; empty where whoever uses this machine is answered."""

    def reply(self, path: str, values: Callable[[str], Sequence[str]], address: str, port: int) -> Reply | None:
        """Answer to a request that is refused, or opens the page with the token in its query; ``None`` for all others.

        The token is stored in the browser and leaves the address. A browser that follows a link of another site sends
        no strict cookie, in the redirected request neither: it loads the page anew instead.

        Args:
            path: Target of the request with its query.
            values: Gives the values of all its header fields of a name.
            address: Address of this machine at which the connection arrived.
            port: Port at which it arrived.
        """
        if split_path(path) is None:
            return Reply(HTTPStatus.BAD_REQUEST, {}, "Refused: this is no address of a page.\n")
        if reason := self._refusal(path, values, address, port):
            return Reply(HTTPStatus.FORBIDDEN, {}, f"Refused: {reason}\n")
        query = parse_qsl(urlsplit(path).query, keep_blank_values=True)
        is_entry = urlsplit(path).path == "/" and not values("Upgrade")
        if not is_entry or not self.token or not self._has_token(dict(query).get("token", "")):
            return None
        place = f"/?{urlencode([each for each in query if each[0] != 'token'])}".removesuffix("?")
        cookie = {"Set-Cookie": f"{cookie_name(port)}={self.token}; Path=/; HttpOnly; SameSite=Strict"}
        sites = values("Sec-Fetch-Site")  # without TLS it comes to loopback alone
        if "cross-site" in sites or not (sites or is_loopback(self.host)):
            return Reply(HTTPStatus.OK, {**cookie, "Refresh": f"0; url={place}"}, "Opening the page\u2026\n")
        return Reply(HTTPStatus.SEE_OTHER, {**cookie, "Location": place})

    def _refusal(self, path: str, values: Callable[[str], Sequence[str]], address: str, port: int) -> str:
        """Reason to refuse a request; empty where it is answered."""
        hosts, origins = values("Host"), values("Origin")
        host = hosts[0].lower() if len(hosts) == 1 else ""
        if not _HOST.fullmatch(host) or not self._is_own(host, address, port):
            return _FOREIGN_HOST
        required = "websocket" in ",".join(values("Upgrade")).lower()
        if len(origins) > 1 or (required and not origins):
            return _FOREIGN_ORIGIN
        own = (
            {f"http://{host}"} if is_loopback(self.host) else {f"http://{host}", f"https://{host}"}
        )  # a proxy with TLS
        if not own.issuperset(map(str.lower, origins)):
            return _FOREIGN_ORIGIN
        query = dict(parse_qsl(urlsplit(path).query, keep_blank_values=True))
        if query.keys() & _ELSEWHERE:
            return "the page shows what this server sends, and nothing from elsewhere; leave out the query."
        if not self.token or self._has_token(query.get("token", "")):
            return ""
        pairs = (pair.partition("=") for field in values("Cookie") for pair in field.split(";"))
        stated = {name.strip(): value.strip() for name, _, value in pairs}.get(cookie_name(port), "")
        return "" if self._has_token(stated) else _NO_TOKEN

    def _is_own(self, host: str, address: str, port: int) -> bool:
        """Whether a Host names this server; one at all addresses takes every name, with a token (docs/adr/0017)."""
        if self.host in ANY_ADDRESS and self.token:
            return True
        names = {bracketed(self.host), bracketed(address)}
        if is_loopback(self.host):
            names |= {"127.0.0.1", "localhost", "[::1]"}
        own = {f"{name}:{port}" for name in names} | (names if port == _HTTP_PORT else set[str]())
        return host in own

    def _has_token(self, stated: str) -> bool:
        return secrets.compare_digest(stated.encode(errors="replace"), self.token.encode())


def split_path(path: str) -> SplitResult | None:
    """Split what a request names into path and query; ``None`` where it is no such thing."""
    try:
        return urlsplit(path)
    except ValueError:
        return None


class AccessError(JobError):
    """A server cannot be opened to so many."""


def access_for(host: str, *, needs_token: bool = True) -> Access:
    """Access to a server at a host, with a random token unless it is for this machine alone and needs none.

    Raises:
        AccessError: other machines would reach a server without token.
    """
    if not needs_token and not is_loopback(host):
        raise AccessError(f"--no-token: other machines reach {host}; leave out one of --host and --no-token.")
    return Access(host, new_token() if needs_token else "")


def new_token() -> str:
    """Give a secret that nobody guesses."""
    return secrets.token_urlsafe(24)


def with_token(address: str, token: str) -> str:
    """Address that is opened first, which has the token if there is one."""
    return f"{address}/?token={token}" if token else address


@lru_cache(maxsize=4)
def script_sources(page: str) -> str:
    """Sources of a content security policy that name each script within a page by its hash."""
    hashes = (sha256(script.encode()).digest() for script in _SCRIPT.findall(page))
    return " ".join(f"'sha256-{b64encode(each).decode()}'" for each in hashes)


def answer_headers(host: str, scripts: str = "") -> dict[str, str]:
    """Header fields of every answer, of refusals too.

    The page is one file with its scripts inside, compiles WebAssembly, and runs its workers from ``blob:``; it may
    connect to this server alone, and on this machine to the operations that run there (docs/adr/0078).

    Args:
        host: As the browser named the server; a name that is not well-formed is left out.
        scripts: Sources of the page's scripts, which may load others.
    """
    own = host.lower() if _HOST.fullmatch(host.lower()) else ""
    sockets = f" ws://{own} wss://{own}" if own else ""
    if own and is_loopback(own.rpartition(":")[0].strip("[]") or own):
        sockets += " http://127.0.0.1:*"
    policy = {
        "default-src": "'none'",
        "script-src": f"{scripts} 'strict-dynamic' 'wasm-unsafe-eval'" if scripts else "'none'",
        "worker-src": "blob:",
        "style-src": "'self' 'unsafe-inline'",
        "img-src": "'self' data: blob:",
        "font-src": "data:",
        "connect-src": f"'self'{sockets} data:",
        "base-uri": "'none'",
        "form-action": "'none'",
        "frame-ancestors": "'none'",
    }
    return {
        "Content-Security-Policy": "; ".join(f"{name} {value}" for name, value in policy.items()),
        "Cross-Origin-Opener-Policy": "same-origin",
        "Cross-Origin-Resource-Policy": "same-origin",
        "Referrer-Policy": "no-referrer",
        "X-Content-Type-Options": "nosniff",
        "X-Frame-Options": "DENY",
    }


def is_loopback(host: str) -> bool:
    """Whether a host is reachable from this machine only."""
    with suppress(ValueError):
        return ipaddress.ip_address(host).is_loopback
    return host == "localhost"


def cookie_name(port: int) -> str:
    """Name of the cookie that carries the token; cookies are shared by all ports of a host."""
    return f"washboard-{port}"


def bracketed(host: str) -> str:
    """Spell a host as in a URL: lower case, addresses in their shortest form."""
    with suppress(ValueError):
        address = ipaddress.ip_address(host)
        return f"[{address.compressed}]" if address.version == 6 else str(address)
    return host.lower()


_MOST_AT_ONCE = 4
"""Of one page, which has two buttons."""
_MOST_TOTAL = 2
"""Largest uploads whose bytes may be held at once, of all pages together."""
_SMALLEST_PART = 64 * 1024
"""Bytes; viser's page sends parts of 512 KiB."""
_MB = 1e6


class UploadError(JobError):
    """An upload breaks a limit; it is dropped, and the page goes on."""


@dataclass(slots=True)
class _Upload:
    """An upload under way."""

    name: str
    size: int
    """Bytes as announced."""
    parts: int
    """As announced."""
    arrived: set[int] = field(default_factory=set[int])
    """Numbers of the parts that arrived."""
    received: int = 0
    """Bytes that arrived."""


class Uploads:
    """The uploads under way of all pages of a server."""

    def __init__(self, largest: int, folder: str) -> None:
        """Start without uploads.

        Args:
            largest: Bytes that one file may have.
            folder: Where a larger file may be copied by hand.
        """
        self._largest, self._folder = largest, folder
        self._lock = threading.Lock()
        self._under_way: dict[int, dict[str, _Upload]] = {}

    def begin(self, client: int, transfer: str, name: str, size: int, parts: int) -> None:
        """Register an announced upload.

        Args:
            client: Connection that it comes from.
            transfer: Its identifier, which the client makes up.
            name: Of the file.
            size: Bytes announced.
            parts: Number of parts announced.

        Raises:
            UploadError: it is too large, contradicts itself, or too many are under way.
        """
        if not isinstance(name, str):  # pyright: ignore[reportUnnecessaryIsInstance]  # whatever was sent
            raise UploadError("an upload without a name was dropped.")
        shown = repr(name[:40])
        if size > self._largest:
            raise UploadError(f"{shown}: {size / _MB:,.0f} MB are too many to upload; copy it into {self._folder}.")
        if size < 0 or (parts < 1) != (size == 0) or parts > size // _SMALLEST_PART + 1:
            raise UploadError(f"{shown}: {size:,} bytes in {parts:,} parts cannot be; upload it again.")
        with self._lock:
            own = self._under_way.setdefault(client, {})
            if len(own) >= _MOST_AT_ONCE or transfer in own:
                raise UploadError(f"{shown}: {len(own)} uploads are under way; wait until they are done.")
            own[transfer] = _Upload(name, size, parts)

    def receive(self, client: int, transfer: str, part: int, content: bytes) -> None:
        """Count a part.

        Raises:
            UploadError: more arrived than was announced, or all uploads together hold too much.
        """
        with self._lock:
            upload = self._under_way.get(client, {}).get(transfer)
            if upload is None or not isinstance(content, bytes):  # pyright: ignore[reportUnnecessaryIsInstance]
                raise UploadError("an upload that was not announced, or is not of bytes, was dropped.")
            if part in upload.arrived:
                return  # viser drops it
            upload.arrived.add(part)
            upload.received += len(content)
            held = sum(each.received for own in self._under_way.values() for each in own.values())
            reason = ""
            if upload.received > upload.size or not 0 <= part < upload.parts:
                reason = f"more than the announced {upload.size:,} bytes in {upload.parts:,} parts arrived"
            elif held > _MOST_TOTAL * self._largest:
                reason = "too much is uploaded at once"
            if reason:
                del self._under_way[client][transfer]
                raise UploadError(f"{upload.name[:40]!r}: {reason}; upload it again.")

    def keep(self, client: int, transfers: Container[str]) -> None:
        """Forget the uploads of a client that are not among its transfers any more: they are complete or dropped."""
        with self._lock:
            own = self._under_way.get(client, {})
            for transfer in [each for each in own if each not in transfers]:
                del own[transfer]

    def forget(self, client: int) -> None:
        """Forget all uploads of a client, which has disconnected."""
        with self._lock:
            self._under_way.pop(client, None)
