"""Files, names of samples, and what cannot be loaded."""

import os
from pathlib import Path

import pytest

from boards.errors import BoardError
from boards.load import board_library, find_board_file, load_board, stem_of
from boards.part.load import load_part

CUBE = [
    (0, 2, 6),
    (0, 6, 4),
    (1, 5, 7),
    (1, 7, 3),
    (0, 4, 5),
    (0, 5, 1),
    (2, 3, 7),
    (2, 7, 6),
    (0, 1, 3),
    (0, 3, 2),
    (4, 6, 7),
    (4, 7, 5),
]


def write_object(name: str, role: str, low: tuple[float, float, float], high: tuple[float, float, float]) -> str:
    corners = [tuple((low, high)[bit][axis] for axis, bit in enumerate(bits)) for bits in
               [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]]  # fmt: skip
    rows = [" ".join(f"{number:g}" for corner in face for number in corners[corner]) for face in CUBE]
    return f"object {name} surfaces 1 role={role}\nsurface 1 patches 12\n" + "\n".join(rows) + "\n"


BOARD = write_object("board", "board", (0, 0, 0), (50, 40, 1.6))
CHIP = write_object("R1", "component", (10, 10, 1.6), (12, 11, 2))
TEXT = "board-tri 1\nunits mm\nobjects 2\n" + BOARD + CHIP


def test_a_file_becomes_a_board_and_progress_is_told(tmp_path: Path) -> None:
    file = tmp_path / "my.board.tri"
    file.write_text(TEXT)
    told: list[tuple[str, float]] = []
    board = load_board(file, progress=lambda text, share: told.append((text, share)))
    assert (board.name, [one.name for one in board.components]) == ("my.board", ["R1"])
    assert [share for _, share in told] == sorted(share for _, share in told)
    assert (told[0][1], told[-1][1]) == (0.0, 1.0)


def test_findings_of_the_reader_stay_with_the_board(tmp_path: Path) -> None:
    file = tmp_path / "b.tri"
    file.write_text(TEXT.replace("patches 12\n", "patches 13\n0 0 0 1 1 1 2 2 2\n", 1))
    assert [finding.rule.id for finding in load_board(file).findings] == ["tri-degenerate"]


def test_what_is_wrong_with_the_board_names_its_file(tmp_path: Path) -> None:
    file = tmp_path / "b.tri"
    file.write_text(TEXT.replace("units mm", "units m"))
    with pytest.raises(BoardError, match="units mm") as caught:
        load_board(file)
    assert str(caught.value).startswith(f"{file}: ")


def test_the_samples_of_the_library_load_by_name() -> None:
    for name, file in board_library().items():
        assert find_board_file(Path(name)) == file
        assert stem_of(file) == name


def test_an_unknown_name_lists_the_samples() -> None:
    with pytest.raises(BoardError) as caught:
        load_board(Path("no-such-sample"))
    assert all(name in str(caught.value) for name in board_library())


def test_stems_drop_the_suffixes_of_the_format() -> None:
    assert [stem_of(Path(name)) for name in ("a/b.tri", "b.tri.gz", "b.kicad_pcb", "b.v2.step")] == [
        "b",
        "b",
        "b",
        "b.v2",
    ]


def test_what_cannot_be_loaded_is_said(tmp_path: Path) -> None:
    (tmp_path / "b.pdf").write_text("x")
    (tmp_path / "dir.tri").mkdir()
    for file, words in (
        (tmp_path / "none.tri", "no such file"),
        (tmp_path / "b.pdf", ".kicad_pcb"),
        (tmp_path / "dir.tri", "directory"),
    ):
        with pytest.raises(BoardError) as caught:
            load_board(file)
        assert words in str(caught.value)
        assert str(caught.value).startswith(str(file))


def test_a_file_that_is_too_large_is_not_opened(tmp_path: Path) -> None:
    file = tmp_path / "huge.tri"
    with file.open("wb") as sparse:
        sparse.truncate(3_000_000_000)
    with pytest.raises(BoardError, match="at most 2,000,000,000"):
        load_board(file)


def test_a_file_without_permission_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "secret.tri"
    file.write_text(TEXT)

    def refuse(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "open", refuse)  # root, who may run the tests, can open everything
    with pytest.raises(BoardError, match="cannot be read: Permission denied"):
        load_board(file)


@pytest.mark.parametrize("name", ["n" * 300 + ".tri", "n" * 300, "n" * 300 + "/x.obj"])
def test_a_name_that_no_file_can_have_is_an_error_of_the_board_that_names_it(name: str, tmp_path: Path) -> None:
    with pytest.raises(BoardError, match=r"n{300}.*: cannot be read: File name too long"):
        load_board(Path(name))
    (tmp_path / "part.yaml").write_text(f"part: p\nbody: {{file: {name.removesuffix('.tri')}.obj}}\n")
    with pytest.raises(BoardError, match=r"part\.yaml:2: body\.file: n{300}.*: cannot be read: File name too long"):
        load_part(tmp_path / "part.yaml")
