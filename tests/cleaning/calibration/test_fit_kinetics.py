"""Kinetics are found again in coupons that they made; what coupons do not tell is said so and left alone."""

import math

import numpy as np
import pytest
from coupon_bench import BENCH, PARAMETERS, TRUTH, coupons
from hypothesis import given, settings
from hypothesis import strategies as st
from made_up import COUPON_HEADER, PLAN, written

from cleaning.calibration import coupon
from cleaning.calibration.coupon import read_coupons
from cleaning.calibration.fit_kinetics import GapFit, calibrate_gap
from cleaning.calibration.fitted_files import calibrated_set
from cleaning.errors import CleaningError
from cleaning.film import film
from cleaning.film.edge_pressure import edge_pressures, prepare_edges
from cleaning.gap.flow_field import solve_gap
from cleaning.jet import jet_coordinates
from cleaning.parameters.load import load_parameters

PATHS = {name: f"soil.{name}" for name in TRUTH}


def held(fit: GapFit, name: str, truth: float) -> bool:
    low, high = fit.estimates[PATHS[name]].interval
    return low <= truth <= high


def test_a_jet_is_found_once_for_its_pressure_and_its_rim_once_for_a_fit(tmp_path) -> None:
    plan = read_coupons(coupons(tmp_path, noise=0, seed=0, **TRUTH), BENCH)
    keys = {(bar, height) for bar, _, _, height, _ in plan.blows[0]}
    assert len({id(jet) for _, jet in plan.jets}) == len(keys)
    film._table_of.cache_clear()
    for puddle_mm in (0.5, 1.0, 2.0):
        plan.drop_pa(puddle_mm)
    assert film._table_of.cache_info().misses == len(keys)


def test_coupons_of_many_pressures_have_one_shape_of_the_jet_and_are_prepared_once(tmp_path, monkeypatch) -> None:
    """Its flow is integrated over a fine grid, and the jet goes into the law of its film: both once for each."""
    prepared: list[object] = []
    monkeypatch.setattr(coupon, "prepare_edges", lambda *each: prepared.append(each) or prepare_edges(*each))
    rows = [
        f"{standoff},{time},{celsius},{1 + number / 50},0.5" for number, (standoff, time, celsius, _) in enumerate(PLAN)
    ]
    rows[0] = rows[0].removesuffix("0.5") + "0.4"
    plan = read_coupons(written(tmp_path, "\n".join([COUPON_HEADER, *rows])), BENCH)
    jet_coordinates._scale_of.cache_clear()
    drops = np.array([plan.drop_pa(puddle_mm) for puddle_mm in (0.5, 1.0, 2.0)])
    assert jet_coordinates._scale_of.cache_info().misses == 1
    assert len(prepared) == len(PLAN)
    for index in (0, len(PLAN) - 1):
        film = PARAMETERS.film.model_copy(update={"puddle_mm": 0.5})
        (_, width, length, _, away) = plan.blows[0][index]
        (found,) = edge_pressures(*plan.jets[index], coupon._edges(width, length, away), film)
        assert drops[0, index] == found.pressure_pa[0, :2].mean() - found.pressure_pa[0, 4:6].mean()


@pytest.mark.slow
def test_a_fit_reports_how_far_it_is(tmp_path) -> None:
    shares: list[float] = []
    file = coupons(tmp_path, noise=0.02, seed=1, **TRUTH)
    calibrate_gap(file, BENCH, lambda _, share: shares.append(share))
    assert len(shares) > 20
    assert shares == sorted(shares)
    assert shares[-1] <= 1.0


def test_the_shear_in_a_coupon_is_that_between_two_plates(tmp_path) -> None:
    plan = read_coupons(coupons(tmp_path, noise=0, seed=0, **TRUTH), BENCH)
    drop = plan.drop_pa(PARAMETERS.film.puddle_mm)
    shear = plan.shear_pa(drop)
    thin = np.array([standoff for standoff, *_ in PLAN]) == 25
    np.testing.assert_allclose(shear[thin], 25e-6 * drop[thin] / (2 * 25e-3), rtol=0.01)  # h dp / (2 L)
    assert (shear[~thin] < np.array([each[0] for each in PLAN])[~thin] * 1e-6 * drop[~thin] / (2 * 25e-3)).all()


