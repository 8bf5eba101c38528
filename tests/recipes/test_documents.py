"""What docs/recipe.md and docs/planning.md show is what Washboard does."""

import re
from pathlib import Path

from recipes.load import load_recipe, parse_recipe, recipe_library
from recipes.paths import PATH_CLASSES, FinalFlush
from recipes.schema import recipe_keys

DOCS = Path(__file__).parents[2] / "docs"
PAGE, PLANNING = ((DOCS / name).read_text("utf-8") for name in ("recipe.md", "planning.md"))


def test_the_example_of_extends_does_what_its_comments_say() -> None:
    (example,) = re.findall(r"```yaml\n(recipe:.*?)```", PAGE, re.DOTALL)
    recipe, base = parse_recipe(example), load_recipe("smt-aqueous")
    assert recipe.functions["clean"].temperature_c == base.functions["clean"].temperature_c
    assert recipe.templates["around"].model_dump()["passes"] == {"bottom_terminated": 3, "default": 1, "large": 6}
    assert "step" not in recipe.templates
    assert recipe.templates["sweep"] == FinalFlush(height_mm=50, speed_mm_s=40)


def test_the_page_names_every_path_class_and_every_library_recipe() -> None:
    paths = [spec.model_fields["path"].default for spec in PATH_CLASSES]
    assert re.findall(r"## templates: (\w+)\n", recipe_keys()) == paths
    for word in (*paths, *recipe_library()):
        assert f"`{word}`" in PAGE, f"docs/recipe.md: add {word} to its table"


def test_the_page_on_planning_has_a_row_for_every_path_class() -> None:
    for spec in PATH_CLASSES:
        row = f"| `{spec.model_fields['path'].default}` |"
        assert row in PLANNING, f"docs/planning.md: add a row {row} to the table of path classes"
