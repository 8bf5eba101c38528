from tiny_session import tiny_session

from specs.source import Source
from webui.cards.findings import recipe_line


def test_the_line_is_the_one_that_states_the_entry():
    session = tiny_session()
    text = session.document.text.splitlines()
    for made_by, begins in (
        ("sequence[0]/edge", "edge:"),
        ("sequence[1]/sweep/transfer", "sweep:"),
        ("classes/small", "small:"),
        ("sequence[2]/park", "- function: dry"),
    ):
        line = int(recipe_line(session.loaded, Source.parse(made_by)).rpartition(" ")[2])
        assert text[line - 1].strip().startswith(begins)


def test_what_no_recipe_caused_has_no_line():
    assert recipe_line(tiny_session().loaded, Source.parse("")) == ""
    assert recipe_line(tiny_session().loaded, Source.parse("nonsense/x")) == ""
