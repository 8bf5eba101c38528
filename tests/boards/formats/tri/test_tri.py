"""The board file: what is written is read back, and what is wrong is said with its line."""

import gzip
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from boards.board import Body, Surface
from boards.errors import BoardError
from boards.formats.tri.tri import read_tri, write_tri

SMALL = """\
# a board and a part
board-tri 1
units mm
objects 2
object board surfaces 1 role=board
surface 1 patches 2
0 0 0  10 0 0  10 8 0  0 0 1
0 0 0  10 8 0  0 8 0   0 0 1   # a comment

object U1 surfaces 2 role=component package="SOIC-8 3.9x4.9" pins=8 side=top standoff=0.1 x-note=kept
surface top patches 1
\t1 1 2 2 1 2 2 2 2 0 0 1
  # another comment
surface walls patches 1
1 1 2 1 2 0 1 2 2 1 0 0
"""

LEGACY = "2\n1\n2\n0 0 0 10 0 0 10 8 0\n0 0 0 10 8 0 0 8 0\n1\n1\n1 1 2 2 1 2 2 2 2\n"


def read(folder: Path, text: str | bytes, name: str = "b.tri") -> tuple[tuple[Body, ...], tuple[str, ...]]:
    file = folder / name
    file.write_bytes(text.encode() if isinstance(text, str) else text)
    bodies, findings = read_tri(file)
    return bodies, tuple(finding.rule.id for finding in findings)


def refuse(folder: Path, text: str | bytes, name: str = "b.tri") -> BoardError:
    with pytest.raises(BoardError) as caught:
        read(folder, text, name)
    assert str(caught.value).startswith(str(folder / name))
    return caught.value


def test_everything_a_file_states_is_kept(tmp_path: Path) -> None:
    (board, part), rules = read(tmp_path, SMALL)
    assert rules == ()
    assert (board.name, board.role, part.role) == ("board", "board", "component")
    assert part.surfaces == (Surface("top", 1), Surface("walls", 1))
    assert (part.package, part.pins, part.side, part.gap_height_mm) == ("SOIC-8 3.9x4.9", 8, "top", 0.1)
    assert part.extra == (("x-note", "kept"),)
    np.testing.assert_array_equal(board.patches[1], [[0, 0, 0], [10, 8, 0], [0, 8, 0]])
    np.testing.assert_array_equal(part.normals[1], [1, 0, 0])


def test_what_is_written_reads_back_and_writes_the_same(tmp_path: Path) -> None:
    bodies, _ = read(tmp_path, SMALL)
    text = write_tri(bodies)
    again, rules = read(tmp_path, text)
    assert write_tri(again) == text
    assert rules == ()
    for one, other in zip(bodies, again, strict=True):
        np.testing.assert_array_equal(one.patches, other.patches)
        assert (one.name, one.package, one.extra, one.surfaces) == (
            other.name,
            other.package,
            other.extra,
            other.surfaces,
        )


def test_packed_files_hold_the_same_board(tmp_path: Path) -> None:
    plain, _ = read(tmp_path, SMALL)
    packed, _ = read(tmp_path, gzip.compress(SMALL.encode()), "b.tri.gz")
    assert write_tri(packed) == write_tri(plain)


@pytest.mark.parametrize(("unit", "factor"), [("mm", 1.0), ("m", 1000.0), ("in", 25.4)])
def test_units_become_millimetres(tmp_path: Path, unit: str, factor: float) -> None:
    (board, part), _ = read(tmp_path, SMALL.replace("units mm", f"units {unit}"))
    assert np.ptp(board.patches[:, :, 0]) == pytest.approx(10.0 * factor)
    assert part.gap_height_mm == pytest.approx(0.1 * factor)
    assert np.linalg.norm(part.normals, axis=1) == pytest.approx(1.0)


def test_line_ends_and_byte_order_marks_do_not_matter(tmp_path: Path) -> None:
    plain, _ = read(tmp_path, SMALL)
    for text in (SMALL.replace("\n", "\r\n"), "\ufeff" + SMALL, SMALL.rstrip("\n"), SMALL.replace("\n", "\n\n# ü\n")):
        assert write_tri(read(tmp_path, text)[0]) == write_tri(plain)


