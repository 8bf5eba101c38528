from dataclasses import replace

import pytest
from installations import WASH
from robot_steps import line, pose, program

from programs.errors import ProgramError
from programs.motion.steps_of_robot import Event, Pause, Switch, UseBoard, UseTool
from programs.pose import IDENTITY
from programs.posts.writing.chapters import Chapter
from programs.posts.writing.routines import Names, number_slots, outputs_of, place_events, tell


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


def test_a_recipe_path_is_told_when_another_one_moves_the_robot() -> None:
    steps = [replace(line(pose(0), pose(1), 9.0), made_by=maker) for maker in ("a", "a", "b", "a")]
    said = tell((Switch(WASH, 0.0, "z"), *steps), lambda text: f"# {text}", lambda placed: [type(placed.step).__name__])
    assert said == ["Switch", "# a", "Line", "Line", "# b", "Line", "# a", "Line"]


def test_names_are_given_once_and_kept() -> None:
    names = Names(10, {"main"})
    assert names.give("call", 1, "main") == "main_2"
    assert names.give("call", 1, "anything") == "main_2"
    assert names.give("call", 2, "MAIN_2") == "MAIN_2_2"
    assert names.routine(Chapter(7, "a long title", (), None, None)) == "a_long_07"
    assert names.routine(Chapter(12, "a long title", (), None, None)) == "a_long_12"


def test_tools_keep_their_numbers_where_the_controller_has_them() -> None:
    tools = [UseTool(number, "n", "s") for number in (9, 2, 0, 2, 1)]
    slots = number_slots(program(UseBoard("", IDENTITY, ""), *tools), 4)
    assert slots.tools == {9: 3, 2: 2, 0: 4, 1: 1}
    slots.use(tools[0])
    assert slots.tool == 3


def test_more_places_than_the_controller_has_are_refused() -> None:
    boards = [UseBoard(name, IDENTITY, "s") for name in "abc"]
    with pytest.raises(ProgramError, match="3 places"):
        number_slots(program(*boards), 2)


def test_the_outputs_of_a_program_are_listed_once() -> None:
    steps = (Switch(WASH, 0.0, "s"), line(pose(0), pose(10), 60.0, events=(event(0.5),)))
    assert outputs_of(program(*steps)) == ["Output doWash: digital 1"]
