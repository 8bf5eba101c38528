"""What is left under one component: chemistry, time and flow each take their share, and a dry gap keeps everything."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from cleaning.gap.edge_segments import SEGMENTS, EdgePressure
from cleaning.gap.flow_field import GapField, solve_gap
from cleaning.gap.flushing import reduced_reynolds
from cleaning.parameters.liquid import viscosity_pa_s
from cleaning.parameters.load import load_parameters
from cleaning.parameters.model import Liquid, Parameters
from cleaning.process.stages import Samples, Stage
from cleaning.undersides.residue import GapResult, GapStage
from cleaning.undersides.washing import simulate_gap
from recipes.nozzles import HollowCone
from specs.source import Source

PARAMETERS = load_parameters("default")
SOAP, WATER, AIR = (PARAMETERS.liquids[name] for name in ("saponifier-15", "di-water", "hot-air"))
SIDE_M = 7e-3
FILM_PA = 820.0
"""What the film of two litres a minute at 3.5 bar presses on an edge."""


@cache
def square_field(side_m: float = SIDE_M, height_m: float = 50e-6, coverage: float = 0.5) -> GapField:
    """Flow in a square gap, as though the joints that squeezed out the residue took no room."""
    return replace(solve_gap(side_m, side_m, height_m, (), 10), coverage=coverage)


def stage_of(liquid: Liquid, temperature_c: float, times: NDArray[np.float64], seconds: float, end_s: float) -> Stage:
    count = len(times)
    samples = Samples(
        times=times,
        seconds=np.full(count, seconds),
        tcp=np.zeros((count, 3)),
        axes=np.tile(np.eye(3), (count, 1, 1)),
        made_by=np.zeros(count, dtype=np.int64),
        makers=("paths[0]",),
    )
    return Stage(
        made_by=Source.parse("sequence[0]"),
        function="wash",
        use=liquid.use,
        nozzle_name="cone",
        nozzle=HollowCone(flow_lpm=2.0, half_angle_deg=30.0),
        solution="solution",
        liquid=liquid,
        pressure_pa=3.5e5,
        temperature_c=temperature_c,
        begin_s=0.0,
        end_s=end_s,
        samples=samples,
    )


def raster(
    liquid: Liquid = SOAP, temperature_c: float = 60.0, minutes: float = 10.0, film_pa: float = FILM_PA
) -> tuple[Stage, EdgePressure]:
    """Every 10 s the film passes for 1.2 s, from the left, the right, the front and the back in turn."""
    passes = round(6 * minutes)
    offsets = 0.1 * np.arange(12)
    times = (10.0 * np.arange(passes)[:, None] + 0.05 + offsets).ravel()
    sides = np.zeros((4, SEGMENTS))
    for windward, lee, row in ((3, 1, 0), (1, 3, 1), (0, 2, 2), (2, 0, 3)):
        sides[row, 2 * windward : 2 * windward + 2] = 1.0
        sides[row, 2 * lee : 2 * lee + 2] = -PARAMETERS.film.lee
    envelope = np.sin(np.pi * (np.arange(12) + 0.5) / 12.0)
    pressure = film_pa * envelope[None, :, None] * sides[np.arange(passes) % 4][:, None, :]
    stage = stage_of(liquid, temperature_c, times, 0.1, 60.0 * minutes)
    return stage, EdgePressure(np.arange(len(times)), pressure.reshape(-1, SEGMENTS))


def wash(
    standoff_um: float = 50.0,
    parameters: Parameters = PARAMETERS,
    field: GapField | None = None,
    **kwargs: float,
) -> GapResult:
    stage, pressure = raster(SOAP, **kwargs)
    return simulate_gap(field or square_field(), 1e-3 * standoff_um, [stage], [pressure], parameters)


def only(result: GapResult) -> GapStage:
    act = result.stages[0]
    assert act is not None
    return act


def test_warmth_counts_for_more_than_standoff() -> None:
    left = {
        warm: [wash(height, temperature_c=warm).residue for height in (25.0, 50.0, 100.0, 200.0)]
        for warm in (40.0, 50.0, 60.0, 70.0)
    }
    for row in left.values():
        assert row == sorted(row, reverse=True)
    for at in range(4):
        column = [row[at] for row in left.values()]
        assert column == sorted(column, reverse=True)
    assert left[60.0][1] / left[60.0][3] < left[40.0][1] / left[60.0][1]
    assert 0.002 < left[60.0][1] < 0.01


def test_time_and_pressure_clean_and_size_does_not() -> None:
    by_time = [wash(minutes=minutes).residue for minutes in (2.0, 5.0, 10.0, 20.0)]
    by_pressure = [wash(film_pa=pa).residue for pa in (200.0, 400.0, 800.0, 1600.0)]
    by_size = [wash(field=square_field(side_m=side)).residue for side in (12e-3, 7e-3, 3e-3)]
    for left in (by_time, by_pressure, by_size):
        assert left == sorted(left, reverse=True)
        assert left[-1] < 0.8 * left[0]


def test_water_is_kept_out_of_low_gaps_and_cleaner_is_not() -> None:
    water = WATER.model_copy(update={"contact_board_deg": 105.0, "contact_part_deg": 105.0})
    clear = square_field(coverage=0.0)
    stage, pressure = raster(water, 25.0, film_pa=400.0)
    low, high = (simulate_gap(clear, mm, [stage], [pressure], PARAMETERS) for mm in (0.075, 0.1))
    assert not only(low).entered
    assert only(low).margin_pa < 0.0
    assert low.residue == low.residue_worst == 1.0
    assert low.worst_at == pytest.approx((0.35, 0.35), abs=0.8)
    assert only(low).exchanges == only(low).wet_s == low.ionic_ug_cm2 == 0.0
    assert only(low).weak_share == 1.0
    assert only(high).entered
    soap, pressure = raster(SOAP, 25.0, film_pa=400.0)
    assert only(simulate_gap(clear, 0.015, [soap], [pressure], PARAMETERS)).entered


def test_a_stage_that_sprays_the_other_side_changes_nothing() -> None:
    stage, pressure = raster()
    alone = simulate_gap(square_field(), 0.05, [stage], [pressure], PARAMETERS)
    both = simulate_gap(square_field(), 0.05, [stage, stage], [pressure, None], PARAMETERS)
    assert both.stages[1] is None
    assert both.residue == alone.residue
    never = EdgePressure(np.empty(0, dtype=np.int64), np.empty((0, SEGMENTS)))
    missed = simulate_gap(square_field(), 0.05, [stage], [never], PARAMETERS)
    assert not only(missed).entered
    assert missed.residue == 1.0
    assert only(missed).edge_pa == (0.0,) * SEGMENTS


@pytest.mark.parametrize(("middles", "seconds"), [([5.0], 2.0), ([5.0], 0.1), ([5.0, 7.0, 9.5], 2.0)])
def test_a_gap_is_wet_from_where_its_first_sample_begins_until_the_stage_ends(
    middles: list[float], seconds: float
) -> None:
    stage = stage_of(SOAP, 60.0, np.array(middles), seconds, 20.0)
    pressed = EdgePressure(np.arange(len(middles)), np.full((len(middles), SEGMENTS), FILM_PA))
    act = only(simulate_gap(square_field(), 0.05, [stage], [pressed], PARAMETERS))
    assert act.entered
    assert act.wet_s == pytest.approx(20.0 - (middles[0] - seconds / 2))


def test_soaking_alone_removes_nothing() -> None:
    left = wash(film_pa=1e-3)
    assert only(left).entered
    assert left.residue == pytest.approx(1.0, abs=1e-9)
    assert only(left).weak_share == 1.0


def test_water_takes_what_is_soft_and_softens_nothing() -> None:
    washing, washed = raster(temperature_c=40.0, minutes=3.0)
    rinsing, rinsed = raster(WATER, temperature_c=40.0, minutes=30.0)
    result = simulate_gap(square_field(), 0.05, [washing, rinsing], [washed, rinsed], PARAMETERS)
    first, second = result.stages
    assert first is not None
    assert second is not None
    hard = np.exp(-0.012 * np.exp(-30e3 / 8.314462618 * (1 / 313.15 - 1 / 333.15)) * 180.0)
    assert second.residue.mean() < first.residue.mean()
    np.testing.assert_allclose(second.residue, hard, rtol=1e-3)
    alone = simulate_gap(square_field(), 0.05, [rinsing], [rinsed], PARAMETERS)
    assert alone.residue == 1.0


def test_a_rinse_dilutes_what_the_bath_leaves() -> None:
    washing, washed = raster()
    rinsing, rinsed = raster(WATER, temperature_c=60.0)
    short = replace(rinsing, samples=replace(rinsing.samples, seconds=1e-3 * rinsing.samples.seconds))
    stages = [[washing], [washing, short], [washing, rinsing]]
    pressures = [washed, rinsed]
    left = [
        simulate_gap(square_field(), 0.05, each, pressures[: len(each)], PARAMETERS).ionic_ug_cm2 for each in stages
    ]
    # a bath with 1 % in a gap of 50 um leaves 50 ug/cm2; water of 1 MOhm cm leaves 0.002
    assert left[0] == pytest.approx(50.0)
    assert left[0] > left[1] > left[2]
    assert left[2] == pytest.approx(0.00219, rel=0.01)


def test_a_plugged_gap_is_eaten_from_its_rim() -> None:
    field = square_field(coverage=0.7)
    stage, pressure = raster()
    result = simulate_gap(field, 0.05, [stage], [pressure], PARAMETERS)
    act = only(result)
    assert result.fill == 1.0
    assert act.entered
    assert act.exchanges == 0.0
    # 0.012 / s through layers of 100 um for ten minutes: 0.72 mm of 7 mm on every side
    assert result.residue == pytest.approx((1.0 - 2.0 * 0.72 / 7.0) ** 2, abs=0.03)
    assert result.residue_worst == 1.0
    assert np.hypot(*result.worst_at) < 1.0
    long, pressure = raster(minutes=60.0)
    assert simulate_gap(field, 0.05, [long], [pressure], PARAMETERS).residue == 0.0


def test_cells_count_by_their_open_area() -> None:
    stage, pressure = raster(minutes=4.0)
    lame = pressure.pressure_pa.copy()
    lame[:, 2:6] = 0.0
    plain = square_field()
    near = plain.centres.sum(axis=1) < 0.0
    results = [
        simulate_gap(replace(plain, open_cells=share), 0.05, [stage], [replace(pressure, pressure_pa=lame)], PARAMETERS)
        for share in (np.ones(100, np.float32), np.where(near, 1.0, 0.1).astype(np.float32))
    ]
    assert results[1].residue < 0.9 * results[0].residue


@settings(max_examples=10)
@given(turns=st.integers(1, 3), standoff=st.floats(20.0, 200.0), seed=st.integers(0, 100))
def test_turning_the_board_turns_the_residue(turns: int, standoff: float, seed: int) -> None:
    stage, pressure = raster(minutes=4.0)
    weights = np.random.default_rng(seed).uniform(0.0, 1.0, SEGMENTS)
    one = replace(pressure, pressure_pa=pressure.pressure_pa * weights)
    other = replace(one, pressure_pa=np.roll(one.pressure_pa, 2 * turns, axis=1))
    before = only(simulate_gap(square_field(), 1e-3 * standoff, [stage], [one], PARAMETERS))
    after = only(simulate_gap(square_field(), 1e-3 * standoff, [stage], [other], PARAMETERS))
    # rows go along y: anticlockwise on the board is clockwise in the array
    turned = np.rot90(before.residue.reshape(10, 10), -turns)
    np.testing.assert_allclose(after.residue.reshape(10, 10), turned, rtol=1e-3, atol=1e-6)
    np.testing.assert_allclose(after.side_shear_pa, np.roll(before.side_shear_pa, turns), rtol=1e-4)


def test_the_side_that_is_never_pressed_shows() -> None:
    stage, pressure = raster()
    lame = pressure.pressure_pa.copy()
    lame[:, 2:4] = -1.0
    act = only(simulate_gap(square_field(), 0.05, [stage], [replace(pressure, pressure_pa=lame)], PARAMETERS))
    assert act.side_shear_pa[1] == 0.0
    assert min(act.side_shear_pa[0], act.side_shear_pa[2], act.side_shear_pa[3]) > 0.1


def test_the_worst_place_lies_far_from_the_flow() -> None:
    stage, pressure = raster(minutes=3.0)
    corner = np.zeros_like(pressure.pressure_pa)
    corner[:, [6, 5]] = pressure.pressure_pa.max(axis=1)[:, None]
    result = simulate_gap(square_field(), 0.05, [stage], [replace(pressure, pressure_pa=corner)], PARAMETERS)
    assert result.residue_worst > result.residue
    assert result.worst_at[0] > 2.0
    assert result.worst_at[1] < -2.0


def test_a_high_gap_of_a_small_part_is_told_by_its_reynolds_number() -> None:
    high = only(wash(250.0, field=square_field(side_m=3e-3)))
    assert high.reynolds > 10.0
    low = only(wash(50.0))
    assert low.reynolds < 0.1
    u = low.exchanges * 0.5 * SIDE_M / 72.0  # mean over the time that the film is near
    mean = reduced_reynolds(u, 50e-6, SIDE_M, 1000.0, viscosity_pa_s(SOAP, 60.0))
    assert mean < low.reynolds < 3.0 * mean


def test_a_field_of_another_height_is_scaled() -> None:
    direct = wash(100.0, field=square_field(height_m=100e-6))
    scaled = wash(100.0, field=square_field(height_m=50e-6))
    assert scaled.residue == pytest.approx(direct.residue, rel=1e-4)


def test_venting_leaves_less_to_remove() -> None:
    stage, pressure = raster()
    full = simulate_gap(square_field(), 0.05, [stage], [pressure], PARAMETERS)
    vented = simulate_gap(square_field(), 0.05, [stage], [pressure], PARAMETERS, 0.3)
    assert vented.fill == pytest.approx(0.3 * full.fill)
    assert vented.residue < full.residue
    assert vented.exchanges_needed < full.exchanges_needed


def test_fast_air_clears_the_gap_and_slow_air_does_not() -> None:
    rinsing, rinsed = raster(WATER, 40.0)
    stage, _ = raster(AIR, 80.0)
    results: list[GapResult] = []
    for head in (300.0, 3000.0):
        blown = np.zeros((3, SEGMENTS))
        blown[1, 6:] = head
        drying = EdgePressure(np.arange(3), blown)
        results.append(simulate_gap(square_field(), 0.05, [rinsing, stage], [rinsed, drying], PARAMETERS))
    slow, fast = results
    assert slow.stages[1] is None
    assert slow.blow_off_um is not None
    assert fast.blow_off_um is not None
    assert slow.blow_off_um > 50.0 > fast.blow_off_um
    assert slow.blow_off_um == pytest.approx(10.0 * fast.blow_off_um)
    assert slow.dry_s is not None
    assert fast.dry_s is not None
    assert slow.dry_s > 300.0
    assert fast.dry_s < 60.0


def test_air_that_passes_on_the_other_side_clears_nothing() -> None:
    assert wash().blow_off_um is wash().dry_s is None
    rinsing, rinsed = raster(WATER, 40.0)
    stage, _ = raster(AIR, 80.0)
    result = simulate_gap(square_field(), 0.05, [rinsing, stage], [rinsed, None], PARAMETERS)
    assert result.blow_off_um == np.inf
