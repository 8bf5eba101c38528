"""Whatever stands in the file: a recipe or one clear error, never anything else."""

import string

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recipes.errors import RecipeError
from recipes.load import parse_recipe, recipe_library
from recipes.recipe import Recipe

LIBRARY = [path.read_text("utf-8") for path in recipe_library().values()]
LINES = sorted({line for text in LIBRARY for line in text.splitlines()})
ODD_VALUES = st.sampled_from(
    [
        *("", "null", "true", "-1", "0", "1e3", "1e999", ".nan", "-.inf", "012", "0x1F", "1_0", "'60'", "sixty"),
        *("[]", "{}", "[1, 2]", "{a: 1}", "{default: 2}", "{small: x}", "&a [*a]", "*b", "!!python/none x", "<<: {}"),
        *(
            "2024-01-01",
            "on",
            "=",
            "~",
            '"\\ud800"',
            '"\\0"',
            "!!bool x",
            "!!int ''",
            "/dev/zero",
            ".",
            "smt-aqueous",
            "9" * 400,
        ),
    ]
)
YAMLISH = st.text(alphabet=string.ascii_lowercase + string.digits + " \n\t:-[]{},&*!|>'\"#%@`.<~?", max_size=120)
FUZZ = settings(max_examples=40)


def read(text: str) -> None:
    """Read a text and hold what comes of it against the promise."""
    said = ""
    try:
        assert isinstance(parse_recipe(text, file="fuzz.yaml"), Recipe)
    except RecipeError as error:
        said = str(error)
    assert not said or "fuzz.yaml" in said or "smt-aqueous.yaml" in said
    assert said.encode("utf-8").decode() == said


@FUZZ
@given(st.text(max_size=200) | YAMLISH)
def test_any_text(text: str) -> None:
    read(text)


@FUZZ
@given(st.lists(st.sampled_from(LINES), max_size=25))
def test_lines_of_the_library_in_any_order(lines: list[str]) -> None:
    read("\n".join(lines))


@pytest.mark.slow
@FUZZ
@given(st.sampled_from(LIBRARY), st.data())
def test_library_recipes_with_one_value_changed(text: str, data: st.DataObject) -> None:
    lines = text.splitlines()
    places = [index for index, line in enumerate(lines) if ":" in line and not line.lstrip().startswith("#")]
    place = data.draw(st.sampled_from(places))
    key = lines[place].split(":")[0]
    lines[place] = f"{key}: {data.draw(ODD_VALUES)}"
    read("\n".join(lines))


@pytest.mark.slow
@FUZZ
@given(st.sampled_from(LIBRARY), st.data())
def test_library_recipes_cut_and_pasted(text: str, data: st.DataObject) -> None:
    begin = data.draw(st.integers(0, len(text)))
    end = data.draw(st.integers(begin, min(len(text), begin + 80)))
    read(text[:begin] + data.draw(YAMLISH) + text[end:])


@pytest.mark.slow
@FUZZ
@given(st.sampled_from(LIBRARY), st.data())
def test_library_recipes_with_lines_gone_or_doubled(text: str, data: st.DataObject) -> None:
    lines = text.splitlines()
    place = data.draw(st.integers(0, len(lines) - 1))
    lines[place : place + 1] = data.draw(st.sampled_from([[], [lines[place]] * 2, [" " + lines[place]]]))
    read("\n".join(lines))
