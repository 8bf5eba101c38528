"""Folders and archives that hold a board in many files: only files inside, of bounded sizes, are ever read."""

import gzip
import io
import os
import stat
import tarfile
import zipfile
import zlib
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Any, TypeAlias, cast

from boards.errors import MAX_BYTES, BoardError, read_bytes
from boards.formats.names import cause
from specs.confinement import resolve
from specs.errors import printable
from specs.input_file import InputFile

MOST_BYTES = 400_000_000
"""Of what is read out of an archive or a folder, together."""

_MOST_MEMBERS = 100_000
_SMALL_BYTES = 10_000_000
_MOST_TIMES = 100
"""An archive unpacks to at most a hundred times its size, or 10 MB."""

_Member: TypeAlias = tuple[str, int, Callable[[], bytes]]
"""Path, size, and what reads it, one after the other."""

_PACKED = ".z"
_JUNK = frozenset({"__MACOSX", "Thumbs.db", "desktop.ini"})
_LITERALS, _NARROWEST, _WIDEST = 256, 9, 16
_DEEPEST = 16
_CHUNK = 1 << 16
_PACK = "Pack the files themselves, as the program exported them."
_ENCRYPTED = 1
"""Flag of a member of a zip."""
_DAMAGED = (
    *(tarfile.TarError, zipfile.BadZipFile, EOFError, zlib.error, ValueError, RuntimeError, NotImplementedError),
    *(OverflowError, LookupError, OSError),
)


def is_archive(path: Path) -> bool:
    """Whether a path is a folder, or its name is that of an archive."""
    return path.is_dir() or path.name.lower().endswith((".zip", ".tgz", ".tar.gz"))


def read_members(path: Path, needed: Callable[[str], bool]) -> tuple[tuple[str, ...], dict[str, bytes]]:
    """Read the files of an archive or a folder that are needed.

    A file that Unix ``compress`` packed, ``NAME.Z``, stands for ``NAME``, unless that is there too. What systems add to
    folders, hidden files and ``__MACOSX`` among it, is left out.

    Args:
        path: A folder, a ``.zip``, a ``.tgz`` or a ``.tar.gz``.
        needed: Of the path inside, with ``/`` between its parts.

    Returns:
        The paths of all files inside, and the content of those that are needed.

    Raises:
        BoardError: It cannot be read; it leads out of itself by a path or a link; or it holds more than a board does.
    """
    total = _Total(path)
    members = _in_folder if path.is_dir() else _in_zip if path.name.lower().endswith(".zip") else _in_tar
    names: list[str] = []
    found: dict[str, bytes] = {}
    try:
        for name, size, read in members(total):
            if any(part.startswith(".") or part in _JUNK for part in name.split("/")):
                continue
            names.append(_plain(name))
            if needed(names[-1]):
                total.size(name, size)
                found[name] = read()
        return tuple(dict.fromkeys(names)), _unpacked(found, total)
    except _DAMAGED as reason:
        raise BoardError(f"the archive is damaged: {cause(reason)}. Export the board again.", file=path) from None


def _plain(name: str) -> str:
    return name[: -len(_PACKED)] if name.lower().endswith(_PACKED) else name


def _unpacked(found: dict[str, bytes], total: "_Total") -> dict[str, bytes]:
    """Unpack files that ``compress`` packed, by the names without their suffix."""
    plain = {name: content for name, content in found.items() if _plain(name) == name}
    for name in found.keys() - plain.keys():
        if _plain(name) not in plain:
            most = max(_MOST_TIMES * len(found[name]), _SMALL_BYTES)
            content = unpack_lzw(found[name], min(most, MOST_BYTES))
            if content is None:
                raise _bomb(total.path)
            total.size(name, len(content))
            plain[_plain(name)] = content
    return plain