def test_the_bulk_reader_and_the_free_reader_agree(tmp_path: Path) -> None:
    numbers = np.random.default_rng(5).uniform(-200, 200, (500, 3, 3))
    body = _body("board", "board", numbers)
    text = write_tri([body])
    fixed, _ = read(tmp_path, text)
    free, _ = read(tmp_path, text.replace(" 0.", " +0."))  # a plus sign is not what the writer writes
    loose, _ = read(tmp_path, text.replace("surface 1 patches 500\n", "surface 1 patches 500\n#\n"))
    np.testing.assert_array_equal(fixed[0].patches, np.round(numbers, 4))
    np.testing.assert_array_equal(free[0].patches, fixed[0].patches)
    np.testing.assert_array_equal(loose[0].normals, fixed[0].normals)


@settings(max_examples=40)
@given(st.lists(st.lists(st.floats(-500, 500), min_size=9, max_size=9), min_size=1, max_size=6), st.sampled_from("efg"))
def test_any_numbers_are_read_as_python_reads_them(tmp_path: Path, rows: list[list[float]], style: str) -> None:
    # The corners of the second patch are a real triangle, so that the object keeps something.
    lines = [" ".join(format(number, f".7{style}") for number in row) for row in [*rows, [0, 0, 0, 5, 0, 0, 5, 5, 0]]]
    text = f"board-tri 1\nunits mm\nobjects 1\nobject b surfaces 1 role=board\nsurface 1 patches {len(lines)}\n"
    (board,), _ = read(tmp_path, text + "\n".join(lines) + "\n")
    wanted = np.array([[float(word) for word in line.split()] for line in lines]).reshape(-1, 3, 3)
    kept = {patch.tobytes() for patch in wanted + 0.0}
    assert all(patch.tobytes() in kept for patch in board.patches)
    np.testing.assert_array_equal(board.patches[-1], wanted[-1])


@pytest.mark.parametrize(
    "wrong", ["1.2.34 5", "1..000  2-3.0000", "1.0000 2..000", "1.0000 -.-000", "1.0000  2.0000 3.0000"]
)
def test_what_only_resembles_our_own_layout_is_not_taken_for_it(tmp_path: Path, wrong: str) -> None:
    text = write_tri([_body("board", "board", np.eye(3)[None] * 9)])
    assert "9.0000 0.0000" in text
    damaged = text.replace("9.0000 0.0000", wrong, 1)
    assert refuse(tmp_path, damaged).line == 6


def test_numbers_alone_are_the_legacy_layout(tmp_path: Path) -> None:
    (board, part), rules = read(tmp_path, LEGACY)
    assert (board.name, board.role, part.name, part.role) == ("object-1", "board", "object-2", "component")
    assert rules == ("tri-legacy",)
    np.testing.assert_allclose(part.normals, [[0, 0, 1]])


def test_the_legacy_board_is_the_largest_in_plan(tmp_path: Path) -> None:
    swapped = "2\n1\n1\n1 1 2 2 1 2 2 2 2 0 0 1\n1\n1\n0 0 0 10 0 0 10 8 0 0 0 1\n"
    (part, board), _ = read(tmp_path, swapped)
    assert (part.role, board.role) == ("component", "board")


