import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_plans import LIMITS, leaning, plan_of, random_plan, spray, transfer

from geometry.frames import rotation_vectors
from recipes.recipe import Limits
from rulesengine.timing.corner_blending import Path, round_corners
from rulesengine.timing.time_plan import chain_of


def path_of(*items: object, limits: Limits = LIMITS) -> Path:
    return round_corners(chain_of(plan_of(*items)), limits)  # type: ignore[arg-type]


@given(bend=st.floats(2.0, 165.0), blend=st.floats(0.05, 3.0), leg=st.floats(1.0, 100.0))
@settings(max_examples=60)
def test_a_corner_is_cut_by_an_arc_within_the_tolerance(bend: float, blend: float, leg: float) -> None:
    heading = np.radians(bend)
    corner = np.array([leg, 0.0, 50.0])
    out = corner + leg * np.array([np.cos(heading), np.sin(heading), 0.0])
    path = path_of(spray([[0.0, 0.0, 50.0], corner, out], 200.0), limits=Limits(blend_mm=blend))
    assert not path.rest[1]
    at = np.linspace(0.0, path.length, 2001)
    points = path.positions(at)
    assert np.linalg.norm(points - corner, axis=1).min() <= blend + 1e-9
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert steps.max() <= at[1] * (1.0 + 1e-9)
    assert steps.sum() == pytest.approx(path.length, rel=1e-3)  # the path parameter is the length of the path
    np.testing.assert_allclose(points[[0, -1]], [[0.0, 0.0, 50.0], out], atol=1e-9)
    middle = path.positions(path.knots[1:2])[0]
    assert np.linalg.norm(middle - corner) == pytest.approx(np.linalg.norm(points - corner, axis=1).min(), rel=1e-2)


def test_direction_is_continuous_round_a_corner_and_bends_by_one_over_the_radius() -> None:
    path = path_of(spray([[0, 0, 50], [20, 0, 50], [20, 20, 50]]))
    at = np.linspace(18.0, 21.0, 3001)
    headings = np.diff(path.positions(at), axis=0) / np.diff(at)[:, None]
    bends = np.linalg.norm(np.diff(headings, axis=0), axis=1) / np.diff(at)[0]
    assert bends.max() == pytest.approx(path.curvature.max(), rel=1e-2)


def test_a_corner_is_rounded_no_wider_than_its_speed_needs() -> None:
    slow = path_of(spray([[0, 0, 50], [20, 0, 50], [20, 20, 50]], 5.0))
    assert 1.0 / slow.curvature.max() == pytest.approx(1.2 * 5.0**2 / 500.0)


@pytest.mark.parametrize(
    ("points", "limits"),
    [
        ([[0, 0, 50], [20, 0, 50], [0, 0, 50]], LIMITS),
        ([[0, 0, 50], [20, 0, 50], [20, 20, 50]], Limits(blend_mm=0)),
    ],
    ids=["reversal", "no blend"],
)
def test_what_cannot_be_rounded_is_a_stop(points: list[list[float]], limits: Limits) -> None:
    path = path_of(spray(points), limits=limits)
    assert path.rest.tolist() == [True, True, True]
    np.testing.assert_allclose(path.positions(path.knots), points)


def test_a_turn_on_the_spot_is_a_stop_and_keeps_its_place() -> None:
    path = path_of(spray([[0, 0, 50], [20, 0, 50], [20, 0, 50], [40, 0, 50]], axes=leaning([0, 0, 1.5, 1.5], 0.4)))
    assert path.rest.tolist() == [True, True, True, True]
    assert path.spin.tolist() == [False, True, False]
    turning = np.linspace(path.knots[1], path.knots[2], 20)
    np.testing.assert_allclose(path.positions(turning), np.tile([20.0, 0.0, 50.0], (20, 1)), atol=1e-12)
    angles = np.linalg.norm(
        rotation_vectors(*(path.orientations(turning)[k] for k in (slice(19), slice(1, 20)))), axis=1
    )
    np.testing.assert_allclose(angles, np.diff(turning), rtol=1e-6)  # the path parameter is the angle


def test_turning_on_about_one_axis_is_one_turn() -> None:
    path = path_of(spray([[0, 0, 50]] * 4 + [[9, 0, 50]], axes=leaning([0, 0.5, 1.0, 1.5, 1.5], 0.4)))
    assert path.rest.tolist() == [True, False, False, True, True]


@pytest.mark.parametrize(("begin", "rests"), [((0, 0, 50), False), ((20, 30, 50), True)])
def test_a_run_up_is_one_run_with_its_pass_only_if_it_leads_straight_in(
    begin: tuple[float, float, float], rests: bool
) -> None:
    path = path_of(transfer([begin, (20, 0, 50)]), spray([[20, 0, 50], [60, 0, 50]]))
    assert bool(path.rest[1]) is rests


def test_a_pause_between_run_up_and_pass_is_a_stop() -> None:
    path = path_of(spray([[0, 0, 50], [20, 0, 50]]), spray([[20, 0, 50], [60, 0, 50]]))
    assert path.rest.tolist() == [True, True, True]


def test_the_orientation_meets_its_vertices_within_the_swing_and_never_jumps() -> None:
    count = 12
    path = path_of(
        spray(np.column_stack((np.arange(count) * 5.0, np.zeros(count), np.full(count, 50.0))),
              axes=leaning([0, 0, 0.1, 0.3, 0.3, 0.3, 0.2, 0.0, 0.0, -0.3, -0.3, -0.3], 0.5))
    )  # fmt: skip
    off = np.linalg.norm(rotation_vectors(path.orientations(path.knots), path.chain.quaternion), axis=1)
    assert off.max() <= np.radians(3.0) + 1e-9
    at = np.linspace(0.0, path.length, 20001)
    turns = path.orientations(at)
    rates = rotation_vectors(turns[:-1], turns[1:]) / at[1]
    jumps = np.linalg.norm(np.diff(rates, axis=0), axis=1)
    assert jumps.max() < 0.01 * np.linalg.norm(path.rate, axis=1).max()


@pytest.mark.slow
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=25)
def test_any_path_is_whole(seed: int) -> None:
    """It never leaves the vertices by more than the blend, and it is as long as its parameter says."""
    chain = chain_of(random_plan(seed, 6))
    path = round_corners(chain, LIMITS)
    off = np.linalg.norm(path.positions(path.knots) - chain.tcp, axis=1)
    assert off.max() <= LIMITS.blend_mm + 1e-9
    assert np.all(np.diff(path.knots) > 0.0)
    at = np.unique(np.concatenate((np.linspace(0.0, path.length, 4001), path.knots)))
    steps = np.linalg.norm(np.diff(path.positions(at), axis=0), axis=1)
    assert np.all(steps <= np.diff(at) * (1.0 + 1e-9) + 1e-9)
    np.testing.assert_allclose(np.linalg.norm(path.orientations(at), axis=1), 1.0, atol=1e-12)
