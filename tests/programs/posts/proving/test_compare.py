"""The comparison has to see what is wrong."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import pytest
from installations import for_language, small_cell
from robot_programs import PROGRAMS

from programs.errors import ProgramError
from programs.export import export
from programs.motion.lower import lower
from programs.motion.make_motion import make_motion
from programs.motion.steps import MotionProgram
from programs.pose import Pose, compose
from programs.posts.dialect import Handover
from programs.posts.proving.compare import compare, prove
from programs.posts.rebuilt import (
    ReadBoard,
    ReadCall,
    ReadEndRepeat,
    ReadLine,
    ReadPause,
    ReadReach,
    ReadRepeat,
    ReadStep,
    ReadSwitch,
    ReadTool,
    Rebuilt,
)
from programs.posts.robots.abb.read import DIALECT

ASIDE = Pose((0.02, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))
TURNED = Pose((0.0, 0.0, 0.0), (1.0, 0.00015, 0.0, 0.0))
"""0.017 degrees."""


@cache
def read_back(made: str) -> tuple[Rebuilt, MotionProgram]:
    motion = make_motion(PROGRAMS[made](), small_cell())
    return DIALECT.read(DIALECT.render(lower(motion, DIALECT.capability), small_cell())), motion


def later(step: ReadLine, seconds: float) -> ReadLine:
    return replace(step, signals=tuple(replace(each, offset_s=each.offset_s + seconds) for each in step.signals))


def renamed(step: ReadLine) -> ReadLine:
    return replace(step, signals=tuple(replace(each, channel="doAir") for each in step.signals))


MISTAKES: dict[str, tuple[str, type, Callable[[Any], ReadStep | None]]] = {
    "aside": ("in_flight", ReadLine, lambda step: replace(step, target=compose(step.target, ASIDE))),
    "turned": ("three_speeds", ReadLine, lambda step: replace(step, target=compose(step.target, TURNED))),
    "speed": ("three_speeds", ReadLine, lambda step: replace(step, speed_mm_s=step.speed_mm_s + 3.0)),
    "stop": ("three_speeds", ReadLine, lambda step: replace(step, stops=not step.stops)),
    "line missing": ("three_speeds", ReadLine, lambda _: None),
    "signal late": ("in_flight", ReadLine, lambda step: later(step, 0.008)),
    "signal early": ("in_flight", ReadLine, lambda step: later(step, -0.008)),
    "signal missing": ("in_flight", ReadLine, lambda step: replace(step, signals=step.signals[1:])),
    "other valve": ("in_flight", ReadLine, renamed),
    "pause": ("three_speeds", ReadPause, lambda step: replace(step, duration_s=step.duration_s + 0.02)),
    "output": ("three_speeds", ReadSwitch, lambda step: replace(step, value=step.value + 1.0)),
    "output missing": ("three_speeds", ReadSwitch, lambda _: None),
    "start": ("three_speeds", ReadReach, lambda step: replace(step, target=compose(step.target, ASIDE))),
    "tool": ("two_tools", ReadTool, lambda step: replace(step, T_flange_tcp=compose(step.T_flange_tcp, ASIDE))),
    "one tool for two": ("two_tools", ReadTool, lambda step: replace(step, label="t", T_flange_tcp=None)),
    "board": ("bottom", ReadBoard, lambda step: replace(step, T_base_board=compose(step.T_base_board, ASIDE))),
    "call missing": ("bottom", ReadCall, lambda _: None),
    "count": ("loop", ReadRepeat, lambda step: replace(step, count=step.count + 1)),
    "reading": ("loop", ReadRepeat, lambda step: replace(step, reading=(0.2, 0.0))),
    "limit": ("loop", ReadRepeat, lambda step: replace(step, least=step.least + 0.5)),
    "end of loop missing": ("loop", ReadEndRepeat, lambda _: None),
}


@pytest.mark.parametrize("mistake", list(MISTAKES))
def test_a_mistake_is_seen(mistake: str) -> None:
    made, kind, spoil = MISTAKES[mistake]
    rebuilt, motion = read_back(made)
    assert compare(rebuilt, motion, small_cell()) == ()
    steps = [step for each in rebuilt.steps if (step := spoil(each) if isinstance(each, kind) else each) is not None]
    assert compare(replace(rebuilt, steps=tuple(steps)), motion, small_cell())


def test_steps_too_many_are_seen() -> None:
    rebuilt, motion = read_back("loop")
    longer = replace(rebuilt, steps=(*rebuilt.steps, ReadPause(0.5)))
    (difference,) = compare(longer, motion, small_cell())
    assert "1 steps too many" in str(difference)


@pytest.mark.slow
def test_a_program_of_something_else_gives_some_differences_and_not_thousands() -> None:
    rebuilt, _ = read_back("in_flight")
    _, motion = read_back("at_random")
    assert 1 <= len(compare(rebuilt, motion, small_cell())) <= 25


FILE = "tiny__smt_aqueous.mod"


def refusal(corrupt: Callable[[str], str]) -> str:
    """Why the text is refused after a corruption."""
    cell = small_cell("abb")
    motion = make_motion(PROGRAMS["loop"](), cell)
    lowered = lower(motion, DIALECT.capability)
    files = DIALECT.render(lowered, cell)
    text = corrupt(files[FILE])
    assert text != files[FILE]
    with pytest.raises(ProgramError) as caught:
        prove(DIALECT, {**files, FILE: text}, motion, cell, lowered.motion)
    place = re.match(rf"{FILE}:(\d+): ", str(caught.value))
    assert place is not None
    line = text.splitlines()[int(place[1]) - 1]
    assert str(caught.value).endswith("Choose another dialect, and report this.")
    return f"{line.strip()} | {caught.value}"


def test_a_wrong_place_names_the_move_and_the_stroke() -> None:
    found = refusal(lambda text: text.replace("p7:=[[0.000,10.000,", "p7:=[[0.000,10.020,"))
    assert found.startswith("TriggL p7,s60,")
    assert "planned at s/pass: the line ends at" in found


def test_a_wrong_pause_names_its_statement() -> None:
    assert refusal(lambda text: text.replace("WaitTime 0.040;", "WaitTime 0.140;")).startswith("WaitTime 0.140; | ")


def test_a_statement_that_cannot_be_read_is_named() -> None:
    found = refusal(lambda text: text.replace("SetGO goMedium,1;", "SetGO goMedium,;"))
    assert found.startswith("SetGO goMedium,; | ")
    assert "The text cannot be read back." in found


def test_an_export_states_how_closely_its_text_does_what_was_planned() -> None:
    done = export(PROGRAMS["in_flight"](), for_language(small_cell(), "abb"), "abb").agreement
    assert done.differences == ()
    assert 0.0 < done.place_mm <= 0.001
    assert 0.0 < done.event_s <= 0.002
    assert done.describe() == (
        f"places within {done.place_mm:.4f} mm and {done.turn_deg:.4f} deg, "
        f"signals within {1e3 * done.event_s:.2f} ms of the plan"
    )


def test_nothing_comes_out_of_a_writer_that_makes_a_mistake(monkeypatch: pytest.MonkeyPatch) -> None:
    def write(*given: object) -> tuple[dict[str, str], Handover]:
        files, handover = DIALECT.write(*given)  # type: ignore[arg-type]
        return {FILE: files[FILE].replace("SetGO goMedium,1;", "SetGO goMedium,2;")}, handover

    monkeypatch.setattr("programs.export.DIALECTS", {"abb": replace(DIALECT, write=write)})
    with pytest.raises(ProgramError, match="planned Switch"):
        export(PROGRAMS["loop"](), for_language(small_cell(), "abb"), "abb")
