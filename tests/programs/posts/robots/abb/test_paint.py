from dataclasses import replace

import pytest
from installations import AIR, small_cell
from robot_programs import PROGRAMS
from robot_steps import line, pose, program

from programs.errors import ProgramError
from programs.export import export
from programs.motion.lower import lower
from programs.motion.steps import MotionProgram, Reach, Step, Switch, UseBoard, UseTool
from programs.motion.valves import SwitchRequest, open_valves
from programs.pose import IDENTITY
from programs.posts.robots.abb.paint import DIALECT as PAINT_DIALECT
from specs.source import Source

READY: tuple[Step, ...] = (UseBoard("", IDENTITY, ""), UseTool(1, "ring60", "s"), Reach(pose(0), (), "s"))


def sprayed() -> MotionProgram:
    stroke = line(pose(0), pose(100), 100.0, blend_mm=1.0)
    requests = [SwitchRequest(3, 0.08, True, "ring60", "s"), SwitchRequest(3, 0.92, False, "ring60", "s")]
    return program(*open_valves((*READY, stroke), requests, small_cell("abb"))[0])


def written(motion: MotionProgram) -> list[str]:
    (text,) = PAINT_DIALECT.render(lower(motion, PAINT_DIALECT.capability), small_cell("abb")).values()
    return [each.strip() for each in text.splitlines()]


def test_the_example_of_the_four_dialects_by_brushes() -> None:
    """On 8 mm after the start, off 8 mm before the end, 40 ms to open and 20 ms to shut, 100 mm/s, 100 mm."""
    lines = written(sprayed())
    frames = "t_ring60\\WObj:=w_board;"
    assert [each for each in lines if each.startswith(("PaintL", "SetBrush"))] == [
        "SetBrush 0;",  # of the routine that shuts all valves
        "SetBrush 0;",
        f"PaintL p2,s100,z0,{frames}",
        "SetBrush 1;",
        f"PaintL p3,s100,z0,{frames}",
        "SetBrush 0;",
        f"PaintL p4,s100,z1,{frames}",
    ]
    places = [
        each.partition(":=[[")[2].partition(",")[0] for each in lines if " robtarget p" in each and "pStart" not in each
    ]
    assert places == ["0.000", "4.000", "90.000", "100.000"]


def test_guns_are_switched_by_brushes_only_and_all_else_by_itself() -> None:
    (text,) = export(PROGRAMS["two_tools"](), small_cell("abb"), "abb-paint").files.values()
    assert 'CONST string sBrush1:="doWash";' in text
    assert 'CONST string sBrush2:="doAir";' in text
    assert "SetDO doWash" not in text
    assert "SetDO doAir" not in text
    assert "SetGO goMedium,1;" in text
    assert "SetBrush 2;" in text


def test_two_guns_at_a_time_are_refused() -> None:
    motion = sprayed()
    steps = (*motion.steps[:-1], Switch(AIR, 1.0, "s"), replace(motion.lines[0], made_by=Source.parse("s")))
    with pytest.raises(ProgramError, match="a brush opens one gun"):
        written(program(*steps, Switch(AIR, 1.0, "s")))


@pytest.mark.parametrize(
    ("right", "wrong"),
    [("SetBrush 1;", "SetBrush 7;"), ("SetBrush 0;", "SetDO doWash,0;"), ("PaintL p2", "PaintC p2")],
)
def test_the_reader_refuses_what_is_not_written(right: str, wrong: str) -> None:
    files = dict(export(PROGRAMS["three_speeds"](), small_cell("abb"), "abb-paint").files)
    assert any(right in text for text in files.values())
    with pytest.raises(ProgramError):
        PAINT_DIALECT.read({name: text.replace(right, wrong) for name, text in files.items()})
