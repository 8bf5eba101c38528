"""Rinsing dilutes what the bath leaves until the water's own ions decide."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_sprays import samples_of, stage_of

from boards.load import load_board
from cleaning.analyse import analyse
from cleaning.errors import CleaningError
from cleaning.parameters.load import load_parameters, read_parameters_text
from cleaning.parameters.model import Liquid
from cleaning.report import cleaning_report
from cleaning.undersides.residue import GapStage
from cleaning.undersides.rinse import (
    Cascade,
    bath_g_m3,
    diluted_g_m3,
    film_exchanges,
    gap_content_g_m3,
    ionic_ug_cm2,
    resistivity_mohm_cm,
    salt_g_m3,
    water_g_m3,
    water_resistivity,
)
from recipes.load import load_recipe
from reports.cards.measured import rinse_table, rinse_words
from rulesengine.planning.pipeline import run

RINSE = load_parameters("default").rinse
BATH = Liquid(use="wash", density_kg_m3=1000.0, bath_nvr_pct=3.0)


def left_ug_cm2(exchanges: float) -> float:
    return ionic_ug_cm2(diluted_g_m3(RINSE, bath_g_m3(BATH), exchanges, 0.0), RINSE.final_film_um)


def test_an_unrinsed_bath_leaves_150_micrograms() -> None:
    assert bath_g_m3(BATH) == pytest.approx(30000.0)
    assert left_ug_cm2(0.0) == pytest.approx(150.0)


def test_seven_exchanges_bring_it_to_one() -> None:
    assert left_ug_cm2(7.16) == pytest.approx(1.0, rel=0.01)


@pytest.mark.parametrize(("mohm_cm", "ug_cm2"), [(1.0, 0.00219), (0.2, 0.0114), (0.1, 0.0230), (1.0 / 333.0, 0.77)])
def test_water_leaves_its_own_ions(mohm_cm: float, ug_cm2: float) -> None:
    assert ionic_ug_cm2(salt_g_m3(mohm_cm), RINSE.final_film_um) == pytest.approx(ug_cm2, rel=0.01)


def test_pure_water_and_water_of_unknown_purity_add_nothing() -> None:
    assert salt_g_m3(18.2) == pytest.approx(0.0, abs=1e-3)
    assert salt_g_m3(25.0) == 0.0
    assert salt_g_m3(None) == 0.0


def test_a_millimetre_of_water_renews_a_film_five_times() -> None:
    assert film_exchanges(RINSE, 1.0) == pytest.approx(5.0)


@settings(max_examples=50)
@given(before=st.floats(0, 1e5), exchanges=st.floats(0, 50), more=st.floats(0, 50), water=st.floats(0, 100))
def test_rinsing_longer_never_leaves_more_nor_less_than_the_water_brings(
    before: float, exchanges: float, more: float, water: float
) -> None:
    longer = diluted_g_m3(RINSE, before, exchanges + more, water)
    assert water <= longer <= diluted_g_m3(RINSE, before, exchanges, water)


@settings(max_examples=50)
@given(before=st.floats(0, 1e5), counts=st.lists(st.floats(0, 10), min_size=1, max_size=10), water=st.floats(0, 500))
def test_rinses_one_after_the_other_are_one_of_as_many_exchanges(
    before: float, counts: list[float], water: float
) -> None:
    content = before
    for count in counts:
        after = diluted_g_m3(RINSE, content, count, water)
        assert water <= after <= max(content, water) * (1 + 1e-12)
        content = after
    assert content == pytest.approx(diluted_g_m3(RINSE, before, sum(counts), water), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("exchanges", [1.0, 3.0, 7.2, 20.0])
@pytest.mark.parametrize("mohm_cm", [1.0 / 333.0, 0.1, 1.0, 18.0])
def test_after_a_bath_the_water_adds_to_what_is_left_of_it(exchanges: float, mohm_cm: float) -> None:
    bath, water = bath_g_m3(BATH), salt_g_m3(mohm_cm)
    both = bath * math.exp(-RINSE.efficiency * exchanges) + water
    assert diluted_g_m3(RINSE, bath, exchanges, water) == pytest.approx(both, rel=0.01)


def in_gap(use: str, exchanges: float, *, repeats: int = 1, entered: bool = True, **changes: object) -> tuple[Any, Any]:
    """A stage, and what it does in a gap."""
    stage = replace(stage_of(samples_of([[0.0, 0.0, 50.0]]), use=use), repeats=repeats, **changes)
    none = np.zeros(1, dtype=np.float32)
    gap = GapStage(
        margin_pa=1.0,
        entered=entered,
        edge_pa=(0.0,) * 8,
        side_shear_pa=(0.0,) * 4,
        shear_pa=none,
        weak_share=0.0,
        exchanges=exchanges,
        reynolds=0.0,
        wet_s=1.0,
        residue=none,
    )
    return stage, gap


def content(*pairs: tuple[Any, Any]) -> float:
    return gap_content_g_m3(RINSE, [stage for stage, _ in pairs], [gap for _, gap in pairs])


@pytest.mark.parametrize("repeats", [1, 2, 7])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_rinses_of_a_gap_count_as_often_as_they_may_be_repeated(repeats: int, count: int) -> None:
    wash = in_gap("wash", 1.0, liquid=BATH)
    found = content(wash, *[in_gap("rinse", 0.4, repeats=repeats, water_g_m3=2.0)] * count)
    again = content(wash, *[in_gap("rinse", 0.4, water_g_m3=2.0)] * (repeats * count))
    assert found == pytest.approx(again)
    assert found == pytest.approx(diluted_g_m3(RINSE, bath_g_m3(BATH), 0.4 * repeats * count, 2.0))


def test_what_stays_in_a_gap_is_of_the_last_wash_and_of_what_entered_after_it() -> None:
    wash, strong = in_gap("wash", 1.0, liquid=BATH), BATH.model_copy(update={"bath_nvr_pct": 6.0})
    rinse = in_gap("rinse", 0.5, water_g_m3=0.0)
    assert content() == content(rinse) == 0.0
    assert content(rinse, wash) == bath_g_m3(BATH), "a rinse before the wash dilutes nothing"
    assert content(wash, in_gap("wash", 1.0, liquid=strong)) == bath_g_m3(strong)
    assert content(in_gap("wash", 1.0, liquid=strong), wash) == bath_g_m3(BATH)
    dry = in_gap("rinse", 9.0, entered=False)
    assert content(wash, dry, (rinse[0], None), rinse) == content(wash, rinse) < bath_g_m3(BATH)
    assert content((wash[0], None), in_gap("wash", 1.0, entered=False)) == 0.0


@pytest.mark.parametrize("given", [None, 40.0])
def test_the_water_of_a_rinse_is_that_of_its_tank_else_as_stated(given: float | None) -> None:
    stage, _ = in_gap("rinse", 1.0, water_g_m3=given)
    stated = stage.liquid.resistivity_mohm_cm
    assert water_g_m3(stage) == (salt_g_m3(stated) if given is None else given)
    expected = stated if given is None else resistivity_mohm_cm(40.0)
    assert water_resistivity(stage) == pytest.approx(expected)


WASH_BATH = 10_000.0
"""1 % of residue in water, g/m3."""


def cascade(tanks: int = 3, ratio: float = 5.0, **changes) -> Cascade:
    made = Cascade(
        solutions=tuple(f"rinse-{number}" for number in range(1, tanks + 1)),
        volumes_m3=(0.02,) * tanks,
        fresh_m3=ratio * 3e-6,
        counter_current=True,
        fresh_g_m3=(0.0,) * tanks,
        carried_m3=3e-6,
        kept=(0.0,) * tanks,
    )
    return replace(made, **changes)


@pytest.mark.parametrize("tanks", [1, 2, 3, 6])
@pytest.mark.parametrize("ratio", [0.4, 5.0, 300.0])
def test_counter_current_tanks_settle_at_the_closed_form(tanks, ratio):
    """c_i / c_0 = (r^(k+1-i) - 1) / (r^(k+1) - 1), r fresh water per carry-over."""
    found = cascade(tanks, ratio).steady_g_m3(WASH_BATH)
    expected = [(ratio ** (tanks + 1 - i) - 1) / (ratio ** (tanks + 1) - 1) for i in range(1, tanks + 1)]
    np.testing.assert_allclose(np.array(found) / WASH_BATH, expected, rtol=1e-9)


def test_by_hand_two_tanks_and_ten_times_the_carry_over():
    """1 / (1 + r + r^2) of the bath in the last tank, (1 + r) times that in the first."""
    first, last = cascade(2, 10.0).steady_g_m3(WASH_BATH)
    assert last == pytest.approx(WASH_BATH / 111.0)
    assert first == pytest.approx(WASH_BATH * 11.0 / 111.0)
    level = cascade(4, 1.0).steady_g_m3(WASH_BATH)  # as much fresh water as carry-over: even steps
    np.testing.assert_allclose(level, [WASH_BATH * 4 / 5, WASH_BATH * 3 / 5, WASH_BATH * 2 / 5, WASH_BATH / 5])


@pytest.mark.parametrize("tanks", [1, 2, 4])
def test_tanks_with_a_feed_each_settle_at_theirs(tanks):
    found = cascade(tanks, 9.0, counter_current=False).steady_g_m3(WASH_BATH)
    np.testing.assert_allclose(np.array(found) / WASH_BATH, [10.0**-i for i in range(1, tanks + 1)])


def test_one_tank_in_time_is_an_exponential():
    one = cascade(1, 4.0, fresh_g_m3=(0.5,))
    (settled,) = one.steady_g_m3(WASH_BATH)
    assert settled == pytest.approx((WASH_BATH + 4.0 * 0.5) / 5.0)
    for boards in (0, 1, 40, 3000, 100_000_000):
        (found,) = one.after_g_m3(boards, WASH_BATH)
        assert found == pytest.approx(settled + (0.5 - settled) * np.exp(-boards * 5.0 * 3e-6 / 0.02))


def test_two_tanks_with_a_feed_each_in_time():
    """Equal rates s = (D + F) / V: c_2 = c_2s (1 - e^-sn (1 + s n)), as of stirred tanks in a row."""
    two = cascade(2, 4.0, counter_current=False)
    rate = 5.0 * 3e-6 / 0.02
    for boards in (10, 500, 4000):
        grown = rate * boards
        np.testing.assert_allclose(
            two.after_g_m3(boards, WASH_BATH),
            [WASH_BATH / 5 * -np.expm1(-grown), WASH_BATH / 25 * (1.0 - np.exp(-grown) * (1.0 + grown))],
            rtol=1e-8,
        )


def test_two_counter_current_tanks_in_time_are_the_sum_of_two_exponentials():
    """Their rates are (D + F -+ sqrt(D F)) / V, from the eigenvalues of the balance."""
    two, ratio = cascade(2, 9.0), 9.0
    steady = np.array(two.steady_g_m3(WASH_BATH))
    slow, fast = ((1.0 + ratio - root) * 3e-6 / 0.02 for root in (3.0, -3.0))
    for boards in (20, 700, 9000):
        # c_1 and c_2 begin at 0; modes are (3, 1) and (3, -1): sqrt(F / D) to one
        along, against = (steady[0] / 3.0 + steady[1]) / 2.0, (steady[0] / 3.0 - steady[1]) / 2.0
        left = along * np.exp(-slow * boards) * np.array([3.0, 1.0])
        left += against * np.exp(-fast * boards) * np.array([3.0, -1.0])
        np.testing.assert_allclose(two.after_g_m3(boards, WASH_BATH), steady - left, rtol=1e-8)


@pytest.mark.slow
@settings(max_examples=25)
@given(
    tanks=st.integers(1, 4),
    ratio=st.floats(0.1, 500),
    kept=st.floats(0, 0.99),
    counter_current=st.booleans(),
    boards=st.integers(0, 120),
    grows=st.floats(0, 2),
)
def test_nothing_is_lost_and_nothing_made(tanks, ratio, kept, counter_current, boards, grows):
    """Walked in small steps: what came over and with fresh water is in the tanks, left with boards, or overflowed."""
    tank = cascade(tanks, ratio, kept=(kept,) * tanks, counter_current=counter_current, fresh_g_m3=(2.0,) * tanks)
    found = np.array(tank.after_g_m3(boards, WASH_BATH, added_g_m3=grows))
    contents, bath, came, gone, fine = np.full(tanks, 2.0), WASH_BATH, 0.0, 0.0, 8
    begin = float(contents @ np.array(tank.volumes_m3))
    for _ in range(boards):
        for _ in range(fine):
            on_board = np.array([bath, *tank.on_board_g_m3(contents.tolist(), bath)])
            inflow = np.append(contents[1:], 2.0) if counter_current else np.full(tanks, 2.0)
            out = contents[:1] if counter_current else contents
            came += (tank.carried_m3 * bath + tank.fresh_m3 * 2.0 * (1 if counter_current else tanks)) / fine
            gone += (tank.carried_m3 * on_board[-1] + tank.fresh_m3 * out.sum()) / fine
            flow = tank.carried_m3 * -np.diff(on_board) + tank.fresh_m3 * (inflow - contents)
            contents = contents + flow / np.array(tank.volumes_m3) / fine
        bath += grows
    assert contents @ np.array(tank.volumes_m3) + gone == pytest.approx(begin + came, rel=1e-9)
    np.testing.assert_allclose(found, contents, rtol=0.01, atol=1e-3 * WASH_BATH / 100)


def test_a_tank_that_hardly_exchanges_leaves_the_bath_on_the_board():
    lazy = cascade(2, 50.0, kept=(0.5, 0.0))
    contents = lazy.steady_g_m3(WASH_BATH)
    first, last = lazy.on_board_g_m3(contents, WASH_BATH)
    assert first == pytest.approx(0.5 * (contents[0] + WASH_BATH))
    assert last == pytest.approx(contents[1])
    assert contents[1] > 10.0 * cascade(2, 50.0).steady_g_m3(WASH_BATH)[1]
    unused = cascade(2, 50.0, kept=(1.0, 0.0)).steady_g_m3(WASH_BATH)
    np.testing.assert_allclose(unused[1], WASH_BATH / 51.0)  # as one tank


def test_the_last_tank_falls_below_a_resistivity_with_the_board_that_is_named():
    tank = cascade(2, 60.0, fresh_g_m3=(salt_g_m3(10.0),) * 2)
    boards = tank.boards_until(0.5, WASH_BATH)
    assert boards is not None
    assert boards > 1
    at, before = (resistivity_mohm_cm(tank.after_g_m3(n, WASH_BATH)[-1]) for n in (boards, boards - 1))
    assert at < 0.5 <= before
    assert tank.boards_until(0.01, WASH_BATH) is None
    assert tank.boards_until(11.0, WASH_BATH) == 0


def test_resistivity_and_salt_are_inverse():
    for resistivity in (0.05, 1.0, 18.0):
        assert resistivity_mohm_cm(salt_g_m3(resistivity)) == pytest.approx(resistivity)
    assert resistivity_mohm_cm(0.0) == pytest.approx(1 / 0.055)


TANKS = """parameters: own
extends: default
liquids:
  first-rinse: {use: rinse, density_kg_m3: 985, resistivity_mohm_cm: 1}
