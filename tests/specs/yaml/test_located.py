"""Values are read as YAML 1.2 says, know their line, and cannot blow up."""

import re

import pytest

from recipes.errors import RecipeError
from recipes.load import RECIPE
from specs.yaml import located
from specs.yaml.located import read_yaml, spell_path


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("012", 12),
        ("1e3", 1000.0),
        ("0o14", 12),
        ("on", "on"),
        ("12:30", "12:30"),
        ("2024-01-01", "2024-01-01"),
        ("1005_C", "1005_C"),
        ("true", True),
        ("~", None),
        ("'60'", "60"),
        ("=", "="),
    ],
)
def test_scalars_are_yaml_1_2(text: str, value: object) -> None:
    read = read_yaml(f"a: {text}", "f", RECIPE).plain()["a"]
    assert read == value
    assert type(read) is type(value)


def test_every_value_knows_its_line() -> None:
    root = read_yaml("a: 1\n\nb:\n  - x\n  - {c: 2}\n", "f", RECIPE)
    assert root.at(("a",)).mark.line == 1
    assert root.at(("b",)).mark.line == 3
    assert root.at(("b", 1)).mark.line == 5
    assert root.at(("b", 1, "c", "deeper")).plain() == 2


def test_an_item_is_found_by_its_number_and_no_other_number_finds_one() -> None:
    root = read_yaml("b: [x, y]", "f", RECIPE)
    found = [root.find(("b", number)) for number in (-2, -1, 0, 1, 2)]
    assert [each and each.plain() for each in found] == [None, None, "x", "y", None]


def test_aliases_and_merge_keys_bring_values_from_where_they_were_written() -> None:
    root = read_yaml("base: &b\n  x: 1\n  y: 2\nother:\n  <<: *b\n  y: 3\nsame: *b\n", "f", RECIPE)
    assert root.plain()["other"] == {"x": 1, "y": 3}
    assert root.plain()["same"] == {"x": 1, "y": 2}
    assert root.at(("other", "x")).mark.line == 2
    assert root.at(("other", "y")).mark.line == 6


def test_of_several_merged_mappings_the_first_wins() -> None:
    root = read_yaml("a: &a {x: 1}\nb: &b {x: 2, y: 2}\nc: {<<: [*a, *b]}\n", "f", RECIPE)
    assert root.plain()["c"] == {"x": 1, "y": 2}


def test_an_anchor_may_be_set_anew() -> None:
    assert read_yaml("a: &x 1\nb: &x 2\nc: *x\n", "f", RECIPE).plain()["c"] == 2


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("a: 1\nb: 2\na: 3", 3, "stands twice; line 1"),
        ("a: 1\na: 2\nb: [", 2, "f.yaml:2: key 'a' stands twice; line 1 has it too"),
        ("- {b: 1,\n   'b': 2}\n- {b: [", 2, "key 'b' stands twice; line 1 has it too"),
        ("a:\n\tb: 1", 2, "indent with spaces"),
        ("a: [*QFN]", 1, "in quotes"),
        ("a: b: c", 1, "holds a colon"),
        ("a: 1\n---\nb: 2", 2, "one document"),
        ("a: [1,\n2", 2, "not valid YAML"),
        ("- 1", 1, "mapping of keys"),
        ("? [a]\n: 1", 1, "a key must be a word"),
        ("a: 1\ntempl\u202eate: 1", 2, "key 'templ\\u202eate' holds a character that cannot be seen"),
        ('a: 1\n"b\\nc": 1', 2, "key 'b\\nc' holds a character that cannot be seen"),
        ("a: {b" + ">" * 500 + ": 1}", 1, "a key of 501 characters"),
        ("a: !foo 1", 1, "tag !foo"),
        ("a: !!binary aGk=", 1, "not allowed"),
        ("a: !!bool x", 1, "cannot be read as bool"),
        ("a: " + "9" * 5000, 1, "cannot be read as int"),
        ('a: 1\nb: "\\ud800"', 2, "surrogate"),
        ("a: 1\nb: \x01", 2, "does not allow"),
        ("a: {<<: 3}", 1, "<< merges"),
        ("a: &a [*a]", 1, "alias may hold itself"),
        ("a: " + "[" * 40 + "]" * 40, 1, "30 deep"),
    ],
)
def test_refused_with_the_line(text: str, line: int, message: str) -> None:
    with pytest.raises(RecipeError, match=re.escape(message)) as caught:
        read_yaml(text, "f.yaml", RECIPE)
    assert caught.value.line == line
    assert str(caught.value).startswith(f"f.yaml:{line}: ")


