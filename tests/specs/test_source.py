import pytest
from hypothesis import given
from hypothesis import strategies as st

from specs.source import NO_SOURCE, Source


@pytest.mark.parametrize(
    ("text", "source", "path"),
    [
        ("sequence[0]/around/U12+U13", Source(0, "around", ("U12", "U13")), ("templates", "around")),
        ("sequence[1]/sweep/transfer", Source(1, "sweep", motion="transfer"), ("templates", "sweep")),
        ("sequence[0]/step/U3/transfer", Source(0, "step", ("U3",), "transfer"), ("templates", "step")),
        ("sequence[2]/park", Source(2, motion="park"), ("sequence", 2)),
        ("sequence[10]", Source(10), ("sequence", 10)),
        ("classes/small", Source(entry="classes/small"), ("classes", "small")),
        ("templates.around.near", Source(entry="templates.around.near"), ("templates", "around", "near")),
        ("masks[2]", Source(entry="masks[2]"), ("masks", 2)),
        ("", NO_SOURCE, ()),
    ],
)
def test_text_and_source_are_two_forms_of_one_thing(text, source, path):
    assert Source.parse(text) == source
    assert str(source) == text
    assert source.recipe_path == path
    assert bool(source) == bool(text)


def test_the_place_of_a_stroke_is_its_template_in_its_step():
    assert Source(0, "around", ("U12",), "transfer").place == Source(0, "around")
    assert Source(2, motion="park").place == Source(2, motion="park")
    assert Source(entry="masks").place == Source(entry="masks")


@pytest.mark.slow
@given(st.text() | st.from_regex(r"sequence\[\d{1,3}\](/[a-z+]{0,4}){0,4}", fullmatch=True))
def test_any_text_of_a_file_is_kept_as_it_stands(text):
    assert str(Source.parse(text)) == text
