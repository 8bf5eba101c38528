"""Pareto front of the recipes that tuning analysed: none is better in time, liquid and cleanliness together."""

from collections.abc import Sequence

from rulesengine.tuning.trial.request import Trial


def cleanliness(trial: Trial) -> tuple[int, int, float]:
    """How clean a recipe is predicted to leave the board: clean components, requirements met, least margin."""
    figures = trial.figures
    return figures.clean_components, -figures.open_requirements, trial.margin


def dominates(one: Trial, other: Trial) -> bool:
    """Whether one recipe takes no more time and liquid and is no less clean, and in one of these is better."""
    costs = [
        (each.figures.seconds, each.figures.litres, tuple(-part for part in cleanliness(each))) for each in (one, other)
    ]
    return costs[0] != costs[1] and all(mine <= theirs for mine, theirs in zip(*costs, strict=True))


def pareto_front(trials: Sequence[Trial]) -> tuple[Trial, ...]:
    """Recipes that no other one dominates, the quickest first; of equal ones the first that was analysed."""
    front: list[Trial] = []
    seen: set[tuple[float, float, tuple[int, int, float]]] = set()
    for trial in trials:
        place = trial.figures.seconds, trial.figures.litres, cleanliness(trial)
        if place not in seen and not any(dominates(other, trial) for other in trials):
            seen.add(place)
            front.append(trial)
    return tuple(sorted(front, key=lambda each: (each.figures.seconds, each.figures.litres)))