@pytest.mark.parametrize("text", ["", "# only a comment\n", "---\n", "~"])
def test_empty(text: str) -> None:
    with pytest.raises(RecipeError, match="empty"):
        read_yaml(text, "f", RECIPE)


@pytest.mark.slow
@pytest.mark.parametrize("opening", ["[", "{a: ", "- ", "? ", "{? ", "[{a: "])
@pytest.mark.parametrize("depth", [31, 200, 100_000])
def test_deep_nesting_is_refused_as_soon_as_it_is_seen(opening: str, depth: int) -> None:
    with pytest.raises(RecipeError, match="nested more than 30 deep; a recipe needs far less") as caught:
        read_yaml("a:\n  " + opening * depth, "f", RECIPE)
    assert caught.value.line == 2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: &a " + "x" * 900_000 + "\nb: [*a, *a, *a]", "expands to more than 2,000,000 characters"),
        ("a: [" + "1," * 45_000 + "]", "more than 20,000 values"),
        ("a: 0x" + "f" * 900_000, "cannot be read as int"),
        ("a: &a {<<: *a, b: 1}", "an alias may hold itself"),
        (
            "a0: &a0 {x: 1}\n" + "".join(f"a{i}: &a{i} {{<<: [{f'*a{i - 1}, ' * 9}]}}\n" for i in range(1, 20)),
            "expands to more than 20,000 values",
        ),
    ],
    ids=["text of aliases", "values", "digits", "merge of itself", "merges of merges"],
)
def test_what_would_fill_the_memory_is_refused(text: str, message: str) -> None:
    with pytest.raises(RecipeError, match=message):
        read_yaml(text, "f", RECIPE)


def test_an_alias_bomb_is_refused() -> None:
    bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n"
    bomb += "".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]\n" for i in range(1, 12))
    with pytest.raises(RecipeError, match="expands to more than"):
        read_yaml(bomb, "f", RECIPE)


def test_a_text_of_megabytes_is_refused() -> None:
    with pytest.raises(RecipeError, match="too many"):
        read_yaml("# " + "x" * 5_000_000, "f", RECIPE)


def test_paths_are_spelt_as_in_the_documents() -> None:
    assert spell_path(("sequence", 0, "paths", 2)) == "sequence[0].paths[2]"
    assert spell_path(("templates", "sweep", "speed_mm_s")) == "templates.sweep.speed_mm_s"


def test_a_text_is_composed_once_though_others_are_read_between():
    text = "recipe: remembered\nlimits: &all {clearance_mm: 5}\nmore: {<<: *all, of: [1, two, 3.5]}\n"
    first = read_yaml(text, "first.yaml", RECIPE)
    for number in range(10):
        read_yaml(f"recipe: between-{number}\n", "between.yaml", RECIPE)
    composed = located._compose_short.cache_info().misses
    again = read_yaml(text, "again.yaml", RECIPE)
    assert located._compose_short.cache_info().misses == composed
    assert again.plain() == first.plain() == {
        "recipe": "remembered",
        "limits": {"clearance_mm": 5},
        "more": {"clearance_mm": 5, "of": [1, "two", 3.5]},
    }  # fmt: skip
    assert (first.mark.file, again.mark.file) == ("first.yaml", "again.yaml")
