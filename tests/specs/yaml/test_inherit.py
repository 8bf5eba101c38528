"""A recipe that extends another says only what is different."""

from pathlib import Path

import pytest

from recipes.errors import RecipeError
from recipes.load import load_recipe, parse_recipe
from recipes.nozzles import FullCone
from recipes.paths import FinalFlush, Raster
from recipes.recipe import Recipe

HEAD = "recipe: mine\nextends: smt-aqueous\n"
BASE = load_recipe("smt-aqueous")


def extend(text: str) -> Recipe:
    return parse_recipe(HEAD + text, file="mine.yaml")


def test_nothing_said_nothing_changed() -> None:
    assert extend("") == BASE.model_copy(update={"recipe": "mine", "extends": "smt-aqueous"})


def test_mappings_merge_and_values_replace() -> None:
    recipe = extend("templates: {around: {passes: {large: 6}, speed_mm_s: 30}}\nlimits: {clearance_mm: 8}\n")
    around = recipe.templates["around"].model_dump()
    assert around["passes"] == {"bottom_terminated": 3, "default": 1, "large": 6}
    assert around["speed_mm_s"] == 30
    assert around["tilt_deg"] == 35
    assert recipe.limits.clearance_mm == 8
    assert recipe.limits.park_height_mm == BASE.limits.park_height_mm


def test_lists_replace() -> None:
    assert extend("classes: {bottom_terminated: {package: [QFN*]}}\n").classes["bottom_terminated"].package == ["QFN*"]
    assert len(extend("sequence: [{function: rinse, nozzle: ring60, paths: [sweep]}]\n").sequence) == 1


def test_null_removes() -> None:
    recipe = extend(
        "templates: {around: {edge_delay_s: null}, step: null}\n"
        "sequence: [{function: rinse, nozzle: ring60, paths: [around]}]\n"
    )
    assert "step" not in recipe.templates
    assert recipe.templates["around"].model_dump()["edge_delay_s"] == 0


def test_null_for_a_name_that_is_not_inherited_is_a_mistake() -> None:
    with pytest.raises(RecipeError, match="did you mean 'step'") as caught:
        extend("templates:\n  stepp: null\n")
    assert (caught.value.path, caught.value.line) == ("templates.stepp", 4)


def test_another_path_class_replaces_the_template_whole() -> None:
    recipe = extend("templates: {sweep: {path: final_flush, height_mm: 55, speed_mm_s: 30}}\n")
    assert recipe.templates["sweep"] == FinalFlush(height_mm=55, speed_mm_s=30)
    assert isinstance(extend("templates: {sweep: {path: raster, height_mm: 55}}\n").templates["sweep"], Raster)


def test_another_pattern_replaces_the_nozzle_whole() -> None:
    recipe = extend("nozzles: {ring60: {pattern: full_cone, half_angle_deg: 25, flow_lpm: 3}}\n")
    assert recipe.nozzles["ring60"] == FullCone(half_angle_deg=25, flow_lpm=3)


def test_inherited_classes_come_first_unless_all_are_listed() -> None:
    inherited = list(BASE.classes)
    assert list(extend("classes: {tall: {height_mm: {min: 9}}}\n").classes) == [*inherited, "tall"]
    listed = ["tall: {height_mm: {min: 9}}", *(f"{name}: {{}}" for name in reversed(inherited))]
    recipe = extend("classes:\n" + "".join(f"  {line}\n" for line in listed))
    assert list(recipe.classes) == ["tall", *reversed(inherited)]
    assert recipe.classes["small"] == BASE.classes["small"]


def test_files_are_looked_for_beside_the_file_that_extends_them(tmp_path: Path) -> None:
    (tmp_path / "site").mkdir()
    (tmp_path / "site" / "base.yaml").write_text("recipe: base\nextends: smt-aqueous\nlimits: {clearance_mm: 7}\n")
    (tmp_path / "board.yaml").write_text("recipe: board\nextends: site/base.yaml\nlimits: {blend_mm: 1}\n")
    recipe = load_recipe(tmp_path / "board.yaml")
    assert (recipe.recipe, recipe.limits.clearance_mm, recipe.limits.blend_mm) == ("board", 7, 1)


def test_an_error_in_an_inherited_part_names_the_file_it_stands_in(tmp_path: Path) -> None:
    (tmp_path / "base.yaml").write_text("recipe: base\nextends: smt-aqueous\nlimits:\n  clearance_mm: -1\n")
    (tmp_path / "board.yaml").write_text("recipe: board\nextends: base.yaml\n")
    with pytest.raises(RecipeError) as caught:
        load_recipe(tmp_path / "board.yaml")
    assert caught.value.file == str(tmp_path / "base.yaml")
    assert caught.value.line == 4


def test_a_clash_between_own_and_inherited_values_names_the_line_of_the_users_file() -> None:
    with pytest.raises(RecipeError, match="above the maximum 30 mm/s") as caught:
        extend("functions: {dry: {max_speed_mm_s: 30}}\n")
    assert (caught.value.path, caught.value.file, caught.value.line) == (
        "functions.dry.max_speed_mm_s",
        "mine.yaml",
        3,
    )
    assert "state templates.blow.speed_mm_s in this file too" in str(caught.value)


@pytest.mark.parametrize(
    ("extends", "message"),
    [
        ("b.yaml", "circle: .*a.yaml -> .*b.yaml -> .*a.yaml"),
        ("a.yaml", "goes in a circle"),
        ("../a/nowhere.yaml", "no such file"),
        ("smt-aqeous", "Did you mean 'smt-aqueous'"),
        ("[a, b]", "names one recipe"),
        ("'.'", "not a file"),
    ],
)
def test_what_cannot_be_extended(tmp_path: Path, extends: str, message: str) -> None:
    (tmp_path / "a.yaml").write_text(f"recipe: a\nextends: {extends}\n")
    (tmp_path / "b.yaml").write_text("recipe: b\nextends: a.yaml\n")
    with pytest.raises(RecipeError, match=message) as caught:
        load_recipe(tmp_path / "a.yaml")
    assert caught.value.path == "extends"


def test_what_extends_something_else_than_a_recipe_is_named_with_its_line(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("wash it twice\n")
    (tmp_path / "a.yaml").write_text("recipe: a\nextends: notes.txt\n")
    with pytest.raises(RecipeError, match=r"a\.yaml:2: extends: .*notes\.txt:1: a recipe is a mapping") as caught:
        load_recipe(tmp_path / "a.yaml")
    assert (caught.value.file, caught.value.line) == (str(tmp_path / "a.yaml"), 2)


def test_links_that_go_in_a_circle_are_refused(tmp_path: Path) -> None:
    (tmp_path / "y.yaml").symlink_to(tmp_path / "x.yaml")
    (tmp_path / "x.yaml").symlink_to(tmp_path / "y.yaml")
    with pytest.raises(RecipeError, match="cannot be read"):
        load_recipe(tmp_path / "x.yaml")