def test_the_shear_in_a_coupon_is_that_of_a_gap_of_the_analysis(tmp_path) -> None:
    """A gap that is much wider than long is fed from front and back alone in its middle, as between shims."""
    plan = read_coupons(coupons(tmp_path, noise=0, seed=0, **TRUTH), BENCH)
    drop = float(plan.drop_pa(PARAMETERS.film.puddle_mm)[0])
    field = solve_gap(0.2, 25e-3, 25e-6, (), 80)
    push = np.array([drop, drop, 0, 0, 0, 0, 0, 0])
    speed = np.einsum("s,sck->ck", push, field.velocity)
    middle = np.argmin(np.hypot(field.centres[:, 0], field.centres[:, 1]))
    shear = 6 * np.hypot(*speed[middle]) / field.height_m
    assert plan.shear_pa(plan.drop_pa(PARAMETERS.film.puddle_mm))[0] == pytest.approx(shear, rel=0.02)


def test_pressure_drives_as_the_momentum_of_the_film(tmp_path) -> None:
    """Flow goes with the root of the pressure, so does speed: the film's momentum goes with the pressure itself."""
    drop = read_coupons(coupons(tmp_path, noise=0, seed=0, **TRUTH), BENCH).drop_pa(PARAMETERS.film.puddle_mm)
    low, high = np.array([drop[[each[3] == bar for each in PLAN]] for bar in (1.5, 3.5)])
    np.testing.assert_allclose(high / low, 3.5 / 1.5, rtol=1e-9)
    assert (low > 0).all()


@pytest.mark.slow
def test_without_noise_the_truth_is_found(tmp_path) -> None:
    fit = calibrate_gap(coupons(tmp_path, noise=0, seed=0, **TRUTH), BENCH)
    for name, truth in TRUTH.items():
        assert fit.estimates[PATHS[name]].value == pytest.approx(truth, rel=0.01)
    assert fit.rms < 6e-4  # three places were written
    assert fit.soil.half_pct == PARAMETERS.soil.half_pct


@pytest.mark.slow
@given(k1=st.floats(0.004, 0.02), activation=st.floats(20, 50), k_m=st.floats(0.015, 0.08), seed=st.integers(0, 999))
@settings(max_examples=2)
def test_with_noise_the_truth_is_near(tmp_path_factory, k1, activation, k_m, seed) -> None:
    truth = {"k1_per_s": k1, "activation_kj_mol": activation, "k_m_per_s": k_m}
    folder = tmp_path_factory.mktemp("coupons")
    fit = calibrate_gap(coupons(folder, noise=0.01, seed=seed, **truth), BENCH)
    for name, value in truth.items():
        estimate = fit.estimates[PATHS[name]]
        wide = 0.5 * math.log(estimate.high / estimate.low)
        assert abs(math.log(estimate.value / value)) < 3 * wide  # beyond 6 sigma never
        assert estimate.low < estimate.value < estimate.high
    assert fit.rms < 0.02


@pytest.mark.slow
def test_intervals_hold_the_truth_about_as_often_as_they_say(tmp_path) -> None:
    fits = [calibrate_gap(coupons(tmp_path, noise=0.03, seed=seed, **TRUTH), BENCH) for seed in range(24)]
    assert 65 <= sum(held(fit, name, truth) for fit in fits for name, truth in TRUTH.items()) <= 72


