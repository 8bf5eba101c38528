from unittest.mock import Mock

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_plans import LIMITS, leaning, plan_of, random_plan, spray, transfer

from geometry.arrays import Scalars
from programs.plan import Plan
from recipes.recipe import Limits
from rulesengine.timing import coupled_limits as coupling
from rulesengine.timing.corner_blending import round_corners
from rulesengine.timing.limit_intervals import Profile, cautious
from rulesengine.timing.time_plan import chain_of, parametrise

TURN = np.radians(LIMITS.rotation_acceleration_deg_s2)
seeds = st.integers(0, 2**32 - 1)


def profile_of(plan: Plan, limits: Limits = LIMITS) -> Profile:
    return parametrise(round_corners(chain_of(plan), limits), limits)


def seconds(profile: Profile) -> float:
    return float(profile.durations().sum())


def rest_to_rest(way: float, speed: float, push: float) -> float:
    """Trapezoid, or triangle where the way is too short to get to the speed."""
    return way / speed + speed / push if way >= speed**2 / push else 2.0 * np.sqrt(way / push)


def load(profile: Profile) -> tuple[Scalars, Scalars]:
    """Shares of the acceleration of the orifice and of the nozzle's rotation that each stage uses."""
    stages, push = profile.stages, np.abs(profile.accelerations())
    highest = np.maximum(profile.begin, profile.end)
    moving = np.isfinite(stages.grip)
    orifice = np.hypot(push, stages.curvature * highest)[moving] / stages.grip[moving]
    return orifice, (push * stages.turn + highest * stages.turn_change) / TURN


@given(way=st.floats(1e-3, 500.0), speed=st.floats(0.1, 500.0), push=st.floats(10.0, 5000.0))
@settings(max_examples=60)
def test_a_straight_move_takes_what_the_closed_form_says(way: float, speed: float, push: float) -> None:
    profile = profile_of(plan_of(spray([[0, 0, 50], [way, 0, 50]], speed)), Limits(acceleration_mm_s2=push))
    assert seconds(profile) == pytest.approx(rest_to_rest(way, speed, push), rel=1e-6)


@given(angle=st.floats(0.01, 3.1), tilt=st.floats(0.0, 1.2))
@settings(max_examples=30)
def test_a_turn_on_the_spot_takes_what_the_closed_form_says(angle: float, tilt: float) -> None:
    profile = profile_of(plan_of(spray([[0, 0, 50]] * 2, axes=leaning([0.0, angle], tilt))))
    assert seconds(profile) == pytest.approx(rest_to_rest(angle, np.pi, TURN), rel=1e-6)


@given(way=st.floats(0.05, 200.0), speed=st.floats(5.0, 250.0), run_up=st.floats(0.5, 50.0))
@settings(max_examples=15)
def test_the_closed_form_is_what_toppra_finds(way: float, speed: float, run_up: float) -> None:
    plan = plan_of(
        transfer([[0, 0, 50], [run_up, 0, 50]]),
        spray([[run_up, 0, 50], [run_up + way, 0, 50]], speed),
    )
    ours = profile_of(plan)
    theirs = coupling.parametrise_coupled(ours, TURN)
    assert seconds(ours) == pytest.approx(seconds(theirs), rel=2e-5)
    kinks = np.append(ours.stages.start, run_up + way)
    expected = np.interp(theirs.stages.start, kinks, np.append(ours.begin, 0.0))
    np.testing.assert_allclose(theirs.begin, expected, rtol=1e-4, atol=1e-2)


def test_a_run_up_is_at_the_speed_of_the_pass_when_the_jet_opens() -> None:
    plan = plan_of(transfer([[0, 0, 50], [20, 0, 50]]), spray([[20, 0, 50], [60, 0, 50]], 40.0))
    profile = profile_of(plan)
    at_joint = profile.begin[np.argmin(np.abs(profile.stages.start - 20.0))]
    assert np.sqrt(at_joint) == pytest.approx(40.0)
    assert np.sqrt(profile.begin.max()) > 90.0


def test_twice_as_fast_and_four_times_as_hard_takes_half_as_long() -> None:
    def plan(speed: float) -> Plan:
        return plan_of(spray([[0, 0, 50], [30, 0, 50], [30, 9, 50], [8, 20, 50]], speed, leaning([0, 0.3, 1, 2], 0.5)))

    fast = Limits(blend_mm=0.5, acceleration_mm_s2=2000, rotation_deg_s=360, rotation_acceleration_deg_s2=2880)
    assert seconds(profile_of(plan(120.0), fast)) == pytest.approx(0.5 * seconds(profile_of(plan(60.0))), rel=1e-3)


