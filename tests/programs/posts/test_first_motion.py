"""The first motion of a program: straight up, whatever the arm's configuration, and only then home."""

from dataclasses import replace

import pytest
from installations import for_language, small_cell
from robot_programs import PROGRAMS

from programs.errors import ProgramError
from programs.export import export
from programs.motion.lower import lower
from programs.motion.make_motion import make_motion
from programs.posts.dialects import DIALECTS
from programs.posts.proving.compare import compare

FIRST = {
    "abb": ("pStart:=CRobT", "IF pStart.trans.z<{}", "pStart.trans.z:={}", "MoveL pStart", "MoveAbsJ jHome"),
    "denso": ("pStart = CurPos", "If PosZ(pStart) < {}", "LetZ pStart = {}", "Move L, @0 pStart", "Move P, @0 J("),
    "epson": ("Tool 1", "If CZ(Here) < {0} Then Move Here :Z({0})", "Go JA("),
    "fanuc": ("UFRAME_NUM=0", "R[88]=PR[91,3]", "IF R[88]>={}", "PR[91,3]={}", "L PR[91] 100mm/sec FINE", "J P[1]"),
    "kuka": ("xStart=$POS_ACT", "IF xStart.Z<{}", "xStart.Z={}", "LIN xStart", "PTP HOME_POSITION"),
    "melfa": ("Base P_NBase", "Tool PTL1", "PSTART=P_Curr", "If PSTART.Z>={}", "PSTART.Z={}", "Mvs PSTART", "Mov J1"),
    "ur": ("p_start = get_actual", "if p_start[2] < {}", "movel(p[p_start[0],p_start[1],{}", "end", "movej(["),
    "val3": (
        "pStart=here(",
        "if pStart.trsf.z<{}",
        "pStart.trsf.z={}",
        "movel(pStart,",
        "waitEndMove()",
        "movej(jHome",
    ),
    "yaskawa": ("GETS PX010 $PX001", "SET D011 {}", "JUMP *HIGH IF D010>=D011", "SETE P010", "MOVL P010", "CALL JOB:"),
}
HEIGHTS = {"ur": "0.145", "fanuc": "145", "yaskawa": "145000"}
HEIGHT = "145.0"
"""110 mm above the board, which is 35.25 mm above the base; rounded down."""


@pytest.mark.parametrize("name", FIRST)
def test_the_orifice_is_raised_to_the_height_of_the_program_before_the_arm_goes_home(name: str) -> None:
    cell, height = small_cell(DIALECTS[name].maker), HEIGHTS.get(name, HEIGHT)
    texts = export(PROGRAMS["two_tools"](), cell, name).files
    marked = next(form for form in FIRST[name] if "{" in form).format(height)
    text = next(text for text in texts.values() if marked in text)
    lines = [line.strip().lstrip("0123456789:").strip() for line in text.splitlines()]
    begin = next(at for at, line in enumerate(lines) if line.startswith(FIRST[name][0].format(height)))
    for form in FIRST[name][1:]:
        begin += 1 + next(at for at, line in enumerate(lines[begin + 1 :]) if line.startswith(form.format(height)))
    hung = export(PROGRAMS["two_tools"](), replace(cell, is_upright=False), name).files
    assert all(marked not in each for each in hung.values())


@pytest.mark.parametrize("name", FIRST)
def test_another_height_than_that_of_the_program_is_found(name: str) -> None:
    cell, height = for_language(small_cell(), name), HEIGHTS.get(name, HEIGHT)
    motion = make_motion(PROGRAMS["two_tools"](), cell)
    files = DIALECTS[name].render(lower(motion, DIALECTS[name].capability), cell)
    forms = [form for form in FIRST[name] if "{" in form]
    changed = dict(files)
    for form in forms:
        file = next(each for each, text in files.items() if form.format(height) in text)
        changed[file] = changed[file].replace(form.format(height), form.format(height.replace("145", "135")))
    (found,) = compare(DIALECTS[name].read(changed), motion, cell)
    assert found.message == "the orifice is first raised to 135.0 mm above the base, planned 145"


TWICE = [name for name, forms in FIRST.items() if sum("{}" in form for form in forms) == 2]


@pytest.mark.parametrize("name", TWICE)
def test_a_height_that_is_written_in_two_ways_is_refused(name: str) -> None:
    cell, height = small_cell(DIALECTS[name].maker), HEIGHTS.get(name, HEIGHT)
    files = dict(export(PROGRAMS["two_tools"](), cell, name).files)
    start = next(form for form in FIRST[name] if "{}" in form).format(height)
    file = next(each for each, text in files.items() if start in text)
    files[file] = files[file].replace(start, start.replace(height, height.replace("145", "135")))
    with pytest.raises(ProgramError, match="compared with one height"):
        DIALECTS[name].read(files)
