"""A ring is found again in patterns that it made, its intervals hold the truth, and bad tables are told by line."""

import numpy as np
import pytest
from coupon_bench import BENCH, coupons
from hypothesis import given, settings
from hypothesis import strategies as st
from jet_references import footprint
from made_up import SHEETS, Ring, edge, edge_table, intensity_table, written

from cleaning.calibration.confidence import Estimate
from cleaning.calibration.coupon import CouponSetup, read_coupons
from cleaning.calibration.fit_spray import RingFit, calibrate_ring
from cleaning.calibration.fitted_files import nozzle_text, recipe_with_ring, wavefront_of
from cleaning.errors import CleaningError
from recipes.footprint import mid_angles
from recipes.load import load_recipe, parse_recipe
from recipes.nozzles import HollowCone

WAVY = Ring(waves=(1.2, -0.6, 0.0, 0.9))


def fitted(tmp_path, text: str, **more) -> RingFit:
    return calibrate_ring(written(tmp_path, text), **more)


def holds(estimate: Estimate, truth: float) -> bool:
    return estimate.low <= truth <= estimate.high


def test_the_edges_of_a_circular_ring_lie_on_the_ellipse_of_its_cone() -> None:
    ring = Ring(half_angle=30.0, sigma=0.0)
    ellipse = footprint(np.radians(30), np.radians(20), 50.0)
    foot = 50.0 * np.tan(np.radians(20))
    assert edge(ring, 50, 20, 0, 2) == pytest.approx(ellipse.far - foot, rel=1e-9)
    assert edge(ring, 50, 20, 180, 2) == pytest.approx(foot - ellipse.near, rel=1e-9)


def test_without_noise_the_ring_is_found_exactly(tmp_path) -> None:
    fit = fitted(tmp_path, edge_table(WAVY, noise_mm=0.0, seed=1))
    assert fit.half_angle_deg.value == pytest.approx(WAVY.half_angle, abs=5e-3)
    assert fit.sigma_deg.value == pytest.approx(WAVY.sigma, abs=5e-3)
    assert fit.waves_deg == pytest.approx(WAVY.waves, abs=1e-2)
    assert fit.rms < 0.01


@pytest.mark.slow
@given(half_angle=st.floats(15, 45), sigma=st.floats(1.5, 5), seed=st.integers(0, 999))
@settings(max_examples=8)
def test_with_noise_the_ring_is_found_as_well_as_the_interval_says(
    tmp_path_factory, half_angle: float, sigma: float, seed: int
) -> None:
    ring = Ring(half_angle, sigma, (0.8, 0.0, -0.7, 0.5))
    fit = fitted(tmp_path_factory.mktemp("ring"), edge_table(ring, noise_mm=0.5, seed=seed))
    for estimate, truth in ((fit.half_angle_deg, half_angle), (fit.sigma_deg, sigma)):
        assert abs(estimate.value - truth) < 2.5 * (estimate.high - estimate.value)  # beyond 5 sigma never
        assert estimate.high - estimate.low < 0.5
    assert fit.rms == pytest.approx(0.5, rel=0.3)


@pytest.mark.slow
def test_intervals_hold_the_truth_in_95_of_100_sets(tmp_path) -> None:
    """200 sets; each interval holds it in 92 to 98 % of them."""
    exact = [line.split(",") for line in edge_table(WAVY, noise_mm=0.0, seed=0, step_deg=45).splitlines()]
    held: dict[str, int] = {"half angle": 0, "sigma": 0}
    for seed in range(200):
        random = np.random.default_rng(seed)
        lines = [",".join(exact[0]), ",".join(exact[1])]
        for *place, inner, outer in exact[2:]:
            # What lies farther away is read less well, and both edges of a row err together.
            noise = 0.01 * float(outer) * (0.7 * random.normal(size=2) + 0.7 * random.normal())
            lines.append(",".join([*place, f"{float(inner) + noise[0]:.2f}", f"{float(outer) + noise[1]:.2f}"]))
        fit = fitted(tmp_path, "\n".join(lines) + "\n")
        held["half angle"] += holds(fit.half_angle_deg, WAVY.half_angle)
        held["sigma"] += holds(fit.sigma_deg, WAVY.sigma)
    assert all(184 <= count <= 196 for count in held.values()), held


def test_a_circle_stays_a_circle(tmp_path) -> None:
    fit = fitted(tmp_path, edge_table(Ring(), noise_mm=0.5, seed=3))
    assert fit.waves_deg == ()
    assert wavefront_of(fit) is None


