"""The committed schema of a cell and the table of its keys agree with the model."""

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from ruamel.yaml import YAML
from small_cells import CELL

from robotcell.cell.load import CELL as CELL_FILE
from robotcell.cell.load import cell_keys, cell_library, cell_schema

ROOT = Path(__file__).parents[3]
VALIDATOR = jsonschema.Draft202012Validator(json.loads(cell_schema()))


def read(text: str) -> Any:
    return YAML(typ="safe", pure=True).load(text)


def as_json(value: Any) -> Any:
    """An editor knows tools by their text, as JSON does."""
    return json.loads(json.dumps(value))


def test_the_committed_schema_is_that_of_the_model() -> None:
    committed = (ROOT / "robotcell" / "cell.schema.json").read_text("utf-8")
    assert committed == cell_schema(), "run: washboard cell schema > robotcell/cell.schema.json"


def test_the_committed_table_of_keys_is_that_of_the_model() -> None:
    committed = (ROOT / "docs" / "cell-keys.md").read_text("utf-8")
    assert committed == cell_keys(), "run: washboard cell keys > docs/cell-keys.md"


def test_the_table_has_every_key_of_every_part() -> None:
    table = cell_keys()
    for name, part in {**CELL_FILE.schema()["$defs"], "CellSpec": CELL_FILE.schema()}.items():
        for key, schema in part["properties"].items():
            assert f"| `{key}` |" in table, f"{name}.{key}"
            assert len(schema.get("description", "see there")) > 3, f"{name}.{key}"


@pytest.mark.parametrize("name", cell_library())
def test_library_cells_fit_the_schema_and_name_it(name: str) -> None:
    text = cell_library()[name].read_text("utf-8")
    assert [error.message for error in VALIDATOR.iter_errors(as_json(read(text)))] == []
    assert text.startswith("# yaml-language-server: $schema=../../cell.schema.json\n")
    assert (cell_library()[name].parent / "../../cell.schema.json").exists()


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("cell: small", "cel: small"),
        ("kind: box, ", ""),
        ("kind: box", "kind: bx"),
        ("radius_mm: 8", "radius_mm: -8"),
        ("xyz_mm: [400, -50, 150]", "xyz_m: [400, -50, 150]"),
        ("kind: digital", "kind: analogue"),
    ],
)
def test_an_editor_marks_mistakes(before: str, after: str) -> None:
    assert before in CELL
    assert not list(VALIDATOR.iter_errors(as_json(read(CELL))))
    assert list(VALIDATOR.iter_errors(as_json(read(CELL.replace(before, after, 1)))))
