"""Parts are found by a filter, gone through and selected; what is selected elsewhere is shown."""

from types import SimpleNamespace

import pytest
from small_page import find, press, small_page
from tiny_session import tiny_session

from specs.source import Source
from webui.layers.paths.strokes import stroke_lines
from webui.panels.board.board import ComponentsPanel

NONE = "\N{EN DASH}"


@pytest.fixture
def opened():
    session = tiny_session()
    looked = []
    scene = SimpleNamespace(strokes=stroke_lines(session.run.plan), look_at=lambda place: looked.append(place.name))
    with small_page(session) as page:
        panel = ComponentsPanel(page, scene)
        page.open()
        yield page, panel, looked
        page.close()


def names_of(page):
    return [component.name for component in page.session.board.components]


def test_all_parts_are_offered_and_none_is_chosen(opened):
    page, panel, looked = opened
    choice = find(page, "Go to")
    assert set(choice.options) == {NONE, *names_of(page)}
    assert choice.value == NONE
    assert looked == []
    assert "Click a part" in panel._card.content


def test_a_chosen_part_is_selected_flown_to_and_described(opened):
    page, panel, looked = opened
    name = names_of(page)[2]
    press(page, "Go to", name)
    assert page.session.selection.component == name
    assert looked == [name]
    assert name in panel._card.content
    press(page, "Go to", NONE)
    assert page.session.selection.component == ""
    assert looked == [name]


def test_a_row_that_is_clicked_is_chosen(opened):
    page, panel, looked = opened
    one, two, *_ = names_of(page)
    assert f'data-row="{one}"' in panel._list.content
    for count, name in enumerate((one, two, two), start=1):
        press(page, "Row", f"{count} {name}")  # as the page writes it
        assert page.session.selection.component == name
    press(page, "Row", "4 no such part")
    assert page.session.selection.component == two
    assert looked == [one, two, two]


def test_a_part_selected_elsewhere_is_shown_without_a_flight(opened):
    page, _, looked = opened
    name = names_of(page)[1]
    page.select(component=name)
    assert find(page, "Go to").value == name
    assert looked == []
    page.select(made_by=Source.parse("sequence[0]/around/X"))
    assert find(page, "Go to").value == NONE


def test_the_filter_narrows_the_choice_and_keeps_the_selection(opened):
    page, panel, _ = opened
    names = names_of(page)
    page.select(component=names[0])
    press(page, "Filter", names[1])
    assert set(find(page, "Go to").options) == {NONE, names[1]}
    assert find(page, "Go to").value == NONE
    assert page.session.selection.component == names[0]
    assert names[1] in panel._list.content
    press(page, "Filter", "no such part")
    assert find(page, "Go to").options == (NONE,)
    press(page, "Filter", "")
    assert find(page, "Go to").value == names[0]


def test_steps_go_through_the_list_and_around_its_end(opened):
    page, _, looked = opened
    listed = [name for name in find(page, "Go to").options if name != NONE]
    for _ in range(len(listed) + 1):
        press(page, "Step", "Next")
    press(page, "Step", "Previous")
    assert looked == [*listed, listed[0], listed[-1]]
    press(page, "Filter", "no such part")
    press(page, "Step", "Next")
    assert page.session.selection.component == listed[-1]
