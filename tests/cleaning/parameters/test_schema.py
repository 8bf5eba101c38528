"""The committed schema of a parameter set and the table of its keys say what the model says."""

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from ruamel.yaml import YAML

from cleaning.parameters.load import PARAMETERS, parameter_library
from cleaning.parameters.schema import parameters_keys, parameters_schema

ROOT = Path(__file__).parents[3]
VALIDATOR = jsonschema.Draft202012Validator(json.loads(parameters_schema()))
DEFAULT = parameter_library()["default"].read_text("utf-8")


def errors(text: str) -> list[str]:
    return [error.message for error in VALIDATOR.iter_errors(YAML(typ="safe", pure=True).load(text))]


def test_the_committed_schema_is_that_of_the_model() -> None:
    committed = (ROOT / "cleaning" / "parameters.schema.json").read_text("utf-8")
    assert committed == parameters_schema(), "run: washboard parameters schema > cleaning/parameters.schema.json"


def test_the_committed_table_of_keys_is_that_of_the_model() -> None:
    committed = (ROOT / "docs" / "parameter-keys.md").read_text("utf-8")
    assert committed == parameters_keys(), "run: washboard parameters keys > docs/parameter-keys.md"


def test_the_table_has_every_key_of_every_part() -> None:
    whole: dict[str, Any] = PARAMETERS.schema()
    for name, part in {**whole["$defs"], "Parameters": whole}.items():
        for key, schema in part["properties"].items():
            assert f"| `{key}` |" in parameters_keys(), f"{name}.{key}"
            assert len(schema.get("description", "see there")) > 3, f"{name}.{key}"


@pytest.mark.parametrize("name", parameter_library())
def test_library_sets_fit_the_schema_and_name_it(name: str) -> None:
    text = parameter_library()[name].read_text("utf-8")
    assert errors(text) == []
    assert text.startswith("# yaml-language-server: $schema=../parameters.schema.json\n")
    assert (parameter_library()[name].parent / "../parameters.schema.json").exists()


@pytest.mark.parametrize(
    "text",
    [
        DEFAULT.replace("k1_per_s: 0.012", "k1_per_sec: 0.012"),
        DEFAULT.replace("k1_per_s: 0.012", "k1_per_s: 0"),
        DEFAULT.replace("use: wash", "use: soak"),
        DEFAULT.replace("soil: {known: proposed", "soil: {known: sure"),
        "parameters: mine\nextends: default\nsoil: {k1: 1}\n",
    ],
)
def test_an_editor_marks_mistakes(text: str) -> None:
    assert errors(text)


def test_a_set_that_extends_another_needs_nothing_else_and_may_remove() -> None:
    assert errors("parameters: mine\nextends: default\nliquids: {di-water: null}\nsoil: {front_um: 3}\n") == []
