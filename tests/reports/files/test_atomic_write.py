"""A file, or a folder of files, is written whole or stays what it was."""

import os
from pathlib import Path

import pytest
from command import contents

from reports.files.atomic_write import OutputError, write_bytes_atomically, write_files, write_text_atomically


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


ONE = {"demo.mod": "MODULE demo\n"}
SOME = {"demo.pgf": "list\n", "demo.mod": "main\n", "demo_01.mod": "part\n"}


def test_one_file_joins_what_is_in_its_folder(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    assert write_files(tmp_path, ONE) == [tmp_path / "demo.mod"]
    assert write_files(tmp_path / "made", ONE) == [tmp_path / "made" / "demo.mod"]
    assert set(contents(tmp_path)) == {"notes.txt", "demo.mod", "made/demo.mod"}


def test_several_files_make_a_folder_and_replace_their_like(tmp_path: Path) -> None:
    out = tmp_path / "demo"
    longer = {**SOME, "demo_02.mod": "more\n"}
    assert write_files(out, longer) == [out / name for name in longer]
    write_files(out, SOME)
    assert contents(tmp_path) == {f"demo/{name}": text.encode() for name, text in SOME.items()}


@pytest.mark.parametrize("name", ["thesis.txt", "demo.mod/x", "demo_1.bak"])
def test_a_folder_with_other_things_is_left_alone(tmp_path: Path, name: str) -> None:
    other = tmp_path / name
    other.parent.mkdir(exist_ok=True)
    other.write_text("mine")
    before = contents(tmp_path)
    with pytest.raises(OutputError, match="holds something else"):
        write_files(tmp_path, SOME)
    assert contents(tmp_path) == before


def test_several_files_do_not_go_into_a_file_or_into_nowhere(tmp_path: Path) -> None:
    file = tmp_path / "demo"
    file.write_text("mine")
    with pytest.raises(OutputError, match="Name a folder"):
        write_files(file, SOME)
    with pytest.raises(OutputError, match="Name a folder"):
        write_files(file, ONE)
    with pytest.raises(OutputError, match="no folder"):
        write_files(tmp_path / "no" / "where", SOME)
    assert contents(tmp_path) == {"demo": b"mine"}


def test_after_a_failure_the_old_files_stand(tmp_path: Path) -> None:
    out = tmp_path / "demo"
    write_files(out, SOME)
    before = contents(tmp_path)
    with pytest.raises(OutputError):
        write_files(out, {**SOME, "demo_03.mod": "größe"})
    assert contents(tmp_path) == before
