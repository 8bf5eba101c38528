"""Every part of a recipe becomes a form, and a form that nobody touched changes nothing."""

import json
from typing import get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recipes.classes import ComponentClass, Mask
from recipes.load import RECIPE, parse_recipe, read_recipe, recipe_library
from recipes.nozzles import Nozzle
from recipes.paths import ComponentPerimeter, PathSpec, Raster, StraightLine
from recipes.recipe import Function, Limits, Recipe, Step
from specs.yaml.edit import set_value
from specs.yaml.load import read_text
from webui.forms.entries import SECTIONS, entries, names_of, spec_at, stated_at
from webui.forms.fields import changes, describe, field_at, label_and_unit, parse

SPECS = [
    *get_args(get_args(PathSpec)[0]),
    *get_args(get_args(Nozzle)[0]),
    Function,
    ComponentClass,
    Mask,
    Step,
    Limits,
]
KINDS = {"number", "integer", "text", "boolean", "choice", "list", "pair", "table"}
LIBRARY = {name: read_recipe(name) for name in recipe_library()}
AROUND = {
    "height_mm": 40,
    "speed_mm_s": 40,
    "passes": {"small": 2, "default": 4},
    "near": {"within_mm": 4, "speed_mm_s": 20},
}
NAMES = {"classes": ("small", "large"), "templates": ("edge", "sweep")}


def form(spec, stated, **answers):
    """Describe a form, answer some of its inputs, and give what changes."""
    fields = describe(spec, stated, NAMES)
    asked = {".".join(map(str, field.path)): field.value for field in fields}
    unknown = {key.replace("__", ".") for key in answers} - asked.keys()
    assert not unknown, unknown
    asked.update({key.replace("__", "."): value for key, value in answers.items()})
    return changes(fields, asked.values(), stated)


@pytest.mark.parametrize("spec", SPECS, ids=lambda spec: spec.__name__)
def test_every_key_of_every_specification_has_an_input(spec):
    fields = describe(spec, {}, NAMES)
    there = {field.path[0] for field in fields}
    kind = {name for name in ("path", "pattern") if name in spec.model_fields}
    assert there == {info.alias or name for name, info in spec.model_fields.items()} - kind
    for field in fields:
        assert field.kind in KINDS
        assert field.label[0].isupper() or field.group.endswith("by class")
        assert field.hint.strip()
        assert isinstance(field.value, bool) is (field.kind == "boolean")
        assert field.kind != "choice" or field.value in (*field.options, "")


@pytest.mark.slow
@pytest.mark.parametrize("name", LIBRARY)
def test_what_a_form_shows_reads_back_as_what_the_recipe_states(name):
    loaded, text = LIBRARY[name], read_text(recipe_library()[name], RECIPE)
    seen = 0
    for section in SECTIONS[:-1]:
        for entry in entries(loaded.recipe, section):
            stated = stated_at(loaded.root, entry.path)
            fields = describe(spec_at(loaded.recipe, entry.path), stated, names_of(loaded.recipe))
            assert changes(fields, [field.value for field in fields], stated) == {}
            for field in fields:
                value = stated.get(field.path[0])
                if len(field.path) == 1 and field.path[0] in stated and not isinstance(value, dict):
                    assert parse(field, field.value) == (value or None if field.kind == "list" else value)
                    if name == "smt-aqueous" and field.kind != "list":
                        assert set_value(text, (*entry.path, *field.path), parse(field, field.value)) == text
                        seen += 1
    assert seen > 60 or name != "smt-aqueous"


def test_units_stand_beside_the_words():
    assert label_and_unit("speed_mm_s") == ("Speed", "mm/s")
    assert label_and_unit("rotation_acceleration_deg_s2") == ("Rotation acceleration", "°/s²")
    assert label_and_unit("area_mm2") == ("Area", "mm²")
    assert label_and_unit("passes") == ("Passes", "")


def test_only_what_was_answered_otherwise_changes():
    assert form(ComponentPerimeter, AROUND, speed_mm_s="35") == {("speed_mm_s",): 35}
    assert form(ComponentPerimeter, AROUND, speed_mm_s=" 40 ") == {}
    assert form(ComponentPerimeter, AROUND, speed_mm_s="35 mm/s", tilt_deg="30.5") == {
        ("speed_mm_s",): 35,
        ("tilt_deg",): 30.5,
    }


def test_an_emptied_input_states_nothing():
    assert form(ComponentPerimeter, AROUND, speed_mm_s="") == {("speed_mm_s",): None}
    assert form(ComponentPerimeter, AROUND, tilt_deg="") == {}, "it was not stated before either"