@pytest.mark.slow
def test_a_puddle_that_only_scales_the_removal_is_not_told_and_kept(tmp_path) -> None:
    fit = calibrate_gap(coupons(tmp_path, noise=0.02, seed=1, **TRUTH), BENCH)
    assert set(fit.undetermined) == {"film.puddle_mm"}
    assert fit.undetermined["film.puddle_mm"].kept == PARAMETERS.film.puddle_mm
    assert fit.film == PARAMETERS.film
    text = calibrated_set(fit, "default", tmp_path / "mine.yaml")
    assert "# film.puddle_mm is not determined by them and stays 1;" in text
    assert "film:" not in text


@pytest.mark.slow
def test_a_puddle_is_told_from_coupons_under_the_front_and_beyond_it(tmp_path) -> None:
    """Under the wave front the jet's own stress pushes, farther out the film alone, which the puddle scales."""
    film = PARAMETERS.film.model_copy(update={"puddle_mm": 1.6})
    rows = [(*row, away) for row in PLAN for away in (29, 45)]
    head = f"{COUPON_HEADER},distance_mm"

    def table(cleaned: list[float]) -> str:
        lines = [f"{h},{t},{c},{p},{y:.3f},{away}" for (h, t, c, p, away), y in zip(rows, cleaned, strict=True)]
        return "\n".join(["# synthetic", head, *lines])

    plan = read_coupons(written(tmp_path, table(np.linspace(0, 1, len(rows)).tolist())), BENCH)
    soil = PARAMETERS.soil.model_copy(update=TRUTH)
    cleaned = plan.predict(soil, plan.shear_pa(plan.drop_pa(film.puddle_mm)))
    seen = np.clip(cleaned + np.random.default_rng(3).normal(0, 0.005, len(cleaned)), 0, 1)
    fit = calibrate_gap(written(tmp_path, table(seen.tolist())), BENCH)
    low, high = fit.estimates["film.puddle_mm"].interval
    assert low < 1.6 < high
    assert high / low < 3
    assert held(fit, "k_m_per_s", TRUTH["k_m_per_s"])


@pytest.mark.slow
def test_where_chemistry_limits_the_removal_is_not_told(tmp_path) -> None:
    fit = calibrate_gap(coupons(tmp_path, noise=0.02, seed=1, k1_per_s=0.004, k_m_per_s=20.0), BENCH)
    assert "soil.k1_per_s" in fit.estimates
    assert fit.undetermined["soil.k_m_per_s"].kept == PARAMETERS.soil.k_m_per_s
    text = calibrated_set(fit, "default", tmp_path / "mine.yaml")
    assert "# soil.k_m_per_s is not determined by them and stays 0.05;" in text
    assert "  k_m_per_s:" not in text
    (tmp_path / "mine.yaml").write_text(text.replace("known: synthetic", "known: calibrated"), "utf-8")
    assert not load_parameters(tmp_path / "mine.yaml").calibrated


@pytest.mark.slow
@pytest.mark.parametrize(
    ("first", "known", "grade"), [("# synthetic", "synthetic", False), ("# ours", "calibrated", True)]
)
def test_made_up_coupons_never_raise_the_grade(tmp_path, first: str, known: str, grade: bool) -> None:
    fit = calibrate_gap(coupons(tmp_path, noise=0.02, seed=1, first=first, **TRUTH), BENCH)
    file = tmp_path / "our-line.yaml"
    text = calibrated_set(fit, "default", file, "2026-11-21")
    file.write_text(text, "utf-8")
    mine = load_parameters(file)
    assert (mine.parameters, mine.calibrated) == ("our-line", grade)
    entry = mine.known("soil.k1_per_s")
    assert (entry.known, entry.date, entry.samples) == (known, "2026-11-21", len(PLAN))
    assert entry.source.startswith("coupons.csv, sha256 ")
    assert entry.rms == pytest.approx(fit.rms, rel=0.01)
    assert mine.soil == PARAMETERS.soil.model_copy(
        update={name: float(f"{fit.estimates[path].value:.4g}") for name, path in PATHS.items()}
    )
    assert ("SYNTHETIC" in text) is not grade


