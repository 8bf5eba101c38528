"""What the page says of a component and of a board."""

from dataclasses import replace

import pytest
from made_findings import made_finding
from tiny_session import tiny_session

from webui.cards.workpiece_card import component_html, workpiece_html
from webui.layers.paths.strokes import stroke_lines
from webui.page.session import Selection
from webui.theme.html import facts_html


def card_of(session, name):
    lines = [] if session.run is None else stroke_lines(session.run.plan)
    return component_html(replace(session, selection=Selection(component=name)), lines)


@pytest.mark.parametrize("index", range(5))
def test_the_card_says_class_and_reason_and_sizes(index):
    session = tiny_session()
    component, known = session.board.components[index], session.run.classified[index]
    card = card_of(session, component.name)
    for text in (component.name, component.package, known.component_class, f"{component.height_mm:.2f} mm"):
        assert text in card
    assert known.because.replace(">", "&gt;").replace("<", "&lt;") in card
    assert f"{component.pins}, {component.pins_source}" in card
    assert component.gap_height_source in card
    for name, distance in component.neighbours[:3]:
        assert f"{name}, {distance:.2f} mm" in card


@pytest.mark.parametrize("index", range(5))
def test_the_card_says_which_passes_serve_a_part(index):
    session = tiny_session()
    name = session.board.components[index].name
    lines = stroke_lines(session.run.plan)
    own = [line for line in lines if name in line.made_by.components]
    card = card_of(session, name)
    assert own
    for line in own:
        step = line.made_by.step
        passes = f"{line.laps} passes" if line.laps > 1 else "1 pass"
        assert f"{step + 1} {line.function} \N{MIDDLE DOT} {line.template} \N{MIDDLE DOT} {passes}" in card
        assert f"at {line.speed_mm_s:g} mm/s" in card
    assert "no pass of its own" in component_html(replace(session, selection=Selection(component=name)), [])


def test_the_card_says_what_was_found_about_a_part():
    session = tiny_session()
    name = session.board.components[0].name
    finding = made_finding("raised-over-body", "warning", "Raised <high>.", f"sequence[0]/around/X9+{name}")
    session = replace(session, run=replace(session.run, findings=(finding,)))
    assert "Raised &lt;high&gt;." in card_of(session, name)
    assert "Raised" not in card_of(session, session.board.components[1].name)


def test_before_the_first_run_the_card_says_what_the_board_knows():
    session = replace(tiny_session(), run=None)
    assert session.board.components[0].package in card_of(session, session.board.components[0].name)
    assert "Click a part" in card_of(session, "nobody")
    assert "Click a part" in card_of(session, "")


def test_the_boards_card_counts_findings_and_says_the_worst_first():
    board = tiny_session().board
    assert "no findings" in workpiece_html(replace(board, findings=()))
    notes = tuple(made_finding("note", "info", f"note {number}") for number in range(9))
    card = workpiece_html(replace(board, findings=(*notes, made_finding("bad", "error", "the worst"))))
    assert "1 error, 9 notes" in card
    assert card.index("the worst") < card.index("note 0")
    assert "and 5 more" in card
    assert "note 8" not in card


def test_names_from_files_cannot_write_html():
    session = tiny_session()
    evil = replace(session.board.components[0], name="<script>", package="<b>x", value="<i>")
    board = replace(
        session.board, components=(evil,), name="<img>", findings=(made_finding("odd", "info", "<iframe> <script>"),)
    )
    session = replace(session, workpiece=board, run=None)
    for html in (card_of(session, "<script>"), workpiece_html(board), facts_html({"<u>": "<s>"})):
        for tag in ("<script>", "<img>", "<b>x", "<i>", "<iframe>", "<u>", "<s>"):
            assert tag not in html
