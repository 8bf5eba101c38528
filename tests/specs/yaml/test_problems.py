"""What the user wrote is blamed before what is inherited; nobody is sent to edit a file of the library."""

from pathlib import Path

import pytest

from cleaning.errors import CleaningError
from cleaning.parameters.load import parameter_library, read_parameters_text
from recipes.errors import RecipeError
from recipes.load import load_recipe, parse_recipe, recipe_library
from specs.errors import LocatedError

RECIPE = "recipe: own\nextends: smt-aqueous\n"
PARAMETERS = "parameters: own\nextends: default\n"
INSTALLED = [str(path) for library in (recipe_library(), parameter_library()) for path in library.values()]


def refused_recipe(text: str) -> LocatedError:
    with pytest.raises(RecipeError) as caught:
        parse_recipe(RECIPE + text, file="own.yaml")
    return caught.value


def refused_parameters(text: str) -> LocatedError:
    with pytest.raises(CleaningError) as caught:
        read_parameters_text(PARAMETERS + text, file="own.yaml")
    return caught.value


@pytest.mark.parametrize(
    ("text", "path", "inherited"),
    [
        ("limits: {clearance_mm: 45}", "limits.clearance_mm", ["templates.around.height_mm"]),
        ("limits: {clearance_mm: 200}", "limits.clearance_mm", ["templates.around.height_mm", "limits.park_height_mm"]),
        ("functions: {dry: {max_speed_mm_s: 20}}", "functions.dry.max_speed_mm_s", ["templates.blow.speed_mm_s"]),
        ("nozzles: {ring60: {half_angle_deg: 51}}", "nozzles.ring60.half_angle_deg", ["templates.around.tilt_deg"]),
        ("templates: {sweep: null}", "templates.sweep", ["sequence[0].paths[0]", "sequence[1].paths[1]"]),
        ("functions: {rinse: null}", "functions.rinse", ["sequence[1].function"]),
        ("nozzles: {knife: null}", "nozzles.knife", ["sequence[2].nozzle"]),
        (
            "classes: {bottom_terminated: null}",
            "classes.bottom_terminated",
            ["templates.around.passes.bottom_terminated"],
        ),
    ],
)
def test_a_recipe_whose_value_does_not_suit_inherited_ones(text: str, path: str, inherited: list[str]) -> None:
    error = refused_recipe(text)
    assert (error.path, error.file, error.line) == (path, "own.yaml", 3)
    for each in inherited:
        assert f"{each}, inherited from smt-aqueous: " in str(error)
    assert "in this file too: that overrides what is inherited" in str(error)
    assert not [path for path in INSTALLED if path in str(error)]


@pytest.mark.parametrize(
    ("text", "path", "inherited"),
    [
        (
            "limits: {gap_dirty: 0.01}\nprovenance: {limits.gap_dirty: {known: proposed, source: us}}",
            "limits.gap_dirty",
            "limits.gap_marginal",
        ),
        (
            "drying: {advancing_deg: 10}\nprovenance: {drying.advancing_deg: {known: proposed, source: us}}",
            "drying.advancing_deg",
            "drying.receding_deg",
        ),
        ("liquids: {saponifier-15: null}", "liquids.saponifier-15", "provenance.liquids.saponifier-15.window_c"),
    ],
)
def test_a_parameter_set_whose_value_does_not_suit_inherited_ones(text: str, path: str, inherited: str) -> None:
    error = refused_parameters(text)
    assert (error.path, error.file, error.line) == (path, "own.yaml", 3)
    assert f"{inherited}, inherited from default: " in str(error)
    assert not [path for path in INSTALLED if path in str(error)]


def test_a_value_that_the_user_states_is_blamed_itself() -> None:
    error = refused_recipe("limits: {clearance_mm: 20}\ntemplates: {edge: {height_mm: 15}}")
    assert (error.path, error.line) == ("templates.edge.height_mm", 4)
    assert "inherited" not in str(error)


def test_the_users_file_comes_before_the_users_base(tmp_path: Path) -> None:
    base = tmp_path / "base.yaml"
    base.write_text("recipe: base\nextends: smt-aqueous\ntemplates: {edge: {height_mm: 15}}\n")
    own = tmp_path / "own.yaml"
    own.write_text("recipe: own\nextends: base.yaml\nlimits:\n  clearance_mm: 16\n")
    with pytest.raises(RecipeError) as caught:
        load_recipe(own)
    assert (caught.value.file, caught.value.line, caught.value.path) == (str(own), 4, "limits.clearance_mm")
    assert f"templates.edge.height_mm, inherited from {base}:3: 15 mm is not above" in str(caught.value)


def test_a_base_of_the_users_is_blamed_for_a_clash_with_the_library(tmp_path: Path) -> None:
    base = tmp_path / "base.yaml"
    base.write_text("recipe: base\nextends: smt-aqueous\nlimits: {clearance_mm: 45}\n")
    own = tmp_path / "own.yaml"
    own.write_text("recipe: own\nextends: base.yaml\n")
    with pytest.raises(RecipeError) as caught:
        load_recipe(own)
    assert (caught.value.file, caught.value.line, caught.value.path) == (str(base), 3, "limits.clearance_mm")


def test_a_name_that_is_stated_anew_is_not_taken_for_removed(tmp_path: Path) -> None:
    (tmp_path / "base.yaml").write_text(
        "recipe: base\nextends: smt-aqueous\ntemplates: {step: null}\n"
        "sequence: [{function: clean, nozzle: ring60, paths: [sweep]}]\n"
    )
    own = tmp_path / "own.yaml"
    own.write_text(
        "recipe: own\nextends: base.yaml\n"
        "templates: {step: {path: step_function, height_mm: 3, speed_mm_s: 20}}\n"
        "sequence: [{function: clean, nozzle: ring60, paths: [step]}]\n"
    )
    with pytest.raises(RecipeError) as caught:
        load_recipe(own)
    assert (caught.value.path, caught.value.line) == ("templates.step.height_mm", 3)
