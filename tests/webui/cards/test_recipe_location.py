import pytest
from tiny_session import tiny_session

from webui.cards.recipe_location import recipe_line, yaml_path


@pytest.mark.parametrize(
    ("made_by", "path"),
    [
        ("sequence[0]/around/U12", ("templates", "around")),
        ("sequence[1]/sweep/transfer", ("templates", "sweep")),
        ("sequence[2]/park", ("sequence", 2)),
        ("sequence[1]", ("sequence", 1)),
        ("classes/small", ("classes", "small")),
        ("masks", ("masks",)),
        ("", ()),
    ],
)
def test_a_maker_leads_to_what_is_edited(made_by, path):
    assert yaml_path(tiny_session().recipe, made_by) == path


def test_the_line_is_the_one_that_says_so():
    session = tiny_session()
    text = session.document.text.splitlines()
    for made_by, begins in (
        ("sequence[0]/edge", "edge:"),
        ("classes/small", "small:"),
        ("sequence[2]/park", "- function: dry"),
    ):
        line = int(recipe_line(session.loaded, made_by).rpartition(" ")[2])
        assert text[line - 1].strip().startswith(begins)


def test_what_no_recipe_asked_for_has_no_line():
    assert recipe_line(tiny_session().loaded, "") == ""
    assert recipe_line(tiny_session().loaded, "nonsense/x") == ""
