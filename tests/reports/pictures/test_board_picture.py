import math
from dataclasses import replace

import pytest
from made_findings import made_finding
from shapely import box
from small_boards import board_of, part
from small_programs import DOWN, hand_program, program_of

from programs.errors import ProgramError
from programs.program import Command, MoveTo, SetNozzle, TimedProgram, Wait
from reports.pictures.board_picture import draw_board, draw_plan
from reports.pictures.sheet import View, arrange, greys
from specs.errors import JobError

BOARD = board_of(
    part("U1", 10, 10, 20, 15, 2.0), part("J$1", 60, 10, 12, 30, 16.0), fixtures=[(box(0, 50, 8, 64), 9.0)]
)


def texts(svg: bytes) -> str:
    """The words in an SVG: each stands in a comment beside its glyphs."""
    return "\n".join(line.strip()[5:-4] for line in svg.decode().split("\n") if line.strip().startswith("<!-- "))


def both_sides() -> TimedProgram:
    up = (1.0, 0.0, 0.0, 0.0)
    return program_of(
        MoveTo(0.0, (0.0, 0.0, 60.0), DOWN, 0.0, ""),
        Command(0.0, "FUNCTION", ("clean",), ""),
        SetNozzle(0.0, True, ""),
        MoveTo(1.0, (50.0, 0.0, 60.0), DOWN, 50.0, ""),
        Wait(1.0, 0.5, ""),
        SetNozzle(1.5, False, ""),
        MoveTo(3.5, (50.0, 0.0, -60.0), up, 60.0, "x/transfer"),
        SetNozzle(3.5, True, ""),
        MoveTo(4.5, (0.0, 0.0, -60.0), up, 50.0, ""),
        SetNozzle(4.5, False, ""),
        Command(4.5, "FUNCTION", ("dry",), ""),
        SetNozzle(4.5, True, ""),
        MoveTo(5.5, (0.0, 30.0, -60.0), up, 30.0, ""),
        SetNozzle(5.5, False, ""),
    )


@pytest.mark.slow
@pytest.mark.parametrize(("suffix", "magic"), [(".png", b"\x89PNG"), (".svg", b"<?xml")])
def test_the_same_input_gives_the_same_bytes(suffix: str, magic: bytes) -> None:
    first, second = (draw_plan(BOARD, hand_program(), suffix) for _ in range(2))
    assert first == second
    assert first.startswith(magic)
    board, again = (draw_board(BOARD, suffix) for _ in range(2))
    assert board == again
    assert board.startswith(magic)
    assert b"dc:date" not in first + board


def test_each_function_has_a_panel_for_each_side_that_it_sprays() -> None:
    words = texts(draw_plan(BOARD, both_sides(), ".svg")).split("\n")
    assert [word for word in words if word.startswith(("clean", "dry")) and "top" not in word]
    assert "clean" in words
    assert "clean  ·  bottom, as seen from the top" in words
    assert "dry  ·  bottom, as seen from the top" in words
    assert words.count("2.5 s sprayed") == 0
    assert words.count("1.5 s sprayed") == 1, "one second of motion and half a second of rest on the top"
    assert words.count("1.0 s sprayed") == 2


def test_a_plan_says_what_it_takes_and_shows_what_it_is_made_from() -> None:
    words = texts(draw_plan(BOARD, hand_program(), ".svg"))
    assert "boxes  ·  smt-aqueous" in words
    assert "4.2 s in all    2.2 s sprayed    0.15 m    5 moves    clean 0.07 l" in words
    assert "recipe sha256 77b0" in words
    assert "tallest body 16.0 mm" in words
    assert "U1" in words.split("\n")


@pytest.mark.slow
def test_another_path_gives_another_picture() -> None:
    assert draw_plan(BOARD, hand_program(), ".png") != draw_plan(BOARD, both_sides(), ".png")


@pytest.mark.slow
def test_a_program_that_never_sprays_is_drawn() -> None:
    parked = program_of(MoveTo(0.0, (0.0, 0.0, 110.0), DOWN, 0.0, ""))
    assert draw_plan(BOARD, parked, ".png").startswith(b"\x89PNG")


def test_a_board_shows_names_sizes_and_numbered_findings() -> None:
    findings = (
        made_finding("far", "info", "nothing to see"),
        made_finding("floating", "warning", "J$1 floats", where=(66.0, 25.0, 0.0)),
    )
    words = texts(draw_board(replace(BOARD, findings=findings), ".svg"))
    assert "J$1" in words.split("\n"), "a dollar in a name is no formula"
    assert "100.0 x 60.0 mm    1.60 mm thick    2 components: 2 on the top" in words
    assert "(1) warning: J$1 floats" in words
    assert words.index("warning") < words.index("info: nothing"), "worst first"


@pytest.mark.slow
def test_a_bare_board_and_a_name_in_another_script_are_drawn() -> None:
    assert draw_board(board_of(), ".png").startswith(b"\x89PNG")
    assert draw_board(board_of(part("電", 10, 10, 20, 15)), ".png").startswith(b"\x89PNG")


@pytest.mark.parametrize("suffix", [".jpg", ".pdf", ""])
def test_another_kind_of_file_is_refused(suffix: str) -> None:
    with pytest.raises(JobError, match=r"written as \.png or \.svg"):
        draw_plan(BOARD, hand_program(), suffix)
    with pytest.raises(JobError, match=r"written as \.png or \.svg"):
        draw_board(BOARD, suffix)


def test_a_program_without_a_move_has_no_picture() -> None:
    with pytest.raises(ProgramError, match="no MOVE"):
        draw_plan(BOARD, program_of(SetNozzle(0.0, False, "")), ".png")


def test_taller_components_are_darker() -> None:
    low, tall = greys(BOARD.components)
    assert tall[0] < low[0]


@pytest.mark.parametrize(("aspect", "columns"), [(0.05, 1), (10.0, 6)])
def test_wide_boards_stand_above_each_other_and_tall_ones_side_by_side(aspect: float, columns: int) -> None:
    layout = arrange(6, View((0.0, 0.0), (100.0, 100.0 * aspect)), 400.0, 200.0)
    assert layout.columns == columns
    assert layout.rows == math.ceil(6 / columns)
    assert layout.height_mm <= 200.0 + 1e-9
