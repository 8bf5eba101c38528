import numpy as np
import pytest
from placed_parts import dome, lance_cell

from robotcell.placement.evaluate import PlacementGoal
from robotcell.placement.optimise import find_placements
from robotcell.placement.search_space import Spots, Surrogate, embed

WEIGHT = np.ones(3)


def values(spots: Spots) -> np.ndarray:
    """(n, 3) of targets that are best at one distance and three yaws; beyond reach where that is negative."""
    towards = 1.0 + 0.15 * np.cos(spots[:, 1, None] - np.array([0.0, 2.0, 4.0]))
    squares = towards - 20.0 * (spots[:, :1] - 0.6) ** 2 - 0.75
    return np.where(squares > 0.0, np.sqrt(np.maximum(squares, 0.0)), -np.inf)


def drawn(count: int, seed: int) -> Spots:
    random = np.random.default_rng(seed)
    return np.column_stack(
        [random.uniform(0.5, 0.7, count), random.uniform(-np.pi, np.pi, count), np.zeros((count, 2))]
    )


def fitted(blocked: np.ndarray | None = None) -> tuple[Spots, Surrogate]:
    spots = drawn(150, 1)
    shares = np.full((1, len(spots)), np.nan) if blocked is None else blocked[None]
    return spots, Surrogate(spots, shares, [values(spots)], WEIGHT, PlacementGoal(criterion="mean"))


def test_values_are_predicted_between_known_places_and_negative_beyond_reach() -> None:
    others = drawn(200, 2)
    expected = values(others)
    predicted = fitted()[1].predict(others)
    reached = expected.min(axis=1) > 0.1
    assert 50 < reached.sum() < 150
    np.testing.assert_allclose(predicted[reached], expected[reached].mean(axis=1), atol=0.02)
    assert fitted()[1].predict(np.array([[0.9, 0.0, 0.0, 0.0]]))[0] < 0.0


def test_the_chosen_are_worth_most_new_and_apart() -> None:
    known, surrogate = fitted()
    others = drawn(300, 3)
    found = surrogate.choose(others, surrogate.predict(others), 4e-3, 0.01, 5)
    points = embed(found)
    assert len(found) == 5
    assert np.linalg.norm(points[:, None] - embed(known)[None], axis=2).min() > 4e-3
    assert np.linalg.norm(points[:, None] - points[None], axis=2)[~np.eye(5, dtype=bool)].min() > 0.01
    assert (np.diff(surrogate.predict(found)) <= 0.0).all()


def test_where_a_branch_collides_its_value_is_not_predicted() -> None:
    """Beyond 0.6 m two of three targets collide."""
    known, free = fitted()
    surrogate = fitted(np.where(known[:, 0] > 0.6, 2.0 / 3.0, 0.0))[1]
    others = drawn(300, 3)
    clear, beyond = others[:, 0] < 0.58, others[:, 0] > 0.63
    np.testing.assert_allclose(surrogate.predict(others)[clear], free.predict(others)[clear])
    np.testing.assert_allclose(surrogate.predict(others)[beyond], -1.0 - 2.0 / 3.0, atol=0.25)
    above = float(np.median(free.predict(others)[clear]))
    gain = surrogate.expected_gain(others, above)
    assert (gain[clear & (free.predict(others) < above)] == 0.0).all()
    assert gain[clear].max() > 2.0 * gain[beyond].max() > 0.0  # beyond it is not ruled out


def test_nothing_is_predicted_from_too_few_places() -> None:
    spots = drawn(5, 1)
    surrogate = Surrogate(spots, np.zeros((1, 5)), [values(spots)], WEIGHT, PlacementGoal())
    others = drawn(9, 2)
    assert len(surrogate.choose(others, surrogate.predict(others), 0.0, 0.0, 3)) == 0


@pytest.mark.slow
def test_the_narrow_peaks_of_a_steep_dome_are_found() -> None:
    """A search of random directions alone ended at 0.0275 with this seed; a dense search finds 0.0282."""
    goal = PlacementGoal(distance=(0.15, 0.95), seed=5)
    found = find_placements(lance_cell(0.1, "ur5e"), dome(0.12, 80, np.radians(60)), goal)[0]
    assert found.value >= 0.99 * 0.02822
