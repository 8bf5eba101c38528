import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from programs.timing.ramps import Ramp

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
