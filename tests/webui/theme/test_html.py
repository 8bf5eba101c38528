from types import SimpleNamespace

from reports.tables.table import Column, Table, Text
from webui.panels.widgets.choices import offer
from webui.theme.html import MOST_ROWS, listing_html
from webui.theme.palette import SEVERITY_COLOURS, css_colour

COLUMNS = (Column("Part", width="40%"), Column("Worst"), Column("Verdict", "right", width="60%"))


def written(names, selected=""):
    rows = [(name, Text("late", tone="error"), Text("dirty", tone="dirty")) for name in names]
    return listing_html(Table.of(COLUMNS, rows), selected, height="10vh", more="more")


def test_text_is_text_and_marks_are_marks():
    html = written(["<i>"])
    assert "&lt;i&gt;" in html
    assert "<i>" not in html
    assert "\N{BLACK CIRCLE}</span> dirty" in html
    assert f"font-weight:600;color:{css_colour(SEVERITY_COLOURS['error'])}" in html
    assert "width:40%" in html


def test_only_the_selected_row_is_marked():
    assert written(["U1", "U2", "U11"], "U1").count("box-shadow") == 1
    assert "box-shadow" not in written(["U1", "U2"])


def test_what_is_beyond_is_counted():
    names = [f"U{number}" for number in range(MOST_ROWS + 3)]
    assert written(names).count("<tr") == 1 + MOST_ROWS
    assert "and 3 more<" in written(names)
    assert "and" not in written(names[:MOST_ROWS])


class Dropdown(SimpleNamespace):
    """Remembers what was set."""

    def __setattr__(self, name, value):
        self.__dict__.setdefault("sent", []).append((name, value))
        self.__dict__[name] = value


def test_a_dropdown_is_told_only_what_is_new():
    choice = Dropdown()
    vars(choice).update(options=["a", "b"], value="a", sent=[])
    offer(choice, ("a", "b"), "a")
    assert choice.sent == []
    offer(choice, ("a", "b"), "b")
    assert choice.sent == [("value", "b")]
    offer(choice, ("b", "c"), "b")
    assert choice.sent[1:] == [("options", ("b", "c"))]
