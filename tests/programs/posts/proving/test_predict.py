"""Times that are predicted from a program's text."""

from dataclasses import replace
from functools import cache

import pytest
from installations import ARM_LANGUAGES, small_cell
from robot_programs import PROGRAMS, joints_of

from programs.export import controller_of, export
from programs.motion.installation import Installation
from programs.motion.make_motion import make_motion
from programs.posts.dialects import DIALECTS
from programs.posts.proving.compare import measure
from programs.posts.proving.predict import predict, run_of
from programs.timing.controller import Controller
from programs.timing.forecast import Forecast

MODELLED = [name for name, each in ARM_LANGUAGES.items() if each.controller is not None and name != "linuxcnc"]


def cell_of(dialect: str) -> Installation:
    return small_cell(DIALECTS[dialect].maker)


@cache
def exported(dialect: str, made: str = "in_flight") -> Forecast:
    forecast = export(PROGRAMS[made](), cell_of(dialect), dialect).forecast
    assert forecast is not None
    return forecast


def of_text(dialect: str, change: tuple[str, str] = ("", ""), **changed: object) -> Forecast:
    cell, language = cell_of(dialect), DIALECTS[dialect]
    program = PROGRAMS["in_flight"]()
    files = export(program, cell, dialect).files
    rebuilt = language.read({name: text.replace(*change) if change[0] else text for name, text in files.items()})
    motion = make_motion(program, cell, None)
    controller = replace(controller_of(language, cell) or Controller("zone"), **changed)
    return predict(run_of(rebuilt, measure(rebuilt, motion, cell), motion, cell, controller))


@pytest.mark.parametrize("dialect", MODELLED)
def test_every_language_states_what_its_controller_takes(dialect: str) -> None:
    forecast = exported(dialect)
    assert 0.8 < forecast.ratio < 1.1
    assert len(forecast.moves) >= 3
    assert all(move.predicted_s >= 0.99 * move.nominal_s for move in forecast.moves)
    assert any(move.spraying for move in forecast.moves)
    assert forecast.predicted_s >= sum(move.predicted_s for move in forecast.moves) - 1e-9


@pytest.mark.parametrize("dialect", MODELLED)
def test_a_jet_that_began_at_rest_is_on_after_the_wait_for_it(dialect: str) -> None:
    first = next(move for move in exported(dialect, "loop").moves if str(move.made_by) == "s/pass")
    assert first.spraying


def test_the_time_is_that_of_the_text_and_not_of_the_plan() -> None:
    as_planned, slower = of_text("ur"), of_text("ur", ("v=0.1,", "v=0.05,"))
    assert slower.planned_s == as_planned.planned_s
    assert slower.predicted_s > 1.5 * as_planned.predicted_s


def test_a_signal_is_late_by_what_the_controller_is_slow_before_its_place() -> None:
    """RAPID leads a jet by time, so it holds its place; SPEL+ leads it by place, planned for another speed."""
    assert of_text("abb").event_mm < 0.01
    slow = of_text("epson", ("SpeedS 100.0", "SpeedS 50.0"))
    assert slow.event_s > 0.01


@pytest.mark.parametrize(
    ("changed", "cause"),
    [
        ({"acceleration_mm_s2": 100.0}, "stops"),
        ({"least_line_s": 4.0}, "short lines"),
        ({"settle_s": 1.0}, "stops"),
    ],
)
def test_a_worse_controller_takes_longer_and_says_why(changed: dict[str, float], cause: str) -> None:
    usual, worse = of_text("kuka"), of_text("kuka", ("", ""), **changed)
    assert worse.predicted_s > 1.1 * usual.predicted_s
    assert worse.losses()[0][0] == cause


def test_joint_limits_slow_a_program_down() -> None:
    program = PROGRAMS["in_flight"]()
    cell = small_cell("kuka")
    tracking = joints_of(program)
    free = export(program, cell, "kuka", tracking).forecast
    tight = replace(cell, joints=tuple(replace(joint, speed=0.05, acceleration=1.0) for joint in cell.joints))
    slow = export(program, tight, "kuka", tracking).forecast
    assert free is not None
    assert slow is not None
    assert slow.predicted_s > 1.2 * free.predicted_s
    assert "joint limits" in {move.cause for move in slow.moves}


def test_pauses_and_joint_motions_count() -> None:
    forecast = exported("kuka", "two_tools")
    assert forecast.predicted_s > sum(move.predicted_s for move in forecast.moves)