@pytest.mark.slow
def test_azimuths_on_one_side_say_nothing_about_the_ring_around(tmp_path) -> None:
    lines = edge_table(WAVY, noise_mm=0.1, seed=3, step_deg=15).splitlines(keepends=True)
    some = [line for line in lines if not line[0].isdigit() or float(line.split(",")[2]) <= 120]
    assert fitted(tmp_path, "".join(some)).waves_deg == ()


@pytest.mark.slow
@pytest.mark.parametrize(("quantity", "power"), [("volume", 1), ("pressure", 2)])
def test_intensities_give_the_ring_and_how_its_strength_varies(tmp_path, quantity, power) -> None:
    ring = Ring(half_angle=27.0, sigma=3.1, waves=(0.9, 0.0, 0.0, -0.8), gain=(0.25, 0.1, 0.0, 0.0))
    fit = fitted(tmp_path, intensity_table(ring, noise=0.01, seed=5, power=power), quantity=quantity)
    for estimate, truth in ((fit.half_angle_deg, 27.0), (fit.sigma_deg, 3.1)):
        assert abs(estimate.value - truth) < 0.1
        assert abs(estimate.value - truth) < 2 * (estimate.high - estimate.value)
    assert fit.waves_deg == pytest.approx(ring.waves, abs=0.15)
    assert fit.gain == pytest.approx(ring.gain, abs=0.05)


@pytest.mark.slow
def test_intensities_by_radius_are_those_by_x_and_y(tmp_path) -> None:
    rows = [line.split(",") for line in intensity_table(Ring(), noise=0.0, seed=5).splitlines()[2:]]
    lines = ["height_mm,tilt_deg,azimuth_deg,radius_mm,intensity"]
    for height, tilt, x, y, value in rows:
        around = np.degrees(np.arctan2(float(y), float(x)))
        lines.append(f"{height},{tilt},{around:.6f},{np.hypot(float(x), float(y)):.6f},{value}")
    polar = fitted(tmp_path, "\n".join(lines))
    plain = fitted(tmp_path, intensity_table(Ring(), noise=0.0, seed=5))
    assert polar.half_angle_deg.value == pytest.approx(plain.half_angle_deg.value, abs=1e-4)
    assert polar.half_angle_deg.value == pytest.approx(31.2, abs=0.02)


@pytest.mark.slow
def test_a_cone_that_contracts_with_distance_shows_in_its_sheets(tmp_path) -> None:
    narrow = edge_table(Ring(half_angle=28.0), noise_mm=0.1, seed=1).splitlines()
    wide = edge_table(Ring(half_angle=31.0), noise_mm=0.1, seed=2).splitlines()
    lines = [line for line in wide if not line.startswith("80")] + [line for line in narrow if line.startswith("80")]
    fit = fitted(tmp_path, "\n".join(lines))
    bias = {(sheet.height_mm, sheet.tilt_deg): sheet.bias for sheet in fit.sheets}
    assert set(bias) == set(SHEETS)
    assert bias[40.0, 0.0] > 0.5
    assert bias[80.0, 0.0] < -0.5


@pytest.mark.slow
def test_the_recipe_gets_the_ring_and_keeps_all_else(tmp_path) -> None:
    fit = fitted(tmp_path, edge_table(WAVY, noise_mm=0.2, seed=7))
    text = recipe_with_ring(fit, "smt-aqueous", "ring60", tmp_path / "mine.yaml")
    nozzle = parse_recipe(text).nozzles["ring60"]
    assert isinstance(nozzle, HollowCone)
    azimuths = np.radians(np.arange(0.0, 360.0, 5.0))
    truth = [WAVY.middle(float(azimuth)) for azimuth in azimuths]
    np.testing.assert_allclose(np.degrees(mid_angles(nozzle, azimuths)), truth, atol=0.4)
    assert nozzle.ring_sigma_deg == pytest.approx(WAVY.sigma, abs=0.2)
    before = load_recipe("smt-aqueous")
    assert parse_recipe(text).templates == before.templates
    assert "# 15 % saponifier in water" in text
    assert text.splitlines()[1].startswith(
        "# Nozzle ring60: SYNTHETIC data, proves nothing: fitted to data.csv, sha256 "
    )


