"""What the page says of components and boards."""

from dataclasses import replace

import pytest
from tiny_session import tiny_session

from geometry.finding import Finding
from webui.component_card import board_html, component_html, list_rows, rows_html


def test_the_filter_takes_parts_of_names_packages_and_classes_and_patterns():
    session = tiny_session()
    everything = [row.component.name for row in list_rows(session, "")]
    assert everything == [component.name for component in session.board.components]
    first = session.board.components[0]
    assert first.name in [row.component.name for row in list_rows(session, first.name.lower())]
    assert [row.component.name for row in list_rows(session, first.name[0] + "*")] == [
        name for name in everything if name.startswith(first.name[0])
    ]
    classes = {row.component_class for row in list_rows(session, "")}
    for name in classes:
        assert {row.component_class for row in list_rows(session, name)} == {name}
    assert list_rows(session, "no such part") == []
    assert "clear the filter" in rows_html([])


def test_components_with_findings_come_first():
    session = tiny_session()
    last = session.board.components[-1].name
    finding = Finding("raised-over-body", "warning", "Raised.", f"sequence[0]/around/{last}+X9")
    session = replace(session, run=replace(session.run, findings=(finding,)))
    rows = list_rows(session, "")
    assert (rows[0].component.name, rows[0].findings) == (last, 1)
    assert "Raised." in component_html(session, last)


@pytest.mark.parametrize("index", range(5))
def test_the_card_says_class_reason_and_passes(index):
    session = tiny_session()
    component = session.board.components[index]
    known = session.run.classified[index]
    card = component_html(session, component.name)
    assert known.component_class in card
    assert component.package in card
    assert "sequence[0]/around" in card
    assert f"{component.height_mm:.2f} mm" in card


def test_before_the_first_run_the_card_says_what_the_board_knows():
    session = replace(tiny_session(), run=None)
    assert session.board.components[0].package in component_html(session, session.board.components[0].name)
    assert "Click a part" in component_html(session, "nobody")


def test_names_from_files_cannot_write_html():
    session = tiny_session()
    evil = replace(session.board.components[0], name="<script>", package="<b>x")
    board = replace(session.board, components=(evil,), name="<img>")
    session = replace(session, board=board, run=None)
    for html in (rows_html(list_rows(session, "")), component_html(session, "<script>"), board_html(board)):
        assert "<script>" not in html
        assert "<img>" not in html
        assert "<b>x" not in html
