"""``washboard calibrate``, as a person at a terminal uses it, on the made-up tables that come along."""

from pathlib import Path

import pytest
from command import contents, washboard

import cleaning
from cleaning.parameters.load import load_parameters
from recipes.load import load_recipe
from recipes.nozzles import HollowCone

DEMO = Path(cleaning.__path__[0]) / "library" / "demo"
RING, COUPONS = DEMO / "ring.csv", DEMO / "coupons.csv"


@pytest.mark.slow
def test_a_ring_goes_into_a_new_recipe_and_a_picture(tmp_path: Path) -> None:
    output, picture = tmp_path / "mine.yaml", tmp_path / "ring.svg"
    result = washboard("calibrate", "ring", RING, "-o", output, "--picture", picture)
    assert (result.code, result.err) == (0, "")
    nozzle = load_recipe(output).nozzles["ring60"]
    assert isinstance(nozzle, HollowCone)
    assert nozzle.half_angle_deg == pytest.approx(29.4, abs=0.1)
    assert nozzle.ring_sigma_deg == pytest.approx(2.8, abs=0.1)
    assert nozzle.wavefront is not None
    assert "SYNTHETIC" in result.out
    assert "SYNTHETIC" in picture.read_text("utf-8")
    assert "SYNTHETIC" in output.read_text("utf-8")


def test_without_a_place_the_lines_of_the_nozzle_are_printed() -> None:
    result = washboard("calibrate", "ring", RING)
    assert result.code == 0
    assert "\nhalf_angle_deg: 29.4" in result.out
    assert "\nwavefront:\n  height_mm: 40\n  points:\n    - [0, " in result.out


@pytest.mark.slow
def test_coupons_make_a_set_that_says_what_they_do_not_tell(tmp_path: Path) -> None:
    output, picture = tmp_path / "our-line.yaml", tmp_path / "coupons.png"
    result = washboard("calibrate", "gap", COUPONS, "--date", "2026-11-21", "-o", output, "--picture", picture)
    assert (result.code, result.err) == (0, "")
    assert any(line.startswith("film.puddle_mm") and "undetermined" in line for line in result.out.splitlines())
    mine = load_parameters(output)
    assert mine.soil.k1_per_s == pytest.approx(0.008, rel=0.1)
    assert mine.soil.activation_kj_mol == pytest.approx(42, rel=0.15)
    assert mine.known("soil.k1_per_s").date == "2026-11-21"
    assert not mine.calibrated
    assert "verdicts keep their grade" in result.out
    assert picture.read_bytes().startswith(b"\x89PNG")
    again = tmp_path / "again.png"
    printed = washboard("calibrate", "gap", COUPONS, "--picture", again)
    assert "\nextends: default\n" in printed.out
    assert again.read_bytes() == picture.read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        (("ring", "none.csv"), "error: none.csv: no such file"),
        (("ring", RING, "--nozzle", "knife"), "'knife' is no hollow cone of this recipe; known: ring60"),
        (("ring", RING, "--recipe", "dry-only"), "this recipe has no hollow cone; name one that has with --recipe"),
        (("ring", RING, "-o", "mine.wash"), "its name is that of a program, and a YAML file is to be written"),
        (("ring", COUPONS), f"error: {COUPONS}:3: unknown column 'standoff_um'"),
        (("gap", RING), f"error: {RING}:3: unknown column 'tilt_deg'; "),
        (("gap", COUPONS, "--solution", "soap"), "'soap' is no liquid for washing; known: saponifier-15"),
        (("gap", COUPONS, "--parameters", "mine"), "no parameter set 'mine'"),
        (("gap", COUPONS, "--date", "today"), "'today' is no date"),
        (("gap", COUPONS, "--date", "2026-13-45"), "'2026-13-45' is no date"),
        (("gap", COUPONS, "--picture", "a.pdf"), "a picture is written as .png or .svg"),
        (("gap", COUPONS, "-o", COUPONS), "it is read by this command"),
    ],
)
def test_what_cannot_be_done_is_one_line_and_leaves_nothing(
    words: tuple[str | Path, ...], wanted: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = washboard("calibrate", *words)
    assert (result.code, result.out) == (2, "")
    assert wanted in result.err
    assert result.err.count("\n") == 1
    assert contents(tmp_path) == {}


@pytest.mark.slow
def test_rings_of_all_kinds_are_drawn(tmp_path: Path) -> None:
    rows = ["height_mm,x_mm,y_mm,intensity"]
    for height in (40, 60):
        for x in range(-60, 61, 5):
            for y in range(-60, 61, 5):
                away = abs((x * x + y * y) ** 0.5 / height - 0.55)
                rows.append(f"{height},{x},{y},{max(0.0, 1 - 5 * away):.3f}")
    data, picture = tmp_path / "film.csv", tmp_path / "film.svg"
    data.write_text("\n".join(rows), "utf-8")
    result = washboard("calibrate", "ring", data, "--quantity", "pressure", "--picture", picture)
    assert result.code == 0
    assert "All sheets have one tilt" in result.out
    assert "the ring is a circle" in result.out
    assert "60 mm, tilted 0" in picture.read_text("utf-8")


def test_rows_that_were_pasted_twice_are_noticed(tmp_path: Path) -> None:
    lines = RING.read_text("utf-8").splitlines()
    data = tmp_path / "ring.csv"
    data.write_text("\n".join([*lines, lines[3], lines[7]]), "utf-8")
    told = washboard("calibrate", "ring", data).out
    assert f"2 rows repeat an earlier one, first line {len(lines) + 1} as line 4" in told
    assert "as an earlier one" not in washboard("calibrate", "ring", RING).out


def test_directions_in_which_a_ring_is_widest_are_in_degrees() -> None:
    assert (
        "most at 337 degrees, 0.72 degrees twice around, most at 44 degrees."
        in washboard("calibrate", "ring", RING).out
    )