@pytest.mark.slow
def test_a_set_extends_a_file_by_the_way_to_it(tmp_path) -> None:
    base = tmp_path / "sets" / "base.yaml"
    base.parent.mkdir()
    base.write_text("parameters: base\nextends: aged\n", "utf-8")
    fit = calibrate_gap(coupons(tmp_path, noise=0.02, seed=1, **TRUTH), BENCH)
    text = calibrated_set(fit, base, tmp_path / "mine.yaml")
    assert 'extends: "sets/base.yaml"\n' in text


@pytest.mark.slow
def test_same_input_same_bytes(tmp_path) -> None:
    file = coupons(tmp_path, noise=0.02, seed=9, **TRUTH)
    texts = {calibrated_set(calibrate_gap(file, BENCH), "default", tmp_path / "mine.yaml") for _ in range(2)}
    assert len(texts) == 1


@pytest.mark.slow
@pytest.mark.parametrize(("name", "wanted"), [("9.yaml", "cannot name a set"), ("a b.yaml", "cannot name a set")])
def test_a_name_that_no_set_can_have_is_told(tmp_path, name: str, wanted: str) -> None:
    fit = calibrate_gap(coupons(tmp_path, noise=0.02, seed=1, **TRUTH), BENCH)
    with pytest.raises(CleaningError, match=wanted):
        calibrated_set(fit, "default", tmp_path / name)
    with pytest.raises(CleaningError, match="'today' is no date; write it as in 2026-11-21"):
        calibrated_set(fit, "default", tmp_path / "mine.yaml", "today")


ROWS = "".join(f"50,{60 + 60 * n},{40 + 10 * (n % 2)},3,0.{n + 1}\n" for n in range(8))


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        (
            COUPON_HEADER.replace(",time_s", "") + "\n",
            "data.csv:1: column 'time_s' is missing; needed are standoff_um, ",
        ),
        (
            COUPON_HEADER.replace("time_s", "time") + "\n" + ROWS,
            "data.csv:1: unknown column 'time'; did you mean 'time_s'",
        ),
        (COUPON_HEADER + "\n" + ROWS[:60], "rows are too few; at least 8 are needed"),
        (COUPON_HEADER + "\n" + ROWS + "50,60,40,3,85\n", "data.csv:10: cleaned_fraction: must lie in 0 to 1, not 85"),
        (
            COUPON_HEADER + "\n" + ROWS + "50,60,40,3,\n",
            "data.csv:10: cleaned_fraction: must be a number with a decimal",
        ),
        (COUPON_HEADER + "\n" + ROWS + "50,60,NaN,3,0.2\n", "data.csv:10: temperature_c: must be a finite number"),
        (
            COUPON_HEADER + "\n" + ROWS.replace(",50,3", ",40,3"),
            "data.csv:2: temperature_c: all 8 rows have 40; measure",
        ),
        (
            COUPON_HEADER + "\n" + "50,60,40,3,0.1\n50,60,50,3,0.2\n" * 4,
            "data.csv:2: time_s: all 8 rows have 60; measure",
        ),
        (
            COUPON_HEADER + ",distance_mm\n" + "".join(f"{row},400\n" for row in ROWS.splitlines()),
            "data.csv:1: the film does not reach the coupon; check nozzle, height_mm and distance_mm",
        ),
    ],
)
def test_a_bad_table_is_told_with_its_line(tmp_path, text: str, wanted: str) -> None:
    with pytest.raises(CleaningError) as caught:
        calibrate_gap(written(tmp_path, text), BENCH)
    assert wanted in str(caught.value)


@pytest.mark.slow
def test_coupons_that_say_nothing_are_told(tmp_path) -> None:
    random = np.random.default_rng(1)
    rows = [f"{50},{60 + 60 * n},{40 + 10 * (n % 2)},3,{random.uniform():.3f}" for n in range(10)]
    with pytest.raises(CleaningError, match=r"data\.csv:1: these coupons determine nothing"):
        calibrate_gap(written(tmp_path, "\n".join([COUPON_HEADER, *rows])), BENCH)
