"""A file is written whole or stays what it was."""

import os
from pathlib import Path

import pytest

from reports.files.atomic_write import OutputError, write_bytes_atomically, write_text_atomically


def test_the_text_arrives_byte_for_byte_and_nothing_else_stays(tmp_path: Path) -> None:
    file = tmp_path / "a.wash"
    write_text_atomically(file, "1 µm\r\n2\n")
    write_text_atomically(file, "é\n")
    assert file.read_bytes() == "é\n".encode()
    assert list(tmp_path.iterdir()) == [file]


def test_the_rights_of_a_file_that_is_replaced_are_kept(tmp_path: Path) -> None:
    file = tmp_path / "a"
    file.write_text("old")
    file.chmod(0o640)
    write_text_atomically(file, "new")
    assert file.stat().st_mode & 0o777 == 0o640


def test_a_link_is_followed(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "file")
    write_bytes_atomically(tmp_path / "link", b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "file").read_bytes() == b"new"


def test_after_a_failure_the_old_file_still_stands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    file = tmp_path / "a"
    file.write_text("old")
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OutputError, match="No space left"):
        write_text_atomically(file, "new")
    assert file.read_text() == "old"
    assert list(tmp_path.iterdir()) == [file]


def test_places_that_cannot_be_written(tmp_path: Path) -> None:
    for place in (tmp_path, tmp_path / "none" / "a", tmp_path / "a\0b"):
        with pytest.raises(OutputError, match="cannot be written"):
            write_text_atomically(place, "x")


def test_the_error_says_what_to_do() -> None:
    assert str(OutputError(Path("a"), "it is a folder")) == "a: cannot be written: it is a folder. Name another place."
    assert str(OutputError(Path("a"), "why", "Do this.")).endswith("why. Do this.")


def test_a_device_is_written_directly() -> None:
    write_text_atomically(Path(os.devnull), "x")
    assert not Path(os.devnull).is_file()