rinse:
  cascade:
    tanks:
      - {solution: first-rinse, volume_l: 20}
      - {solution: di-water, volume_l: 20}
    fresh_l: 1
provenance:
  liquids.first-rinse: {known: proposed, source: us}
  rinse.cascade: {known: source, source: the data sheet of the machine}
"""


def test_tanks_stand_in_a_parameter_set():
    own = read_parameters_text(TANKS).rinse.cascade
    assert own is not None
    assert [tank.solution for tank in own.tanks] == ["first-rinse", "di-water"]
    assert own.feed == "counter_current"
    assert load_parameters().rinse.cascade is None


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("solution: di-water", "solution: di-wate", "is not among liquids; did you mean 'di-water'"),
        ("solution: di-water", "solution: saponifier-15", "saponifier-15 is for wash, not for rinse"),
        ("solution: di-water", "solution: first-rinse", "first-rinse has a tank already"),
        ("fresh_l: 1", "fresh_l: 0", "at least 0.0001 l"),
    ],
)
def test_tanks_that_cannot_be_are_refused_with_their_line(old, new, words):
    with pytest.raises(CleaningError, match=words) as caught:
        read_parameters_text(TANKS.replace(old, new), file="own.yaml")
    assert (caught.value.line or 0) >= 6


def analysed(parameters):
    board, recipe = load_board(Path("tiny")), load_recipe("smt-aqueous")
    return analyse(run(recipe, board).program, board, recipe, parameters, "sketch")


@pytest.mark.slow
def test_a_rinse_sprays_what_its_tank_holds():
    """Board, bath and fresh water by hand: the last tank, its resistivity, the rule on it, and what stays in gaps."""
    parameters = read_parameters_text(TANKS.replace("fresh_l: 1", "fresh_l: 0.2"))
    fresh, report = analysed(load_parameters()), analysed(parameters)
    water = report.rinse_water
    assert fresh.rinse_water is None
    assert water is not None
    area = float(report.facets.areas_mm2.sum())
    gaps = [max(part.gaps, key=lambda gap: gap.gap_height_mm) for part in report.parts if part.gaps]
    held = sum(
        gap.gap_height_mm * 1e6 * gap.field.length_m * gap.field.width_m * (1.0 - gap.field.coverage) for gap in gaps
    )
    assert 1e9 * water.cascade.carried_m3 == pytest.approx(area * 0.05 + held, rel=0.03)
    assert water.bath_g_m3 == 10_000.0
    first, last = water.tanks
    assert (first.kept, last.kept) == (1.0, pytest.approx(0.0, abs=1e-4))  # only di-water is sprayed
    ratio = water.cascade.fresh_m3 / water.cascade.carried_m3
    assert last.content_g_m3 == pytest.approx((10_000.0 + ratio * salt_g_m3(1.0)) / (1.0 + ratio), rel=1e-3)
    sprayed = [stage for stage in report.stages if stage.solution == "di-water"]
    assert {stage.water_g_m3 for stage in sprayed} == {last.content_g_m3}
    spoilt = [each for each in report.process if each.rule.id == "R10"]
    assert spoilt
    assert "boards carry the bath over into its tank" in spoilt[0].because
    assert not [each for each in fresh.process if each.rule.id == "R10"]
    dirtier = [part.gaps[0].ionic_ug_cm2 for part in report.parts if part.gaps]
    before = [part.gaps[0].ionic_ug_cm2 for part in fresh.parts if part.gaps]
    assert all(now > 10 * then for now, then in zip(dirtier, before, strict=True))
    data = cleaning_report(report)["rinse_water"]
    assert [tank["solution"] for tank in data["tanks"]] == ["first-rinse", "di-water"]
    assert cleaning_report(fresh)["rinse_water"] is None
    (words,) = rinse_words(report)
    assert words.startswith("Rinse tanks: first-rinse has ")
    assert len(rinse_table(report).rows) == 2
    assert rinse_words(fresh) == []