@pytest.mark.slow
def test_the_jet_of_the_new_recipe_is_the_ring_that_was_measured(tmp_path) -> None:
    fit = fitted(tmp_path, edge_table(WAVY, noise_mm=0.2, seed=7))
    nozzle = parse_recipe(recipe_with_ring(fit, "smt-aqueous", "ring60", tmp_path / "mine.yaml")).nozzles["ring60"]
    setup = CouponSetup(nozzle, BENCH.liquid, BENCH.parameters)
    _, jet = read_coupons(coupons(tmp_path, noise=0, seed=0), setup).jets[0]
    truth = [WAVY.middle(float(azimuth)) for azimuth in jet.azimuths]
    np.testing.assert_allclose(np.degrees(jet.half_angles), truth, atol=0.4)
    np.testing.assert_allclose(np.degrees(jet.sigmas), WAVY.sigma, atol=0.25)


@pytest.mark.slow
def test_a_circle_takes_the_measured_ring_out_of_the_recipe(tmp_path) -> None:
    fit = fitted(tmp_path, edge_table(Ring(), noise_mm=0.5, seed=3))
    for source in ("smt-aqueous", "low-standoff"):  # the latter inherits its nozzle
        nozzle = parse_recipe(recipe_with_ring(fit, source, "ring60", tmp_path / "mine.yaml")).nozzles["ring60"]
        assert isinstance(nozzle, HollowCone)
        assert nozzle.wavefront is None
        assert nozzle.half_angle_deg == pytest.approx(31.2, abs=0.3)


@pytest.mark.slow
def test_the_block_of_lines_is_that_of_the_recipe(tmp_path) -> None:
    fit = fitted(tmp_path, edge_table(WAVY, noise_mm=0.2, seed=7))
    indented = "".join(f"    {line}\n" for line in nozzle_text(fit).splitlines())
    printed = parse_recipe(f"recipe: a\nextends: smt-aqueous\nnozzles:\n  ring60:\n{indented}")
    edited = parse_recipe(recipe_with_ring(fit, "smt-aqueous", "ring60", tmp_path / "mine.yaml"))
    assert printed.nozzles == edited.nozzles


def test_a_nozzle_that_is_no_hollow_cone_is_told(tmp_path) -> None:
    fit = fitted(tmp_path, edge_table(Ring(), noise_mm=0.5, seed=3))
    with pytest.raises(
        CleaningError, match=r"nozzles: 'ring6' is no hollow cone of this recipe; did you mean 'ring60'"
    ):
        recipe_with_ring(fit, "smt-aqueous", "ring6", tmp_path / "mine.yaml")


@pytest.mark.slow
def test_same_input_same_fit(tmp_path) -> None:
    text = intensity_table(WAVY, noise=0.01, seed=2)
    assert nozzle_text(fitted(tmp_path, text)) == nozzle_text(fitted(tmp_path, text))


@pytest.mark.slow
def test_only_a_comment_at_the_beginning_of_a_line_makes_a_table_synthetic(tmp_path) -> None:
    made_up = fitted(tmp_path, edge_table(Ring(), noise_mm=0.5, seed=3))
    real = fitted(tmp_path, edge_table(Ring(), noise_mm=0.5, seed=3, first="# Nozzle 7, not synthetic"))
    assert (made_up.measurements.synthetic, real.measurements.synthetic) == (True, False)
    assert "SYNTHETIC" not in nozzle_text(real)


