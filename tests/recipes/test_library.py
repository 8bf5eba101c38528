"""The recipes that come with Washboard are good to start from."""

from itertools import product

import pytest

from recipes.check import check_recipe
from recipes.consistency import half_spread_deg, values_of
from recipes.load import load_recipe, recipe_library
from recipes.nozzles import AirKnife, HollowCone
from recipes.paths import ComponentPerimeter, FinalFlush, Raster, for_class

NAMES = list(recipe_library())


def test_the_library() -> None:
    assert {"smt-aqueous", "low-standoff", "rinse-only", "dry-only"} <= set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_each_is_documented_and_without_findings(name: str) -> None:
    text = recipe_library()[name].read_text("utf-8")
    recipe = load_recipe(name)
    assert recipe.recipe == name
    assert recipe.description
    for heading in ("When to use it", "What it does", "What to adapt"):
        assert heading in text
    assert check_recipe(recipe) == ()


@pytest.mark.parametrize("name", NAMES)
def test_each_moves_rigidly_with_the_board(name: str) -> None:
    for spec in load_recipe(name).templates.values():
        assert getattr(spec, "direction_deg", "longest_edge") in ("longest_edge", "across_longest_edge")


@pytest.mark.parametrize("name", NAMES)
def test_around_components_the_near_wave_front_reaches_the_edge_from_outside(name: str) -> None:
    recipe = load_recipe(name)
    used = [(recipe.templates[name], recipe.nozzles[step.nozzle]) for step in recipe.sequence for name in step.paths]
    for spec, nozzle in used:
        if isinstance(spec, ComponentPerimeter) and spec.align == "wavefront":
            assert isinstance(nozzle, HollowCone)
            assert all(tilt >= half_spread_deg(nozzle) for _, tilt in values_of(spec, "tilt_deg"))


def test_the_default_washes_rinses_and_dries_with_its_own_nozzles() -> None:
    recipe = load_recipe("smt-aqueous")
    assert [step.function for step in recipe.sequence] == ["clean", "rinse", "dry"] * 2
    assert [step.side for step in recipe.sequence] == ["top"] * 3 + ["bottom"] * 3
    assert isinstance(recipe.nozzles[recipe.sequence[-1].nozzle], AirKnife)
    assert recipe.functions["rinse"].pressure_bar < recipe.functions["clean"].pressure_bar
    last_of_each = [recipe.templates[step.paths[-1]] for step in recipe.sequence if step.function != "clean"]
    assert all(isinstance(spec, FinalFlush) and spec.toward == "travel" for spec in last_of_each)
    assert any(isinstance(spec, Raster) for spec in recipe.templates.values())


def test_low_standoff_gives_every_class_at_least_the_work_of_the_default() -> None:
    default, low = load_recipe("smt-aqueous"), load_recipe("low-standoff")
    before, after = default.templates["around"], low.templates["around"]
    assert isinstance(before, ComponentPerimeter)
    assert isinstance(after, ComponentPerimeter)
    for name, (field, sign) in product(default.classes, (("passes", 1), ("edge_delay_s", 1), ("speed_mm_s", -1))):
        assert sign * for_class(getattr(after, field), name) >= sign * for_class(getattr(before, field), name)
    assert for_class(after.passes, "bottom_terminated") > for_class(before.passes, "bottom_terminated")
