"""The text of a ``.tri`` file: its bytes, its record lines, and its numbers in bulk."""

import gzip
import io
import math
import re
import warnings
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from boards.errors import MAX_BYTES, BoardError, Line, read_bytes
from geometry.arrays import Indices, Scalars

_SMALL_BYTES = 10_000_000
_MOST_TIMES = 100
_UNPACKED_CHUNK = 1 << 20
_CHUNK_LINES = 4096  # a block stays in the cache
_BLANK_STARTS = np.isin(np.arange(256), np.frombuffer(b" \t", np.uint8))
_NUMERIC_STARTS = np.isin(np.arange(256), np.frombuffer(b"0123456789+-.", np.uint8))
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_TOKEN = re.compile(r'([^\s"#]*"[^"]*"|[^\s"#]+)(?=[\s#]|$)|#.*|\s+')
_COMMENT = re.compile(rb"#[^\n]*")
_DECIMALS = np.tile(np.array([4] * 9 + [5] * 3), _CHUNK_LINES)
_SCALES = 10.0**_DECIMALS
_POINTS = _DECIMALS + 1  # from a point to the blank behind its number


@dataclass(frozen=True, slots=True)
class Record(Line):
    """A line that begins with a word."""

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
    last: Line


def read_text(file: Path) -> bytes:
    """Return the plain UTF-8 bytes of a file, unpacked if its name ends with ``.gz``; every line ends with a line feed.

    Raises:
        BoardError: The file cannot be read, is empty, too large, truncated or not UTF-8.
    """
    text = read_bytes(file)
    if file.suffix.lower() == ".gz":
        text = _unpack(text, file)
    if not text.isascii():
        text = text.removeprefix(b"\xef\xbb\xbf")
        try:
            text.decode()
        except UnicodeDecodeError as error:
            line = text.count(b"\n", 0, error.start) + 1
            raise BoardError("is not UTF-8 text. Save the board as UTF-8.", file=file, line=line) from None
    if b"\r" in text:
        text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if not text or text.isspace():
        raise BoardError("is empty. A board file begins with 'board-tri 1'.", file=file)
    return text if text.endswith(b"\n") else text + b"\n"


def _unpack(packed: bytes, file: Path) -> bytes:
    """Unpack a board; what has more than 10 MB and a hundred times its packed size is none, and would fill the memory.

    Raises:
        BoardError: It is damaged, or too large.
    """
    most = min(MAX_BYTES, max(_SMALL_BYTES, _MOST_TIMES * len(packed)))
    parts: list[bytes] = []
    total = 0
    try:
        with gzip.open(io.BytesIO(packed)) as stream:
            while part := stream.read(_UNPACKED_CHUNK):
                parts.append(part)
                total += len(part)
                if total > most:
                    message = f"unpacks from {len(packed):,} to more than {most:,} bytes: that is no board"
                    raise BoardError(f"{message}. Pack the board file itself.", file=file)
    except (EOFError, gzip.BadGzipFile, zlib.error):
        raise BoardError("damaged gzip file, or cut short. Pack or copy it again.", file=file) from None
    return b"".join(parts)


def cut(text: bytes, file: Path) -> Content:
    """Cut a text into records and numbers, the numbers in bulk.

    Raises:
        BoardError: A quote is not closed, or something that is not a finite number stands in a line of numbers.
    """
    letters = np.frombuffer(text, np.uint8)
    step = 1 << 18  # what fits the cache is searched several times faster
    blocks = range(0, len(letters), step)
    ends = np.concatenate([np.flatnonzero(letters[begin : begin + step] == ord("\n")) + begin for begin in blocks])
    starts = np.concatenate(([0], ends[:-1] + 1))
    first = starts.copy()
    while (blank := _BLANK_STARTS[letters[first]]).any():
        first[blank] += 1
    numeric = _NUMERIC_STARTS[letters[first]]
    rows = np.flatnonzero(numeric)
    others = np.flatnonzero(~numeric & (first < ends))
    places = zip(
        *(some.tolist() for some in (others, first[others], ends[others], np.cumsum(numeric)[others])), strict=True
    )
    records: list[Record] = []
    for line, begin, end, rows_before in places:
        tokens = _split(text[begin:end].decode(), Line(file, line + 1))
        if tokens:
            records.append(Record(file, line + 1, tokens, rows_before))
    if not records and not len(rows):
        raise BoardError("holds comments only. A board file begins with 'board-tri 1'.", file=file)
    return Content(tuple(records), _read_rows(text, starts, ends, rows, file), Line(file, len(ends)))


