import dataclasses
import math
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from small_programs import DOWN, hand_program, program_of, programs

from programs import native
from programs.errors import ProgramError
from programs.program import Command, MoveTo, SetNozzle, TimedProgram, Wait

HAND = native.render(hand_program())
PARK = MoveTo(0.0, (0.0, 0.0, 110.0), DOWN, 0.0, "start")


def line_of(text: str, words: str) -> int:
    return next(number for number, line in enumerate(text.split("\n"), start=1) if words in line)


def test_a_small_program_reads_as_the_format_says(golden: Callable[[str, str], None]) -> None:
    golden("hand.wash", HAND)


def test_a_stored_file_of_the_present_version_is_read() -> None:
    """Whoever changes the format stores a file of the new version, and this one stays."""
    stored = (Path(__file__).parent / "formats" / "program-1.wash").read_text("utf-8")
    assert stored.startswith("WASHBOARD 1\n")
    assert native.render(native.parse(stored)) == stored


def test_the_recipe_paths_stand_in_one_column() -> None:
    lines = [line for line in HAND.split("\n") if " ; " in line]
    assert {line.index("; ") for line in lines if "MOVE" not in line} == {56}
    assert all("   ; " in line for line in lines)


def test_a_negative_zero_is_not_written() -> None:
    assert "-0.000 " not in HAND
    assert "MOVE 10.000 0.000 60.000" in HAND


@pytest.mark.slow
@settings(max_examples=120)
@given(program=programs())
def test_what_is_written_is_read_and_written_the_same(program: TimedProgram) -> None:
    text = native.render(program)
    assert native.render(native.parse(text)) == text


@pytest.mark.slow
@settings(max_examples=30)
@given(program=programs())
def test_a_line_written_alone_is_that_of_the_file(program: TimedProgram) -> None:
    alone = [native.render_line(program, index) for index in range(len(program.instructions))]
    assert native.render(program).split("\n")[-2 - len(alone) : -2] == alone


@pytest.mark.slow
@settings(max_examples=60)
@given(program=programs())
def test_reading_gives_the_program_rounded(program: TimedProgram) -> None:
    read = native.parse(native.render(program))
    assert read.origin == program.origin
    assert len(read.instructions) == len(program.instructions)
    for got, given_ in zip(read.instructions, program.instructions, strict=True):
        assert type(got) is type(given_)
        assert str(got.made_by) == str(given_.made_by)
        assert got.time_s == pytest.approx(given_.time_s, abs=5.1e-5)
        match got, given_:
            case MoveTo(), MoveTo():
                assert got.position == pytest.approx(given_.position, abs=5.1e-4)
                assert got.quaternion == pytest.approx(given_.quaternion, abs=5.1e-8)
                assert math.hypot(*got.quaternion) == pytest.approx(1.0, abs=1e-6)
            case SetNozzle(), SetNozzle():
                assert got.spraying == given_.spraying
            case Command(), Command():
                assert (got.keyword, got.arguments) == (given_.keyword, given_.arguments)
            case Wait(), Wait():
                assert got.duration_s == pytest.approx(given_.duration_s, abs=5.1e-5)
            case _:
                raise AssertionError(got)


def test_windows_line_ends_and_blank_lines_read_the_same() -> None:
    loose = HAND.replace("BEGIN\n", "BEGIN\n\n").replace("\n", "\r\n")
    assert native.parse(loose) == native.parse(HAND)


