"""A bath over many boards: its balance against boards that are washed one by one, and its limit to the board."""

import math
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from boards.load import load_board
from cleaning.analyse import analyse
from cleaning.errors import CleaningError
from cleaning.parameters.load import load_parameters
from cleaning.parameters.provenance import with_values
from cleaning.uncertainty.bath import Bath, drag_out_ml, flux_g, washing_liquid
from recipes.load import load_recipe
from rulesengine.planning.pipeline import run

PARAMETERS = load_parameters()


def bath(**changes):
    return Bath(
        **({"volume_l": 20.0, "density_kg_m3": 1000.0, "fresh_pct": 1.0, "flux_g": 0.5, "drag_out_ml": 4.0} | changes)
    )


@pytest.mark.slow
@settings(max_examples=200)
@given(
    litres=st.floats(1, 500),
    flux=st.floats(0, 20),
    dragged=st.floats(0, 900),
    fresh=st.floats(0, 5),
    boards=st.integers(0, 300),
)
def test_nothing_is_lost_and_nothing_made(litres, flux, dragged, fresh, boards):
    """What came in is in the bath or left with the boards; the mass of the bath stays."""
    tank = bath(volume_l=litres, flux_g=flux, drag_out_ml=dragged, fresh_pct=fresh)
    mass_g = 1000.0 * litres
    share = dragged / mass_g
    residue_g = came_g = 0.01 * fresh * mass_g
    left_g = 0.0
    for _ in range(boards):
        residue_g, came_g = residue_g + flux, came_g + flux
        left_g += share * residue_g
        residue_g -= share * residue_g
        made_up_g = 0.01 * fresh * share * mass_g
        residue_g, came_g = residue_g + made_up_g, came_g + made_up_g
    assert residue_g + left_g == pytest.approx(came_g, rel=1e-9)
    assert tank.residue_pct(boards) == pytest.approx(100.0 * residue_g / mass_g, rel=1e-6, abs=1e-9)


def test_by_hand():
    """20 kg, 0.5 g of flux and 4 g of drag-out a board: it settles at 1 + 0.0025 (1 - d) / d, d = 1/5000."""
    tank = bath()
    assert tank.settles_pct == pytest.approx(1.0 + 0.0025 * 4999.0)
    assert tank.residue_pct(0) == pytest.approx(1.0)
    assert tank.residue_pct(1) == pytest.approx((1.0 + 0.0025) * (1.0 - 2e-4) + 2e-4)
    assert bath(drag_out_ml=0.0).residue_pct(800) == pytest.approx(1.0 + 800 * 0.0025)
    assert math.isinf(bath(drag_out_ml=0.0).settles_pct)


@pytest.mark.parametrize("limit", [1.0, 1.01, 2.0, 3.0, 12.0])
def test_the_limit_is_passed_with_the_board_that_is_named(limit):
    tank = bath()
    boards = tank.boards_until(limit)
    assert tank.residue_pct(boards) > limit
    assert boards == 0 or tank.residue_pct(boards - 1) <= limit


def test_a_bath_that_never_gets_there_and_one_that_begins_beyond():
    assert bath().boards_until(13.6) is None
    assert bath(flux_g=0.0).boards_until(2.0) is None
    assert bath(flux_g=0.0, drag_out_ml=0.0).boards_until(2.0) is None
    assert bath(begin_pct=4.0).boards_until(3.0) == 0
    assert bath(begin_pct=4.0, flux_g=0.0).residue_pct(100_000) == pytest.approx(1.0)


def test_more_drag_out_than_bath_is_refused():
    with pytest.raises(CleaningError, match="all of a bath of 1 l"):
        bath(volume_l=1.0, drag_out_ml=1000.0)


@pytest.mark.slow
def test_what_a_board_brings_and_takes_along():
    board, recipe = load_board(Path("tiny")), load_recipe("smt-aqueous")
    report = analyse(run(recipe, board).program, board, recipe, PARAMETERS, "sketch")
    assert washing_liquid(report) == "saponifier-15"
    gaps = [max(part.gaps, key=lambda gap: gap.gap_height_mm) for part in report.parts if part.gaps]
    volumes = (
        gap.fill * gap.gap_height_mm * 1e3 * gap.field.length_m * 1e3 * gap.field.width_m * (1 - gap.field.coverage)
        for gap in gaps
    )
    assert flux_g(report) == pytest.approx(sum(volumes) * 1100e-6, rel=0.03)  # mm3 at 1.1 mg; 2 % of it stays
    surfaces = float(report.facets.areas_mm2.sum())
    assert drag_out_ml(report) == pytest.approx(surfaces * 0.05 / 1000.0)  # 50 um
    assert surfaces > 2 * 20 * 30
    spent = with_values(PARAMETERS, {"liquids.saponifier-15.bath_nvr_pct": 3.5})
    later = analyse(run(recipe, board).program, board, recipe, spent, "sketch")
    assert "R9" in {each.rule.id for each in later.process}
    assert "R9" not in {each.rule.id for each in report.process}


def test_without_a_wash_there_is_no_bath():
    board, recipe = load_board(Path("tiny")), load_recipe("rinse-only")
    report = analyse(run(recipe, board).program, board, recipe, PARAMETERS, "sketch")
    with pytest.raises(CleaningError, match="does not wash"):
        washing_liquid(report)
