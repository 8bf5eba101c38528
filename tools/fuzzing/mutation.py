"""Seeded mutation of valid files: numbers, words, lines, bytes, nesting, length."""

import random
import re
import struct
from collections.abc import Callable

_NUMBER = re.compile(rb"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
_WORD = re.compile(rb"[^\s,;:=()<>{}\[\]\"']+")
_EXTREME = (
    *(b"0", b"-0", b"-1", b"1e308", b"-1e308", b"1e300", b"1e30", b"1e15", b"-1e11", b"1e9", b"99999999999", b"1e8"),
    *(b"24332001.99", b"123456.7", b"9999.5", b"1e4", b"1e-7", b"1e-308", b"5e-324", b"nan", b"inf", b"-inf", b"1e999"),
    *(b"NaN", b"2147483647", b"-2147483648", b"4294967295", b"18446744073709551616", b"9" * 400, b"9" * 5000, b"0x10"),
    *(b"1_000", b"1e", b".", b"-", b"", b"1,5", "٣".encode(), b"true", b"null", b"360", b"-360", b"1e5deg"),
)
_ODD = (
    *(b"", b"\0", b"\xff\xfe", b"\xed\xb2\x80", b"\x1b[2J", "\u202e".encode(), "\u2028".encode(), b"A" * 100_000),
    *(
        b"../../etc/passwd",
        b"/dev/zero",
        b"%s%n",
        b"$(id)",
        b"'",
        b'"',
        b"''''",
        b"~",
        b"#",
        b"*a",
        b"&a",
        b"<<",
        b"!!x",
    ),
    *("ß" * 50).encode().split(b"|"),
)
_BRACKETS = (b"(", b")", b"[", b"{", b"<a>", b"- ", b"[[", b"((", b'"', b"&a [*a", b"?")
_PIECES = (
    *(
        b'\\"',
        b'"',
        b"'",
        b"\\",
        b"(",
        b")",
        b"[",
        b"]",
        b"{",
        b"}",
        b"<",
        b">",
        b"<!--",
        b",",
        b";",
        b":",
        b"\n",
        b" ",
    ),
    *(b"\t", b"*", b"#", b"//", b"%", b"$", b"&", b"-", b".", b"0", b"1 ", b"a", b"a,", b"a\n", b"=", b"\n\n", b"\r"),
)
_AMPLIFIED = 60_000
"""Bytes."""
_LONGEST = 3_000_000
"""Bytes of a file, at each of its changes too."""
_ADDED, _LONG = 4000, 0.03
"""Changes that add more than these bytes take a reader a hundred times as long: only this share of them is made."""
_FLOATS = (float("inf"), float("nan"), 1e30, -1e30, 1e8, 1e-38, 0.0, -0.0)
_INTEGERS = (0, 1, 2, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0xFFFF, 255)


def mutate(data: bytes, others: tuple[bytes, ...], rng: random.Random) -> bytes:
    """Change a file in one to five places; ``others`` are valid files of the same kind, for splices."""
    usual = 2 * len(data) + _ADDED
    for _ in range(rng.choice((1, 1, 1, 2, 2, 3, 5))):
        text = b"\0" not in data[:2000]
        changed = rng.choice(_OF_TEXT if text else _OF_BYTES)(data, rng)
        data = changed if len(changed) <= usual or rng.random() < _LONG else data
        if rng.random() < 0.03:
            other = rng.choice(others)
            data = data[: rng.randint(0, len(data))] + other[rng.randint(0, len(other)) :]
        data = data[:_LONGEST]
    return data


def _number(data: bytes, rng: random.Random) -> bytes:
    return _replace(data, _NUMBER, lambda _: rng.choice(_EXTREME), rng)


def _scale(data: bytes, rng: random.Random) -> bytes:
    def scaled(word: bytes) -> bytes:
        value = float(word) * rng.choice((-1.0, 10.0, 0.1, 1000.0, 1e-3, 1.0001, 1e6, 1e12))
        return f"{value:.6g}".encode()

    return _replace(data, _NUMBER, scaled, rng)


def _word(data: bytes, rng: random.Random) -> bytes:
    words = _WORD.findall(data[: 1 << 16])
    return _replace(data, _WORD, lambda _: rng.choice(words or [b""]) if rng.random() < 0.6 else rng.choice(_ODD), rng)


def _replace(data: bytes, pattern: re.Pattern[bytes], change: Callable[[bytes], bytes], rng: random.Random) -> bytes:
    """Change one match, or every match that equals it where that does not become too long."""
    start = rng.randint(0, max(len(data) - 1, 0))
    found = pattern.search(data, start) or pattern.search(data)
    if found is None:
        return data
    new = change(found[0])
    if rng.random() < 0.15 and data.count(found[0]) * len(new) < _LONGEST:
        return data.replace(found[0], new)
    return data[: found.start()] + new + data[found.end() :]


def _lines(data: bytes, rng: random.Random) -> bytes:
    lines = data.splitlines(keepends=True)
    if not lines:
        return data
    at, count = rng.randrange(len(lines)), rng.choice((1, 1, 1, 2, 5, 20))
    some = lines[at : at + count]
    match rng.choice(("drop", "double", "move", "shuffle", "repeat")):
        case "drop":
            lines[at : at + count] = []
        case "double":
            lines[at:at] = some
        case "move":
            lines[at : at + count] = []
            place = rng.randint(0, len(lines))
            lines[place:place] = some
        case "shuffle":
            rng.shuffle(some)
            lines[at : at + count] = some
        case _:
            lines[at:at] = some * rng.choice((10, 10, 10, 100, 100, 1000))
    return b"".join(lines)


def _nest(data: bytes, rng: random.Random) -> bytes:
    at = rng.randint(0, len(data))
    return data[:at] + rng.choice(_BRACKETS) * rng.choice((1, 1, 2, 2, 10, 10, 200, 200, 5000, 100_000)) + data[at:]


def _amplify(data: bytes, rng: random.Random) -> bytes:
    """Repeat a few bytes until they are many: what a reader does with each of them to the end shows."""
    at = rng.randint(0, len(data))
    piece = data[at : at + rng.choice((1, 2, 4, 10, 40))] if rng.random() < 0.6 else b"".join(rng.choices(_PIECES, k=2))
    return data[:at] + piece * (_AMPLIFIED // max(len(piece), 1)) + data[at:]


def _cut(data: bytes, rng: random.Random) -> bytes:
    at = rng.randint(0, len(data))
    return data[:at] if rng.random() < 0.5 else data[at:] if rng.random() < 0.2 else data[:at] + data[at + 50 :]


def _byte(data: bytes, rng: random.Random) -> bytes:
    if not data:
        return b"\0"
    at = rng.randrange(len(data))
    new = rng.choice((bytes([rng.randrange(256)]), b"", rng.randbytes(rng.choice((1, 4, 40))), b"\n", b" ", b"\0"))
    return data[:at] + new + data[at + rng.choice((0, 1, 1, 4)) :]


def _binary(data: bytes, rng: random.Random) -> bytes:
    """Replace four bytes by an extreme number of floating point, or a count."""
    if len(data) < 8:
        return data
    at = rng.randrange(len(data) - 4)
    at -= at % rng.choice((1, 2, 4))
    real = rng.random() < 0.5
    new = struct.pack("<f", rng.choice(_FLOATS)) if real else struct.pack("<I", rng.choice(_INTEGERS))
    return data[:at] + new + data[at + 4 :]


_OF_TEXT = (_number, _number, _number, _number, _scale, _scale, _word, _word, _lines, _lines, _nest, _cut, _byte,
            _amplify)  # fmt: skip
_OF_BYTES = (_binary, _binary, _binary, _byte, _byte, _number, _word, _cut, _nest)


def odd_word(rng: random.Random) -> str:
    """Give a word that nobody would give, as an argument of a command can be: without the byte 0."""
    return rng.choice((*_EXTREME, *_ODD)).decode("utf-8", "surrogateescape").replace("\0", "")
