"""The first motion of a program: straight up, whatever the arm's configuration, and only then home."""

from dataclasses import replace

import pytest
from installations import small_cell
from robot_programs import PROGRAMS

from programs.errors import ProgramError
from programs.export import export
from programs.posts.dialects import DIALECTS

FIRST = {
    "abb": ("pStart:=CRobT", "IF pStart.trans.z<{}", "pStart.trans.z:={}", "MoveL pStart", "MoveAbsJ jHome"),
    "kuka": ("xStart=$POS_ACT", "IF xStart.Z<{}", "xStart.Z={}", "LIN xStart", "PTP HOME_POSITION"),
    "ur": ("p_start = get_actual", "if p_start[2] < {}", "movel(p[p_start[0],p_start[1],{}", "end", "movej(["),
}
HEIGHTS = {"abb": "145.0", "kuka": "145.0", "ur": "0.145"}
"""110 mm above the board, which is 35.25 mm above the base; rounded down."""


@pytest.mark.parametrize("name", FIRST)
def test_the_orifice_is_raised_to_the_height_of_the_program_before_the_arm_goes_home(name: str) -> None:
    cell = small_cell(DIALECTS[name].maker)
    (text,) = (text for file, text in export(PROGRAMS["two_tools"](), cell, name).files.items() if file[-3:] != "dat")
    lines = [line.strip() for line in text.splitlines()]
    at = [
        next(number for number, line in enumerate(lines) if line.startswith(form.format(HEIGHTS[name])))
        for form in FIRST[name][:3]
    ]
    assert at == sorted(at)
    rest = lines[at[-1] :]
    assert next(line for line in rest if line.startswith(("MoveAbsJ", "PTP", "movej"))).startswith(FIRST[name][-1])
    hung = export(PROGRAMS["two_tools"](), replace(cell, is_upright=False), name).files
    assert all(FIRST[name][0] not in each for each in hung.values())


@pytest.mark.parametrize("name", FIRST)
def test_a_height_that_is_written_in_two_ways_is_refused(name: str) -> None:
    cell, height = small_cell(DIALECTS[name].maker), HEIGHTS[name]
    files = dict(export(PROGRAMS["two_tools"](), cell, name).files)
    start = FIRST[name][1].format(height)
    file = next(each for each, text in files.items() if start in text)
    files[file] = files[file].replace(start, start.replace(height, height.replace("145", "135")))
    with pytest.raises(ProgramError, match="compared with one height"):
        DIALECTS[name].read(files)
