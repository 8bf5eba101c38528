import numpy as np
import pytest
from placed_parts import dome, lance_cell

from robotcell.placement.criteria import PlacementGoal
from robotcell.placement.optimise import find_placements
from robotcell.placement.search_space import Spots
from robotcell.placement.surrogate import Surrogate, embed

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


def fitted(clear: bool = True) -> tuple[Spots, Surrogate]:
    spots = drawn(150, 1)
    flags = np.full(len(spots), clear)
    return spots, Surrogate(spots, flags, [values(spots)], WEIGHT, PlacementGoal(criterion="mean"))


def test_values_are_predicted_between_known_places_and_negative_beyond_reach() -> None:
    others = drawn(200, 2)
    expected = values(others)
    predicted = fitted()[1].predict(others)
    reached = expected.min(axis=1) > 0.1
    assert 50 < reached.sum() < 150
    np.testing.assert_allclose(predicted[reached], expected[reached].mean(axis=1), atol=0.02)
    assert fitted()[1].predict(np.array([[0.9, 0.0, 0.0, 0.0]]))[0] < 0.0


def test_the_most_promising_are_new_apart_and_not_where_something_collides() -> None:
    known, surrogate = fitted()
    others = drawn(300, 3)
    found = surrogate.most_promising(others, 4e-3, 0.01, 5)
    points = embed(found)
    assert len(found) == 5
    assert np.linalg.norm(points[:, None] - embed(known)[None], axis=2).min() > 4e-3
    assert np.linalg.norm(points[:, None] - points[None], axis=2)[~np.eye(5, dtype=bool)].min() > 0.01
    assert (np.diff(surrogate.predict(found)) <= 0.0).all()
    away = fitted(clear=False)[1].most_promising(others, 4e-3, 0.01, 5)
    assert np.linalg.norm(embed(away)[:, None] - embed(known)[None], axis=2).min() > 0.02  # all of them collide


def test_nothing_is_predicted_from_too_few_places() -> None:
    spots = drawn(5, 1)
    surrogate = Surrogate(spots, np.ones(5, dtype=np.bool_), [values(spots)], WEIGHT, PlacementGoal())
    assert len(surrogate.most_promising(drawn(9, 2), 0.0, 0.0, 3)) == 0


@pytest.mark.slow
def test_the_narrow_peaks_of_a_steep_dome_are_found() -> None:
    """A search of random directions alone ended at 0.0275 with this seed; a dense search finds 0.0282."""
    goal = PlacementGoal(distance=(0.15, 0.95), seed=5)
    found = find_placements(lance_cell(0.1, "ur5e"), dome(0.12, 80, np.radians(60)), goal)[0]
    assert found.value >= 0.99 * 0.02822
