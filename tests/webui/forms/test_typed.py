"""What was typed and not applied is marked as that, in forms and in the text."""

import pytest
from small_page import find, press, small_page
from tiny_session import tiny_session
from viser import GuiHtmlHandle

from webui.forms.spec_form import NOT_APPLIED
from webui.page.project import Project
from webui.panels.recipe.recipe import RecipePanel
from webui.panels.recipe.text import TextPanel

SESSION = tiny_session()


@pytest.fixture
def page(tmp_path):
    with small_page(SESSION, Project(tmp_path)) as page:
        RecipePanel(page, None)
        TextPanel(page, None)
        page.open()
        press(page, "Entry", "around")
        yield page


def notes(page):
    """What is written on the page and seen now."""
    containers = page.client.gui._container_handle_from_uuid.values()
    elements = [each for container in containers for each in container._children.values()]
    return [each.content for each in elements if isinstance(each, GuiHtmlHandle) and each.visible]


def is_marked(page):
    return any(NOT_APPLIED in note for note in notes(page))


def is_called_for(page):
    return find(page, "Apply").color is None  # the accent


def test_nothing_is_marked_before_something_is_typed(page):
    assert not is_marked(page)
    assert not is_called_for(page)


def test_what_is_typed_is_marked_until_it_is_applied(page):
    press(page, "Speed (mm/s)", "33", at=0)
    assert is_marked(page)
    assert is_called_for(page)
    press(page, "Apply")
    assert page.session.recipe.templates["around"].speed_mm_s == 33
    assert not is_marked(page)
    assert not is_called_for(page)


def test_what_is_typed_back_is_not_marked(page):
    press(page, "Speed (mm/s)", "33", at=0)
    press(page, "Speed (mm/s)", "40", at=0)
    assert not is_marked(page)


def test_a_refused_value_stays_marked_and_another_entry_is_not(page):
    press(page, "Speed (mm/s)", "500", at=0)
    press(page, "Apply")
    assert is_marked(page)
    press(page, "Entry", "sweep")
    assert not is_marked(page)


def test_an_edit_from_elsewhere_leaves_the_mark_on_what_is_still_typed(page):
    press(page, "Speed (mm/s)", "33", at=0)
    page.attempt(lambda session: session.set_value(("limits", "clearance_mm"), 6))
    assert find(page, "Speed (mm/s)", 0).value == "33"
    assert is_marked(page)


def test_typed_text_is_marked_until_it_is_applied_or_taken_back(page):
    typed = SESSION.document.text.replace("tilt_deg: 35", "tilt_deg: 34")
    press(page, "YAML", typed)
    assert any("Apply text" in note for note in notes(page))
    press(page, "Text", "Revert")
    assert not any("Apply text" in note for note in notes(page))
    press(page, "YAML", typed)
    press(page, "Text", "Apply text")
    assert page.session.document.text == typed
    assert not any("Apply text" in note for note in notes(page))
