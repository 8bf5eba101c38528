from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robotcell.motion.cell_queries import time_move
from robotcell.motion.retime import differences, retime, stretch_runs
from robotcell.motion.sampled_path import runs_of
from robotcell.robot.robot import Joint, Robot


def robot(speed: float, acceleration: float, dof: int = 1) -> Robot:
    joint = Joint("j", "revolute", np.eye(4), np.array([0.0, 0.0, 1.0]), -10.0, 10.0, speed, acceleration)
    return Robot("r", (joint,) * dof, np.eye(4), ((),) * (dof + 1))


def trapezoid(length: float, speed: float, acceleration: float, step: float = 0.01) -> tuple[np.ndarray, np.ndarray]:
    """Times and places from rest to rest, long enough to reach the speed."""
    ramp = speed / acceleration
    total = length / speed + ramp
    times = np.linspace(0.0, total, int(total / step) + 2)
    up, down = np.minimum(times, ramp), np.maximum(times - total + ramp, 0.0)
    way = acceleration * up**2 / 2 + speed * np.clip(times - ramp, 0.0, None) - acceleration * down**2 / 2
    return times, way[:, None]


def uncut(times: np.ndarray) -> np.ndarray:
    return np.zeros(len(times) - 1, dtype=np.bool_)


def test_a_timing_that_the_joints_hold_is_kept_to_the_bit() -> None:
    times, q = trapezoid(2.0, 1.0, 4.0)
    found = retime(robot(1.2, 5.0), times, q, uncut(times))
    np.testing.assert_array_equal(found.lasting, np.diff(times))
    assert (found.share == 1.0).all()


def test_half_the_speed_takes_as_long_as_the_slower_trapezoid() -> None:
    times, q = trapezoid(2.0, 1.0, 4.0)
    found = retime(robot(0.5, 50.0), times, q, uncut(times))
    # At half the speed no ramp is slower than before: the program's own ramps are kept up to where it matters.
    assert found.lasting.sum() == pytest.approx(2.0 / 0.5, rel=0.05)
    speed = np.abs(np.diff(q, axis=0)[:, 0] / found.lasting)
    assert speed.max() <= 0.5 * 1.001
    middle = len(found.share) // 2
    assert found.share[middle] == pytest.approx(0.5, abs=0.01)
    assert found.by_speed[middle]


def test_less_acceleration_gives_the_longer_ramps() -> None:
    times, q = trapezoid(2.0, 1.0, 10.0)
    found = retime(robot(5.0, 2.0), times, q, uncut(times))
    assert found.lasting.sum() == pytest.approx(2.0 / 1.0 + 1.0 / 2.0, rel=0.03)  # L / v + v / a
    assert not found.by_speed[0]


