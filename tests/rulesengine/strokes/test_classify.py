"""Every component ends in exactly one class, and says why."""

import pytest
from small_boards import board_of, part

from recipes.classes import ComponentClass, Mask, Range, match_masks
from recipes.errors import RecipeError
from recipes.load import load_recipe
from rulesengine.strokes.classify import classify, read_masks

BOARD = board_of(
    part("U1", 10, 10, 7, 7, package="QFN-48", pins=48),
    part("C1", 30, 10, 2, 1.25),
    part("C2", 33, 10, 2, 1.25),
    part("J1", 60, 10, 10, 20, 12, package="Header", pins=20),
)


def recipe_with(**changes):
    return load_recipe("smt-aqueous").model_copy(update=changes)


def test_first_class_that_matches_takes_the_component():
    recipe = recipe_with(
        classes={
            "bottom": ComponentClass(package=["*qfn*"]),
            "many": ComponentClass(pins=Range(min=20)),
            "rest": ComponentClass(),
        }
    )
    classified, findings = classify(recipe, BOARD)
    assert [each.component_class for each in classified] == ["bottom", "rest", "rest", "many"]
    assert classified[0].because == "package QFN-48 is *qfn*"
    assert classified[3].because == "pins 20 >= 20"
    assert not findings


@pytest.mark.parametrize(
    ("wanted", "members"),
    [
        ({"area_mm2": Range(max=3)}, {"C1", "C2"}),
        ({"height_mm": Range(min=10)}, {"J1"}),
        ({"standoff_mm": Range(max=0.2)}, {"U1", "C1", "C2", "J1"}),
        ({"neighbour_mm": Range(max=1.5)}, {"C1", "C2"}),
        ({"refdes": ["C?", "j*"]}, {"C1", "C2", "J1"}),
        ({"side": "bottom"}, set()),
        ({"pins": Range(min=10, max=30), "height_mm": Range(max=5)}, set()),
    ],
)
def test_each_condition(wanted, members):
    recipe = recipe_with(classes={"it": ComponentClass(**wanted), "rest": ComponentClass()})
    classified, findings = classify(recipe, BOARD)
    assert {each.component for each in classified if each.component_class == "it"} == members
    assert [finding.rule.id for finding in findings] == ([] if members else ["class-empty"]) + (
        ["class-empty"] if len(members) == 4 else []
    )


def test_component_that_no_class_takes_stops_the_job():
    recipe = recipe_with(classes={"big": ComponentClass(area_mm2=Range(min=20))})
    with pytest.raises(RecipeError, match=r"classes: no class takes C1 .* last class without conditions"):
        classify(recipe, BOARD)


def test_masks_name_components_by_pattern():
    masks = [Mask(avoid=["J*"], margin_mm=4), Mask(ignore=["C*"]), Mask(clean=["C2", "X9"])]
    read, findings = read_masks(recipe_with(masks=masks), BOARD)
    assert read.avoided == (("J1", 4.0),)
    assert read.ignored == {"C1"}
    assert read.required == {"C2"}
    assert [(finding.rule.id, str(finding.made_by)) for finding in findings] == [("mask-empty", "masks[2]")]


def test_avoiding_what_must_be_cleaned_is_an_error():
    _, findings = read_masks(recipe_with(masks=[Mask(avoid=["U1"]), Mask(clean=["U*"])]), BOARD)
    assert [(finding.rule.id, finding.severity) for finding in findings] == [("mask-conflict", "error")]


def test_masks_compare_the_names_on_their_own_board_and_hold_for_every_board_of_a_panel():
    names = {"U1@1": "U1", "U2@1": "U2", "U1@2": "U1", "U2@2": "U2"}
    masks = match_masks([Mask(avoid=["u1"], margin_mm=1.0), Mask(avoid=["U*"], margin_mm=0.5)], names)
    assert masks.avoided == (("U1@1", 1.0), ("U1@2", 1.0), ("U2@1", 0.5), ("U2@2", 0.5))
