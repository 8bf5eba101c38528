"""Edits change the lines they are about, and what they say, and nothing else."""

import difflib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recipes.load import RECIPE, parse_recipe, recipe_library
from specs.errors import EditError
from specs.yaml.edit import insert_value, move_value, remove_value, rename_key, set_value
from specs.yaml.load import read_text
from specs.yaml.located import read_yaml

DEFAULT = read_text(recipe_library()["smt-aqueous"], RECIPE)
LIBRARY = {name: read_text(path, RECIPE) for name, path in recipe_library().items()}


def changed(before, after):
    """Lines taken out (-) and put in (+)."""
    return [
        line
        for line in difflib.unified_diff(before.splitlines(), after.splitlines(), lineterm="", n=0)
        if not line.startswith(("---", "+++", "@@"))
    ]


def test_a_number_changes_in_its_line_and_the_comment_stays():
    after = set_value(DEFAULT, ("templates", "sweep", "margin_mm"), 12.5)
    assert changed(DEFAULT, after) == [
        "-    margin_mm: 3                  # the cone is wider than this, so the rim is wetted too",
        "+    margin_mm: 12.5               # the cone is wider than this, so the rim is wetted too",
    ]


def test_one_class_of_a_value_by_class_changes_alone():
    after = set_value(DEFAULT, ("templates", "around", "passes", "small"), 3)
    assert changed(DEFAULT, after)[1] == "+    passes: {bottom_terminated: 3, default: 1, small: 3}"


def test_the_same_value_changes_nothing():
    assert set_value(DEFAULT, ("templates", "sweep", "speed_mm_s"), 60.0) == DEFAULT


@pytest.mark.parametrize("name", LIBRARY)
def test_what_is_written_unusually_stays_as_it_is(name):
    strange = LIBRARY[name].replace("recipe: ", "recipe:    ", 1).replace("  clean:", "  'clean' :", 1)
    after = set_value(strange, ("description",), "Something else.")
    lines = changed(strange, after)
    assert [line[0] for line in lines] == ["-", "+"]
    assert lines[1] == "+description: Something else."


@pytest.mark.slow
def test_a_new_template_and_its_step_are_read_back():
    line = {"path": "straight_line", "from": [10.0, 20.5], "to": [60.0, 20.5], "height_mm": 50.0, "speed_mm_s": 40.0}
    text = set_value(DEFAULT, ("templates", "contacts"), line)
    text = insert_value(text, ("sequence", 0, "paths", 1), "contacts")
    assert "    from: [10, 20.5]\n" in text
    assert "    paths: [sweep, contacts, edge, around, step, soak]\n" in text
    recipe = parse_recipe(text)
    assert recipe.templates["contacts"].to_mm == (60.0, 20.5)


@pytest.mark.slow
def test_a_removed_template_takes_its_comments_along():
    text = DEFAULT
    for at in (0, 3):
        text = remove_value(text, ("sequence", at, "paths", 3))
    text = remove_value(text, ("templates", "step"))
    assert "flushes out what has come loose" not in text
    assert "the sweep went along it" not in text
    assert list(parse_recipe(text).templates) == ["edge", "sweep", "around", "soak", "flush", "blow"]


def test_a_step_moves_with_its_lines():
    after = move_value(DEFAULT, ("sequence", 2), 0)
    assert [step.function for step in parse_recipe(after).sequence] == [
        "dry",
        "clean",
        "rinse",
        "clean",
        "rinse",
        "dry",
    ]
    assert sorted(after.splitlines()) == sorted(DEFAULT.splitlines())


def test_the_order_of_classes_changes_with_their_comments():
    after = move_value(DEFAULT, ("classes", "fine_pitch"), 0)
    assert list(parse_recipe(after).classes) == ["fine_pitch", "bottom_terminated", "small", "large"]
    assert sorted(after.splitlines()) == sorted(DEFAULT.splitlines())


def test_a_renamed_template_keeps_its_place_and_its_comment():
    text = rename_key(DEFAULT, ("templates", "around"), "rings")
    assert list(read_yaml(text, "x", RECIPE).plain()["templates"]) == [
        *("edge", "sweep", "rings", "step", "soak", "flush", "blow")
    ]
    (line,) = [line for line in text.splitlines() if line.startswith("  rings:")]
    assert line.endswith("# around every component, from outside, with the near wave front on its edge")
    with pytest.raises(EditError, match="'sweep' is there already"):
        rename_key(text, ("templates", "rings"), "sweep")


