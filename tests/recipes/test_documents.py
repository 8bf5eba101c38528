"""What docs/recipe.md shows is what Washboard does."""

import re
from pathlib import Path

from recipes.load import load_recipe, parse_recipe, recipe_library
from recipes.paths import FinalFlush
from recipes.schema import recipe_keys

PAGE = (Path(__file__).parents[2] / "docs" / "recipe.md").read_text("utf-8")


def test_the_example_of_extends_does_what_its_comments_say() -> None:
    (example,) = re.findall(r"```yaml\n(recipe:.*?)```", PAGE, re.DOTALL)
    recipe, base = parse_recipe(example), load_recipe("smt-aqueous")
    assert recipe.functions["clean"].temperature_c == base.functions["clean"].temperature_c
    assert recipe.templates["around"].model_dump()["passes"] == {"small": 2, "default": 4, "large": 6}
    assert "step" not in recipe.templates
    assert recipe.templates["sweep"] == FinalFlush(height_mm=50, speed_mm_s=40)


def test_the_page_names_every_path_class_and_every_library_recipe() -> None:
    paths = set(re.findall(r"## templates: (\w+)\n", recipe_keys()))
    assert len(paths) == 6
    for word in (*paths, *recipe_library()):
        assert f"`{word}`" in PAGE
