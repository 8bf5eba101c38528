"""``washboard spacing``: which spacings are even, which the maximum speed allows, and what is refused."""

from pathlib import Path

import pytest
from command import washboard

COAT = """recipe: coat
functions: {coat: {solution: saponifier-15, temperature_c: 25, pressure_bar: 3.0, max_speed_mm_s: 700}}
nozzles:
  gun: {pattern: radial, radius_mm: 40, at_mm: 200, flow_lpm: 0.0301593, at_bar: 3.0}
  knife: {pattern: air_knife, width_mm: 80, flow_lpm: 400}
  cone: {pattern: full_cone, half_angle_deg: 20, flow_lpm: 0.03}
classes: {other: {}}
templates: {sweep: {path: raster, height_mm: 200, speed_mm_s: 400}}
sequence: [{function: coat, nozzle: gun, paths: [sweep]}]
"""


@pytest.fixture
def coat(tmp_path: Path) -> Path:
    file = tmp_path / "coat.yaml"
    file.write_text(COAT, "utf-8")
    return file


@pytest.mark.slow
def test_the_printed_gun(coat: Path, tmp_path: Path) -> None:
    picture = tmp_path / "spacing.svg"
    result = washboard("spacing", coat, "gun", "--film-um", "40", "--picture", picture)
    assert (result.code, result.err) == (0, "")
    rows = [line.split() for line in result.out.splitlines()]
    valleys = {row[0]: row for row in rows if row and row[0] in ("48.665", "29.700", "21.535", "16.925")}
    assert [" ".join(row[2:4]) for row in valleys.values()] == ["±3.92 %", "±1.06 %", "±0.46 %", "±0.24 %"]
    assert [row[-1] for row in valleys.values()] == ["allowed", "allowed", "best", "fast"]
    assert "29.70 mm" in picture.read_text("utf-8")


@pytest.mark.slow
def test_a_slower_limit_forbids_the_narrow_ones(coat: Path) -> None:
    result = washboard("spacing", coat, "gun", "--film-um", "40", "--max-speed-mm-s", "300")
    assert result.out.count("too fast") == 8
    none = washboard("spacing", coat, "gun", "--film-um", "40", "--max-speed-mm-s", "200")
    assert "None is allowed by 200 mm/s" in none.out
    assert "at least 51.3 µm" in none.out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("guns",), "there is no nozzle 'guns'"),
        (("knife",), "an air knife lays no film"),
        (("cone",), "state --height-mm"),
        (("cone", "--height-mm", "50"), "state --max-speed-mm-s"),
    ],
)
def test_what_cannot_be_answered_says_what_to_do(coat: Path, words: tuple[str, ...], message: str) -> None:
    result = washboard("spacing", coat, *words, "--film-um", "40")
    assert result.code == 2
    assert message in result.err