def unpack_lzw(packed: bytes, most: int) -> bytes | None:
    """Unpack a ``.Z`` file of Unix ``compress``; ``None`` if it unpacks to more bytes than allowed.

    Codes of 9 bits at first and up to 16, the lowest bit first. Where their width grows, or begins anew at a clear
    code, the rest of eight codes is padding. T. A. Welch, Computer 17 (1984) 8.

    Raises:
        ValueError: it is damaged.
    """
    if len(packed) < 3 or packed[:2] != b"\x1f\x9d" or not _NARROWEST <= packed[2] & 31 <= _WIDEST:
        raise ValueError("a .Z file has another head")
    widest, clear = packed[2] & 31, _LITERALS if packed[2] & 128 else -1
    first = _LITERALS + 1 if clear > 0 else _LITERALS
    out = bytearray()
    spans: list[
        tuple[int, int]
    ] = []  # of each entry, from the code `first` on: where it stands in `out`, and its length
    last: tuple[int, int] | None = None
    width, at, section = _NARROWEST, 24, 24
    most_width = max(widest, _NARROWEST + 1)  # full tables of 9 bits have codes of 10
    while True:
        if width < most_width and first + len(spans) >= 1 << width:
            at = section = _next_eight(at, section, width)
            width += 1
        if at + width > 8 * len(packed):
            return bytes(out)
        code = int.from_bytes(packed[at >> 3 : (at >> 3) + 4], "little") >> (at & 7) & ((1 << width) - 1)
        at += width
        if code == clear:
            at = section = _next_eight(at, section, width)
            width, last = _NARROWEST, None
            spans.clear()
            continue
        begin = len(out)
        _append(out, code, first, spans, last)
        if last is not None and first + len(spans) < 1 << widest:
            spans.append((last[0], last[1] + 1))
        last = begin, len(out) - begin
        if len(out) > most:
            return None


def _append(
    out: bytearray, code: int, first: int, spans: Sequence[tuple[int, int]], last: tuple[int, int] | None
) -> None:
    """Append what a code stands for."""
    if code < _LITERALS:
        out.append(code)
    elif code - first < len(spans):
        start, length = spans[code - first]
        out += out[start : start + length]
    elif code - first == len(spans) and last is not None:  # the entry that this very code completes
        start, length = last
        out += out[start : start + length]
        out.append(out[start])
    else:
        raise ValueError("a .Z file has a code that is not defined yet")


