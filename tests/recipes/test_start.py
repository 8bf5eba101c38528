"""A new recipe is a working copy with its comments."""

from pathlib import Path

import pytest

from recipes.errors import RecipeError
from recipes.load import load_recipe, parse_recipe, recipe_library
from recipes.start import start_recipe


@pytest.mark.parametrize("name", recipe_library())
def test_a_copy_says_the_same_under_its_own_name(name: str, tmp_path: Path) -> None:
    text = start_recipe(name, tmp_path / "my-board.yaml")
    original = parse_recipe(recipe_library()[name].read_text("utf-8"))
    assert parse_recipe(text) == original.model_copy(update={"recipe": "my-board"})
    assert "# When to use it" in text
    assert "$schema=recipe.schema.json\n" in text


def test_a_copy_in_another_folder_still_finds_what_it_extends(tmp_path: Path) -> None:
    (tmp_path / "site").mkdir()
    (tmp_path / "site" / "base.yaml").write_text("recipe: base\nextends: smt-aqueous\nlimits: {clearance_mm: 7}\n")
    (tmp_path / "site" / "one.yaml").write_text("recipe: one\nextends: 'base.yaml'  # ours\n")
    text = start_recipe(tmp_path / "site" / "one.yaml", tmp_path / "two.yaml")
    assert text == "recipe: two\nextends: 'site/base.yaml' # ours\n"
    assert parse_recipe(text, file=tmp_path / "two.yaml").limits.clearance_mm == 7


def test_a_name_that_no_recipe_can_bear(tmp_path: Path) -> None:
    with pytest.raises(RecipeError, match="cannot name a recipe"):
        start_recipe("smt-aqueous", tmp_path / "my board.yaml")


@pytest.mark.parametrize(
    "text",
    [
        "recipe: one\nextends: my base.yaml\n",
        "recipe: one\nextends: 'my base.yaml'  # with a blank\n",
        "{extends: my base.yaml, recipe: one}\n",
        "recipe:\n  one\nextends:\n  my base.yaml\n",
        "recipe: >-\n  one\nextends: &base my base.yaml\n",
    ],
)
def test_a_recipe_is_placed_however_its_yaml_is_written(tmp_path: Path, text: str) -> None:
    (tmp_path / "my base.yaml").write_text(recipe_library()["rinse-only"].read_text("utf-8"))
    (tmp_path / "one.yaml").write_text(text)
    (tmp_path / "sub").mkdir()
    for place in ("two.yaml", "sub/two.yaml"):
        written = tmp_path / place
        written.write_text(start_recipe(tmp_path / "one.yaml", written))
        assert load_recipe(written).recipe == "two"
