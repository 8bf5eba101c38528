"""Findings on the time and the size of a program's text."""

from dataclasses import replace

import pytest
from installations import small_cell
from robot_programs import PROGRAMS

from programs.export import Exported, export
from programs.posts.proving.findings import check_short
from specs.source import Source


def with_controller(**values: float) -> Exported:
    cell = replace(
        small_cell("kuka"), controller={"turn_acceleration_deg_s2": 1800.0} | values, controller_source="the cell"
    )
    return export(PROGRAMS["three_speeds"](), cell, "kuka")


def rules(done: Exported) -> dict[str, str]:
    return {finding.rule.id: finding.message for finding in done.findings}


def test_a_program_that_takes_longer_than_planned_says_so_and_why() -> None:
    assert "slower-on-controller" not in rules(with_controller())
    done = with_controller(acceleration_mm_s2=50.0)
    assert done.forecast is not None
    message = rules(done)["slower-on-controller"]
    assert f"{done.forecast.ratio:.2f} times" in message
    assert "Remedy" in message
    finding = next(each for each in done.findings if each.rule.id == "slower-on-controller")
    assert finding.made_by
    assert any("slower" in text or "is predicted to take" in text for text in done.files.values())


def test_the_header_states_the_predicted_time() -> None:
    done = with_controller(acceleration_mm_s2=50.0)
    assert done.forecast is not None
    assert any(f"Predicted time {done.forecast.describe()}" in text for text in done.files.values())


@pytest.mark.parametrize("word", ["most_lines", "most_bytes"])
def test_a_file_that_is_longer_than_the_controller_takes_is_a_finding(word: str) -> None:
    assert "too-many-points" not in rules(with_controller(**{word: 1_000_000}))
    message = rules(with_controller(**{word: 1}))["too-many-points"]
    assert word in message
    assert "the cell" in message


@pytest.mark.parametrize(("at_corner", "severity"), [(True, "info"), (False, "warning")])
def test_moves_that_are_short_while_a_jet_is_on_are_stated_with_where_they_come_from(
    at_corner: bool, severity: str
) -> None:
    forecast = with_controller().forecast
    assert forecast is not None
    assert list(check_short(replace(forecast, moves=tuple(each for each in forecast.moves if not each.spraying)))) == []
    sprayed = next(each for each in forecast.moves if each.spraying)
    source = Source(0, "around", ("U1", "U2"))
    short = replace(sprayed, nominal_s=0.0125, at_corner=at_corner, made_by=source)
    (found,) = check_short(replace(forecast, moves=(*forecast.moves, short, replace(short, nominal_s=0.015))))
    assert found.severity == severity
    assert "2 of sequence[0]/around" in found.message
    assert "12.5 ms" in found.message
    assert found.made_by == source


def test_a_way_that_no_routine_holds_is_divided_by_stops() -> None:
    assert "too-many-points" not in rules(with_controller(most_positions=100))
    assert "on its way for the next routine" in rules(with_controller(most_positions=2))["too-many-points"]


def test_a_long_program_is_divided_at_the_positions_that_the_cell_states() -> None:
    assert len(with_controller(most_positions=8).files) > len(with_controller().files)
