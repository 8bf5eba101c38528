"""What is allowed but probably not meant is found and said."""

import pytest

from recipes.check import check_recipe
from recipes.load import parse_recipe
from specs.finding import Finding

HEAD = "recipe: mine\nextends: smt-aqueous\n"


def findings(text: str) -> tuple[Finding, ...]:
    return check_recipe(parse_recipe(HEAD + text))


def test_a_recipe_as_it_should_be_has_none() -> None:
    assert findings("") == ()


def test_what_no_step_uses() -> None:
    found = findings("sequence: [{function: rinse, nozzle: ring60, paths: [edge, sweep, around, step]}]\n")
    assert [(finding.rule.id, str(finding.made_by)) for finding in found] == [
        ("unused-function", "functions.clean"),
        ("unused-function", "functions.dry"),
        ("unused-nozzle", "nozzles.knife"),
        ("unused-template", "templates.soak"),
        ("unused-template", "templates.flush"),
        ("unused-template", "templates.blow"),
    ]
    assert {finding.severity for finding in found} == {"warning"}


def test_a_class_behind_one_that_takes_all() -> None:
    (found,) = findings("classes: {tall: {height_mm: {min: 10}}}\n")
    assert (found.rule.id, str(found.made_by)) == ("class-out-of-reach", "classes.tall")
    assert "put it before large" in found.message


def test_no_class_for_what_is_left() -> None:
    (found,) = findings("classes: {large: {area_mm2: {min: 20}}}\n")
    assert found.rule.id == "no-class-for-the-rest"


def test_near_that_is_merged_away() -> None:
    (found,) = findings("templates: {around: {near: {within_mm: 2, speed_mm_s: 20}}}\n")
    assert found.rule.id == "near-within-merge-gap"
    assert findings("templates: {around: {near: {within_mm: 2.1, speed_mm_s: 20}}}\n") == ()


@pytest.mark.parametrize(
    ("order", "early"),
    [
        ("clean rinse dry", []),
        ("rinse clean dry", [0]),
        ("dry rinse rinse clean rinse", [1, 2]),
        ("rinse dry", []),
        ("clean rinse clean", []),
    ],
)
def test_a_rinse_before_anything_is_washed(order: str, early: list[int]) -> None:
    found = [each for each in findings(sequence(*order.split())) if each.rule.id == "rinse-before-clean"]
    assert [str(each.made_by) for each in found] == [f"sequence[{index}]" for index in early]
    assert all(each.severity == "warning" for each in found)


def test_a_step_that_is_not_enabled_washes_nothing() -> None:
    text = sequence("rinse", "clean").replace("clean,", "clean, enabled: false,")
    assert "rinse-before-clean" not in {each.rule.id for each in findings(text)}


def sequence(*functions: str) -> str:
    steps = [
        f"  - {{function: {each}, nozzle: {'knife' if each == 'dry' else 'ring60'}, paths: [flush]}}\n"
        for each in functions
    ]
    return f"sequence:\n{''.join(steps)}"


def test_a_measured_ring_that_contradicts_the_half_angle() -> None:
    (found,) = findings("nozzles: {ring60: {half_angle_deg: 15}}\n")
    assert found.rule.id == "ring-contradicts-half-angle"
    assert "29.7" in found.message
