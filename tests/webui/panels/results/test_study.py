import re

import pytest
from made_study import PATHS, write_made_study
from small_page import find, press, small_page, windows
from tiny_session import tiny_session
from waiting import wait_for

from specs.progress import no_progress
from studies.results.card import combination_card, effects_card, label_of, tables_card
from studies.results.read_tables import read_tables
from webui.cards.study_card import (
    choose_combinations,
    combinations_html,
    pareto_svg,
)
from webui.page.project import open_project
from webui.panels.results.comparison import OPEN, TAKE, StudyPanel
from webui.theme.html import card_html


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study")
    write_made_study(folder, boards=("tiny", "two-sided"), failing=frozenset({3}))
    return read_tables(folder / "runs.csv", no_progress)


def numbers(shown):
    return [each.number for each in shown]


def test_combinations_are_those_of_a_board_in_the_chosen_order(tables):
    assert numbers(choose_combinations(tables, "two-sided", "Number", front=False)) == list(range(9, 17))
    by_time = choose_combinations(tables, "tiny", "Time", front=False)
    assert by_time[-1].number == 3  # its error has no time
    assert [each.seconds for each in by_time[:-1]] == sorted(each.seconds for each in by_time[:-1])
    clean = [each.clean for each in choose_combinations(tables, "tiny", "Clean", front=False)]
    assert clean[:-1] == sorted(clean[:-1], reverse=True)
    robust = choose_combinations(tables, "tiny", "All clean", front=False)
    assert (robust[0].number, robust[0].all_clean) == (2, 4)
    front = choose_combinations(tables, "tiny", "Number", front=True)
    assert numbers(front) == [each.number for each in tables.combinations if each.board == "tiny" and each.pareto]


def test_the_table_marks_the_selected_one_and_states_errors(tables):
    html = combinations_html(tables, choose_combinations(tables, "tiny", "Number", front=False), "2")
    rows = html.split("<tr")[2:]
    assert [row.count("inset 3px") for row in rows] == [0, 1, 0, 0, 0, 0, 0, 0]
    assert ">error<" in rows[-1]
    assert label_of(tables, tables.combinations[0]) == "40, 300"
    assert " 40, 300<" in rows[0]


def test_the_card_has_values_verdicts_and_how_often_each_part_is_clean(tables):
    html = card_html(combination_card(tables, tables.combinations[0]))
    for text in (*PATHS, "7 min 58 s", "17.70 l", "5 clean", "2 of 4 with deviations", "50% (15% to 85%)"):
        assert text in html
    assert html.index(">U5<") < html.index(">U1<")  # the least often clean first
    assert "too fast" in card_html(combination_card(tables, tables.combinations[2]))
    assert "2 boards, 2 with" not in card_html(tables_card("x", tables))
    assert "16 combinations, 2 boards, 1 with an error" in card_html(tables_card("x", tables))
    assert f">{PATHS[1]}<" in card_html(effects_card(tables.effects))


def test_the_picture_has_a_dot_for_each_and_larger_ones_for_more_clean_components(tables):
    shown = choose_combinations(tables, "tiny", "Number", front=False)
    svg = pareto_svg(shown, "2")
    dots = {
        int(number): (float(x), float(y), float(radius))
        for x, y, radius, number in re.findall(r'cx="([\d.]+)" cy="([\d.]+)" r="([\d.]+)"[^>]*><title>(\d+):', svg)
    }
    good = [each for each in shown if not each.error]
    assert sorted(dots) == numbers(good)
    by_time = sorted(good, key=lambda each: each.seconds)
    assert [dots[each.number][0] for each in by_time] == sorted(place[0] for place in dots.values())
    by_litres = sorted(good, key=lambda each: -each.litres)
    assert [dots[each.number][1] for each in by_litres] == sorted(place[1] for place in dots.values())
    assert dots[1][2] > dots[8][2]
    assert len(re.findall(r'stroke-width="2"', svg)) == 1
    assert pareto_svg([tables.combinations[2]], "") == ""


def test_one_combination_is_a_picture_too(tables):
    assert "<circle" in pareto_svg(tables.combinations[:1], "")


def test_a_name_from_a_file_is_text(tables, tmp_path):
    write_made_study(tmp_path, boards=("<img src=x>",), recipes=("<b>", "&"))
    hostile = read_tables(tmp_path / "runs.csv", no_progress)
    html = combinations_html(hostile, hostile.combinations, "") + card_html(
        combination_card(hostile, hostile.combinations[0])
    )
    assert "<img" not in html
    assert "<b>" not in html


@pytest.fixture
def page(tmp_path):
    write_made_study(tmp_path / "made")
    with small_page(tiny_session(), open_project(tmp_path)) as page:
        StudyPanel(page, None)
        page.open()
        yield page


def open_made(page):
    press(page, OPEN)
    press(page, "Open")
    wait_for(lambda: page.session.study is not None)


def test_a_study_is_opened_chosen_from_and_its_combination_taken(page):
    open_made(page)
    assert page.session.study.name == "made/runs.csv"
    press(page, "Combination", "2")
    press(page, TAKE)
    wait_for(lambda: page.session.document.dirty)
    assert page.session.workpiece_name == "tiny"
    assert page.session.recipe.templates["sweep"].speed_mm_s == 40
    assert page.session.recipe.sequence[0].least_time_s == 330
    assert page.session.undone().document.text == page.session.document.saved


def test_what_is_not_saved_is_not_lost_silently(page):
    open_made(page)
    page.attempt(lambda session: session.edited(session.document.text + "\n# mine\n"))
    press(page, "Combination", "2")
    press(page, TAKE)
    assert page.session.document.text.endswith("# mine\n")
    assert len(windows(page)) == 1
    press(page, "Open")
    wait_for(lambda: not page.session.document.text.endswith("# mine\n"))


def test_a_recipe_that_is_not_in_the_folder_is_named(page, tmp_path):
    write_made_study(tmp_path / "other" / "study", recipes=("mine.yaml",))
    press(page, OPEN)
    find(page, "Study").value = "other/study/runs.csv"
    press(page, "Open")
    wait_for(lambda: page.session.study is not None)
    press(page, "Combination", "2")
    press(page, TAKE)
    wait_for(lambda: page.client.said)
    assert "'mine.yaml' is not in" in page.client.said[0]
    (tmp_path / "other" / "mine.yaml").write_text("recipe: mine\nextends: smt-aqueous\n")
    press(page, TAKE)
    wait_for(lambda: page.session.document.dirty)
    assert page.session.document.file == tmp_path / "other" / "mine.yaml"


def test_without_a_study_one_sentence_names_the_command(tmp_path):
    with small_page(tiny_session(), open_project(tmp_path)) as page:
        StudyPanel(page, None)
        page.open()
        press(page, OPEN)
        assert page.client.said == [
            f"Not done: There is no study in {tmp_path}; `washboard study` writes one into its folder."
        ]