def _split(line: str, where: Line) -> tuple[str, ...]:
    if '"' not in line:
        return tuple(line.partition("#")[0].split())
    tokens: list[str] = []
    place = 0
    while place < len(line):
        match = _TOKEN.match(line, place)
        if match is None:
            raise where.error(f"a quote is not closed, or stands inside a word: {line[place:][:40]}")
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
        lengths = ends[some] - starts[some] + 1
        # Lines of numbers one after the other, without the records between them; comments become blanks.
        breaks = np.flatnonzero(starts[some][1:] != ends[some][:-1] + 1)
        begins = [int(starts[some[0]]), *starts[some][breaks + 1].tolist()]
        stops = [*(ends[some][breaks] + 1).tolist(), int(ends[some[-1]]) + 1]
        block = b"".join([text[first:stop] for first, stop in zip(begins, stops, strict=True)])
        if b"#" in block:
            block = _COMMENT.sub(lambda comment: b" " * len(comment[0]), block)
        room = values[place : place + 12 * len(some)]
        if len(room) == 12 * len(some) and _parse_fixed(block, lengths, room):
            place += len(room)
            continue
        chunk, counts[begin : begin + len(some)] = _parse_free(block, np.cumsum(lengths) - lengths, some, file)
        if place + len(chunk) > len(values):
            values = np.concatenate((values[:place], np.empty(len(chunk) + len(values))))
        values[place : place + len(chunk)] = chunk
        place += len(chunk)
    return Numbers(values[:place], counts, rows + 1)


def _parse_fixed(block: bytes, lengths: Indices, numbers: NDArray[np.float64]) -> bool:
    """Parse rows as our writer lays them out, 9 numbers with 4 decimals and 3 with 5; ``False`` for any other layout.

    Without its points such a text is integers, which numpy reads three times faster; divided by a power of ten they
    are the correctly rounded numbers. As many blanks as numbers and as points, and before each blank a point at its
    distance and no other blank nearer than that, leave room for nothing else.

    Args:
        block: Lines of numbers and nothing between them.
        lengths: (n,) bytes in each line with its line feed.
        numbers: (12 n,) is filled.
    """
    letters = np.frombuffer(block, np.uint8)
    blanks = np.flatnonzero(letters <= ord(" "))
    whole_text = block.translate(None, b".")
    if not (len(blanks) == len(numbers) == len(block) - len(whole_text)):
        return False
    if min(blanks[0] + 1, (blanks[1:] - blanks[:-1]).min()) <= _POINTS[0]:
        return False
    if (letters.take(blanks - _POINTS[: len(blanks)]) != ord(".")).any():
        return False
    if (blanks[11::12] != np.cumsum(lengths) - 1).any():
        return False
    whole = _parse(whole_text, np.int64)
    if whole is None or len(whole) != len(numbers) or max(whole.max(), -whole.min()) >= 2**53:
        return False
    np.divide(whole, _SCALES[: len(whole)], out=numbers)
    return True


def _parse_free(block: bytes, starts: Indices, rows: Indices, file: Path) -> tuple[Scalars, Indices]:
    """Parse rows of any layout and count the numbers of each."""
    spaces = np.frombuffer(b" " + block, np.uint8) <= ord(" ")
    begins = spaces[:-1] & ~spaces[1:]
    counts = np.add.reduceat(begins, starts, dtype=np.int64)
    values = _parse(block, np.float64)
    if values is None or len(values) != counts.sum() or not np.isfinite(values).all():
        texts = (line for line in block.split(b"\n") if line.strip())
        for row, line in zip(rows.tolist(), texts, strict=True):
            for word in line.decode(errors="replace").split():
                if not is_number(word):
                    message = f"{word[:40]!r} stands where a finite number is expected. "
                    raise Line(file, row + 1).error(f"{message}Correct it or export the board again.")
        raise Line(file, int(rows[0]) + 1).error("its numbers are not separated. Put spaces between them.")
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
