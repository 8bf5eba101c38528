from dataclasses import replace

import pytest

from boards.board import Board
from boards.load import load_board
from recipes.load import RECIPE, load_recipe, parse_recipe, recipe_library
from reports.tables.comparison import Row, compare
from rulesengine.planning.pipeline import Run, run
from specs.yaml.load import read_text
from webui.panels.results.comparison import comparison_html, unlike_strokes


@pytest.fixture(scope="module")
def board() -> Board:
    from pathlib import Path

    return load_board(Path("smt-demo"))


@pytest.fixture(scope="module")
def here(board: Board) -> Run:
    return run(load_recipe("rinse-only"), board)


@pytest.fixture(scope="module")
def slower(board: Board, here: Run) -> Run:
    """The same recipe with its first template at half the speed."""
    name = here.recipe.sequence[0].paths[0]
    template = here.recipe.templates[name]
    slow = template.model_copy(update={"speed_mm_s": template.speed_mm_s / 2})
    return run(here.recipe.model_copy(update={"templates": {**here.recipe.templates, name: slow}}), board)


def find(rows: list[Row], name: str) -> Row:
    return next(row for row in rows if row.name == name)


@pytest.mark.slow
def test_a_run_does_not_differ_from_itself(here: Run) -> None:
    rows = compare(here, here)
    assert [row for row in rows if row.differs or row.change] == []
    assert unlike_strokes(here, here) == []


def test_half_the_speed_takes_longer_and_more_liquid_on_the_same_paths(here: Run, slower: Run) -> None:
    rows = compare(here, slower)
    assert find(rows, "Total time").change.startswith("+")
    liquid = [row for row in rows if row.group == "Liquid"]
    assert liquid
    assert any(row.change.startswith("+") for row in liquid)
    assert not any(row.differs for row in rows if row.group == "Strokes")
    assert unlike_strokes(here, slower) == []


def test_changes_turn_around_with_the_runs(here: Run, slower: Run) -> None:
    forth, back = find(compare(here, slower), "Spraying"), find(compare(slower, here), "Spraying")
    assert (forth.here, forth.there) == (back.there, back.here)
    assert forth.change.startswith("+")
    assert back.change.startswith("-")


def test_other_paths_are_found(here: Run, board: Board) -> None:
    other = run(load_recipe("dry-only"), board)
    assert len(unlike_strokes(here, other)) > 0
    strokes = [row for row in compare(here, other) if row.group == "Strokes"]
    assert any("none" in (row.here, row.there) for row in strokes)


def test_a_path_that_is_moved_is_another_one(here: Run, board: Board) -> None:
    text = read_text(recipe_library()["rinse-only"], RECIPE)
    recipe = parse_recipe(text, file=recipe_library()["rinse-only"])
    name = recipe.sequence[0].paths[0]
    higher = recipe.templates[name].model_copy(update={"height_mm": here.fitted.templates[name].height_mm + 3})
    moved = run(recipe.model_copy(update={"templates": {**recipe.templates, name: higher}}), board)
    places = {line.template for line in unlike_strokes(here, moved)}
    assert name in places


def test_findings_are_compared_by_severity(here: Run) -> None:
    rows = compare(here, replace(here, findings=()))
    assert find(rows, "Notes").there == "0"
    assert find(rows, "Notes").here == str(sum(finding.severity == "info" for finding in here.findings))


def test_names_cannot_become_markup() -> None:
    html = comparison_html([Row("Strokes", "<b>x", "<i>", "2")], "<u>", "b")
    assert "<b>x" not in html
    assert "<i>" not in html
    assert "<u>" not in html
