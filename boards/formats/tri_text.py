"""The text of a ``.tri`` file: its bytes, its record lines, and its numbers in bulk."""

import gzip
import math
import re
import warnings
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn, cast

import numpy as np
from numpy.typing import NDArray

from boards.errors import BoardError
from geometry.arrays import Indices, Scalars

MAX_BYTES = 2_000_000_000
"""A board file of more than this is refused: nothing that holds a board is so large."""

_CHUNK_LINES = 2048  # a block stays in the cache
_BLANK_STARTS = np.isin(np.arange(256), np.frombuffer(b" \t", np.uint8))
_NUMERIC_STARTS = np.isin(np.arange(256), np.frombuffer(b"0123456789+-.", np.uint8))
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_TOKEN = re.compile(r'([^\s"#]*"[^"]*"|[^\s"#]+)(?=[\s#]|$)|#.*|\s+')
_VERTEX_DECIMALS, _NORMAL_DECIMALS = 4, 5


@dataclass(frozen=True, slots=True)
class Record:
    """A line that begins with a word."""

    line: int
    """Line number, from 1."""
    tokens: tuple[str, ...]
    """Words, quotes still in place."""
    rows_before: int
    """How many lines of numbers stand above it."""


@dataclass(frozen=True, slots=True, eq=False)
class Numbers:
    """Every line of numbers, one after the other."""

    values: Scalars
    """(k,) all numbers of the file."""
    counts: Indices
    """(n,) how many numbers each line has."""
    lines: Indices
    """(n,) line numbers, from 1."""


@dataclass(frozen=True, slots=True, eq=False)
class Content:
    """A file that has been cut into records and numbers."""

    records: tuple[Record, ...]
    numbers: Numbers
    last_line: int


def read_text(file: Path) -> bytes:
    """Return the plain UTF-8 bytes of a file, unpacked if its name ends with ``.gz``; every line ends with a line feed.

    Raises:
        BoardError: The file cannot be read, is empty, too large, truncated or not UTF-8.
    """
    try:
        if file.suffix.lower() == ".gz":
            with gzip.open(file, "rb") as packed:
                text = packed.read(MAX_BYTES + 1)
        else:
            text = file.read_bytes()
    except (EOFError, gzip.BadGzipFile, zlib.error) as error:
        raise BoardError(f"damaged gzip file ({error}). Pack or copy it again.", file=file) from None
    except IsADirectoryError:
        raise BoardError("is a directory. Name the board file inside it.", file=file) from None
    except OSError as error:
        raise BoardError(f"cannot be read ({error.strerror}).", file=file) from None
    if len(text) > MAX_BYTES:
        raise BoardError(f"holds more than {MAX_BYTES:,} bytes. Tessellate the board more coarsely.", file=file)
    if not text.isascii():
        text = _check_encoding(text, file)
    if b"\r" in text:
        text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if not text or text.isspace():
        raise BoardError("is empty. A board file begins with 'board-tri 1'.", file=file)
    return text if text.endswith(b"\n") else text + b"\n"


def _check_encoding(text: bytes, file: Path) -> bytes:
    text = text.removeprefix(b"\xef\xbb\xbf")
    try:
        text.decode()
    except UnicodeDecodeError as error:
        line = text.count(b"\n", 0, error.start) + 1
        raise BoardError("is not UTF-8 text. Save the board as UTF-8.", file=file, line=line) from None
    return text


def cut(text: bytes, file: Path) -> Content:
    """Cut a text into records and numbers, the numbers in bulk.

    Raises:
        BoardError: A quote is not closed, or something that is not a finite number stands in a line of numbers.
    """
    letters = np.frombuffer(text, np.uint8)
    ends = np.flatnonzero(letters == ord("\n"))
    starts = np.concatenate(([0], ends[:-1] + 1))
    first = starts.copy()
    while (blank := _BLANK_STARTS[letters[first]]).any():
        first[blank] += 1
    numeric = _NUMERIC_STARTS[letters[first]]
    rows = np.flatnonzero(numeric)
    rows_before = np.cumsum(numeric)
    records: list[Record] = []
    for line in np.flatnonzero(~numeric & (first < ends)).tolist():
        tokens = _split(text[first[line] : ends[line]].decode(), file, line + 1)
        if tokens:
            records.append(Record(line + 1, tokens, int(rows_before[line])))
    if not records and not len(rows):
        raise BoardError("holds comments only. A board file begins with 'board-tri 1'.", file=file)
    return Content(tuple(records), _read_rows(text, starts, ends, rows, file), len(ends))


def _split(line: str, file: Path, number: int) -> tuple[str, ...]:
    if '"' not in line:
        return tuple(line.partition("#")[0].split())
    tokens: list[str] = []
    place = 0
    while place < len(line):
        match = _TOKEN.match(line, place)
        if match is None:
            raise BoardError(
                f"a quote is not closed, or stands inside a word: {line[place:][:40]}", file=file, line=number
            )
        if match[1]:
            tokens.append(match[1])
        place = match.end()
    return tuple(tokens)


