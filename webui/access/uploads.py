"""Limits of uploads, which are counted while they arrive."""

import threading
from collections.abc import Container
from dataclasses import dataclass, field

from specs.errors import JobError

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