def test_the_legacy_layout_may_break_lines_anywhere(tmp_path: Path) -> None:
    text = "1 1 2 0 0 0 10 0 0 10 8 0 0 0 1 0 0 0 10 8 0 0 8 0 0 0 1"
    wide, _ = read(tmp_path, text)
    narrow, _ = read(tmp_path, text.replace(" ", "\n"))
    assert write_tri(wide) == write_tri(narrow)
    assert len(wide[0].patches) == 2


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (LEGACY + "5\n", 9, "left over"),
        (LEGACY.replace("2\n1\n2\n", "2\n1\n3\n", 1), 6, "1 numbers where patch 3 of 3"),
        (LEGACY.replace("0 0 0 10 8 0 0 8 0", "0 0 0 10 8 0 0 8"), 5, "8 numbers"),
        (LEGACY.replace("2\n1\n2\n", "2\n1.5\n2\n", 1), 2, "surfaces of object-1"),
        ("2\n1\n", 2, "ends where"),
        ("0\n", 1, "no objects"),
    ],
)
def test_a_wrong_legacy_file_is_refused_with_its_line(tmp_path: Path, text: str, line: int, words: str) -> None:
    error = refuse(tmp_path, text)
    assert (error.line, words in str(error)) == (line, True), str(error)


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("board-tri 1", "board-tri 2", 2, "version 1"),
        ("board-tri 1", "circuit 1", 2, "'board-tri 1'"),
        ("units mm", "units furlong", 3, "mm, m or in"),
        ("units mm\n", "", 4, "units mm"),
        ("objects 2\n", "", 4, "objects N"),
        ("objects 2", "objects 3", 15, "'objects 3'"),
        ("objects 2", "objects 1", 10, "one object more"),
        ("objects 2", "objects two", 4, "expected a count"),
        ("surfaces 1 role", "surfaces 2 role", 10, "2 surfaces"),
        ("surfaces 2 role", "surfaces 1 role", 14, "one surface more"),
        ("surfaces 2 role", "surfaces 3 role", 15, "3 surfaces"),
        ("patches 2", "patches 3", 10, "only 2 follow"),
        ("patches 2", "patches 1", 8, "one patch more"),
        ("patches 2", "patches -2", 6, "expected a count"),
        ("walls patches 1", "walls patches 2", 15, "only 1 follow"),
        ("10 8 0  0 0 1", "10 8 0  0 0", 7, "11 numbers"),
        ("10 8 0  0 0 1", "10 8 zero  0 0 1", 7, "'zero'"),
        ("10 8 0  0 0 1", "10 8 nan  0 0 1", 7, "'nan'"),
        ("0 0 0  10 0 0", "nan 0 0  10 0 0", 7, "'nan'"),
        ("10 8 0  0 0 1", "10 8 1e999  0 0 1", 7, "'1e999'"),
        ("10 8 0  0 0 1", "10 8 1e8  0 0 1", 7, "1 km"),
        ("10 8 0  0 0 1", "10 8-0  0 0 1", 7, "'8-0'"),
        ("object U1", "object board", 10, "stands already in line 5"),
        ("role=component", "role=board", 10, "a second board"),
        ("role=board", "role=component", None, "role=board"),
        ("role=component", "role=part", 10, "component"),
        ("role=component ", "", 10, "no role"),
        ("package=", "packge=", 10, "'package'"),
        ("pins=8", "pins=8.5", 10, "expected a count"),
        ("pins=8", "pins=8 pins=9", 10, "twice"),
        ("side=top", "side=up", 10, "top or bottom"),
        ("standoff=0.1", "standoff=-1", 10, "≥ 0"),
        ("standoff=0.1", "standoff=nan", 10, "≥ 0"),
        ("x-note=kept", "x-note", 10, "key=value"),
        ('4.9"', "4.9", 10, "quote"),
        ("surface walls", "surfce walls", 14, "'surface'"),
        ("object board", "7 8 9\nobject board", 5, "numbers where"),
    ],
)
def test_a_wrong_file_is_refused_with_its_line(
    tmp_path: Path, old: str, new: str, line: int | None, words: str
) -> None:
    assert SMALL.count(old) >= 1
    error = refuse(tmp_path, SMALL.replace(old, new, 1))
    assert words in str(error)
    assert error.line == line, str(error)


