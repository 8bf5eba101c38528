"""Pareto front of the recipes that tuning analysed: none is better in time, liquid and cleanliness together."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar

from rulesengine.tuning.trial.request import Trial

T = TypeVar("T")


def cleanliness(trial: Trial) -> tuple[int, int, float]:
    """How clean a recipe is predicted to leave the board: clean components, requirements met, least margin."""
    figures = trial.figures
    return figures.clean_components, -figures.open_requirements, trial.margin


def non_dominated(items: Iterable[T], costs: Callable[[T], tuple[Any, ...]]) -> tuple[T, ...]:
    """Items than which no other one is as good in all costs and better in one; of equal ones the first stays.

    Args:
        items: What is compared.
        costs: Gives as many costs of each item; less is better.

    Returns:
        The items by ascending costs.
    """
    front: list[tuple[tuple[Any, ...], T]] = []
    for each in sorted(items, key=costs):  # what dominates an item, or is its equal, comes before it
        mine = costs(each)
        if not any(all(a <= b for a, b in zip(other, mine, strict=True)) for other, _ in front):
            front.append((mine, each))
    return tuple(each for _, each in front)


def pareto_front(trials: Sequence[Trial]) -> tuple[Trial, ...]:
    """Recipes that no other one dominates, the quickest first; of equal ones the first that was analysed."""
    return non_dominated(
        trials,
        lambda each: (each.figures.seconds, each.figures.litres, tuple(-part for part in cleanliness(each))),
    )
