from dataclasses import replace
from math import inf, sqrt

import numpy as np
import pytest

from programs.timing.controller import Controller
from programs.timing.ways import Machine, Way

NONE = np.zeros(2)
SLOW = Machine(Controller("zone", 2000.0), np.array([90.0, 100.0]), np.array([900.0, 1000.0]), np.array([1.0, 0.0]))
ALONG_X = Way(40.0, False, (1.0, 0.0, 0.0), (0.0, 0.0, 0.0), NONE, NONE, NONE, NONE, 100.0, False, 1.0)
ALONG_Y = replace(ALONG_X, direction=(0.0, 1.0, 0.0))


def leave(machine: Machine, one: Way, other: Way) -> float:
    return machine.lanes([one, other])[0][0].leave


def under(**changed: object) -> Machine:
    return replace(SLOW, controller=replace(SLOW.controller, **changed))


def test_a_joint_at_its_limit_slows_the_line_down() -> None:
    rates = np.array([1.8, 0.0])  # degrees per mm
    lane, cause = SLOW.lanes([replace(ALONG_X, fastest=rates, first=rates, last=rates)])[0]
    assert (lane.top, cause) == (pytest.approx(50.0), "joint limits")
    assert lane.ramp.acceleration == pytest.approx(500.0)


def test_a_zone_is_passed_as_fast_as_the_acceleration_turns_the_speed() -> None:
    assert leave(SLOW, ALONG_X, ALONG_Y) == pytest.approx(sqrt(2.0 * 1.0 * 2000.0 / sqrt(2.0)))
    assert leave(SLOW, ALONG_X, replace(ALONG_Y, length=1.0)) == pytest.approx(sqrt(2.0 * 0.5 * 2000.0 / sqrt(2.0)))
    assert leave(SLOW, ALONG_X, ALONG_X) == inf


def test_a_joint_that_changes_its_rate_in_a_zone_is_accelerated_there() -> None:
    after = replace(ALONG_X, first=np.array([0.9, 0.0]))
    assert leave(SLOW, ALONG_X, after) == pytest.approx(sqrt(2.0 * 900.0 / 0.9))


def test_lines_that_overlap_keep_their_share_of_the_speed() -> None:
    machine = under(blending="overlap")
    assert leave(machine, replace(ALONG_X, zone=0.4), replace(ALONG_Y, speed=60.0)) == pytest.approx(24.0)


def test_linuxcnc_puts_an_arc_into_a_corner_of_slides() -> None:
    machine = under(blending="tolerance")
    half = sqrt(0.5)
    radius = 0.05 * half / (1.0 - half)
    found = leave(machine, replace(ALONG_X, zone=0.05), ALONG_Y)
    assert found == pytest.approx(sqrt(sqrt(0.75) * 2000.0 * radius))


def test_linuxcnc_blends_turning_lines_at_half_the_acceleration_and_within_their_length() -> None:
    machine = under(blending="tolerance", blend_acceleration_share=0.5, stops_in_turning_line=True)
    rates = np.array([0.1, 0.0])
    turning = replace(ALONG_X, length=0.5, fastest=rates, first=rates, last=rates, zone=0.05)
    lane, cause = machine.lanes([turning, turning])[0]
    assert (lane.top, cause) == (pytest.approx(sqrt(1000.0 * 0.5)), "short lines")
    assert lane.leave == inf
    across = replace(turning, direction=(0.0, 1.0, 0.0))
    assert leave(machine, turning, across) == pytest.approx(2.0 * sqrt(1000.0 * 0.05 / sqrt(0.5)))


def test_a_whole_time_from_rest_to_rest_is_kept() -> None:
    turn = replace(ALONG_X, length=90.0, turns=True, turning=(0.0, 0.0, 1.0), stops=True, whole_s=1.0)
    machine = under(turn_acceleration_deg_s2=600.0)
    lane, _ = machine.lanes([turn])[0]
    assert 90.0 / lane.top + lane.top / 600.0 == pytest.approx(1.0)


def test_a_joint_motion_takes_as_long_as_its_slowest_joint() -> None:
    assert SLOW.joint_time(np.array([45.0, 10.0]), 0.5) == pytest.approx(45.0 / 45.0 + 45.0 / 900.0)
    assert SLOW.joint_time(np.zeros(2), 1.0) == 0.0