def test_what_is_no_text_is_refused(tmp_path: Path) -> None:
    assert "empty" in str(refuse(tmp_path, ""))
    assert "empty" in str(refuse(tmp_path, "\n \n"))
    assert "board-tri 1" in str(refuse(tmp_path, "# only a comment\n"))
    assert refuse(tmp_path, SMALL.encode().replace(b"U1", b"U\xff")).line == 10
    packed = gzip.compress(SMALL.encode())
    assert "gzip" in str(refuse(tmp_path, packed[:-12], "b.tri.gz"))
    assert "gzip" in str(refuse(tmp_path, SMALL, "b.tri.gz"))
    with pytest.raises(BoardError, match="directory"):
        read_tri(tmp_path)
    with pytest.raises(BoardError, match="no such file"):
        read_tri(tmp_path / "none.tri")


def test_degenerate_patches_are_left_out_and_counted(tmp_path: Path) -> None:
    (board, part), rules = read(tmp_path, SMALL.replace("0 0 0  10 8 0  0 8 0", "0 0 0  10 8 0  5 4 0"))
    assert rules == ("tri-degenerate",)
    assert board.surfaces == (Surface("1", 1),)
    assert (len(board.patches), len(part.patches)) == (1, 2)


def test_an_object_of_degenerate_patches_is_refused(tmp_path: Path) -> None:
    text = SMALL.replace("10 8 0", "5 0 0").replace("0 8 0", "2 0 0")
    assert "no patch with an area" in str(refuse(tmp_path, text))


def test_the_stated_normal_wins_over_the_winding(tmp_path: Path) -> None:
    (board, _), rules = read(tmp_path, SMALL.replace("10 8 0  0 0 1", "10 8 0  0 0 -1"))
    assert rules == ("tri-normal",)
    np.testing.assert_array_equal(board.normals[0], [0, 0, -1])


def test_a_normal_of_no_length_comes_from_the_winding(tmp_path: Path) -> None:
    (board, _), rules = read(tmp_path, SMALL.replace("10 8 0  0 0 1", "10 8 0  0 0 0"))
    assert rules == ("tri-zero-normal",)
    np.testing.assert_array_equal(board.normals[0], [0, 0, 1])


def test_names_and_values_with_spaces_survive(tmp_path: Path) -> None:
    body = replace(_body("J 1", "board", np.eye(3)[None] * 9), package="a #b", value="", part='1/4" jack')
    (again,), _ = read(tmp_path, write_tri([body]))
    assert (again.name, again.package, again.value, again.part) == ("J 1", "a #b", "", "1/4'' jack")


def test_patches_that_rounding_makes_degenerate_are_not_written(tmp_path: Path) -> None:
    body = _body("board", "board", np.stack([np.eye(3), np.eye(3) * 1e-6]))
    (again,), rules = read(tmp_path, write_tri([body]))
    assert (len(again.patches), rules) == (1, ())


@pytest.mark.slow
@settings(max_examples=150)
@given(st.data())
def test_any_damage_gives_a_board_or_one_clear_error(tmp_path: Path, data: st.DataObject) -> None:
    text = bytearray(data.draw(st.sampled_from([SMALL, LEGACY])).encode())
    for _ in range(data.draw(st.integers(1, 4))):
        begin = data.draw(st.integers(0, max(len(text) - 1, 0)))
        end = data.draw(st.integers(begin, min(begin + 12, len(text))))
        text[begin:end] = data.draw(
            st.one_of(st.binary(max_size=4), st.sampled_from([b"nan", b"-", b"9", b"\n", b'"', b"."]))
        )
    file = tmp_path / "damaged.tri"
    file.write_bytes(text)
    bodies: tuple[Body, ...] = ()
    said = ""
    try:
        bodies, _ = read_tri(file)
    except BoardError as error:
        said = str(error)
    assert said.startswith(str(file)) or [body.role for body in bodies].count("board") == 1
    assert all(np.isfinite(body.patches).all() and len(body.patches) == len(body.normals) for body in bodies)


def _body(name: str, role: str, patches: np.ndarray) -> Body:
    normals = np.cross(patches[:, 1] - patches[:, 0], patches[:, 2] - patches[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return Body(name, role, patches, normals, (Surface("1", len(patches)),))  # type: ignore[arg-type]
