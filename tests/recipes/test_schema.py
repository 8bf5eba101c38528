"""The committed schema and the table of keys say what the model says."""

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from ruamel.yaml import YAML

from recipes.load import RECIPE, recipe_library
from recipes.schema import recipe_keys, recipe_schema
from specs.yaml.schema import known_keys, name_nearest

ROOT = Path(__file__).parents[2]
VALIDATOR = jsonschema.Draft202012Validator(json.loads(recipe_schema()))


def read(text: str) -> Any:
    return YAML(typ="safe", pure=True).load(text)


def test_the_committed_schema_is_that_of_the_model() -> None:
    committed = (ROOT / "recipes" / "recipe.schema.json").read_text("utf-8")
    assert committed == recipe_schema(), "run: washboard recipe schema > recipes/recipe.schema.json"


def test_the_committed_table_of_keys_is_that_of_the_model() -> None:
    committed = (ROOT / "docs" / "recipe-keys.md").read_text("utf-8")
    assert committed == recipe_keys(), "run: washboard recipe keys > docs/recipe-keys.md"


@pytest.mark.slow
def test_the_schema_is_one() -> None:
    jsonschema.Draft202012Validator.check_schema(json.loads(recipe_schema()))
    assert json.loads(recipe_schema())["title"] == "Washboard recipe"


def test_every_key_has_a_description() -> None:
    parts = {**RECIPE.schema()["$defs"], "Recipe": RECIPE.schema()}
    for name, part in parts.items():
        assert part["description"], name
        for key, schema in part["properties"].items():
            described = schema if "description" in schema else parts[schema["$ref"].rsplit("/", 1)[-1]]
            assert len(described["description"]) > 3, f"{name}.{key}"


@pytest.mark.parametrize("name", recipe_library())
def test_library_recipes_fit_the_schema_and_name_it(name: str) -> None:
    text = recipe_library()[name].read_text("utf-8")
    assert [error.message for error in VALIDATOR.iter_errors(read(text))] == []
    assert text.startswith("# yaml-language-server: $schema=../recipe.schema.json\n")
    assert (recipe_library()[name].parent / "../recipe.schema.json").exists()


@pytest.mark.parametrize(
    "text",
    [
        "recipe: a",
        "recipe: a\nextends: smt-aqueous\nlimit: {}",
        "recipe: a\nextends: smt-aqueous\ntemplates: {sweep: {sped_mm_s: 3}}",
        "recipe: a\nextends: smt-aqueous\ntemplates: {sweep: {path: rastr}}",
        "recipe: a\nextends: smt-aqueous\nfunctions: {clean: {pressure_bar: -1}}",
    ],
)
def test_an_editor_marks_mistakes(text: str) -> None:
    assert list(VALIDATOR.iter_errors(read(text)))


def test_a_template_without_its_path_class_is_marked_unless_it_may_be_inherited() -> None:
    whole = read(recipe_library()["smt-aqueous"].read_text("utf-8"))
    assert not list(VALIDATOR.iter_errors(whole))
    del whole["templates"]["sweep"]["path"]
    assert list(VALIDATOR.iter_errors(whole))
    assert not list(VALIDATOR.iter_errors({**whole, "extends": "smt-aqueous"}))


def test_known_keys_follow_the_path_class() -> None:
    data = {"templates": {"a": {"path": "raster", "pitch_mm": {}}, "b": {"path": "nonsense"}}}
    assert "pitch_mm" in known_keys(("templates", "a"), data, RECIPE)
    assert "passes" not in known_keys(("templates", "a"), data, RECIPE)
    assert known_keys(("templates", "b"), data, RECIPE) == {}
    assert "from" in known_keys(("templates", "c"), {"templates": {"c": {"path": "straight_line"}}}, RECIPE)
    assert "max_repeats" in known_keys(("sequence", 0, "until"), {"sequence": [{"until": {}}]}, RECIPE)


def test_the_nearest_name_is_given_if_there_is_one_near() -> None:
    assert name_nearest("swep", ["edge", "sweep"]) == "did you mean 'sweep'? Known: edge, sweep"
    assert name_nearest("zzz", ["edge", "sweep"]) == "known: edge, sweep"
