"""Access control: which requests the server answers, by their Host, their Origin and their token.

A browser lets every web page open a websocket to this machine and states the page's origin; it is the server that has
to refuse foreign ones. A foreign name in ``Host`` is a name that somebody had resolved to this machine (DNS rebinding).
"""

import ipaddress
import re
import secrets
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Protocol
from urllib.parse import parse_qsl, urlsplit

ANY_ADDRESS = ("0.0.0.0", "::")
"""Hosts that stand for every address of the machine."""
_HTTP_PORT = 80
_HOST = re.compile(r"[a-z0-9_.-]+(:[0-9]{1,5})?|\[[0-9a-f:.]+\](:[0-9]{1,5})?")
_ELSEWHERE = frozenset({"websocket", "playbackPath"})
"""Queries by which viser's page takes what it shows, scripts included, from another server."""
_FOREIGN_HOST = "this server has another name; open the address that `washboard ui` printed, with its port."
_FOREIGN_ORIGIN = "pages of other origins cannot use this server; open the address that `washboard ui` printed."
_NO_TOKEN = "the token is missing or wrong; open the address that `washboard ui` printed, with its token."


class RequestHeaders(Protocol):
    """Header fields of a request, by name in any case."""

    def get_all(self, key: str) -> Sequence[str]:
        """Values of all fields of that name."""
        ...


@dataclass(frozen=True, slots=True)
class Access:
    """Whose requests are answered by a server that was started at a host."""

    host: str
    """Name or address as it was started with."""
    token: str = ""
    """Secret that every request has to carry; empty where only this machine reaches the server."""

    def refusal(self, path: str, headers: RequestHeaders, address: str, port: int) -> str:
        """Reason to refuse a request with 403; empty where it is answered.

        Args:
            path: Target of the request with its query.
            headers: Its header fields.
            address: Address of this machine at which the connection arrived.
            port: Port at which it arrived.
        """
        hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
        host = hosts[0].lower() if len(hosts) == 1 else ""
        if not _HOST.fullmatch(host) or not self._is_own(host, address, port):
            return _FOREIGN_HOST
        required = "websocket" in ",".join(headers.get_all("Upgrade")).lower()
        if len(origins) > 1 or (required and not origins):
            return _FOREIGN_ORIGIN
        if any(origin.lower() not in self._origins(host) for origin in origins):
            return _FOREIGN_ORIGIN
        query = dict(parse_qsl(urlsplit(path).query, keep_blank_values=True))
        if query.keys() & _ELSEWHERE:
            return "the page shows what this server sends, and nothing from elsewhere; leave out the query."
        if not self.token or self._has_token(query.get("token", "")):
            return ""
        stated = _cookies(headers.get_all("Cookie")).get(cookie_name(port), "")
        return "" if self._has_token(stated) else _NO_TOKEN

    def new_cookie(self, path: str, port: int) -> str:
        """Value of ``Set-Cookie`` in the answer to an accepted request that carries the token in its query."""
        stated = dict(parse_qsl(urlsplit(path).query)).get("token", "")
        if not self.token or not self._has_token(stated):
            return ""
        return f"{cookie_name(port)}={self.token}; Path=/; HttpOnly; SameSite=Strict"

    def _is_own(self, host: str, address: str, port: int) -> bool:
        """Whether a Host names this server; one at all addresses takes every name, with a token (docs/adr/0017)."""
        if self.host in ANY_ADDRESS and self.token:
            return True
        names = {bracketed(self.host), bracketed(address)}
        if is_loopback(self.host):
            names |= {"127.0.0.1", "localhost", "[::1]"}
        own = {f"{name}:{port}" for name in names} | (names if port == _HTTP_PORT else set[str]())
        return host in own

    def _origins(self, host: str) -> set[str]:
        """Origins of this server's pages when they are opened under a name; https is that of a proxy in front."""
        return {f"http://{host}"} | ({f"https://{host}"} if self.token else set[str]())

    def _has_token(self, stated: str) -> bool:
        return secrets.compare_digest(stated.encode(errors="replace"), self.token.encode())


def access_for(host: str) -> Access:
    """Access to a server at a host: with a random token where other machines reach it."""
    return Access(host, "" if is_loopback(host) else secrets.token_urlsafe(24))


def answer_headers(host: str) -> dict[str, str]:
    """Header fields of every answer, of refusals too.

    The page is one file with its scripts inside, compiles WebAssembly, and runs its workers from ``blob:``; it may
    connect to this server alone, and on this machine to the operations that run there (docs/adr/0078).

    Args:
        host: As the browser named the server; a name that is not well-formed is left out.
    """
    own = host.lower() if _HOST.fullmatch(host.lower()) else ""
    sockets = f" ws://{own} wss://{own}" if own else ""
    if own and is_loopback(own.rpartition(":")[0].strip("[]") or own):
        sockets += " http://127.0.0.1:*"
    policy = {
        "default-src": "'none'",
        "script-src": "'self' 'unsafe-inline' 'unsafe-eval'",
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


def _cookies(fields: Sequence[str]) -> dict[str, str]:
    pairs = (pair.partition("=") for field in fields for pair in field.split(";"))
    return {name.strip(): value.strip() for name, _, value in pairs}


def bracketed(host: str) -> str:
    """Spell a host as in a URL: lower case, addresses in their shortest form."""
    with suppress(ValueError):
        address = ipaddress.ip_address(host)
        return f"[{address.compressed}]" if address.version == 6 else str(address)
    return host.lower()
