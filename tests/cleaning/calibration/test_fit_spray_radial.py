"""A measured film gives back the profile and the flow that laid it; what is no pattern is refused with its line."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from command import washboard

import cleaning
from cleaning.calibration.fit_spray import calibrate_pattern, pattern_text
from cleaning.errors import CleaningError
from recipes.nozzles import Radial

DEMO = Path(cleaning.__path__[0]) / "library" / "demo" / "pattern.csv"


def table(radii, films, height=100.0, time=True) -> str:
    head = "height_mm,radius_mm,film_um" + ",time_s" * time
    return "\n".join([head, *(f"{height},{r},{q}" + ",2" * time for r, q in zip(radii, films, strict=True))])


def fitted(tmp_path: Path, text: str):
    file = tmp_path / "films.csv"
    file.write_text(text, "utf-8")
    return calibrate_pattern(file)


@pytest.mark.parametrize("height", [60.0, 100.0, 250.0])
def test_a_profile_is_found_again_from_any_distance(tmp_path: Path, height: float) -> None:
    radii = np.arange(0.0, 50.0, 1.0) * height / 100.0
    at_100 = np.arange(0.0, 50.0, 1.0)
    films = 2.0 * np.clip(1600 - at_100**2, 0, None) / 8 * (100.0 / height) ** 2
    fit = fitted(tmp_path, table(radii, films, height))
    assert fit.at_mm == height
    assert fit.radius_mm[-1] == pytest.approx(0.4 * height, rel=0.02)
    inside = fit.radius_mm < 0.35 * height
    truth = 1 - (fit.radius_mm / height / 0.4) ** 2
    assert fit.flux[inside] == pytest.approx(truth[inside], abs=0.01)
    assert fit.flow_lpm == pytest.approx(np.pi * 40**4 / 16 * 60e-9, rel=0.01)


def test_the_demo_table_with_tilted_sheets_gives_the_printed_gun() -> None:
    fit = calibrate_pattern(DEMO)
    assert fit.flow_lpm == pytest.approx(np.pi * 40**4 / 16 * 60e-9, rel=0.01)
    assert fit.rms < 0.01
    nozzle = Radial.model_validate({**read(pattern_text(fit)), "at_bar": 3})
    assert nozzle.radius_mm == pytest.approx(40, abs=1)


def read(text: str):
    return yaml.safe_load(text)


def test_without_times_the_flow_is_unknown(tmp_path: Path) -> None:
    fit = fitted(tmp_path, table(range(12), [5, 5, 5, 4, 4, 3, 2, 1, 0, 0, 0, 0], time=False))
    assert fit.flow_lpm is None
    assert "flow_lpm" not in pattern_text(fit)


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (table(range(9), [9, 9, 8, 8, 7, 6, 5, 4, 3]), 10, "outermost place still has 33 % of the peak"),
        (table(range(9), [0] * 9), 2, "no film is above 0"),
        ("height_mm,film_um\n" + "100,1\n" * 9, 1, "either radius_mm, or x_mm and y_mm"),
        (table(range(3), [2, 1, 0]), 1, "too few"),
    ],
)
def test_what_is_no_pattern_is_refused(tmp_path: Path, text: str, line: int, words: str) -> None:
    with pytest.raises(CleaningError, match=words) as caught:
        fitted(tmp_path, text)
    assert caught.value.line == line


@pytest.mark.slow
def test_the_command_prints_a_block_that_a_recipe_takes(tmp_path: Path) -> None:
    picture = tmp_path / "pattern.svg"
    result = washboard("calibrate", "pattern", DEMO, "--picture", picture)
    assert result.code == 0, result.err
    assert "\npattern: radial\n" in result.out
    assert "SYNTHETIC" in picture.read_text("utf-8")
