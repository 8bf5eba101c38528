"""Linear programs of dwell times: optimal by proof, whatever cells they begin with."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.sparse import csr_array

from geometry.coverage.dwell import TOLERANCE, Unknowns, even_film, keep_acceleration, least_time
from geometry.coverage.time_bound import least_time_bound, times_of_few_groups


def free(count, least=0.1, most=100.0):
    return Unknowns(
        np.ones(count),
        np.full(count, least),
        np.full(count, most),
        np.zeros((0, 2), np.int64),
        np.zeros(0),
        np.zeros(0),
    )


def random_rates(seed, cells, segments):
    """Each segment sprays a bell of cells about its own place, of a strength of its own."""
    rng = np.random.default_rng(seed)
    place, middle = np.linspace(0, 1, cells)[:, None], np.linspace(-0.05, 1.05, segments)
    bells = np.maximum(1 - ((place - middle) * segments / 3) ** 2, 0) * rng.uniform(0.5, 2.0, segments)
    return csr_array(bells * rng.uniform(0.8, 1.2, (cells, 1)))


def test_two_segments_that_share_a_cell() -> None:
    rates = csr_array(np.array([[1.0, 0.0], [1.0, 2.0], [0.0, 1.0]]))
    found = least_time(rates, np.array([3.0, 9.0, 1.0]), free(2))
    assert found.values == pytest.approx([3.0, 3.0], rel=1e-4)
    assert found.value == pytest.approx(6.0, rel=1e-4)
    assert found.gap < 1e-4


def test_a_film_that_can_be_even_is_even() -> None:
    rates = csr_array(np.array([[2.0, 0.0], [0.0, 5.0]]))
    found = even_film(rates, np.array([40.0, 40.0]), free(2))
    assert found.values == pytest.approx([20.0, 8.0])
    assert found.value == pytest.approx(0.0, abs=1e-6)


def test_the_greatest_deviation_is_halved_between_two_that_disagree() -> None:
    rates = csr_array(np.array([[1.0], [2.0]]))
    found = even_film(rates, np.array([10.0, 10.0]), free(1))
    assert found.value == pytest.approx(1 / 3)
    assert found.bound == pytest.approx(1 / 3)


def test_what_is_there_already_counts() -> None:
    """10 of 40 and 50 of 40 are there: the second cell is a quarter off whatever comes, and the first need not be."""
    rates = csr_array(np.array([[2.0, 0.0], [0.0, 5.0]]))
    found = even_film(rates, np.array([40.0, 40.0]), free(2, least=0.0), np.array([10.0, 50.0]))
    assert found.value == pytest.approx(0.25, abs=1e-6)
    assert found.bound == pytest.approx(0.25, abs=1e-6)
    assert found.values[0] == pytest.approx(15.0, abs=5.1)
    assert found.values[1] == pytest.approx(0.0, abs=1e-4)


def test_a_cell_that_cannot_get_enough_gets_all_there_is() -> None:
    rates = csr_array(np.array([[1.0, 0.0], [0.0, 0.01]]))
    found = least_time(rates, np.array([3.0, 9.0]), free(2, most=10.0))
    assert found.short.tolist() == [1]
    assert found.values == pytest.approx([3.0, 10.0], rel=1e-3)


def test_neighbours_keep_to_their_change() -> None:
    pairs = np.array([[1, 0], [2, 1]])
    unknowns = Unknowns(np.ones(3), np.full(3, 0.1), np.full(3, 50.0), pairs, np.ones(2), np.full(2, 2.0))
    found = least_time(csr_array(np.eye(3)), np.array([10.0, 1.0, 1.0]), unknowns)
    assert found.values == pytest.approx([10.0, 8.0, 6.0], rel=1e-3)


def test_speeds_of_neighbours_keep_to_the_acceleration_and_use_it() -> None:
    """From 10 mm/s at 500 mm/s² 100.5 mm/s are reached after 10 mm; tangents elsewhere allow less, never more."""
    unknowns, required = free(2, least=1e-3, most=1.0), np.array([0.1, 1e-3])
    paces = np.array([0.1, 0.1])
    for _ in range(3):
        near = keep_acceleration(unknowns, paces, np.array([[0, 1]]), np.array([10.0]), 500.0)
        slower, paces = paces, least_time(csr_array(np.eye(2)), required, near).values
        assert (1 / paces[1]) ** 2 - (1 / paces[0]) ** 2 <= 2 * 500 * 10 * (1 + 1e-6)
        assert paces.sum() <= slower.sum() * (1 + 1e-6)
    assert 1 / paces == pytest.approx([10.0, np.sqrt(100 + 2 * 500 * 10)], rel=1e-3)


@pytest.mark.slow
@settings(max_examples=6, derandomize=True)  # of random rates the interior point does not always end: seed 3289
@given(seed=st.integers(0, 10_000), goal=st.sampled_from(["least", "even"]))
def test_the_optimum_is_that_of_one_program_over_all_rows(seed, goal) -> None:
    """More cells than the first program has; compared with one program over all of them."""
    cells, segments = 3000, 20
    rates, q = random_rates(seed, cells, segments), np.full(cells, 5.0)
    unknowns = free(segments)
    dense = rates.toarray()
    bounds = [(0.1, 100.0)] * segments
    if goal == "least":
        found = least_time(rates, q, unknowns)
        whole = linprog(np.ones(segments), A_ub=-dense, b_ub=-q, bounds=bounds).fun
        assert (rates @ found.values).min() >= 5.0 * (1 - 2 * TOLERANCE)
    else:
        found = even_film(rates, q, unknowns)
        one = -np.ones((cells, 1))
        both = np.vstack([np.hstack([dense / 5, one]), np.hstack([-dense / 5, one])])
        limits = np.concatenate([np.ones(cells), -np.ones(cells)])
        whole = linprog(np.append(np.zeros(segments), 1), A_ub=both, b_ub=limits, bounds=[*bounds, (0, None)]).fun
        assert np.abs(rates @ found.values / 5 - 1).max() == pytest.approx(found.value)
    assert found.value == pytest.approx(whole, rel=1e-3)
    assert found.bound <= whole * (1 + 1e-7)
    assert found.gap < 1e-3
    assert (found.rows < cells) == (goal == "least")


def test_the_bound_to_the_time_is_just_below_the_optimum_of_another_solver() -> None:
    rng = np.random.default_rng(4)
    for cells, segments in ((40, 12), (400, 150), (300, 500)):
        dense = rng.uniform(0.1, 1.0, (cells, segments)) * (rng.uniform(size=(cells, segments)) < 0.06)
        dense[np.arange(cells), rng.integers(0, segments, cells)] = 1.0
        required = rng.uniform(0.5, 2.0, cells)
        optimum = linprog(np.ones(segments), A_ub=-dense, b_ub=-required).fun
        bound = least_time_bound(csr_array(dense), required)
        assert 0.995 * optimum < bound <= optimum * (1 + 1e-9)


def test_a_bound_by_columns_is_that_of_all_columns_and_never_above_the_optimum() -> None:
    """Discs over a square: poses on a fine grid, of which the first program has few."""
    places = np.stack(np.meshgrid(np.arange(0, 60, 2.0), np.arange(0, 40, 2.0)), -1).reshape(-1, 2)
    poses = np.stack(np.meshgrid(np.arange(0, 60, 1.5), np.arange(0, 40, 1.5)), -1).reshape(-1, 2)
    dense = (np.linalg.norm(places[:, None] - poses[None], axis=2) <= 9.0).astype(np.float64)
    first = np.flatnonzero((poses % 4.5 == 0).all(axis=1))
    required = np.ones(len(places))
    assert (dense[:, first].max(axis=1) == 1.0).all()
    optimum = linprog(np.ones(len(poses)), A_ub=-dense, b_ub=-required, method="highs").fun
    of_few = linprog(np.ones(len(first)), A_ub=-dense[:, first], b_ub=-required, method="highs").fun
    bound = least_time_bound(csr_array(dense), required, first)
    assert of_few > 1.02 * optimum
    assert 0.988 * optimum <= bound <= optimum * (1 + 1e-6)


@pytest.mark.slow
def test_few_groups_hold_nearly_as_quickly_as_all() -> None:
    """Lines 1 apart over a strip 60 wide, each holding 8 to either side: all of them are no better than a few."""
    places, lines = np.linspace(0, 60, 241)[:, None], np.arange(0.0, 61.0)
    rates = csr_array(np.sqrt(np.maximum(64.0 - (places - lines) ** 2, 0.0)) / 8.0)
    required, group = np.ones(241), np.arange(61)
    times = times_of_few_groups(rates, required, group, np.zeros(61), 0.4)
    assert np.count_nonzero(times) <= 10
    assert (rates @ times).min() >= 0.97
    free_s = least_time(rates, required, free(61, least=0.0)).value
    assert times.sum() <= 1.25 * free_s
    alone = times_of_few_groups(rates, required, group, np.zeros(61), 1e-6)
    assert alone.sum() <= 1.02 * free_s


def test_a_group_whose_least_time_is_long_is_left_out() -> None:
    """Two groups of equal use: the one that cannot be gone through in the time that is needed goes."""
    rates = csr_array(np.array([[1.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, 1.0]]))
    least = np.array([6.0, 6.0, 0.1, 0.1])
    times = times_of_few_groups(rates, np.ones(2), np.array([0, 0, 1, 1]), least, 0.1)
    assert times[:2].sum() == 0.0
    assert times[2:] == pytest.approx([1.0, 1.0], abs=0.02)