def test_a_class_gets_a_value_of_its_own_and_loses_it():
    assert form(ComponentPerimeter, AROUND, speed_mm_s__small="20") == {("speed_mm_s",): {"small": 20, "default": 40}}
    assert form(ComponentPerimeter, AROUND, passes__large="6") == {("passes", "large"): 6}
    assert form(ComponentPerimeter, AROUND, passes="3") == {("passes", "default"): 3}
    assert form(ComponentPerimeter, AROUND, passes__small="") == {("passes",): 4}
    assert form(ComponentPerimeter, AROUND, passes="", passes__large="6") == {
        ("passes", "default"): None,
        ("passes", "large"): 6,
    }


def test_a_part_of_its_own_is_stated_and_taken_out():
    assert form(ComponentPerimeter, AROUND, near__passes="3") == {("near", "passes"): 3}
    assert form(ComponentPerimeter, AROUND, near__within_mm="", near__speed_mm_s="") == {("near",): None}
    assert form(Step, {"function": "rinse"}, until__max_repeats="4", until__temperature_c="50") == {
        ("until",): {"max_repeats": 4, "temperature_c": 50}
    }
    assert form(ComponentClass, {}, pins__min="48") == {("pins",): {"min": 48}}


def test_lists_and_points_are_read_as_people_write_them():
    assert form(ComponentClass, {}, refdes="U1 ,J[1,2], R*") == {("refdes",): ["U1", "J[1,2]", "R*"]}
    assert form(StraightLine, {"from": [0, 0]}, **{"from": "10; 20.5"}) == {("from",): [10, 20.5]}
    hollow = next(spec for spec in SPECS if spec.__name__ == "HollowCone")
    rows = "0 24 31\n 120, 25, 32\n\n240\t24 31"
    assert form(hollow, {}, wavefront__height_mm="50", wavefront__points=rows)[("wavefront",)]["points"] == [
        [0, 24, 31],
        [120, 25, 32],
        [240, 24, 31],
    ]


def test_a_table_may_be_a_word() -> None:
    radial = next(spec for spec in SPECS if spec.__name__ == "Radial")
    assert form(radial, {}, profile="0 1\n20 0.8\n40 0") == {("profile",): [[0, 1], [20, 0.8], [40, 0]]}
    assert form(radial, {"profile": [[0, 1], [40, 0]]}, profile="parabola") == {("profile",): "parabola"}
    shown = next(field for field in describe(radial, {"profile": "parabola"}, {}) if field.path == ("profile",))
    assert (shown.kind, shown.value) == ("table", "parabola")


def test_a_word_stands_for_a_number_where_the_recipe_knows_it():
    assert form(Raster, {}, direction_deg="Longest edge") == {("direction_deg",): "longest_edge"}
    assert form(Raster, {}, direction_deg="45 °") == {("direction_deg",): 45}
    assert form(Raster, {}, direction_deg="upwards") == {("direction_deg",): "upwards"}, "the recipe refuses it"


def test_an_error_finds_its_input():
    fields = describe(ComponentPerimeter, AROUND, NAMES)
    base = ("templates", "around")

    def found(path):
        field = field_at(fields, base, path)
        return None if field is None else field.path

    assert found("templates.around.speed_mm_s") == ("speed_mm_s",)
    assert found("templates.around.passes.small") == ("passes", "small")
    assert found("templates.around.near") == ("near", "within_mm")
    assert found("templates.around.from_nowhere") is None
    assert found("templates.around") is None
    assert found("sequence[0].paths[2]") is None


@settings(max_examples=60)
@given(text=st.text(max_size=60), spec=st.sampled_from(SPECS))
def test_whatever_is_typed_is_a_value_or_is_refused_by_the_recipe(text, spec):
    for field in describe(spec, {}, NAMES):
        if field.kind != "boolean":
            value = parse(field, text)
            assert value is None or isinstance(value, str | int | float | list)
            json.dumps(value, allow_nan=False)


def test_a_recipe_of_the_library_takes_what_a_form_gives():
    text = read_text(recipe_library()["smt-aqueous"], RECIPE)
    loaded = LIBRARY["smt-aqueous"]
    stated = stated_at(loaded.root, ("templates", "around"))
    fields = describe(ComponentPerimeter, stated, names_of(loaded.recipe))
    shown = ["12.5" if field.path == ("distance_mm", "large") else field.value for field in fields]
    for path, value in changes(fields, shown, stated).items():
        text = set_value(text, ("templates", "around", *path), value)
    assert parse_recipe(text).templates["around"].distance_mm == {"large": 12.5, "default": 0}
    assert spec_at(loaded.recipe, ()) is Recipe
