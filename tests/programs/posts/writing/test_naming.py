import pytest
from robot_steps import program

from programs.errors import ProgramError
from programs.motion.steps import UseBoard, UseTool
from programs.pose import IDENTITY
from programs.posts.writing.naming import Names, number_slots


def test_names_are_given_once_and_kept() -> None:
    names = Names(10, {"main"})
    assert names.give("call", 1, "main") == "main_2"
    assert names.give("call", 1, "anything") == "main_2"
    assert names.give("call", 2, "MAIN_2") == "MAIN_2_2"
    capitals = Names(6, set(), str.upper, link="X")
    assert [capitals.give("call", key, "clean up") for key in range(3)] == ["CLEAN", "CLEAX2", "CLEAX3"]


def test_a_number_may_be_any_where_the_controller_has_a_table() -> None:
    slots = number_slots(program(UseBoard("", IDENTITY, ""), UseTool(99, "n", "s")))
    assert slots.tools == {99: 99}


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
