from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from small_plans import LIMITS, leaning, plan_of, spray, transfer

from geometry.arrays import Scalars
from programs.plan import Plan
from programs.program import MoveTo
from rulesengine.timing.limit_intervals import FREE
from rulesengine.timing.robot_pace import robot_pace, robot_times, seconds_by_kind
from rulesengine.timing.time_plan import TimedPath, time_path


def laps() -> Plan:
    """Two edges with a turn on the spot between them, and the way back."""
    at = [[0, 0, 50], [60, 0, 50], [60, 0, 50], [60, 40, 50]]
    axes = leaning([0.0, 0.0, 1.5, 1.5], 0.4)
    back = leaning([1.5, 0.0], 0.4)
    return plan_of(spray(at, 60.0, axes), transfer([[60, 40, 50], [0, 0, 50]], axes=back))


def carried_out(timed: TimedPath, warp: Callable[[Scalars], Scalars]) -> Any:
    """The report of a robot whose clock is a function of the program's."""
    moves = [item for item in timed.program.instructions if isinstance(item, MoveTo)]
    clock = np.array([item.time_s for item in moves])
    fine = np.unique(np.concatenate([np.linspace(a, b, int(np.ceil((b - a) / 0.1)) + 1) for a, b in pairwise(clock)]))
    program = replace(
        timed.program,
        instructions=tuple(replace(moves[0], time_s=float(at)) for at in warp(fine)),
    )
    return SimpleNamespace(program=program, clock=fine)


def replanned(plan: Plan, warp: Callable[[Scalars], Scalars]) -> tuple[TimedPath, TimedPath, float]:
    free = time_path(plan, LIMITS)
    assert free.path is not None
    report = carried_out(free, warp)
    times = robot_times(free, free.path, report)
    return free, time_path(plan, LIMITS, robot_pace(times)), report.program.instructions[-1].time_s


@pytest.mark.parametrize("slower", [1.05, 1.5, 3.0])
def test_a_robot_that_is_slower_throughout_sets_the_planned_time(slower: float) -> None:
    _, bounded, robot_s = replanned(laps(), lambda clock: slower * clock)
    assert bounded.program.totals.duration_s == pytest.approx(robot_s, rel=1e-3)


def test_only_where_the_robot_is_slower_is_the_plan_slower() -> None:
    plan = laps()
    free = time_path(plan, LIMITS)
    assert free.path is not None
    first = float(np.interp(free.path.knots[1], free.at, [each.time_s for each in _moves(free)]))
    second = float(np.interp(free.path.knots[2], free.at, [each.time_s for each in _moves(free)]))
    _, bounded, robot_s = replanned(plan, lambda clock: clock + np.clip(clock - first, 0.0, second - first))
    before, after = seconds_by_kind(free), seconds_by_kind(bounded)
    assert bounded.program.totals.duration_s == pytest.approx(robot_s, rel=1e-3)
    assert after["turning on the spot"] == pytest.approx(2.0 * before["turning on the spot"], rel=0.02)
    assert after["on sprayed lines"] == pytest.approx(before["on sprayed lines"], abs=2e-3)
    assert after["on transfers"] == pytest.approx(before["on transfers"], abs=2e-3)


def test_a_robot_that_keeps_up_sets_no_pace() -> None:
    free = time_path(laps(), LIMITS)
    assert free.path is not None
    times = robot_times(free, free.path, carried_out(free, lambda clock: clock))
    assert len(robot_pace(times).begin) == 0
    assert robot_pace(times).within(FREE) is FREE


def _moves(timed: TimedPath) -> list[MoveTo]:
    return [item for item in timed.program.instructions if isinstance(item, MoveTo)]