def test_what_is_inherited_is_overridden_and_removed_in_the_own_file():
    text = "recipe: mine\nextends: smt-aqueous # the house recipe\n"
    text = set_value(text, ("templates", "sweep", "speed_mm_s"), 50.0)
    text = remove_value(text, ("classes", "fine_pitch"))
    assert text.startswith("recipe: mine\nextends: smt-aqueous # the house recipe\n")
    recipe = parse_recipe(text)
    assert recipe.templates["sweep"].speed_mm_s == 50.0
    assert "fine_pitch" not in recipe.classes


def test_a_value_that_an_anchor_shares_is_not_changed_in_two_places():
    text = "a: &x {speed: 1, tilt: 2}\nb: *x\n"
    with pytest.raises(EditError, match=r"b\.speed: shared by an anchor"):
        set_value(text, ("b", "speed"), 3)


@pytest.mark.parametrize("path", [("sequence", 9, "nozzle"), ("recipe", "x"), ("templates", 0)])
def test_what_is_not_there_is_not_changed(path):
    with pytest.raises(EditError):
        set_value(DEFAULT, path, 1)


def test_what_is_not_there_is_not_moved_or_removed():
    with pytest.raises(EditError, match=r"^sequence\[9\]: there is nothing"):
        remove_value(DEFAULT, ("sequence", 9))
    with pytest.raises(EditError, match=r"^classes\.none: there is nothing"):
        move_value(DEFAULT, ("classes", "none"), 0)


VALUES = st.one_of(
    st.integers(-1000, 1000),
    st.floats(-1e4, 1e4).map(lambda value: round(value, 4)),
    st.booleans(),
    st.text(st.characters(codec="ascii", categories=["L", "N", "P", "Zs"]), max_size=20),
    st.dictionaries(st.sampled_from(["small", "large", "default"]), st.integers(0, 9), min_size=1),
    st.lists(st.integers(0, 9), min_size=1, max_size=4),
)
PLACES = st.sampled_from(
    [("description",), ("templates", "around", "passes"), ("sequence", 1, "until"), ("limits", "blend_mm"), ("masks",)]
)


@pytest.mark.slow
@settings(max_examples=15)
@given(place=PLACES, value=VALUES)
def test_any_value_reads_back_and_putting_the_old_one_back_restores_the_meaning(place, value):
    old = read_yaml(DEFAULT, "x", RECIPE).at(place).plain()
    missing = place == ("limits", "blend_mm")
    text = set_value(DEFAULT, place, value)
    assert read_yaml(text, "x", RECIPE).at(place).plain() == value
    back = remove_value(text, place) if missing else set_value(text, place, old)
    assert read_yaml(back, "x", RECIPE).plain() == read_yaml(DEFAULT, "x", RECIPE).plain()
    assert sum(line not in DEFAULT.splitlines() for line in back.splitlines()) <= 3


def scalars(located, path=()):
    if isinstance(located.value, dict):
        for key, inner in located.value.items():
            yield from scalars(inner, (*path, key))
    elif isinstance(located.value, list):
        for index, inner in enumerate(located.value):
            yield from scalars(inner, (*path, index))
    else:
        yield path, located.value


@pytest.mark.slow
@pytest.mark.parametrize("name", LIBRARY)
def test_a_number_or_word_replaced_in_its_line_reads_as_the_round_trip_writes_it(name, monkeypatch):
    text = LIBRARY[name]
    changes = [
        (path, {int: 7, float: 123456.75, str: "a_word_that_is_longer_than_the_one_before"}[type(value)])
        for path, value in scalars(read_yaml(text, "x", RECIPE))
        if type(value) in (int, float, str)
    ]
    quick = {path: set_value(text, path, value) for path, value in changes[::9]}
    monkeypatch.setattr("specs.yaml.edit._replace_in_line", lambda *_: None)
    assert quick == {path: set_value(text, path, value) for path, value in changes[::9]}


def test_a_key_that_is_a_number_is_found():
    text = "tools:\n  1: {tcp: [0, 0, 600]} # the long one\n  2: {tcp: [0, 0, 180]}\n"
    assert set_value(text, ("tools", "1", "tcp"), [0, 0, 180]) == text.replace("600", "180")
