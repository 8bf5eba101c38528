"""The list of components is filtered, worst first."""

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_findings import made_finding
from tiny_session import tiny_session

from webui.cards.workpiece_card import findings_about, list_rows, rows_html
from webui.theme.html import MOST_ROWS


def names_of(session, wanted=""):
    return [row.component.name for row in list_rows(session, wanted)]


def with_findings(session, *findings):
    return replace(session, run=replace(session.run, findings=findings))


def test_without_a_filter_all_come_in_the_order_of_the_file():
    session = with_findings(tiny_session())
    assert names_of(session) == [component.name for component in session.board.components]
    assert names_of(replace(session, run=None), "  ") == names_of(session)


def test_the_filter_takes_parts_of_names_packages_and_classes_and_patterns():
    session = with_findings(tiny_session())
    first = session.board.components[0]
    assert first.name in names_of(session, first.name.lower())
    assert first.name in names_of(session, first.package[1:6].upper())
    everything = names_of(session)
    assert names_of(session, f"{first.name[0]}*") == [name for name in everything if name.startswith(first.name[0])]
    for name in {row.component_class for row in list_rows(session, "")}:
        assert {row.component_class for row in list_rows(session, name)} == {name}
    assert names_of(session, "no such part") == []
    assert "Clear the filter" in rows_html([], "")


@settings(max_examples=100)
@given(st.text(max_size=12) | st.text(alphabet="[]*?!RCU1-", max_size=8))
def test_any_filter_gives_some_of_the_components(wanted):
    session = tiny_session()
    assert set(names_of(session, wanted)) <= set(names_of(session))


def test_components_with_findings_come_first_and_errors_before_warnings():
    session = tiny_session()
    *_, second, third, last = [component.name for component in session.board.components]
    session = with_findings(
        session,
        made_finding("raised-over-body", "warning", "Raised.", f"sequence[0]/around/{last}+X9"),
        made_finding("not-served", "error", f"{third} must be cleaned, but no step sprays the top side.", "masks"),
        made_finding("narrow-corridor", "info", f"Between {second} and X9.", "sequence[0]/around"),
    )
    rows = list_rows(session, "")
    assert [(row.component.name, row.worst) for row in rows[:2]] == [(third, "error"), (last, "warning")]
    assert {row.worst for row in rows[2:]} == {None}


@pytest.mark.parametrize("message", ["Raised over {}.", "{}: odd.", "({}, X1) differ", "X1+{} stand close"])
def test_a_finding_is_about_the_parts_that_its_message_names(message):
    components = tiny_session().board.components
    name = components[0].name
    assert list(findings_about([made_finding("odd", "info", message.format(name))], components)) == [name]
    assert findings_about([made_finding("odd", "info", message.format(f"{name}7"))], components) == {}


def test_long_lists_say_how_many_more_there_are():
    session = tiny_session()
    rows = list_rows(session, "") * 100
    html = rows_html(rows, "")
    assert html.count("<tr") == MOST_ROWS + 1
    assert f"and {len(rows) - MOST_ROWS} more" in html


def test_the_selected_one_is_marked():
    session = tiny_session()
    rows = list_rows(session, "")
    chosen = rows[1].component.name
    assert rows_html(rows, chosen) != rows_html(rows, "")
    marked = rows_html(rows, chosen).split("<tr")[3]
    assert "background" in marked
    assert chosen in marked


def test_names_from_files_cannot_write_html():
    session = tiny_session()
    evil = replace(session.board.components[0], name='"><script>', package="<b>x")
    session = replace(session, workpiece=replace(session.board, components=(evil,)), run=None)
    html = rows_html(list_rows(session, ""), "")
    assert "<script>" not in html
    assert "<b>x" not in html
    assert 'title=""' not in html.replace('title=""></td>', "")  # an unknown class is an empty cell