@pytest.mark.slow
@given(seed=seeds)
@settings(max_examples=12)
def test_any_motion_keeps_to_every_limit_and_rests_at_every_stop(seed: int) -> None:
    profile = profile_of(random_plan(seed, 5))
    stages = profile.stages
    orifice, turning = load(profile)
    long = stages.length > 1e-4  # below, the rounding that makes alike runs alike shows
    assert orifice.max() <= 1.005
    assert turning[long].max() <= 1.005
    assert np.all(np.maximum(profile.begin, profile.end) <= stages.cap * (1.0 + 1e-5))
    assert np.isfinite(seconds(profile))
    border = np.concatenate(([True], np.diff(stages.run) > 0))
    np.testing.assert_allclose(profile.begin[border], 0.0, atol=1e-3)
    np.testing.assert_allclose(profile.end[np.append(border[1:], True)], 0.0, atol=1e-3)
    np.testing.assert_allclose(profile.begin[1:][~border[1:]], profile.end[:-1][~border[1:]], rtol=1e-3, atol=1e-2)


@pytest.mark.slow
@given(seed=seeds)
@settings(max_examples=12)
def test_the_cautious_motion_keeps_to_every_limit_and_is_no_faster(seed: int) -> None:
    fastest = profile_of(random_plan(seed, 5))
    careful = cautious(fastest.stages, TURN)
    orifice, turning = load(careful)
    assert max(orifice.max(), turning.max()) <= 1.0 + 1e-4
    assert seconds(careful) >= seconds(fastest) * (1.0 - 5e-3)


def test_runs_solved_together_are_the_runs_solved_alone() -> None:
    ring = [[20 * np.cos(a), 20 * np.sin(a), 50] for a in np.linspace(0, 6, 40)]
    arch = [[9 * np.cos(a), 5 * np.sin(a), 50] for a in np.linspace(0, 3, 20)]
    both = profile_of(plan_of(spray(ring), transfer([ring[-1], arch[0]]), spray(arch)))
    alone = [profile_of(plan_of(item)) for item in (spray(ring), transfer([ring[-1], arch[0]]), spray(arch))]
    assert seconds(both) == pytest.approx(sum(seconds(profile) for profile in alone), rel=1e-6)


def test_a_curve_is_gone_through_at_constant_speed_where_the_acceleration_allows_it() -> None:
    ring = np.array([[20 * np.cos(a), 20 * np.sin(a), 50] for a in np.linspace(0, 2 * np.pi, 73)])
    profile = profile_of(plan_of(spray(ring, 60.0)))
    inner = (profile.stages.start > 5.0) & (profile.stages.start < 120.0)
    np.testing.assert_allclose(np.sqrt(profile.begin[inner]), 60.0, rtol=1e-4)


def test_where_toppra_gives_up_the_motion_is_cautious(monkeypatch: pytest.MonkeyPatch) -> None:
    ring = np.array([[20 * np.cos(a), 20 * np.sin(a), 50] for a in np.linspace(0, 2 * np.pi, 73)])
    fastest = profile_of(plan_of(spray(ring, 90.0)))

    unsolved = Mock(problem_data=Mock(sd_vec=None))
    monkeypatch.setattr(coupling, "TOPPRA", Mock(return_value=unsolved))
    careful = profile_of(plan_of(spray(ring, 90.0)))
    orifice, turning = load(careful)
    assert max(orifice.max(), turning.max()) <= 1.0 + 1e-4
    assert seconds(fastest) < seconds(careful) < 1.2 * seconds(fastest)


def test_a_run_that_toppra_cannot_solve_is_solved_with_a_little_less_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    ring = np.array([[20 * np.cos(a), 20 * np.sin(a), 50] for a in np.linspace(0, 2 * np.pi, 73)])
    fastest, real = profile_of(plan_of(spray(ring, 90.0))), coupling.TOPPRA
    first = iter([Mock(problem_data=Mock(sd_vec=None))])
    monkeypatch.setattr(coupling, "TOPPRA", lambda *args, **named: next(first, None) or real(*args, **named))
    again = profile_of(plan_of(spray(ring, 90.0)))
    orifice, turning = load(again)
    assert max(orifice.max(), turning.max()) <= 1.0 + 1e-4
    assert seconds(fastest) < seconds(again) < 1.006 * seconds(fastest)
