"""Files are read without waiting, and names are printed on one line."""

import errno
import io
import os
import socket
from pathlib import Path

import pytest

from specs.errors import JobError, LocatedError, printable
from specs.input_file import InputFile

MOST = 3_000_000


def read(file: Path) -> bytes:
    return InputFile(file, LocatedError, "recipe", MOST).read()


@pytest.mark.parametrize("size", [0, 1, MOST])
def test_a_file_is_read_as_a_whole(size: int, tmp_path: Path) -> None:
    content = os.urandom(size)
    (tmp_path / "a").write_bytes(content)
    (tmp_path / "link").symlink_to("a")
    assert read(tmp_path / "a") == read(tmp_path / "link") == content


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("directory", "is a directory, not a file; give the path of a recipe"),
        ("pipe", "is a pipe, not a file; save its content"),
        ("device", "is a device, not a file; save its content"),
        ("socket", "is a socket, not a file; save its content"),
        ("large", "3,000,001 bytes are too many; a recipe has at most 3,000,000"),
        ("nothing", "no such file; give the path of a recipe"),
        ("circle", "cannot be read: Too many levels of symbolic links"),
        ("a\0b", "cannot be read: embedded null byte"),
    ],
)
def test_what_is_no_file_is_refused_at_once(kind: str, words: str, tmp_path: Path) -> None:
    place = tmp_path / kind
    match kind:
        case "directory":
            place.mkdir()
        case "pipe":
            os.mkfifo(place)
        case "device":
            place.symlink_to("/dev/zero")
        case "socket":
            with socket.socket(socket.AF_UNIX) as each:
                each.bind(str(place))
        case "large":
            place.write_bytes(b"0" * (MOST + 1))
        case "circle":
            place.symlink_to(place)
        case _:
            pass
    for use in (read, lambda file: InputFile(file, LocatedError, "recipe", MOST).check()):
        with pytest.raises(LocatedError) as caught:
            use(place)
        assert str(caught.value).startswith(f"{printable(str(place))}: {words}")


def test_a_file_that_grows_is_read_to_the_bound() -> None:
    """Files of the kernel state a size of 0 and have content all the same."""
    assert read(Path("/proc/self/status")).startswith(b"Name:")
    with pytest.raises(LocatedError, match="too many"):
        InputFile(Path("/proc/self/status"), LocatedError, "recipe", 10).read()


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("Leiterplatte 3 µ.tri", "Leiterplatte 3 µ.tri"),
        ("a\nerror: b", "a\\nerror: b"),
        ("\x1b[2J", "\\x1b[2J"),
        (os.fsdecode(b"caf\xe9"), "caf\\xe9"),
        ("a\u2028b\u202eb", "a\\u2028b\\u202eb"),
        ("a\\nb", "a\\nb"),
    ],
)
def test_what_breaks_a_line_is_escaped(text: str, shown: str) -> None:
    assert printable(text) == shown
    assert printable(shown) == shown
    assert str(LocatedError("is not", file=Path(text), line=2)) == f"{shown}:2: is not"
    assert LocatedError("is not", file=Path(text)).file == Path(text)


def test_a_long_place_in_a_file_is_shortened_and_the_message_stays() -> None:
    error = LocatedError("is missing", path="a." * 3000 + "b\x1b[2J", file="r.yaml", line=2)
    assert error.path.startswith("a.a.")
    assert len(str(error)) < 400
    assert str(error).isprintable()
    assert str(error).startswith("r.yaml:2: a.a.")
    assert str(error).endswith(".a.b\\x1b[2J: is missing")


def test_a_beginning_that_cannot_be_read_names_its_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Broken(io.FileIO):
        def readinto(self, buffer: object, /) -> int:
            raise OSError(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr("specs.input_file.io.FileIO", Broken)
    (tmp_path / "a.yaml").write_text("panel:")
    with pytest.raises(JobError, match=r"a\.yaml: cannot be read: Input/output error"):
        InputFile(tmp_path / "a.yaml").head(10)


def test_a_beginning_that_cannot_be_opened_is_no_other_kind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: object, flags: int) -> int:
        raise OSError(errno.EMFILE, os.strerror(errno.EMFILE))

    (tmp_path / "a.yaml").write_text("panel:")
    assert InputFile(tmp_path).head(10) == InputFile(tmp_path / "b.yaml").head(10) == b""
    monkeypatch.setattr(os, "open", refuse)
    with pytest.raises(JobError, match=r"a\.yaml: cannot be read: Too many open files"):
        InputFile(tmp_path / "a.yaml").head(10)
