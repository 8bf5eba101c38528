"""Operations that are running, found by small files in the folder in which they were begun."""

import json
import re
import secrets
from collections.abc import Generator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, fields
from http.client import HTTPConnection, HTTPException
from pathlib import Path
from typing import cast

from reports.files.atomic_write import write_text_atomically
from specs.json import Json
from specs.read_file import read_head

FOLDER = Path(".washboard") / "live"
"""In the project folder; one file for each operation."""
_ADDRESS = re.compile(r"http://127\.0\.0\.1:([0-9]{1,5})")
_PLAIN = re.compile(r"[A-Za-z0-9_-]{1,100}")
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
    """Secret that requests of pages of other origins carry."""
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


def new_token() -> str:
    """Give a secret that nobody guesses."""
    return secrets.token_urlsafe(24)


@contextmanager
def announced(folder: Path, running: Running) -> Generator[None]:
    """Let pages whose project folder it is find an operation, until it is over.

    Raises:
        OutputError: the file cannot be written.
    """
    with suppress(OSError):  # then the file cannot be written, which is reported
        (folder / FOLDER).mkdir(parents=True, exist_ok=True)
        (folder / FOLDER).chmod(0o700)  # the token is for pages of this user
    file = folder / FOLDER / f"{running.port}.json"
    write_text_atomically(file, json.dumps(asdict(running)))
    try:
        yield
    finally:
        with suppress(OSError):
            file.unlink()


def running_in(folder: Path) -> list[Running]:
    """Operations that were begun in a folder and answer now, by their port; files that are none are left out.

    A process that was killed leaves its file: it does not answer.
    """
    try:
        files = sorted(each for each in (folder / FOLDER).glob("*.json") if each.is_file() and not each.is_symlink())
    except OSError:
        return []
    found = [running for file in files[:_MOST] if (running := _read(file)) is not None]
    return [running for running in found if look(running.port, _BRIEF_S) is not None]


def look(port: int, patience_s: float = 0.5) -> Mapping[str, Json] | None:
    """Give the state of the operation at a port of this machine; ``None`` where none answers."""
    connection = HTTPConnection("127.0.0.1", port, timeout=patience_s)
    try:
        return look_over(connection)
    finally:
        connection.close()


def look_over(connection: HTTPConnection) -> Mapping[str, Json] | None:
    """Give the state over a connection that is kept; ``None`` where none answers, and it is closed then."""
    try:
        connection.request("GET", "/state")
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
    """Read a file; ``None`` where it is not what ``announced`` writes."""
    try:
        stated = json.loads(read_head(file, _LARGEST_FILE))
    except (ValueError, RecursionError):
        return None
    names = [each.name for each in fields(Running)]
    if not isinstance(stated, dict) or set(cast("dict[str, object]", stated)) != {*names}:
        return None
    values = [cast("dict[str, object]", stated)[name] for name in names]
    if not all(isinstance(value, str) and value.isprintable() for value in values):
        return None
    running = Running(*cast("list[str]", values))
    address = _ADDRESS.fullmatch(running.address)
    is_own = address is not None and 0 < int(address[1]) <= _LAST_PORT and _PLAIN.fullmatch(running.token) is not None
    return running if is_own else None