def _next_eight(at: int, section: int, width: int) -> int:
    """Bit after the eight codes that bit ``at`` is in, counted from the section's first bit."""
    return section + -(-(at - section) // (8 * width)) * 8 * width


class _Total:
    """Counts members and bytes against their bounds."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.members = self.bytes = 0

    def name(self, name: str) -> str:
        """Check a member's path, which must stay inside."""
        self.members += 1
        if self.members > _MOST_MEMBERS:
            raise BoardError(f"holds more than {_MOST_MEMBERS:,} files. That is no board.", file=self.path)
        parts = PurePosixPath(name).parts
        if name.startswith("/") or ".." in parts or "\\" in name or "\0" in name or ":" in name[:2]:
            raise BoardError(f"holds the path {printable(name)[:80]!r}, which leads out of it. {_PACK}", file=self.path)
        return "/".join(parts)

    def link(self, name: str) -> BoardError:
        """Error of a link, a device or a pipe."""
        message = f"holds {printable(name)[:80]!r}, which is a link or a device and not a file. {_PACK}"
        return BoardError(message, file=self.path)

    def size(self, name: str, size: int) -> None:
        """Check the size of a member before it is read."""
        self.bytes += size
        if size < 0 or self.bytes > MOST_BYTES:
            message = f"{printable(name)[:80]!r} brings what is read to {self.bytes:,} bytes"
            raise BoardError(f"{message}; at most {MOST_BYTES:,} are. That is no board.", file=self.path)


def _in_folder(total: _Total) -> Iterator[_Member]:
    """Yield the files below a folder in the order of their names; a link that leads out of it is refused."""
    root = total.path
    inside = root.resolve()

    def below(folder: Path, depth: int) -> Iterator[_Member]:
        if depth > _DEEPEST:
            raise BoardError(f"folders are nested more than {_DEEPEST} deep. That is no board.", file=root)
        try:
            files = sorted(folder.iterdir())
        except OSError as reason:
            raise BoardError(f"cannot be read: {reason.strerror}", file=folder) from None
        for file in files:
            if file.is_symlink() and not resolve(file).is_relative_to(inside):
                name = printable(file.relative_to(root).as_posix())[:80]
                raise BoardError(f"holds the link {name!r}, which leads out of it. {_PACK}", file=root)
            if file.is_dir():
                yield from below(file, depth + 1)
            elif file.is_file():
                yield total.name(file.relative_to(root).as_posix()), file.stat().st_size, partial(read_bytes, file)

    return below(root, 0)


def _in_zip(total: _Total) -> Iterator[_Member]:
    with InputFile(total.path, BoardError, "board file", MAX_BYTES).stream() as stream:
        yield from _in_stream(total, stream)


def _in_stream(total: _Total, stream: io.RawIOBase | io.BytesIO) -> Iterator[_Member]:
    path = total.path
    _check_directory(stream, path)
    with zipfile.ZipFile(stream) as archive:
        for member in archive.infolist():
            name = total.name(member.filename)
            if stat.S_IFMT(member.external_attr >> 16) not in (0, stat.S_IFREG, stat.S_IFDIR):
                raise total.link(name)
            if member.is_dir():
                continue
            most = max(_MOST_TIMES * member.compress_size, _SMALL_BYTES)
            yield name, member.file_size, partial(_read_packed, archive, member, most, path)


def read_zip(content: bytes, path: Path, needed: Callable[[str], bool]) -> dict[str, bytes]:
    """Read files of an archive that is in memory.

    Raises:
        BoardError: As ``read_members``.
    """
    total = _Total(path)
    found: dict[str, bytes] = {}
    try:
        for name, size, read in _in_stream(total, io.BytesIO(content)):
            if needed(name):
                total.size(name, size)
                found[name] = read()
    except _DAMAGED as reason:
        raise BoardError(f"the file is damaged: {cause(reason)}. Save it again.", file=path) from None
    return found


def _read_packed(archive: zipfile.ZipFile, member: zipfile.ZipInfo, most: int, path: Path) -> bytes:
    if member.file_size > most:
        raise _bomb(path)
    if member.flag_bits & _ENCRYPTED:
        shown = printable(member.filename)[:80]
        raise BoardError(f"{shown!r} in it needs a password. Pack the board without one.", file=path)
    if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        shown = printable(member.filename)[:80]  # others unpack what is read of them at once, whatever that becomes
        raise BoardError(f"{shown!r} in it is packed by a method that is not read here. {_PACK}", file=path)
    with archive.open(member) as file:
        return file.read(member.file_size)


def _check_directory(stream: io.RawIOBase | io.BytesIO, path: Path) -> None:
    """Refuse a directory of more members than are read, before it is read as a whole."""
    size = stream.seek(0, os.SEEK_END)
    stream.seek(max(size - 66_000, 0))
    tail = stream.read(66_000) or b""
    end = tail.rfind(b"PK\x05\x06")
    length = int.from_bytes(tail[end + 12 : end + 16], "little") if end >= 0 else 0
    if length > 300 * _MOST_MEMBERS:
        raise BoardError(f"holds more than {_MOST_MEMBERS:,} files. That is no board.", file=path)
    stream.seek(0)


class _Bounded(io.RawIOBase):
    """What an archive unpacks to, up to a bound."""

    def __init__(self, source: io.BufferedIOBase | gzip.GzipFile, most: int, path: Path) -> None:
        self._source, self._left, self._path = source, most, path

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: object, /) -> int:
        view = memoryview(buffer).cast("B")  # type: ignore[arg-type]
        chunk = self._source.read(min(len(view), _CHUNK))
        self._left -= len(chunk)
        if self._left < 0:
            raise _bomb(self._path)
        view[: len(chunk)] = chunk
        return len(chunk)


def _bomb(path: Path) -> BoardError:
    message = f"unpacks to more than {_MOST_TIMES} times its size: that is no board. Export it again."
    return BoardError(message, file=path)


def _in_tar(total: _Total) -> Iterator[_Member]:
    path = total.path
    InputFile(path, BoardError, "board file", MAX_BYTES).check()
    most = max(_MOST_TIMES * path.stat().st_size, _SMALL_BYTES)
    with (
        InputFile(path, BoardError, "board file", MAX_BYTES).stream() as stream,
        gzip.GzipFile(fileobj=stream) as unpacked,
    ):
        source = _Bounded(unpacked, most, path)
        with tarfile.open(fileobj=source, mode="r|") as archive:
            while (member := archive.next()) is not None:
                cast(Any, archive).members.clear()  # the memory stays flat
                name = total.name(member.name)
                if member.isdir():
                    continue
                if not member.isreg():
                    raise total.link(name)
                if member.size > most:  # more than the archive can hold
                    raise _bomb(path)
                yield name, member.size, partial(_extract, archive, member)


def _extract(archive: tarfile.TarFile, member: tarfile.TarInfo) -> bytes:
    file = archive.extractfile(member)
    content = b"" if file is None else file.read()
    if len(content) != member.size:
        raise tarfile.ReadError("it ends in the middle of a file")
    return content