# Each: what is replaced by what, words of the message, and words of the line that must be named.
BAD_TEXTS = {
    "magic": ("WASHBOARD 1", "HELLO", "not a Washboard program", "HELLO"),
    "version": ("WASHBOARD 1", "WASHBOARD 2", "only 'WASHBOARD 1'", "WASHBOARD 2"),
    "units": ("UNITS mm s", "UNITS in s", "expected 'UNITS mm s'", "UNITS in"),
    "frame": ("FRAME board", "FRAME cell", "expected 'FRAME board'", "FRAME cell"),
    "board": ("sha256 9f2c", "9f2c", "BOARD name sha256 hash", "BOARD tiny"),
    "totals": (" moves 5", "", "TOTALS duration_s", "TOTALS"),
    "liquid": ("0.073 l", "much l", "LIQUID function litres l", "LIQUID"),
    "begin": ("BEGIN\n", "", "or BEGIN", "FUNCTION"),
    "unknown keyword": ("1.0000 SPRAY ON", "1.0000 SPRY ON", "did you mean SPRAY?", "SPRY"),
    "no keyword": ("1.0000 SPRAY ON ", "1.0000 ", "a time without an instruction", "1.0000     "),
    "no time": ("1.0000 SPRAY ON", "SPRAY ON", "'SPRAY' is not a number", "SPRAY ON "),
    "no instruction": ("\n1.0000 SPRAY ON ", "\n  ; lonely", "without an instruction before it", "lonely"),
    "spray": ("SPRAY ON", "SPRAY MAYBE", "SPRAY ON or SPRAY OFF", "MAYBE"),
    "time back": ("3.2000 SPRAY OFF", "3.1000 SPRAY OFF", "time runs back", "3.1000"),
    "missing number": ("40.000 20.000 60.000", "40.000 60.000", "(x y z qw qx qy qz v), found 7", "3.2000 M"),
    "extra number": ("40.000 20.000 60.000", "1 40.000 20.000 60.000", "found 9", "3.2000 MOVE"),
    "not a number": ("40.000 20.000 60.000", "40.000 2O.000 60.000", "'2O.000' is not a number", "3.2000 MOVE"),
    "underscore": ("40.000 20.000 60.000", "40.000 2_0.000 60.000", "'2_0.000' is not a number", "3.2000 MOVE"),
    "nan": ("40.000 20.000 60.000", "40.000 nan 60.000", "not finite", "3.2000 MOVE"),
    "infinite time": ("4.2000 MOVE", "inf MOVE", "not finite", "inf MOVE"),
    "huge": ("40.000 20.000 60.000", "40.000 2e10 60.000", "beyond 1e9", "3.2000 MOVE"),
    "quaternion": ("0.0871557 0.9961947", "0.0871557 0.9961967", "length is 1.0000020", "1.0000 MOVE"),
    "wait broken": ("2.0000 WAIT 0.2000", "2.0000 WAIT 1.4000", "ends at 3.4000 s", "3.2000 MOVE"),
    "wait negative": ("WAIT 0.2000", "WAIT -0.2000", "negative", "WAIT -0.2"),
    "wait what": ("WAIT 0.2000", "WAIT", "WAIT needs 1 number (seconds), found 0", "WAIT  "),
    "speed negative": (" 20.000   ;", " -20.000   ;", "speed", "3.2000 MOVE"),
    "time negative": ("0.0000 FUNCTION", "-1.0000 FUNCTION", "negative", "FUNCTION"),
    "tool": ("TOOL 1", "TOOL one", "NOZZLE name TOOL number", "NOZZLE"),
    "grip": ("GRIP close", "GRIP loose", "GRIP open or GRIP close", "GRIP"),
    "set": ("pressure_bar 3.500", "pressure_bar nan", "SET key value", "SET"),
    "repeat": ("REPEAT 4 UNTIL", "REPEAT 0 UNTIL", "REPEAT number UNTIL key >= value", "REPEAT 0"),
    "repeat open": ("3.2000 ENDREPEAT", "3.2000 CALL other", "no ENDREPEAT", "REPEAT 4"),
    "endrepeat alone": ("REPEAT 4 UNTIL resistivity_mohm_cm >= 1.0", "CALL other", "without a REPEAT", "ENDREPEAT"),
    "jet on": ("SPRAY OFF", "SPRAY ON", "ends with the jet on", "4.2000 MOVE"),
    "moves": (" moves 5", " moves 6", "state 6 moves, the program has 5", "TOTALS"),
    "duration": ("duration_s 4.2000", "duration_s 4.3000", "ends at 4.2000 s", "TOTALS"),
    "after the end": ("END\n", "END\nmore\n", "text after END", "more"),
    "cut off": ("END\n", "", "ends without END", "\n"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD_TEXTS)
def test_a_bad_text_is_refused_in_its_line(case: str) -> None:
    before, after, message, place = BAD_TEXTS[case]
    text = HAND.replace(before, after, 1)
    assert text != HAND
    with pytest.raises(ProgramError) as caught:
        native.parse(text, file="x.wash")
    assert message in str(caught.value)
    line = text.count("\n") + 1 if case == "cut off" else line_of(text, place)
    assert str(caught.value).startswith(f"x.wash:{line}: ")
    assert caught.value.line == line


def test_a_program_without_a_move_is_refused() -> None:
    with pytest.raises(ProgramError, match="no MOVE"):
        native.render(program_of(Command(0.0, "CALL", ("flip",), "")))


@pytest.mark.parametrize(
    ("instruction", "message"),
    [
        (MoveTo(1.0, (math.nan, 0.0, 0.0), DOWN, 1.0, ""), "not finite"),
        (MoveTo(1.0, (0.0, 0.0, 0.0), (0.9, 0.0, 0.0, 0.0), 1.0, ""), "quaternion"),
        (MoveTo(-1.0, (0.0, 0.0, 0.0), DOWN, 1.0, ""), "time runs back"),
        (SetNozzle(1.0, True, ""), "jet on"),
        (SetNozzle(1.0, False, "two\nlines"), "cannot stand in a line"),
        (Command(1.0, "CALL", ("two words",), ""), "CALL name"),
        (Command(1.0, "CALL", (";",), ""), "CALL name"),
        (Command(1.0, "JUMP", (), ""), "unknown command 'JUMP'"),
    ],
)
def test_what_could_not_be_read_is_not_written(instruction: MoveTo | SetNozzle | Command, message: str) -> None:
    with pytest.raises(ProgramError, match="cannot be written at instruction 2") as caught:
        native.render(program_of(PARK, instruction))
    assert message in str(caught.value)


def test_a_board_whose_name_breaks_the_line_is_not_written() -> None:
    program = hand_program()
    origin = dataclasses.replace(program.origin, board="two\nlines")
    with pytest.raises(ProgramError, match="name of a board"):
        native.render(dataclasses.replace(program, origin=origin))


def test_a_board_with_spaces_in_its_name_comes_back() -> None:
    program = hand_program()
    origin = dataclasses.replace(program.origin, board="my sha256 board")
    assert native.parse(native.render(dataclasses.replace(program, origin=origin))).origin == origin


def test_the_cell_that_a_program_is_timed_for_comes_back() -> None:
    program = hand_program()
    origin = dataclasses.replace(program.origin, cell="my cell", cell_sha256="c0ffee")
    text = native.render(dataclasses.replace(program, origin=origin))
    assert "\nCELL my cell sha256 c0ffee\nTOTALS " in text
    assert native.parse(text).origin == origin
    with pytest.raises(ProgramError, match="expected 'CELL name sha256 hash'") as caught:
        native.parse(text.replace(" sha256 c0ffee", ""))
    assert caught.value.line == 6
    with pytest.raises(ProgramError, match="the totals state") as caught:
        native.parse(text.replace("duration_s ", "duration_s 1"))
    assert caught.value.line == 7


def test_a_cell_whose_name_breaks_the_line_is_not_written() -> None:
    program = hand_program()
    origin = dataclasses.replace(program.origin, cell="two\nlines", cell_sha256="c0ffee")
    with pytest.raises(ProgramError, match="name of a cell"):
        native.render(dataclasses.replace(program, origin=origin))


def read_or_refuse(text: str) -> None:
    refused: ProgramError | None = None
    try:
        again = native.render(native.parse(text))
        assert native.render(native.parse(again)) == again
    except ProgramError as error:
        refused = error
    if refused is not None:
        assert refused.line is not None
        assert 1 <= refused.line <= text.count("\n") + 1


@settings(max_examples=150)
@given(text=st.text(max_size=200))
@example("")
@example("WASHBOARD 1")
@example("WASHBOARD 1\nUNITS mm s\nFRAME board\nBOARD")
def test_any_text_is_read_or_refused(text: str) -> None:
    read_or_refuse(text)


@pytest.mark.slow
@settings(max_examples=300)
@given(
    at=st.integers(0, len(HAND) - 1),
    cut=st.integers(0, 30),
    put=st.one_of(
        st.text(max_size=4), st.sampled_from(["\n", " ", ";", "-", "e9", "nan", "1e400", "_", "\x85", "\u2028", "\0"])
    ),
)
def test_a_damaged_program_is_read_or_refused(at: int, cut: int, put: str) -> None:
    read_or_refuse(HAND[:at] + put + HAND[at + cut :])


@settings(max_examples=100)
@given(order=st.permutations(HAND.split("\n")[8:-2]))
def test_shuffled_instructions_are_read_or_refused(order: list[str]) -> None:
    head = HAND.split("\n")[:8]
    read_or_refuse("\n".join([*head, *order, "END", ""]))
