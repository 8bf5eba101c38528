from pathlib import Path

import pytest
from small_programs import hand_program

from programs import load, native
from programs.errors import ProgramError
from programs.load import load_program

HAND = native.render(hand_program())


def test_a_file_is_read(tmp_path: Path) -> None:
    path = tmp_path / "a.wash"
    path.write_text(HAND)
    assert native.render(load_program(path)) == HAND


def test_a_byte_order_mark_is_no_part_of_the_program(tmp_path: Path) -> None:
    path = tmp_path / "a.wash"
    path.write_bytes(b"\xef\xbb\xbf" + HAND.encode())
    assert native.render(load_program(path)) == HAND


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "a.wash:1: this is not a Washboard program"),
        (b"WASHBOARD 1\nUNITS mm s\nFRAME b\xff\n", "a.wash:3: this is not UTF-8 text"),
        (HAND.encode()[:-5], "ends without END"),
    ],
)
def test_a_bad_file_is_one_clear_error(tmp_path: Path, data: bytes, message: str) -> None:
    path = tmp_path / "a.wash"
    path.write_bytes(data)
    with pytest.raises(ProgramError) as caught:
        load_program(path)
    assert message in str(caught.value)


def test_no_file_and_a_folder(tmp_path: Path) -> None:
    with pytest.raises(ProgramError, match="no such file"):
        load_program(tmp_path / "none.wash")
    with pytest.raises(ProgramError, match="folder"):
        load_program(tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(ProgramError, match="cannot be read"):
        load_program(tmp_path / "file" / "a.wash")


def test_an_enormous_file_is_not_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.wash"
    path.write_text(HAND)
    monkeypatch.setattr(load, "LARGEST_BYTES", 100)
    with pytest.raises(ProgramError, match="at most 100"):
        load_program(path)
