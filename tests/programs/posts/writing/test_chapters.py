import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from installations import WASH, small_cell
from robot_programs import PROGRAMS
from robot_steps import line, pose, program

from programs.motion.make_motion import make_motion
from programs.motion.steps import EndRepeat, Event, Line, Note, Pause, Reach, Repeat, Step, UseBoard, UseTool
from programs.posts.writing.chapters import Chapter, Part, divide, place_events


def steps_of(parts: tuple[Part, ...]) -> list[Step]:
    return [step for part in parts for step in (part.steps if isinstance(part, Chapter) else (part,))]


@pytest.mark.slow
@pytest.mark.parametrize("made", list(PROGRAMS))
@pytest.mark.parametrize("most", [15, 100, 5000])
def test_nothing_is_lost_and_no_routine_is_too_long(made: str, most: int) -> None:
    motion = make_motion(PROGRAMS[made](), small_cell())
    parts = divide(motion, most)
    told = steps_of(parts)
    assert len(told) == len(motion.steps)
    for step, planned in zip(told, motion.steps, strict=True):
        assert step is planned or (
            isinstance(step, Line) and isinstance(planned, Line) and step.samples is planned.samples
        )
    chapters = [part for part in parts if isinstance(part, Chapter)]
    assert max(len(chapter.steps) for chapter in chapters) <= most
    assert [chapter.number for chapter in chapters] == list(range(1, len(chapters) + 1))


@pytest.mark.slow
@pytest.mark.parametrize("most", [15, 100])
def test_the_robot_stands_where_routines_meet(most: int) -> None:
    parts = divide(make_motion(PROGRAMS["at_random"](), small_cell()), most)
    for part in parts:
        if isinstance(part, Chapter):
            last = part.steps[-1]
            assert not isinstance(last, Line) or last.blend_mm == 0.0


@pytest.mark.slow
def test_loops_stand_between_routines_and_functions_name_them() -> None:
    parts = divide(make_motion(PROGRAMS["planned"](), small_cell()), 5000)
    kinds = [part.title if isinstance(part, Chapter) else type(part).__name__ for part in parts]
    assert kinds == ["clean", "rinse", "Repeat", "rinse", "EndRepeat", "dry"]


def test_a_routine_knows_its_tool_and_board() -> None:
    parts = divide(make_motion(PROGRAMS["two_tools"](), small_cell()), 5000)
    first, second, third = (part for part in parts if isinstance(part, Chapter))
    assert (first.tool, first.board) == (None, None)
    assert isinstance(second.tool, UseTool)
    assert isinstance(second.board, UseBoard)
    assert (second.tool.number, third.tool.number if third.tool else 0) == (1, 2)


@settings(max_examples=50)
@given(kinds=st.lists(st.sampled_from("lspnr"), max_size=40), most=st.integers(3, 10))
def test_any_steps_can_be_divided(kinds: list[str], most: int) -> None:
    steps: list[Step] = [Reach(pose(0), (), "s")]
    for number, kind in enumerate(kinds):
        way = pose(number), pose(number + 1)
        loop = (Repeat(2, "x", 1.0, None, "s"), Pause(0.5, "s"), EndRepeat("s"))
        made: dict[str, tuple[Step, ...]] = {
            "l": (line(*way, 10.0, blend_mm=0.3),),
            "s": (line(*way, 10.0),),
            "p": (Pause(0.1, "s"),),
            "n": (Note(f"function f{number}", "s"),),
            "r": loop,
        }
        steps += made[kind]
    told = steps_of(divide(program(*steps), most))
    assert [type(step) for step in told] == [type(step) for step in steps]


def event(share: float, value: float = 1.0) -> Event:
    return Event(WASH, value, "start", 0.0, 0.0, share, share, 60.0, "s")


def test_an_output_at_the_end_of_a_passed_line_belongs_to_the_next() -> None:
    passed = line(pose(0), pose(10), 60.0, blend_mm=1.0, events=(event(0.0), event(0.5, 0.0), event(1.0)))
    after = line(pose(10), pose(20), 60.0, events=(event(0.0, 0.0), event(1.0)))
    first, second = place_events((passed, after))
    assert [len(first.begins), len(first.inside), len(first.ends)] == [1, 1, 0]
    assert [each.value for each in second.begins] == [1.0, 0.0]
    assert second.ends == (event(1.0),)


def test_where_the_robot_stops_an_output_stays_at_the_end() -> None:
    stopped = line(pose(0), pose(10), 60.0, events=(event(1.0),))
    first, second, _ = place_events((stopped, Pause(0.1, "s"), line(pose(10), pose(20), 60.0)))
    assert first.ends == (event(1.0),)
    assert not second.begins
