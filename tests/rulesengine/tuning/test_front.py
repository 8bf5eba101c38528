"""The Pareto front against its definition, over random recipes."""

from hypothesis import given
from hypothesis import strategies as st

from rulesengine.tuning.trial.outcome import Figures
from rulesengine.tuning.trial.request import Trial, pareto_front

SMALL = st.integers(0, 4)
TRIALS = st.lists(st.tuples(SMALL, SMALL, SMALL, SMALL, SMALL), max_size=12).map(
    lambda rows: [
        Trial(f"recipe: r{number}", Figures(clean, unmet, 0.0, float(seconds), float(litres)), margin / 2)
        for number, (seconds, litres, clean, unmet, margin) in enumerate(rows)
    ]
)


def is_better(one, other):
    """The definition, written out: as good in time, liquid and cleanliness, and better in one of them."""
    a, b = one.figures, other.figures
    clean = (
        (a.clean_components, -a.open_requirements, one.margin),
        (b.clean_components, -b.open_requirements, other.margin),
    )
    as_good = a.seconds <= b.seconds and a.litres <= b.litres and clean[0] >= clean[1]
    return as_good and (a.seconds < b.seconds or a.litres < b.litres or clean[0] > clean[1])


@given(TRIALS)
def test_no_recipe_of_the_front_is_dominated_and_every_other_one_is_or_is_its_equal(trials):
    front = pareto_front(trials)
    assert not any(is_better(other, each) for each in front for other in trials)
    places = [(each.figures, each.margin) for each in front]
    for each in trials:
        if each not in front:
            assert any(is_better(one, each) for one in front) or any(
                (one.figures, one.margin) == (each.figures, each.margin) for one in front
            )
    assert len(set(places)) == len(places)
    assert [each.figures.seconds for each in front] == sorted(each.figures.seconds for each in front)


@given(TRIALS, st.randoms())
def test_the_order_of_the_trials_does_not_matter(trials, chance):
    mixed = list(trials)
    chance.shuffle(mixed)
    assert [(each.figures, each.margin) for each in pareto_front(mixed)] == [
        (each.figures, each.margin) for each in pareto_front(trials)
    ]
