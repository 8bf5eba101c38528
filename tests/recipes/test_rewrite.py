"""What is only inherited can be changed as well, and nothing that is not concerned is written."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recipes.errors import RecipeError
from recipes.load import RECIPE, parse_recipe, recipe_library
from recipes.rewrite import insert, move, remove, rename, write_values
from specs.errors import EditError
from specs.yaml.load import read_text, resolve_text

SMT = recipe_library()["smt-aqueous"]
OWN = "recipe: mine\nextends: smt-aqueous  # as it comes\n"
MASK = {"avoid": ["U1"]}
TALL = {"height_mm": {"min": 9.0}}


@pytest.fixture
def file(tmp_path):
    return tmp_path / "mine.yaml"


def read(text, file):
    return parse_recipe(text, file=file)


@pytest.fixture
def base(file):
    return read(OWN, file)


def test_a_value_is_written_alone(file):
    after = write_values(OWN, file, {("templates", "sweep", "speed_mm_s"): 30})
    assert after == OWN + "templates:\n  sweep:\n    speed_mm_s: 30\n"


@pytest.mark.slow
def test_values_are_written_in_their_order(file):
    after = write_values(OWN, file, {("sequence", 0, "paths"): ["sweep"], ("sequence", 0, "paths", 0): "edge"})
    assert read(after, file).sequence[0].paths == ["edge"]


def test_a_step_changes_in_a_copy_of_the_sequence(file, base):
    after = write_values(OWN, file, {("sequence", 1, "paths"): ["sweep"]})
    steps = read(after, file).sequence
    assert after.startswith(OWN)
    assert steps[1].paths == ["sweep"]
    assert (steps[0], *steps[2:]) == (base.sequence[0], *base.sequence[2:])


def test_a_mask_is_added_to_those_that_are_inherited(file):
    first = insert(OWN, file, ("masks", 0), MASK)
    assert len(read(first, file).masks) == 1
    file.write_text(first)
    child = insert("recipe: child\nextends: mine.yaml\n", file.with_name("child.yaml"), ("masks", 1), MASK)
    assert len(read(child, file.with_name("child.yaml")).masks) == 2


def test_an_inherited_step_is_taken_out(file, base):
    after = remove(OWN, file, ("sequence", 0))
    assert read(after, file).sequence == base.sequence[1:]


def test_an_inherited_name_is_taken_out_by_nothing_and_an_own_one_goes(file, base):
    classes = list(base.classes)
    own = write_values(OWN, file, {("classes", "tall"): TALL})
    assert list(read(own, file).classes) == [*classes, "tall"]
    assert resolve_text(remove(own, file, ("classes", "tall")), file, RECIPE).plain() == (
        resolve_text(OWN, file, RECIPE).plain()
    )
    gone = write_values(OWN, file, {("templates", "around", "passes", "bottom_terminated"): None})
    assert gone.endswith("      bottom_terminated:\n")
    assert "bottom_terminated" not in read(gone, file).templates["around"].passes


def test_what_is_not_there_is_taken_out_already(file):
    assert remove(OWN, file, ("classes", "nobody")) == OWN


def test_inherited_names_change_their_order_and_keep_what_they_say(file, base):
    names = list(base.classes)
    classes = read(move(OWN, file, ("classes", names[-1]), 0), file).classes
    assert list(classes) == [names[-1], *names[:-1]]
    assert classes == base.classes


def test_a_name_that_is_inherited_stays(file):
    own = write_values(OWN, file, {("classes", "tall"): TALL})
    assert "high" in read(rename(own, file, ("classes", "tall"), "high"), file).classes
    with pytest.raises(RecipeError, match=r"templates\.sweep: is inherited and keeps its name"):
        rename(OWN, file, ("templates", "sweep"), "broom")


def test_a_step_that_is_not_there_is_refused(file):
    with pytest.raises(EditError):
        write_values(OWN, file, {("sequence", 9, "paths"): ["sweep"]})


@pytest.mark.slow
@settings(max_examples=15)
@given(data=st.data())
def test_steps_that_are_moved_are_the_same_steps(data):
    steps = parse_recipe(read_text(SMT, RECIPE), file=SMT).sequence
    at, to = (data.draw(st.integers(0, len(steps) - 1)) for _ in range(2))
    expected = [step for number, step in enumerate(steps) if number != at]
    expected.insert(to, steps[at])
    file = SMT.with_name("mine.yaml")
    assert read(move(OWN, file, ("sequence", at), to), file).sequence == expected


@pytest.mark.parametrize("path", [(), ("a",) * 20_000, ("sequence", *[0] * 5_000)], ids=["none", "names", "places"])
def test_a_path_of_no_keys_or_of_far_too_many_is_refused(path, file):
    for value in (1, None):
        with pytest.raises(RecipeError, match="a path has 1 to 32 keys"):
            write_values(OWN, file, {path: value})
