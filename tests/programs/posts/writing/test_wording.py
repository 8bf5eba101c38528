import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from programs.posts.writing.forms import fixed, short
from programs.posts.writing.wording import cut, make_name, plain


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
        taken.append(make_name(text, 12, taken))
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
