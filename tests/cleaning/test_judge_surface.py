import pytest
from judged import case, exposed

from cleaning.case import Reach
from cleaning.verdict import judge_part


def rinsed(low):
    judged = judge_part(case(reached=(Reach("rinse", "rinse", "sequence[1]", 1, exposed(low=low)),)))
    return next(each for each in judged if each.rule == "R2")


@pytest.mark.parametrize("low", [0.0, 6.1e-06, 0.0199])
def test_less_than_a_hundredth_of_the_limit_is_said_the_same_and_without_digits_that_mean_nothing(low):
    judged = rinsed(low)
    assert "gets less than 0.02 mm in rinse (limit 2 mm)" in judged.because
    assert "add a pass from another side" in judged.advice
    assert "slower" not in judged.advice
    assert judged.numbers[0].value == low


def test_more_than_that_is_said_with_its_digits():
    judged = rinsed(0.023)
    assert "gets at most 0.023 mm in rinse" in judged.because
    assert "Go slower or nearer" in judged.advice


def test_a_side_that_is_only_blown_dry_is_told_to_need_a_liquid():
    (judged,) = judge_part(case(reached=()))
    assert judged.advice == "Add a step to the sequence that sprays a liquid, with side: top."
