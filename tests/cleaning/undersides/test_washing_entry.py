from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cleaning.gap.edge_segments import EdgePressure
from cleaning.parameters.liquid import capillary_pa
from cleaning.parameters.load import load_parameters
from cleaning.parameters.model import Liquid
from cleaning.process.stages import Samples, Stage
from cleaning.undersides.washing import entry_margin
from recipes.nozzles import HollowCone

PARAMETERS = load_parameters()
HOLD_S = PARAMETERS.film.hold_s
ON_FLUX = Liquid(use="rinse", contact_board_deg=105.0, contact_part_deg=105.0)


def stage_of(seconds, pauses=None, liquid=ON_FLUX):
    seconds = np.asarray(seconds, dtype=float)
    pauses = np.zeros(len(seconds)) if pauses is None else np.asarray(pauses, dtype=float)
    times = np.cumsum(pauses + seconds) - 0.5 * seconds
    n = len(seconds)
    samples = Samples(times, seconds, np.zeros((n, 3)), np.tile(np.eye(3), (n, 1, 1)), np.zeros(n, dtype=int), ("a",))
    nozzle = HollowCone(half_angle_deg=30.0, flow_lpm=2.0)
    return Stage("a", "rinse", "rinse", "n", nozzle, "w", liquid, 2.5e5, 25.0, 0.0, float(times[-1]), samples)


def felt(*values, segment=0, sample=None):
    pressure = np.zeros((len(values), 8))
    pressure[:, segment] = values
    return EdgePressure(np.arange(len(values)) if sample is None else np.array(sample), pressure)


@pytest.mark.parametrize(
    ("liquid", "height_um", "enters"),
    [(ON_FLUX, 100, True), (ON_FLUX, 75, False)]
    + [(PARAMETERS.liquids["saponifier-15"], height, True) for height in (15, 25, 50, 75, 100, 150, 250)],
)
def test_water_does_not_get_under_low_parts_and_chemistry_does(liquid, height_um, enters):
    capillary = capillary_pa(liquid, 25.0, 1e-6 * height_um)
    margin, first = entry_margin(felt(400.0), stage_of([0.1]), capillary, HOLD_S)
    assert margin == pytest.approx(400.0 + capillary)
    assert (margin >= 0.0, first == 0) == (enters, enters)


def test_only_what_is_held_counts():
    stage = stage_of([0.01] * 5)
    margin, first = entry_margin(felt(0, 900, 300, 500, 400), stage, -350.0, HOLD_S)
    assert margin == pytest.approx(400.0 - 350.0)
    assert first == 4


def test_a_long_sample_holds_by_itself():
    assert entry_margin(felt(0, 900, 0), stage_of([0.01, 0.05, 0.01]), -350.0, HOLD_S) == (pytest.approx(550.0), 1)


def test_a_pause_of_the_jet_breaks_the_hold():
    sprayed = felt(0, 500, 500)
    assert entry_margin(sprayed, stage_of([0.01] * 3), -350.0, HOLD_S)[1] == 2
    assert entry_margin(sprayed, stage_of([0.01] * 3, pauses=[0, 0, 0.4]), -350.0, HOLD_S) == (-350.0, -1)


def test_samples_that_are_far_away_break_the_hold():
    stage = stage_of([0.01] * 4)
    assert entry_margin(felt(500, 500, sample=[0, 1]), stage, -350.0, HOLD_S)[1] == 1
    assert entry_margin(felt(500, 500, sample=[0, 2]), stage, -350.0, HOLD_S) == (-350.0, -1)


def test_one_segment_must_hold_it():
    moving = EdgePressure(np.arange(2), np.zeros((2, 8)))
    moving.pressure_pa[0, 3] = moving.pressure_pa[1, 4] = 500.0
    assert entry_margin(moving, stage_of([0.01, 0.01]), -350.0, HOLD_S) == (-350.0, -1)


def test_a_gap_that_draws_opens_where_the_film_first_comes():
    assert entry_margin(felt(0, 0, 90), stage_of([0.01] * 3), 200.0, HOLD_S) == (pytest.approx(200.0), 0)


def test_suction_alone_keeps_no_drawing_gap_dry():
    assert entry_margin(felt(-50.0), stage_of([1.0]), 20.0, HOLD_S) == (pytest.approx(20.0), 0)


@pytest.mark.parametrize("capillary", [500.0, -500.0])
def test_what_no_film_reaches_stays_dry(capillary):
    nothing = EdgePressure(np.empty(0, dtype=np.int64), np.empty((0, 8)))
    margin, first = entry_margin(nothing, stage_of([0.1]), capillary, HOLD_S)
    assert margin <= 0.0
    assert first == -1


@settings(max_examples=60)
@given(
    values=st.lists(st.floats(-200.0, 2000.0), min_size=1, max_size=12),
    seconds=st.floats(0.002, 0.05),
    hold=st.floats(0.0, 0.1),
    capillary=st.floats(-1000.0, 1000.0),
)
def test_longer_holds_and_lower_pressures_never_help(values, seconds, hold, capillary):
    stage = stage_of([seconds] * len(values))
    margin, first = entry_margin(felt(*values), stage, capillary, hold)
    assert (first >= 0) == (margin >= 0.0)
    assert margin >= capillary
    assert entry_margin(felt(*values), stage, capillary, hold + 0.01)[0] <= margin
    lower = replace(felt(*values), pressure_pa=felt(*values).pressure_pa - 10.0)
    assert entry_margin(lower, stage, capillary, hold)[0] <= margin


def test_the_hold_is_the_least_of_a_window():
    random = np.random.default_rng(3)
    values = random.uniform(0.0, 1000.0, (40, 8))
    margin, _ = entry_margin(EdgePressure(np.arange(40), values), stage_of([0.01] * 40), 0.0, 0.05)
    windows = np.lib.stride_tricks.sliding_window_view(values, 5, axis=0)
    assert margin == pytest.approx(windows.min(axis=2).max())
