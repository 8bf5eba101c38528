"""Lines are commanded so that a controller, by its model, has the jet on for the planned time on each stroke."""

from dataclasses import replace
from itertools import pairwise

import pytest
from installations import ARM_LANGUAGES, small_cell
from robot_programs import PROGRAMS, joints_of

from programs.export import Exported, export
from programs.posts.dialects import DIALECTS
from programs.posts.proving.findings import LEAST_DOSE, MOST_DOSE, check_dose
from programs.posts.proving.predict import driven_times, run_of
from programs.summary import jet_seconds

MODELLED = [name for name, each in ARM_LANGUAGES.items() if each.controller is not None]


def exported(dialect: str, made: str, **controller: float) -> Exported:
    program, language = PROGRAMS[made](), DIALECTS[dialect]
    cell = replace(small_cell(language.maker), controller=controller)
    return export(program, cell, dialect, joints_of(program) if language.needs_joints else None)


@pytest.mark.parametrize("made", ["faces", "two_tools", "bottom"])
@pytest.mark.parametrize("dialect", MODELLED)
def test_each_stroke_takes_its_planned_time_with_the_jet_on(dialect: str, made: str) -> None:
    forecast = exported(dialect, made).forecast
    assert forecast is not None
    strokes = forecast.strokes()
    assert strokes
    assert all(LEAST_DOSE <= stroke.jet_s / stroke.jet_planned_s <= MOST_DOSE for stroke in strokes)
    assert list(check_dose(forecast)) == []


@pytest.mark.parametrize("made", ["faces", "two_tools", "bottom"])
@pytest.mark.parametrize("dialect", MODELLED)
def test_jets_are_on_for_their_planned_time_with_what_valves_take_at_stops(dialect: str, made: str) -> None:
    done = exported(dialect, made)
    assert done.controller is not None
    run = run_of(done.rebuilt, done.agreement, done.commanded, done.installation, done.controller)
    _, jets = driven_times(run)
    seconds = [end - begin for (begin, on), (end, _) in pairwise(jets) if on]
    assert seconds
    assert sum(seconds) == pytest.approx(sum(jet_seconds(PROGRAMS[made]()).values()), rel=0.03)


@pytest.mark.parametrize("made", ["faces", "two_tools", "bottom", "three_speeds", "loop"])
@pytest.mark.parametrize("dialect", MODELLED)
def test_signals_leave_where_jets_come_to_their_places_as_the_controller_drives(dialect: str, made: str) -> None:
    forecast = exported(dialect, made).forecast
    assert forecast is not None
    assert forecast.event_mm <= 0.05


def test_a_controller_that_is_too_slow_is_a_finding_with_its_seconds() -> None:
    done = exported("kuka", "three_speeds", acceleration_mm_s2=20.0)
    (message,) = (finding.message for finding in done.findings if finding.rule.id == "dose-differs")
    assert done.forecast is not None
    late_s = sum(each.late_s for each in done.forecast.strokes() if each.jet_s > MOST_DOSE * each.jet_planned_s)
    assert f"{late_s:.2f} s more" in message


def test_strokes_that_are_too_short_are_found_too_though_the_total_is_right() -> None:
    forecast = exported("kuka", "three_speeds").forecast
    assert forecast is not None
    sprayed = [at for at, move in enumerate(forecast.moves) if move.jet_planned_s >= 0.25]
    moves = list(forecast.moves)
    for at, by in zip(sprayed[:2], (-0.1, 0.1), strict=True):
        moves[at] = replace(moves[at], jet_s=moves[at].jet_planned_s + by)
    (finding,) = check_dose(replace(forecast, moves=tuple(moves)))
    assert "2 of" in finding.message
    assert "0.10 s more and 0.10 s less" in finding.message
