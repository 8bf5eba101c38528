"""The tree shows the sequence as it is, and edits it as the recipe's text is edited."""

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_page import click, find, press, small_page
from tiny_session import tiny_session

from specs.source import Source
from webui.layers.paths.strokes import times_by_place
from webui.panels.recipe.job import JobPanel, Row, label_of, rows_of, source_of
from webui.server.server import open_session

SESSION = tiny_session()


@pytest.fixture
def tree():
    with small_page(SESSION) as page:
        panel = JobPanel(page, None)
        page.open()
        yield page, panel


def labels(panel):
    return [button.label for button in panel._rows if button.visible]


def choose(page, panel, row):
    click(page, panel._rows[rows_of(page.session.recipe).index(row)])  # labels of like rows are the same


def paths(page, step=0):
    return page.session.recipe.sequence[step].paths


def test_each_step_and_path_is_a_row_with_its_time(tree):
    _, panel = tree
    rows, times = rows_of(SESSION.recipe), times_by_place(SESSION.run.program)
    assert len(labels(panel)) == len(rows)
    first, step = SESSION.recipe.sequence[0], times[Source(0)]
    assert labels(panel)[0].startswith(f"1  {first.function}, {first.nozzle}")
    assert sum(times[source_of(SESSION.recipe, Row(0, index))] for index in range(len(first.paths))) <= step + 1e-9
    of_steps = [time_s for place, time_s in times.items() if not place.template]
    assert sum(of_steps) == pytest.approx(SESSION.run.program.totals.duration_s, rel=0.05)


@pytest.mark.slow
def test_the_step_before_which_the_board_is_turned_over_has_it_in_its_row():
    session = open_session("two-sided", "smt-aqueous")
    sides = [step.side for step in session.recipe.sequence]
    rows = [label_of(session, Row(index), {}) for index in range(len(sides))]
    assert ["\N{UPWARDS ARROW LEFTWARDS OF DOWNWARDS ARROW}" in row for row in rows] == [
        False,
        *(one != two for one, two in pairwise(sides)),
    ]
    assert len({*sides}) == 2
    first = sides.index(sides[-1])
    off = session.set_value(("sequence", first, "enabled"), False)
    assert "\N{UPWARDS ARROW LEFTWARDS OF DOWNWARDS ARROW}" not in label_of(off, Row(first), {})


def test_a_chosen_path_is_selected_and_marked_and_chosen_again_let_go(tree):
    page, panel = tree
    choose(page, panel, Row(0, 1))
    assert page.session.selection.made_by == Source(0, paths(page)[1])
    assert [label.startswith("\N{BLACK RIGHT-POINTING SMALL TRIANGLE}") for label in labels(panel)].count(True) == 1
    choose(page, panel, Row(0, 1))
    assert not page.session.selection.made_by
    assert not any("\N{BLACK RIGHT-POINTING SMALL TRIANGLE}" in label for label in labels(panel))


def test_a_stroke_that_is_selected_chooses_its_path(tree):
    page, panel = tree
    page.select(made_by=Source(0, paths(page)[2], ("U1",)))
    assert panel._row == Row(0, 2)


def test_a_path_moves_and_stays_chosen(tree):
    page, panel = tree
    before = list(paths(page))
    choose(page, panel, Row(0, 1))
    press(page, "Chosen", "Up")
    assert paths(page) == [before[1], before[0], *before[2:]]
    assert panel._row == Row(0, 0)
    press(page, "Chosen", "Up")
    assert paths(page) == [before[1], before[0], *before[2:]]
    press(page, "Chosen", "Down")
    assert paths(page) == before


@pytest.mark.slow
def test_a_step_is_switched_off_moved_and_removed(tree):
    page, panel = tree
    functions = [step.function for step in SESSION.recipe.sequence]
    choose(page, panel, Row(1))
    press(page, "Chosen", "On/off")
    assert [step.enabled for step in page.session.recipe.sequence][:3] == [True, False, True]
    assert "(off)" in labels(panel)[rows_of(page.session.recipe).index(Row(1))]
    press(page, "Chosen", "Down")
    assert [step.function for step in page.session.recipe.sequence][1:3] == functions[2:0:-1]
    press(page, "Chosen", "Remove")
    assert len(page.session.recipe.sequence) == len(functions) - 1
    assert len(labels(panel)) == len(rows_of(page.session.recipe))


@pytest.mark.slow
def test_a_path_and_a_step_are_added_after_the_chosen_one(tree):
    page, panel = tree
    before = list(paths(page))
    choose(page, panel, Row(0, 0))
    find(page, "Path").value = before[-1]
    press(page, "Add", "Add path")
    assert paths(page) == [before[0], before[-1], *before[1:]]
    press(page, "Add", "Add step")
    assert page.session.recipe.sequence[1].paths == paths(page)
    assert panel._row == Row(1)


def test_a_click_on_a_row_that_went_meanwhile_chooses_nothing(tree):
    page, panel = tree
    last = panel._rows[-1]
    choose(page, panel, Row(len(page.session.recipe.sequence) - 1))
    press(page, "Chosen", "Remove")
    click(page, last)
    assert panel._row is None


def test_without_a_choice_the_page_says_what_is_missing(tree):
    page, _ = tree
    press(page, "Chosen", "Remove")
    assert any("Choose a step or a path" in message for message in page.client.said)
    assert page.session.recipe is SESSION.recipe


@pytest.mark.slow
@settings(max_examples=5)
@given(
    st.lists(st.tuples(st.integers(0, 40), st.sampled_from(("Up", "Down", "On/off", "Remove", "Add path"))), max_size=6)
)
def test_the_rows_are_always_those_of_the_recipe(events):
    with small_page(SESSION) as page:
        panel = JobPanel(page, None)
        page.open()
        for at, what in events:
            rows = rows_of(page.session.recipe)
            wanted = rows[at % len(rows)]
            if panel._row != wanted:
                choose(page, panel, wanted)
            press(page, "Add" if what == "Add path" else "Chosen", what)
            rows = rows_of(page.session.recipe)
            assert len(labels(panel)) == len(rows)
            for row, label in zip(rows, labels(panel), strict=True):
                step = page.session.recipe.sequence[row.step]
                assert (step.function if row.path is None else step.paths[row.path]) in label
