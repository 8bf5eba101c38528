"""``washboard recipe``, as a person at a terminal uses it."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from commandline.nouns.recipe import app
from recipes.load import load_recipe, recipe_library


def call(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments], env={"COLUMNS": "160"})


def test_list_names_each_with_its_purpose() -> None:
    result = call("list")
    assert result.exit_code == 0
    for name in recipe_library():
        assert f"{load_recipe(name).description}\n" in result.stdout
        assert f"{name} " in result.stdout


def test_new_then_check(tmp_path: Path) -> None:
    file = tmp_path / "my-board.yaml"
    assert call("new", "low-standoff", "-o", file).exit_code == 0
    assert load_recipe(file).recipe == "my-board"
    result = call("check", file)
    assert (result.exit_code, result.stderr) == (0, "")
    assert "my-board: can be used; 6 steps" in result.stdout


def test_new_overwrites_only_by_force(tmp_path: Path) -> None:
    file = tmp_path / "a.yaml"
    file.write_text("mine")
    result = call("new", "-o", file)
    assert result.exit_code == 2
    assert "--force" in result.stderr
    assert file.read_text() == "mine"
    assert call("new", "-o", file, "--force").exit_code == 0
    assert load_recipe(file).recipe == "a"


def test_new_without_a_place_writes_beside_us(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert call("new", "rinse-only").exit_code == 0
    assert load_recipe(tmp_path / "rinse-only.yaml").recipe == "rinse-only"


def test_a_mistake_is_one_line_on_stderr(tmp_path: Path) -> None:
    file = tmp_path / "a.yaml"
    file.write_text("recipe: a\nextends: smt-aqueous\ntemplates:\n  sweep:\n    sped_mm_s: 3\n")
    for command in ("check", "show"):
        result = call(command, file)
        assert (result.exit_code, result.stdout) == (2, "")
        assert result.stderr.startswith(f"error: {file}:5: templates.sweep.sped_mm_s: unknown key; did you mean")


def test_check_says_what_is_probably_not_meant(tmp_path: Path) -> None:
    file = tmp_path / "a.yaml"
    file.write_text("recipe: a\nextends: smt-aqueous\nclasses: {tall: {height_mm: {min: 9}}}\n")
    result = call("check", file)
    assert result.exit_code == 0
    assert "warning: classes.tall: " in result.stdout
    assert "1 finding\n" in result.stdout


def test_show_resolves_every_value_and_says_where_it_stands() -> None:
    result = call("show", "low-standoff")
    assert result.exit_code == 0
    for word in ("saponifier-15", "ring of 12 points", "bottom_terminated", "what is left", "until resistivity"):
        assert word in result.stdout
    knife = next(line for line in result.stdout.splitlines() if line.startswith("knife"))
    assert "smt-aqueous:" in knife
    own = next(line for line in result.stdout.splitlines() if line.startswith("step_along"))
    assert "smt-aqueous" not in own


@pytest.mark.parametrize("name", recipe_library())
def test_every_library_recipe_can_be_shown(name: str) -> None:
    result = call("show", name)
    assert result.exit_code == 0
    for template in load_recipe(name).templates:
        assert f"\n{template} " in result.stdout


def test_show_knows_every_path_class_and_masks(tmp_path: Path) -> None:
    file = tmp_path / "a.yaml"
    file.write_text(
        "recipe: a\nextends: smt-aqueous\nmasks: [{avoid: ['J*', '[x]'], margin_mm: 3}, {clean: [U1]}]\n"
        "templates: {spot: {path: straight_line, from: [1, 2], to: [3, 4], height_mm: 40, speed_mm_s: 9}}\n"
        "sequence: [{function: rinse, nozzle: ring60, paths: [spot], enabled: false},\n"
        "  {function: rinse, nozzle: ring60, paths: [spot], side: bottom, repeat: 3}]\n"
    )
    shown = call("show", file).stdout
    for words in ("J*, [x]", "(1.0, 2.0) to (3.0, 4.0)", "not enabled", "bottom", "3 x"):
        assert words in shown


def test_schema_and_keys_are_printed_as_committed() -> None:
    root = Path(__file__).parents[3]
    schema = call("schema").stdout
    assert json.loads(schema)
    assert schema == (root / "recipes" / "recipe.schema.json").read_text("utf-8")
    assert call("keys").stdout == (root / "docs" / "recipe-keys.md").read_text("utf-8")