HEAD = "height_mm,tilt_deg,azimuth_deg,inner_mm,outer_mm\n"
ROWS = "".join(f"{height},0,{around},20,30\n" for height in (40, 50) for around in range(0, 360, 45))


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("", "data.csv:1: the table is empty"),
        (HEAD, "data.csv:1: 0 rows are too few; at least 8 are needed"),
        (ROWS, "data.csv:1: unknown column '40'; known: height_mm"),
        (HEAD.replace("height", "hight") + ROWS, "data.csv:1: unknown column 'hight_mm'; did you mean 'height_mm'?"),
        (HEAD.replace(",outer_mm", ""), "data.csv:1: 0 rows are too few"),
        (HEAD.replace("tilt_deg", "azimuth_deg") + ROWS, "data.csv:1: column 'azimuth_deg' stands twice"),
        ("# a\n" + HEAD.replace("azimuth_deg", "x_mm") + ROWS, "data.csv:2: column 'azimuth_deg' is missing; edges of"),
        (HEAD.replace("inner_mm", "intensity") + ROWS, "data.csv:1: intensities need places: either x_mm and y_mm"),
        (HEAD + ROWS + "40,0,0,20\n", "data.csv:18: has 4 cells; the header names 5 columns"),
        (HEAD + ROWS + "\n# end\n40,0,0,2x,30\n", "data.csv:20: inner_mm: must be a number with a decimal point"),
        (HEAD + ROWS + "40,0,0,nan,30\n", "data.csv:18: inner_mm: must be a finite number, not 'nan'"),
        (HEAD + ROWS + "40,0,0,-3,30\n", "data.csv:18: inner_mm: must lie in 0.01 to 2000, not -3"),
        (HEAD + ROWS + "40,0,0,31,30\n", "data.csv:18: inner_mm: 31 is not below outer_mm, 30"),
        (HEAD + ROWS.replace("50,", "40,"), "data.csv:2: height_mm: all 16 rows have 40; measure at two heights"),
        (
            HEAD + "".join(f"{40 + n},0,9,20,30\n" for n in range(101)),
            "data.csv:1: 101 pairs of height_mm and tilt_deg",
        ),
        (HEAD + ROWS + '40,0,0,"2,30\n', "data.csv:18: not valid CSV"),
    ],
)
def test_a_bad_table_is_told_with_its_line(tmp_path, text: str, wanted: str) -> None:
    with pytest.raises(CleaningError) as caught:
        fitted(tmp_path, text)
    assert wanted in str(caught.value)


def test_patterns_without_a_ring_are_told(tmp_path) -> None:
    random = np.random.default_rng(1)
    rows = [f"{40 + 30 * (k % 2)},{x:.1f},{y:.1f},1" for k, (x, y) in enumerate(random.uniform(-50, 50, (60, 2)))]
    with pytest.raises(CleaningError, match="show no ring"):
        fitted(tmp_path, "height_mm,x_mm,y_mm,intensity\n" + "\n".join(rows))


@pytest.mark.slow
@pytest.mark.parametrize("separator", [";", "\t"])
def test_other_separators_are_read_too(tmp_path, separator: str) -> None:
    text = edge_table(WAVY, noise_mm=0.2, seed=7)
    assert fitted(tmp_path, text.replace(",", separator)).half_angle_deg == fitted(tmp_path, text).half_angle_deg


def test_a_file_that_cannot_be_read_is_told(tmp_path) -> None:
    with pytest.raises(CleaningError, match=r"none\.csv: no such file"):
        calibrate_ring(tmp_path / "none.csv")
    (tmp_path / "latin.csv").write_bytes(HEAD.encode() + "1,2,3,4,5 µ\n".encode("latin-1"))
    with pytest.raises(CleaningError, match=r"latin\.csv:2: is not UTF-8 text"):
        calibrate_ring(tmp_path / "latin.csv")


def test_a_ring_that_would_close_or_pass_the_plane_on_one_side_is_refused(tmp_path) -> None:
    rows = ["0,2,4", "60,8,28", "120,2,3", "180,7,9", "210,3,7", "240,3,57", "7,50,56", "300,7,55"]
    lines = [f"{height},0,{row}" for height, row in zip([4, 4, 8, 1, 8, 8, 8, 80], rows, strict=True)]
    with pytest.raises(CleaningError, match=r"show no ring: .* half angle of 62\.1, between 24\.6 and 98"):
        fitted(tmp_path, HEAD + "\n".join(lines) + "\n")


def test_measurements_that_do_not_determine_a_ring_are_refused(tmp_path) -> None:
    strengths = ["-30,-30,0", "-30,24,1e-6", "-30,30,9e6", "0,24,31", "30,-30,9e-10", "30,-24,1.06", "30,30,9e-10"]
    rows = [*(f"40,0,0,{each}" for each in strengths), "1,0,0,0,30,22"]
    with pytest.raises(CleaningError, match="do not determine a ring: its half angle or sigma could be off"):
        fitted(tmp_path, "height_mm,tilt_deg,azimuth_deg,x_mm,y_mm,intensity\n" + "\n".join(rows) + "\n")


@pytest.mark.slow
def test_a_ring_that_does_not_suit_the_recipe_is_no_new_recipe(tmp_path) -> None:
    fit = fitted(tmp_path, edge_table(Ring(half_angle=60.0), noise_mm=0.1, seed=5))
    with pytest.raises(CleaningError, match="does not suit this recipe, so none was written") as caught:
        recipe_with_ring(fit, "smt-aqueous", "ring60", tmp_path / "new.yaml")
    assert "templates.around.tilt_deg: spray not closed on board" in str(caught.value)
