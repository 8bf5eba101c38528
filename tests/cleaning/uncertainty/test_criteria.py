"""What rules ask of a gap: numbers by hand, each limit kept at its bound and broken just beyond, repeats, no rinse."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cleaning_report import small_report
from small_sprays import samples_of, stage_of

from cleaning.parameters.load import load_parameters
from cleaning.uncertainty.criteria import GapNumbers, criteria_of
from cleaning.verdicts import rules

PARAMETERS = load_parameters()
LIMITS = PARAMETERS.limits
GOOD = GapNumbers(
    residue=LIMITS.gap_marginal,
    worst=LIMITS.pocket,
    washed=12.0,
    rinsed=LIMITS.exchanges,
    margin_pa=0.0,
    weak_share=LIMITS.weak_share,
)
FILL = np.nextafter(PARAMETERS.gap.plugged, 0.0)


def broken(numbers, fill=FILL, needed=12.0):
    return [each.rule for each in criteria_of(numbers, fill, needed, PARAMETERS) if not each.kept]


def test_every_limit_itself_is_kept():
    assert broken(GOOD) == []


@pytest.mark.parametrize(
    ("changes", "rule"),
    [
        ({"margin_pa": -1e-9}, rules.DRY_GAP),
        ({"washed": 11.999}, rules.NOT_FLUSHED),
        ({"weak_share": 1.001 * LIMITS.weak_share}, rules.ONE_SIDED),
        ({"residue": 1.001 * LIMITS.gap_marginal}, rules.RESIDUE_LEFT),
        ({"worst": 1.001 * LIMITS.pocket}, rules.RESIDUE_LEFT),
        ({"rinsed": 0.999 * LIMITS.exchanges}, rules.INCOMPLETE_RINSE),
    ],
)
def test_one_number_beyond_its_limit_breaks_one_rule(changes, rule):
    assert broken(GOOD._replace(**changes)) == [rule]


def test_a_gap_is_plugged_from_its_limit_on_and_dry_before_all():
    assert broken(GOOD, PARAMETERS.gap.plugged) == [rules.PLUGGED_GAP]
    worst = GapNumbers(1.0, 1.0, 0.0, 0.0, -5.0, 1.0)
    assert broken(worst, 1.0) == [
        rules.DRY_GAP, rules.PLUGGED_GAP, rules.NOT_FLUSHED, rules.ONE_SIDED, rules.RESIDUE_LEFT, rules.INCOMPLETE_RINSE
    ]  # fmt: skip


def test_the_room_is_how_many_times_a_number_is_on_the_good_side():
    numbers = GOOD._replace(washed=30.0, weak_share=LIMITS.weak_share / 4, rinsed=2 * LIMITS.exchanges)
    rooms = {each.rule: each.room for each in criteria_of(numbers, 0.1, 12.0, PARAMETERS) if each.room is not None}
    assert rooms == {rules.NOT_FLUSHED: 2.5, rules.ONE_SIDED: pytest.approx(4.0), rules.INCOMPLETE_RINSE: 2.0}
    unflushed = criteria_of(numbers._replace(weak_share=0.0, rinsed=math.nan), 0.1, 0.0, PARAMETERS)
    assert {each.rule: each.room for each in unflushed if each.room is not None} == {rules.ONE_SIDED: math.inf}
    assert all(each.kept for each in unflushed), "nothing rinses: that is judged of the process as a whole"


def gap_in(*stages):
    """A gap of the small report that a stage of each use acts on, with its numbers; ``None`` does not act."""
    gap = next(part.gaps[0] for part in small_report().parts if part.gaps)
    acts = next(each for each in gap.stages if each is not None)
    found, acting = [], []
    for use, repeats, changes in stages:
        found.append(replace(stage_of(samples_of([[0.0, 0.0, 50.0]]), use=use), repeats=repeats))
        acting.append(None if changes is None else replace(acts, **changes))
    return GapNumbers.of(replace(gap, stages=tuple(acting)), found)


def test_the_numbers_of_a_gap_by_hand():
    """Washes count once, rinses as often as they may be repeated; the best wash decides on entry and on weak flow."""
    wet = {"entered": True, "margin_pa": 40.0, "exchanges": 3.0, "weak_share": 0.5}
    found = gap_in(
        ("wash", 4, wet),
        ("wash", 1, {"entered": False, "margin_pa": 90.0, "exchanges": 0.5, "weak_share": 0.2}),
        ("rinse", 1, {"exchanges": 2.0}),
        ("rinse", 3, {"exchanges": 1.5}),
        ("rinse", 7, None),
        ("dry", 1, None),
    )
    assert found[2:] == (3.5, 6.5, 40.0, 0.2)
    dry = gap_in(("wash", 1, {"entered": False, "margin_pa": 90.0, "exchanges": 0.0, "weak_share": 1.0}))
    assert dry.margin_pa == -1.0, "no film reaches its edges"
    assert math.isnan(dry.rinsed)
    lacking = gap_in(("wash", 1, {"entered": False, "margin_pa": -30.0, "exchanges": 0.0, "weak_share": 1.0}))
    assert lacking.margin_pa == -30.0
    nothing = gap_in(("wash", 1, None), ("rinse", 2, None))
    assert (nothing.washed, nothing.margin_pa, nothing.weak_share) == (0, 0.0, 0.0)