def _read_rows(text: bytes, starts: Indices, ends: Indices, rows: Indices, file: Path) -> Numbers:
    values = np.empty(12 * len(rows))
    counts = np.full(len(rows), 12, np.int64)
    place = 0
    for begin in range(0, len(rows), _CHUNK_LINES):
        some = rows[begin : begin + _CHUNK_LINES]
        origin = int(starts[some[0]])
        start, end = starts[some] - origin, ends[some] - origin
        block = _blanked(text[origin : origin + int(end[-1]) + 1], start, end)
        chunk = _parse_fixed(block, start, end)
        if chunk is None:
            chunk, counts[begin : begin + len(some)] = _parse_free(block, start, some, file)
        if place + len(chunk) > len(values):
            values = np.concatenate((values[:place], np.empty(len(chunk) + len(values))))
        values[place : place + len(chunk)] = chunk
        place += len(chunk)
    return Numbers(values[:place], counts, rows + 1)


def _blanked(text: bytes, starts: Indices, ends: Indices) -> bytes:
    """Blank whatever is no number in a block of lines: records between the rows, and comments."""
    block = bytearray(text)
    gaps = np.flatnonzero(starts[1:] > ends[:-1] + 1)
    for begin, end in zip(ends[gaps].tolist(), starts[gaps + 1].tolist(), strict=True):
        block[begin:end] = b" " * (end - begin - 1) + b"\n"
    place = block.find(b"#")
    while place >= 0:
        end = block.find(b"\n", place)
        block[place:end] = b" " * (end - place)
        place = block.find(b"#", end)
    return bytes(block)


def _parse_fixed(block: bytes, starts: Indices, ends: Indices) -> Scalars | None:
    """Parse rows as our writer lays them out: 9 numbers with 4 decimals and 3 with 5; ``None`` for any other.

    Without its points such a text is integers, which numpy reads three times faster; divided by a power of ten they
    are the correctly rounded numbers.
    """
    letters = np.frombuffer(block + b"\n" * 8, np.uint8)
    points = np.flatnonzero(letters == ord("."))
    if len(points) != 12 * len(starts):
        return None
    points = points.reshape(-1, 12)
    if not ((points[:, 0] >= starts).all() and (points[:, -1] < ends).all()):
        return None
    after = points + (_VERTEX_DECIMALS + 1)
    after[:, 9:] += _NORMAL_DECIMALS - _VERTEX_DECIMALS
    digits = (letters - np.uint8(ord("0"))) < 10
    spaces = letters <= ord(" ")
    if not (spaces[after].all() and digits[after[:, 9:] - 1].all()):
        return None
    if not _four_digits_follow(digits, points):
        return None
    whole = cast(NDArray[np.int64] | None, _parse(block.translate(None, b"."), np.int64))
    if whole is None or len(whole) != points.size or np.abs(whole).max() >= 2**53:
        return None
    table = whole.reshape(-1, 12)
    numbers = np.empty(table.shape)
    np.divide(table[:, :9], 10.0**_VERTEX_DECIMALS, out=numbers[:, :9])
    np.divide(table[:, 9:], 10.0**_NORMAL_DECIMALS, out=numbers[:, 9:])
    return numbers.ravel()


def _four_digits_follow(digits: NDArray[np.bool_], points: Indices) -> bool:
    four = digits[1:-3] & digits[2:-2] & digits[3:-1] & digits[4:]
    return bool(four[points].all())


def _parse_free(block: bytes, starts: Indices, rows: Indices, file: Path) -> tuple[Scalars, Indices]:
    """Parse rows of any layout and count the numbers of each."""
    spaces = np.frombuffer(b" " + block, np.uint8) <= ord(" ")
    begins = spaces[:-1] & ~spaces[1:]
    counts = np.add.reduceat(begins, starts, dtype=np.int64)
    values = cast(Scalars | None, _parse(block, np.float64))
    if values is None or len(values) != counts.sum() or not np.isfinite(values).all():
        _refuse(block, rows, file)
    return values + 0.0, counts  # + 0.0 turns -0.0 into 0.0


def _parse(block: bytes, kind: type[np.generic]) -> NDArray[Any] | None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # numpy's word for "this is not a number"
        try:
            return np.fromstring(block, dtype=kind, sep=" ")
        except (DeprecationWarning, ValueError):
            return None


def is_number(word: str) -> bool:
    """Whether a word is a finite decimal number."""
    return _NUMBER.fullmatch(word) is not None and math.isfinite(float(word))


def _refuse(block: bytes, rows: Indices, file: Path) -> NoReturn:
    texts = (line for line in block.split(b"\n") if not (line == b"" or line.isspace()))
    for row, line in zip(rows.tolist(), texts, strict=True):
        for word in line.decode(errors="replace").split():
            if not is_number(word):
                message = (
                    f"{word[:40]!r} stands where a finite number is expected. Correct it or export the board again."
                )
                raise BoardError(message, file=file, line=row + 1)
    raise BoardError("its numbers cannot be told apart. Put spaces between them.", file=file, line=int(rows[0]) + 1)
