"""The library recipes as shipped, on every sample board: clean but for stated causes, little slower than tuned."""

import json
from pathlib import Path

import pytest
from board_recipes import BOARD_RECIPES

from boards.load import board_library, load_board
from cleaning.parameters.load import load_parameters
from cleaning.prepared_board import prepare
from recipes.load import load_recipe
from rulesengine.planning.pipeline import run
from rulesengine.planning.spray_findings import landed_shares
from rulesengine.tuning.trial.trial_runner import TrialRunner

TUNED = json.loads((Path(__file__).parents[1] / "golden" / "tuned.json").read_text("utf-8"))
"""Seconds and litres that ``benchmarks/library_recipes.py --write`` reached."""
CAUSES = {
    ("sensor-hub", "U3"): {"R5", "R10"},  # its gap is plugged before washing begins
    ("sensor-hub", "J1"): {"R1"},  # the recess of its own port
    ("smt-demo", "J1"): {"R1"},
    ("smt-demo", "J2"): {"R1"},
    ("smt-demo", "board"): {"R1"},  # between parts, 1.0 % that is shadowed
    ("two-sided", "J1"): {"R1"},
}
"""Rules that no library recipe meets for some parts, with the cause."""
MOST_MISSED = 0.06
"""Share of its surface that a part may hide from the spray by its own recess."""
LARGE_MM = 50.0


@pytest.mark.slow
@pytest.mark.parametrize("board", sorted(board_library()))
def test_every_recipe_leaves_nothing_that_a_recipe_can_clean(board):
    prepared = prepare(load_board(board_library()[board]), load_parameters(), lambda *_: None)
    residues: dict[str, float] = {}
    for name, file in BOARD_RECIPES.items():
        outcome = TrialRunner(file, prepared, "clean", 1).first(file.read_text("utf-8"))
        if name == "dry-only":  # it sprays no liquid: what has to be cleaned before it remains
            assert {each.judgement.name for each in outcome.unmet} == {"not sprayed"}
            continue
        for each in outcome.unmet:
            assert each.rule.id in CAUSES.get((board, each.component), set()), (name, each.judgement.because)
            if each.rule.id == "R1":
                assert each.judgement.numbers[0].value <= 100.0 * MOST_MISSED
        residues[name] = max(share for part, share in outcome.residues.items() if (board, part) not in CAUSES)
        if name == "smt-aqueous":
            assert outcome.seconds <= 1.15 * TUNED[board]["seconds"]
            assert outcome.litres <= 1.15 * TUNED[board]["litres"]
    # The longer wash buys margin.
    assert residues["low-standoff"] < 0.25 * residues["smt-aqueous"]


@pytest.mark.slow
@pytest.mark.parametrize("board", sorted(board_library()))
def test_most_of_the_spray_of_every_step_lands_on_boards_of_50_mm_or_more(board):
    loaded = load_board(board_library()[board])
    low_x, low_y, high_x, high_y = loaded.outline.bounds
    large = max(high_x - low_x, high_y - low_y) >= LARGE_MM
    assert large == (board != "tiny")
    for name in ("smt-aqueous", "low-standoff", "rinse-only"):
        done = run(load_recipe(name), loaded)
        landed: dict[int, float] = {}
        sprayed: dict[int, float] = {}
        for each in landed_shares(done.fitted, loaded, done.plan.items):
            landed[each.made_by.step] = landed.get(each.made_by.step, 0.0) + each.share * each.seconds
            sprayed[each.made_by.step] = sprayed.get(each.made_by.step, 0.0) + each.seconds
        assert sprayed
        if large:
            assert min(landed[step] / sprayed[step] for step in sprayed) >= 0.5
