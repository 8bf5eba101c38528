from collections import Counter

import pytest
from tiny_session import tiny_session

from recipes.errors import RecipeError
from recipes.paths import StraightLine
from webui.panels.board.paths import DrawnLine, add_line, free_name, step_names

LINE = DrawnLine("contacts", (10.0, 20.123), (60.0, 20.0), 50.0, 40.0)


def test_a_drawn_line_becomes_a_template_and_the_last_path_of_its_step_in_one_edit():
    before = tiny_session()
    after = add_line(before, LINE, 1)
    spec = after.recipe.templates["contacts"]
    assert isinstance(spec, StraightLine)
    assert (spec.from_mm, spec.to_mm, spec.height_mm, spec.speed_mm_s) == ((10.0, 20.12), (60.0, 20.0), 50.0, 40.0)
    assert after.recipe.sequence[1].paths == [*before.recipe.sequence[1].paths, "contacts"]
    assert after.document.undone().text == before.document.text


def test_everything_else_stays_as_it_was_written():
    before, after = (
        tiny_session().document.text.splitlines(),
        add_line(tiny_session(), LINE, 0).document.text.splitlines(),
    )
    (gone,) = (Counter(before) - Counter(after)).elements()
    assert "paths:" in gone


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        (DrawnLine("edge", (0, 0), (1, 0), 50, 40), "is there already"),
        (DrawnLine("two words", (0, 0), (1, 0), 50, 40), "two words"),
        (DrawnLine("dot", (5, 5), (5, 5), 50, 40), "no length"),
        (DrawnLine("fast", (0, 0), (1, 0), 50, 4000), "above the maximum"),
    ],
)
def test_what_the_recipe_refuses_is_refused_with_the_reason(line, reason):
    with pytest.raises(RecipeError, match=reason):
        add_line(tiny_session(), line, 0)


def test_proposed_names_are_free_and_steps_can_be_told_apart():
    session = tiny_session()
    assert free_name(session.recipe) == "line1"
    assert free_name(add_line(session, DrawnLine("line1", (0, 0), (9, 0), 50, 40), 0).recipe) == "line2"
    assert step_names(session.recipe) == (
        *("1 clean, ring60", "2 rinse, ring60", "3 dry, knife"),
        *("4 clean, ring60, bottom", "5 rinse, ring60, bottom", "6 dry, knife, bottom"),
    )
