import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_plans import LIMITS, leaning, plan_of, random_plan, spray

from rulesengine.timing.corner_blending import round_corners
from rulesengine.timing.limit_intervals import FREE, Pace
from rulesengine.timing.time_plan import chain_of, parametrise, time_path


def pace(*stretches: tuple[float, float, float, float]) -> Pace:
    """Stretches from, to, speed at the begin, speed at the end."""
    begin, end, first, last = np.array(stretches).T
    return Pace(begin, end, first**2, last**2)


def test_a_line_at_half_the_speed_takes_what_the_closed_form_gives() -> None:
    plan = plan_of(spray([[0, 0, 50], [100, 0, 50]], 60.0))
    path = round_corners(chain_of(plan), LIMITS)
    profile = parametrise(path, LIMITS, pace((0.0, 100.0, 30.0, 30.0)))
    assert profile.durations().sum() == pytest.approx(100.0 / 30.0 + 30.0 / LIMITS.acceleration_mm_s2)


def test_a_pace_that_rises_from_rest_is_followed() -> None:
    # x = 2 u s with u = 40 mm/s2, over the first 20 mm, and down again over the last 20 mm.
    plan = plan_of(spray([[0, 0, 50], [40, 0, 50]], 60.0))
    path = round_corners(chain_of(plan), LIMITS)
    top = np.sqrt(2.0 * 40.0 * 20.0)
    profile = parametrise(path, LIMITS, pace((0.0, 20.0, 0.0, top), (20.0, 40.0, top, 0.0)))
    assert profile.durations().sum() == pytest.approx(2.0 * np.sqrt(2.0 * 20.0 / 40.0), rel=1e-6)
    assert np.abs(profile.accelerations()) == pytest.approx(40.0)


def test_a_turn_on_the_spot_keeps_to_its_pace() -> None:
    plan = plan_of(spray([[0, 0, 50]] * 2, axes=leaning([0.0, 1.0], 0.5)))
    path = round_corners(chain_of(plan), LIMITS)
    length = path.length
    profile = parametrise(path, LIMITS, pace((0.0, 0.5 * length, 0.0, 0.3), (0.5 * length, length, 0.3, 0.0)))
    assert profile.durations().sum() == pytest.approx(2.0 * length / 0.3, rel=1e-6)


@pytest.mark.slow
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=15)
def test_no_plan_is_faster_than_its_pace_nor_than_its_limits(seed: int) -> None:
    plan = random_plan(seed, 5)
    path = round_corners(chain_of(plan), LIMITS)
    rng = np.random.default_rng(seed)
    borders = np.sort(rng.uniform(0.0, path.length, 9))
    speeds = rng.uniform(0.5, 80.0, 9)
    given_pace = Pace(borders[:-1:2], borders[1::2], speeds[:-1:2] ** 2, speeds[1::2] ** 2)
    free, bounded = parametrise(path, LIMITS), parametrise(path, LIMITS, given_pace)
    assert bounded.durations().sum() >= free.durations().sum() * (1.0 - 1e-3)  # grids differ
    for at, squared in (
        (bounded.stages.start, bounded.begin),
        (bounded.stages.start + bounded.stages.length, bounded.end),
    ):
        which = np.clip(np.searchsorted(given_pace.begin, at, side="right") - 1, 0, None)
        inside = (given_pace.begin[which] < at - 1e-6) & (at + 1e-6 < given_pace.end[which])
        share = (at - given_pace.begin[which]) / (given_pace.end[which] - given_pace.begin[which])
        highest = given_pace.first[which] + share * (given_pace.last[which] - given_pace.first[which])
        assert np.all(squared[inside] <= highest[inside] * (1.0 + 1e-6) + 1e-6)


def test_the_lower_of_two_paces_holds() -> None:
    both = pace((0.0, 10.0, 5.0, 5.0)).within(pace((5.0, 20.0, 3.0, 9.0)))
    crossed = 5.0 + 15.0 * 16.0 / 72.0
    assert both.begin == pytest.approx(np.array([0.0, 5.0, crossed, 10.0]))
    assert both.end == pytest.approx(np.array([5.0, crossed, 10.0, 20.0]))
    assert both.first == pytest.approx(np.array([25.0, 9.0, 25.0, 33.0]))
    assert both.last == pytest.approx(np.array([25.0, 25.0, 25.0, 81.0]))
    assert FREE.within(FREE) is FREE


def test_paces_that_cross_leave_no_rest_between_them() -> None:
    both = pace((0.0, 10.0, 0.0, 10.0)).within(pace((0.0, 10.0, 10.0, 0.0)))
    assert both.end.tolist() == [5.0, 10.0]
    assert both.first.tolist() == [0.0, 50.0]
    assert both.last.tolist() == [50.0, 0.0]


def test_a_free_pace_changes_nothing() -> None:
    plan = random_plan(3, 6)
    far = pace((0.0, 1e6, 1e4, 1e4))
    assert time_path(plan, LIMITS).program.totals == time_path(plan, LIMITS, FREE).program.totals
    assert time_path(plan, LIMITS, far).program.totals.duration_s == pytest.approx(
        time_path(plan, LIMITS).program.totals.duration_s, abs=2e-3
    )
