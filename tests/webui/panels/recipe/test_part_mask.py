"""The selected part is masked, and unmasked, by one click."""

import pytest
from small_page import find, press, small_page
from tiny_session import tiny_session

from rulesengine.strokes.classify import read_masks
from webui.panels.recipe.recipe import RecipePanel

PART = tiny_session().board.components[0].name


@pytest.fixture
def page():
    with small_page(tiny_session()) as page:
        RecipePanel(page, None)
        page.open()
        yield page


def masks_of(page):
    return read_masks(page.session.recipe, page.session.board)[0]


@pytest.mark.slow
def test_two_clicks_mask_a_part_and_one_takes_the_mask_out_again(page):
    text = page.session.document.text
    assert not find(page, "Mask").visible
    page.select(component=PART)  # a click on it in the scene
    press(page, f"Mask {PART}", "Avoid")
    assert [name for name, _ in masks_of(page).avoided] == [PART]
    assert find(page, f"Mask {PART}").options == ("Do not avoid",)
    press(page, f"Mask {PART}", "Do not avoid")
    assert masks_of(page).avoided == ()
    assert find(page, f"Mask {PART}").options == ("Avoid", "Ignore", "Must clean")
    page.attempt(lambda session: session.undone().undone())
    assert page.session.document.text == text


@pytest.mark.parametrize(("button", "kept"), [("Ignore", "ignored"), ("Must clean", "required")])
def test_a_part_is_left_out_or_required(page, button, kept):
    page.select(component=PART)
    press(page, f"Mask {PART}", button)
    assert getattr(masks_of(page), kept) == {PART}


@pytest.mark.slow
def test_a_mask_of_several_parts_is_left_alone(page):
    page.attempt(lambda session: session.insert(("masks", 0), {"ignore": [PART, "J*"]}))
    page.select(component=PART)
    press(page, f"Mask {PART}", "Must clean")
    press(page, f"Mask {PART}", "Need not clean")
    assert [mask.ignore for mask in page.session.recipe.masks] == [[PART, "J*"]]


def test_a_click_that_comes_late_does_nothing(page):
    page.select(component=PART)
    press(page, f"Mask {PART}", "Avoid")
    press(page, f"Mask {PART}", "Ignore")
    assert len(page.session.recipe.masks) == 1
