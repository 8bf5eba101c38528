import math
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from programs.timing.drive import Lane, Ramp, drive

FAST = 1e9
LANE = Lane(100.0, False, 100.0, Ramp(500.0), FAST)


def test_a_line_from_rest_to_rest_takes_its_plateau_and_two_ramps() -> None:
    (done,) = drive([LANE], 10)
    assert done.duration_s == pytest.approx(100.0 / 100.0 + 100.0 / 500.0)
    assert done.second_at(0.5) == pytest.approx(0.5 * done.duration_s)
    assert done.way_at(0.5 * done.duration_s) == pytest.approx(50.0)


def test_a_line_that_goes_straight_on_may_be_divided_without_loss() -> None:
    parts = drive([replace(LANE, length=10.0)] * 10, 10)
    assert sum(part.duration_s for part in parts) == pytest.approx(drive([LANE], 10)[0].duration_s)


def test_a_controller_that_sees_one_line_ahead_can_stop_within_it() -> None:
    parts = drive([replace(LANE, length=1.0)] * 100, 1)
    assert max(part.begin for part in parts) == pytest.approx((2.0 * 500.0 * 1.0) ** 0.5)
    assert sum(part.duration_s for part in parts) > 2.0 * drive([LANE], 1)[0].duration_s


def test_a_corner_slows_down_both_its_lines() -> None:
    before, after = drive([replace(LANE, leave=20.0), LANE], 10)
    assert before.end == after.begin == 20.0
    assert before.duration_s == pytest.approx(after.duration_s)
    # 10 mm of speeding up, 9.6 mm of slowing down to 20 mm/s, 80.4 mm between.
    assert before.duration_s == pytest.approx(0.2 + 0.804 + 0.16)


def test_a_turn_on_the_spot_takes_no_speed_along() -> None:
    turn = Lane(90.0, True, 180.0, Ramp(1800.0), FAST)
    parts = drive([LANE, turn, LANE], 10)
    assert [part.end for part in parts] == [0.0, 0.0, 0.0]
    assert parts[1].duration_s == pytest.approx(90.0 / 180.0 + 180.0 / 1800.0)


def test_a_stop_takes_the_time_to_settle() -> None:
    stops = replace(LANE, leave=0.0, rest_s=0.05)
    assert drive([stops, LANE], 10)[0].duration_s == pytest.approx(1.25)
    assert drive([stops, LANE], 10)[0].second_at(1.0) == pytest.approx(1.2)


LANES = st.lists(
    st.builds(
        Lane,
        st.floats(0.01, 50.0),
        st.booleans(),
        st.floats(5.0, 200.0),
        st.builds(Ramp, st.floats(200.0, 4000.0), st.sampled_from((0.0, 0.03))),
        st.floats(0.0, 200.0),
    ),
    min_size=1,
    max_size=12,
)


@pytest.mark.slow
@given(LANES, st.integers(1, 6))
def test_speeds_join_and_keep_to_all_limits(lanes: list[Lane], look_ahead: int) -> None:
    done = drive(lanes, look_ahead)
    assert done[0].begin == done[-1].end == 0.0
    assert all(one.end == other.begin for one, other in pairwise(done))
    for each in done:
        assert each.peak <= each.lane.top * (1.0 + 1e-9)
        assert each.end <= each.lane.leave
        ramps = each.lane.ramp.length(each.begin, each.peak) + each.lane.ramp.length(each.peak, each.end)
        assert ramps <= each.lane.length * (1.0 + 1e-6) + 1e-6
        assert each.duration_s >= each.lane.length / each.lane.top * (1.0 - 1e-9)
        assert each.second_at(1.0) == pytest.approx(each.moving_s)
        times = [each.second_at(0.1 * tenth) for tenth in range(11)]
        assert times == sorted(times)
        for share, seconds in zip(range(11), times, strict=True):
            assert each.way_at(seconds) == pytest.approx(0.1 * share * each.lane.length, rel=1e-6, abs=1e-6)


@pytest.mark.slow
@given(LANES)
def test_a_longer_look_ahead_is_never_slower(lanes: list[Lane]) -> None:
    near, far = (sum(each.duration_s for each in drive(lanes, ahead)) for ahead in (1, 20))
    assert far <= near * (1.0 + 1e-6)


SPEEDS = st.floats(0.0, 300.0)
RAMPS = st.builds(Ramp, st.floats(100.0, 5000.0), st.sampled_from((0.0, 0.02, 0.1)))


def test_a_change_of_speed_takes_its_size_over_the_acceleration() -> None:
    assert Ramp(500.0).duration(-100.0) == pytest.approx(0.2)
    assert Ramp(500.0).length(0.0, 100.0) == pytest.approx(10.0)


def test_an_acceleration_that_builds_up_adds_the_time_of_that() -> None:
    assert Ramp(500.0, 0.1).duration(100.0) == pytest.approx(0.3)
    # 10 mm/s need less than the whole acceleration: the jerk is 5000 mm/s3, and 2 sqrt(10 / 5000) s pass.
    assert Ramp(500.0, 0.1).duration(10.0) == pytest.approx(2.0 * math.sqrt(10.0 / 5000.0))


@given(RAMPS, SPEEDS, st.floats(0.01, 100.0))
def test_what_is_reached_needs_the_whole_way(ramp: Ramp, begin: float, length: float) -> None:
    end = ramp.reach(begin, length)
    assert end >= begin
    assert ramp.length(begin, end) == pytest.approx(length, rel=1e-6, abs=1e-6)


@given(RAMPS, SPEEDS, st.floats(0.01, 100.0), st.floats(1.0, 400.0))
def test_both_ramps_of_a_peak_fit_the_way(ramp: Ramp, begin: float, length: float, top: float) -> None:
    begin, end = min(begin, top), 0.5 * min(begin, top)
    if ramp.length(begin, end) > length:
        return
    peak = ramp.peak(begin, end, length, top)
    needed = ramp.length(begin, peak) + ramp.length(peak, end)
    assert needed <= length * (1.0 + 1e-6) + 1e-6
    assert peak == pytest.approx(top) or needed == pytest.approx(length, rel=1e-6, abs=1e-6)
