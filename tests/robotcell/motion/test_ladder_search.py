import itertools

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from robotcell.motion.ladder_search import (
    DISCONTINUITY_COST_S,
    FOLLOW,
    MAY_RECONFIGURE,
    MUST_RECONFIGURE,
    JointSpeeds,
    Ladder,
    Steps,
    cheapest,
)

NEVER = np.zeros((0, 2), dtype=np.int64)


def ladder(rows: list[list[float]], costs: list[list[float]] | None = None) -> Ladder:
    """States of one joint."""
    first = np.concatenate(([0], np.cumsum([len(row) for row in rows])))
    q = np.array([value for row in rows for value in row])[:, None]
    cost = np.zeros(len(q)) if costs is None else np.array([value for row in costs for value in row])
    return Ladder(first, q, np.zeros(len(q)), np.zeros((len(q), 2)), cost)


def steps(count: int, kind: int = FOLLOW, lasting: float = 1.0) -> Steps:
    ones = np.ones(count)
    return Steps(lasting * ones, np.full(count, kind), 0.5 * ones, ones, ones, 0.02 * ones)


def speeds(*, wraps: bool = False) -> JointSpeeds:
    return JointSpeeds(np.array([1.0]), np.array([wraps]), np.array([True]))


def price(table: Ladder, way: tuple[int, ...]) -> float:
    """Cost of a way that tracks the path everywhere."""
    q = table.q[list(way), 0]
    far = np.abs(np.diff(q))
    return float(table.cost[list(way)].sum() + np.sum(far**2 + 4.0 * np.maximum(0.0, far - 0.8)))


@settings(max_examples=30)
@given(seed=st.integers(0, 10_000))
def test_it_finds_what_trying_all_ways_finds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rows = [list(rng.uniform(0.0, 0.45, rng.integers(1, 5))) for _ in range(5)]
    table = ladder(rows, [list(rng.uniform(0.0, 0.2, len(row))) for row in rows])
    found = cheapest(table, steps(4), speeds(), NEVER)
    every = itertools.product(*(range(table.first[node], table.first[node + 1]) for node in range(5)))
    assert price(table, tuple(found.state.tolist())) == min(price(table, way) for way in every)
    assert not found.reconfigurations.any()


def test_a_jump_is_a_reconfiguration_where_allowed_and_a_discontinuity_where_not() -> None:
    table = ladder([[0.0], [2.0]])
    assert cheapest(table, steps(1, MAY_RECONFIGURE), speeds(), NEVER).reconfigurations.all()
    assert not cheapest(table, steps(1, MAY_RECONFIGURE), speeds(), NEVER).discontinuities.any()
    assert cheapest(table, steps(1, FOLLOW), speeds(), NEVER).discontinuities.all()
    assert cheapest(ladder([[0.0], [0.0]]), steps(1, MUST_RECONFIGURE), speeds(), NEVER).reconfigurations.all()


def test_it_reconfigures_early_rather_than_break_the_path_late() -> None:
    table = ladder([[0.0, 3.0], [0.1, 3.1], [0.2, 3.2], [3.3]], [[0.0, 50.0], [0, 0], [0, 0], [0]])
    between = steps(3)._replace(kind=np.array([MAY_RECONFIGURE, FOLLOW, FOLLOW]))
    found = cheapest(table, between, speeds(), NEVER)
    assert found.state.tolist() == [0, 3, 5, 6]
    assert found.reconfigurations.tolist() == [True, False, False]
    assert DISCONTINUITY_COST_S > 50.0


def test_a_joint_that_wraps_goes_the_short_way_round() -> None:
    table = ladder([[3.1], [-3.1]])
    assert not cheapest(table, steps(1), speeds(wraps=True), NEVER).reconfigurations.any()
    assert cheapest(table, steps(1), speeds(), NEVER).discontinuities.all()


def test_a_forbidden_pair_is_not_taken() -> None:
    table = ladder([[0.0], [0.1, 0.3], [0.2]])
    assert cheapest(table, steps(2), speeds(), NEVER).state.tolist() == [0, 1, 3]
    assert cheapest(table, steps(2), speeds(), np.array([[0, 1]])).state.tolist() == [0, 2, 3]


def test_of_equals_the_first_is_taken() -> None:
    table = ladder([[0.0], [0.2, 0.2, 0.2], [0.4, 0.4]])
    assert cheapest(table, steps(2), speeds(), NEVER).state.tolist() == [0, 1, 4]