@pytest.mark.slow
@settings(max_examples=15)
@given(speed=st.floats(0.1, 3.0), acceleration=st.floats(0.3, 20.0), seed=st.integers(0, 99))
def test_limits_hold_and_nothing_is_faster_than_the_program(speed: float, acceleration: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    times, way = trapezoid(1.0, 0.8, 3.0)
    q = np.sin(way * rng.uniform(0.5, 3.0, 3)) * rng.uniform(0.2, 1.0, 3)
    arm = robot(speed, acceleration, 3)
    found = retime(arm, times, q, uncut(times))
    assert (found.lasting >= np.diff(times) * (1 - 1e-6)).all()
    rate = np.diff(q, axis=0) / found.lasting[:, None]
    assert np.abs(rate).max() <= speed * (1 + 1e-9)
    change = np.diff(rate, axis=0) / (0.5 * (found.lasting[1:] + found.lasting[:-1]))[:, None]
    assert np.abs(change).max() <= acceleration * (1 + 1e-9)


@pytest.mark.parametrize("over", [1.005, 1.019, 1.3])
def test_a_limit_that_is_exceeded_by_little_is_kept_exactly(over: float) -> None:
    times, q = trapezoid(2.0, 1.0, 4.0)
    pause = np.concatenate((times, times[-1] + 0.3 + times))  # a run of its own after a rest
    both = np.concatenate((q, q[-1] - q))
    for arm in (robot(1.0 / over, 50.0), robot(5.0, 4.0 / over)):
        found = retime(arm, pause, both, uncut(pause))
        rates, changes = differences(found.lasting, both)
        assert np.abs(rates).max() <= arm.speed[0]
        assert np.abs(changes).max() <= arm.acceleration[0]
        assert found.lasting.sum() <= np.diff(pause).sum() * over * 1.02
        assert found.lasting[len(times) - 1] == pytest.approx(0.3)


def test_pauses_last_as_long_as_before_and_cuts_are_stops() -> None:
    times, way = trapezoid(1.0, 0.5, 2.0)
    both = np.concatenate((times, times[-1] + 0.7 + times))
    q = np.concatenate((way, way[-1] - way))
    found = retime(robot(0.2, 1.0), both, q, uncut(both))
    assert found.lasting[len(times) - 1] == pytest.approx(0.7)
    cuts = uncut(times)
    cuts[len(cuts) // 2] = True  # in full motion
    stopped = retime(robot(5.0, 4.0), times, way, cuts)
    rate = np.diff(way[:, 0]) / stopped.lasting
    assert rate[len(cuts) // 2 - 1] < 0.25
    assert stopped.lasting.sum() > np.diff(times).sum() + 0.05


def test_a_joint_move_takes_half_of_what_the_joints_can() -> None:
    times, q = time_move(robot(2.0, 8.0, 2), np.array([[0.0, 0.0], [1.0, -0.5]]))
    assert times[-1] == pytest.approx(1.0 / 1.0 + 1.0 / 4.0)  # L / v + v / a with v = 1, a = 4
    np.testing.assert_allclose(q[-1], [1.0, -0.5])
    np.testing.assert_allclose(q[:, 1], -0.5 * q[:, 0])
    assert (np.diff(times) > 0).all()


def test_runs_that_meet_and_motions_of_no_duration_end_within_the_limits() -> None:
    arm = robot(2.0, 5.0, 2)
    for seed in range(60):
        rng = np.random.default_rng(seed)
        count = int(rng.integers(5, 60))
        lasting = 10.0 ** rng.uniform(-6.3, -0.5, count)
        turns = rng.normal(0.0, 0.02, (count + 1, 2)) * (rng.random((count + 1, 1)) < 0.7)
        q, cuts = np.cumsum(turns, axis=0), rng.random(count) < 0.1
        moving = (np.abs(np.diff(q, axis=0)).max(axis=1) > 1e-9) & ~cuts
        found = stretch_runs(np.where(moving, np.maximum(lasting, 1e-6), lasting), q, cuts, runs_of(moving), arm)
        np.testing.assert_array_equal(found[~moving], lasting[~moving])  # pauses last as long as before
        for a, b in runs_of(~cuts):
            rows = a + np.concatenate(([0], 1 + np.flatnonzero(found[a:b] > 1e-6)))
            if len(rows) > 1:
                seconds = [float(found[begin:end].sum()) for begin, end in pairwise(rows.tolist())]
                speed, change = differences(np.array(seconds), q[rows])
                assert np.abs(speed).max() <= 2.0, seed
                assert np.abs(change).max() <= 5.0, seed


@pytest.mark.parametrize(("over", "total"), [(1.01, 1.01), (1.1, 1.0134)])
def test_a_limit_that_is_exceeded_clearly_slows_down_only_where_it_is(over: float, total: float) -> None:
    times = np.linspace(0.0, 5.0, 501)
    knots = [0.0, 0.2, 2.0, 2.2, 2.7, 2.9, 4.8, 5.0]
    speed = np.interp(times, knots, [0.0, 0.5, 0.5, 1.0, 1.0, 0.5, 0.5, 0.0])
    q = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(times))))[:, None]
    found = retime(robot(1.0 / over, 50.0), times, q, uncut(times))
    assert found.lasting.sum() == pytest.approx(total * times[-1], rel=0.003)
    assert found.share[250] == pytest.approx(1.0 / over, abs=0.01)
    assert (found.share[50:150] < 0.995).all() == (over < 1.02)  # what is exceeded by little is slowed down evenly


def test_a_run_takes_as_long_alone_as_among_others() -> None:
    times, q = trapezoid(2.0, 1.0, 10.0)
    both, turned = np.concatenate((times, times[-1] + 0.3 + times)), np.concatenate((q, q[-1] - q))
    arm = robot(0.7, 3.0)
    alone, twice = retime(arm, times, q, uncut(times)).lasting, retime(arm, both, turned, uncut(both)).lasting
    np.testing.assert_allclose(twice[: len(alone)], alone, rtol=1e-9)
    np.testing.assert_allclose(twice[-len(alone) :], alone, rtol=1e-9)
