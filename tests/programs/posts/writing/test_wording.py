import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from robot_steps import program

from programs.errors import ProgramError
from programs.motion.steps import UseBoard, UseTool
from programs.pose import IDENTITY
from programs.posts.writing.forms import fixed, short
from programs.posts.writing.vocabulary import Vocabulary
from programs.posts.writing.wording import Names, cut, make_name, name_program, number_slots, plain


@settings(max_examples=100)
@given(text=st.text(max_size=80), longest=st.integers(6, 40))
def test_any_text_becomes_a_name(text: str, longest: int) -> None:
    name = make_name(text, longest)
    assert name.isascii()
    assert name.replace("_", "a").isalnum()
    assert name[0].isalpha()
    assert len(name) <= longest


@settings(max_examples=60)
@given(texts=st.lists(st.sampled_from(["a b", "a-b", "A_B", "a/b", "board" * 9, "board" * 9 + "x"]), max_size=15))
def test_names_differ_also_without_regard_to_case(texts: list[str]) -> None:
    taken: list[str] = []
    for text in texts:
        taken.append(make_name(text, 12, {each.lower() for each in taken}))
    assert len({name.lower() for name in taken}) == len(texts)
    assert all(len(name) <= 12 for name in taken)


def test_letters_lose_their_accents_and_not_their_meaning() -> None:
    assert make_name("Ω 7/3", 20) == "Ohm_7_3"
    assert plain("Größe µm é \N{SNOWMAN}\n") == "Grosse um e ??"
    assert make_name("7 segments", 20) == "W7_segments"
    assert make_name("", 8) == "W"


@settings(max_examples=60)
@given(text=st.text(max_size=60), longest=st.integers(1, 40))
def test_a_comment_fits(text: str, longest: int) -> None:
    assert len(cut(text, longest)) <= longest
    assert cut(text, longest).isascii()


def test_a_comment_that_is_cut_says_so() -> None:
    assert cut("a long comment", 9) == "a long..."
    assert cut("short", 9) == "short"


@pytest.mark.parametrize(("value", "text"), [(-0.0001, "0.000"), (1.5, "1.500"), (-2.0, "-2.000")])
def test_numbers_have_their_decimals_and_no_negative_zero(value: float, text: str) -> None:
    assert fixed(value, 3) == text


@pytest.mark.parametrize(("value", "text"), [(100.0, "100"), (0.10, "0.1"), (-0.0, "0"), (7.1239, "7.124")])
def test_short_numbers_end_where_they_say_nothing_more(value: float, text: str) -> None:
    assert short(value, 3) == text


def test_names_are_given_once_and_kept() -> None:
    names = Names(Vocabulary("any", 10, frozenset({"main"})), set())
    assert names.give("call", 1, "main") == "main_2"
    assert names.give("call", 1, "anything") == "main_2"
    assert names.give("call", 2, "MAIN_2") == "MAIN_2_2"
    capitals = Names(Vocabulary("any", 6), set(), str.upper, link="X")
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


@pytest.mark.parametrize(("longest", "link"), [(6, ""), (10, ""), (12, "_"), (27, "_"), (60, "_")])
def test_boards_and_recipes_that_are_spelled_alike_give_programs_other_names(longest: int, link: str) -> None:
    words = ["a", "b", "A", "a-b", "a_b", "a.b", "a-", "b-a", "board", "board" * 9, "board" * 9 + "x", "größe", ""]
    pairs = [(board, recipe) for board in words for recipe in words if board]
    names = [name_program(*pair, longest, link) for pair in pairs]
    assert len({name.lower() for name in names}) == len(pairs)
    assert all(len(name) <= longest and name[0].isalpha() and name.isascii() for name in names)
    assert name_program("a-b", "c", 60) == "a_b__c"
    assert name_program("a", "b-c", 60) == "a__b_c"
