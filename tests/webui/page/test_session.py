"""A session is edited as a whole or not at all, also where the recipe inherits what is edited."""

import difflib

import pytest
from small_boards import board_of, part

from recipes.errors import RecipeError
from webui.page.document import open_document
from webui.page.session import Session


def changed(before, after):
    lines = difflib.unified_diff(before.document.text.splitlines(), after.document.text.splitlines(), lineterm="", n=0)
    return [line for line in lines if not line.startswith(("---", "+++", "@@"))]


def session_of(source):
    document = open_document(str(source))
    board = board_of(part("U1", 20, 20, 10, 10, pins=64), part("R1", 60, 20, 2, 1))
    return Session(workpiece_name="small", workpiece=board, document=document, loaded=document.read())


@pytest.fixture
def session():
    return session_of("smt-aqueous")


@pytest.fixture
def heir(tmp_path):
    file = tmp_path / "heir.yaml"
    file.write_text("recipe: heir\nextends: smt-aqueous # the house recipe\n\ntemplates:\n  sweep:\n    overlap: 0.4\n")
    return session_of(file)


def test_several_values_are_one_edit(session):
    at = ("templates", "around")
    after = session.set_values({(*at, "speed_mm_s"): 35, (*at, "tilt_deg"): 40, (*at, "near", "within_mm"): 3})
    assert after.recipe.templates["around"].speed_mm_s == 35
    assert after.recipe.templates["around"].near.within_mm == 3
    assert session.recipe.templates["around"].speed_mm_s == 40
    assert after.document.undone().text == session.document.text
    assert [line[0] for line in changed(session, after)].count("-") == 2


def test_a_refused_value_changes_nothing(session):
    with pytest.raises(RecipeError, match="above the maximum") as caught:
        session.set_value(("templates", "around", "speed_mm_s"), 500)
    assert caught.value.path == "templates.around.speed_mm_s"
    assert not session.document.past


@pytest.mark.slow
def test_what_makes_sense_together_only_is_accepted_together(session):
    at = ("classes", "fine_pitch", "pins")
    after = session.set_values({(*at, "min"): None, (*at, "max"): 500})
    assert after.recipe.classes["fine_pitch"].pins.min is None
    assert after.recipe.classes["fine_pitch"].pins.max == 500


def test_what_is_taken_out_returns_to_its_default(session):
    after = session.set_values({("templates", "around", "tilt_deg"): None})
    assert after.recipe.templates["around"].tilt_deg == 30
    assert session.set_values({("templates", "around", "near"): None}) is not None
    assert changed(session, session.set_values({("templates", "around", "near"): None})) == []


def test_an_inherited_value_is_overridden_alone(heir):
    after = heir.set_values({("templates", "around", "passes", "small"): 3})
    assert after.recipe.templates["around"].passes == {"bottom_terminated": 3, "default": 1, "small": 3}
    assert after.recipe.templates["around"].speed_mm_s == 40
    assert "speed" not in after.document.text


def test_an_inherited_value_by_class_is_taken_out(heir):
    after = heir.set_values({("templates", "around", "passes", "bottom_terminated"): None})
    assert after.recipe.templates["around"].passes == {"default": 1}


def test_an_inherited_step_changes_in_a_copy_of_the_sequence(heir):
    after = heir.set_value(("sequence", 1, "nozzle"), "knife")
    assert [step.nozzle for step in after.recipe.sequence] == ["ring60", "knife", "knife", "ring60", "ring60", "knife"]
    assert "# the house recipe" in after.document.text
    assert [step.function for step in heir.remove(("sequence", 0)).recipe.sequence] == [
        "rinse",
        "dry",
        "clean",
        "rinse",
        "dry",
    ]
    moved = heir.move(("sequence", 2), 0)
    assert [step.function for step in moved.recipe.sequence] == ["dry", "clean", "rinse", "clean", "rinse", "dry"]


def test_a_mask_is_added_where_there_is_none(heir):
    after = heir.insert(("masks", 0), {"avoid": ["J*"]})
    assert after.recipe.masks[0].avoid == ["J*"]
    assert after.remove(("masks", 0)).recipe.masks == []


def test_inherited_classes_change_their_order_and_keep_what_they_say(heir):
    after = heir.move(("classes", "small"), 0)
    assert list(after.recipe.classes) == ["small", "bottom_terminated", "fine_pitch", "large"]
    assert dict(after.recipe.classes) == dict(heir.recipe.classes)
    again = after.move(("classes", "small"), 2)
    assert list(again.recipe.classes) == list(heir.recipe.classes)


@pytest.mark.slow
def test_an_inherited_template_is_removed(session, heir):
    lighter = heir
    for at in (0, 3):
        lighter = lighter.set_value(("sequence", at, "paths"), ["edge", "sweep", "around"])
    after = lighter.remove(("templates", "step"))
    assert "step" not in after.recipe.templates
    with pytest.raises(RecipeError, match="there is no template 'step'"):
        session.remove(("templates", "step"))


def test_another_text_of_the_same_recipe_is_not_read_again(session):
    assert session.with_document(session.document).loaded is session.loaded
