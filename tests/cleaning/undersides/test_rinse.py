"""Rinsing dilutes what the bath leaves until the water's own ions decide."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_sprays import samples_of, stage_of

from cleaning.parameters.load import load_parameters
from cleaning.parameters.model import Liquid
from cleaning.undersides.gap_result import GapStage
from cleaning.undersides.rinse import (
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
