"""Whole boards with whole recipes: an independent reader has nothing to complain about, and moving changes nothing."""

from functools import cache
from pathlib import Path

import pytest
from acceptance import complaints
from board_recipes import BOARD_RECIPES
from rigid import Motion, differences, moved_bodies, moved_recipe

from boards.formats.tri.tri import write_tri
from boards.load import board_library, load_board
from boards.understand import understand
from programs import native
from programs.native import parse
from recipes.load import load_recipe
from rulesengine.planning.pipeline import run

RECIPES = sorted(BOARD_RECIPES)
BIG = sorted(set(board_library()) - {"tiny"})
MOTIONS = [
    Motion(0, (137.31, -88.07, 2.5)),
    Motion(90, (0.0, 0.0, 0.0)),
    Motion(180, (-3.3, 1000.0, -7.123)),
    Motion(37, (137.31, -88.07, 2.5)),
]


@cache
def board_of(name):
    return load_board(Path(name))


@cache
def planned(board, recipe):
    return run(load_recipe(recipe), board_of(board))


def moved_run(board, recipe, motion):
    moved = understand(moved_bodies(board_of(board).bodies, motion), board)
    return run(moved_recipe(load_recipe(recipe), motion), moved)


def said(done):
    return [(finding.rule.id, finding.severity, finding.message, str(finding.made_by)) for finding in done.findings]


@pytest.mark.slow
@pytest.mark.parametrize("recipe", RECIPES)
def test_no_complaints_about_the_tiny_board(recipe):
    assert complaints(planned("tiny", recipe)) == []


@pytest.mark.slow
@pytest.mark.parametrize("recipe", RECIPES)
@pytest.mark.parametrize("board", BIG)
def test_no_complaints_about_any_sample_board(board, recipe):
    assert complaints(planned(board, recipe)) == []


@pytest.mark.parametrize("recipe", RECIPES)
def test_same_input_gives_the_same_bytes(recipe):
    again = run(load_recipe(recipe), load_board(Path("tiny")))
    assert native.render(again.program) == native.render(planned("tiny", recipe).program)
    assert again.findings == planned("tiny", recipe).findings


@pytest.mark.parametrize(
    "board",
    ["tiny", pytest.param("two-sided", marks=pytest.mark.slow), pytest.param("smt-demo", marks=pytest.mark.slow)],
)
def test_text_reads_back_to_the_same_bytes(board):
    text = native.render(planned(board, "smt-aqueous").program)
    assert native.render(parse(text)) == text


@pytest.mark.slow
@pytest.mark.parametrize("recipe", ["smt-aqueous", "dry-only"])
@pytest.mark.parametrize("motion", MOTIONS, ids=str)
def test_moved_together_the_program_moves_and_nothing_else(recipe, motion):
    here, there = planned("tiny", recipe), moved_run("tiny", recipe, motion)
    assert differences(here.program, there.program, motion) == []
    assert said(here) == said(there)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("board", "motion"),
    [*((board, MOTIONS[-1]) for board in BIG), *(("two-sided", motion) for motion in MOTIONS[:-1])],
    ids=str,
)
def test_moved_together_the_program_of_a_big_board_moves_and_nothing_else(board, motion):
    here, there = planned(board, "smt-aqueous"), moved_run(board, "smt-aqueous", motion)
    assert differences(here.program, there.program, motion) == []
    assert said(here) == said(there)


@pytest.mark.slow
@pytest.mark.parametrize("motion", [Motion(0, (12.3, -4.5, 0.7)), Motion(90, (0.0, 0.0, 0.0)), Motion(270, (5, 5, 5))])
def test_moved_by_way_of_a_file_the_program_moves_and_nothing_else(motion, tmp_path):
    file = tmp_path / "tiny.tri"
    file.write_text(write_tri(moved_bodies(board_of("tiny").bodies, motion)))
    here = planned("tiny", "smt-aqueous")
    there = run(moved_recipe(load_recipe("smt-aqueous"), motion), load_board(file))
    assert differences(here.program, there.program, motion) == []


def test_differences_are_seen():
    here = planned("tiny", "dry-only").program
    assert differences(here, here, Motion(0, (0.0, 0.0, 0.0))) == []
    assert differences(here, here, Motion(0, (0.0, 0.0, 0.006)))
    assert differences(here, here, Motion(0.01, (0.0, 0.0, 0.0)))
