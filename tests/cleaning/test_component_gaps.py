from dataclasses import replace
from itertools import pairwise
from math import log

import numpy as np
import pytest
from analysed import PARAMETERS, board_of, prepared_of
from small_sprays import downward, samples_of, sprayed, stage_of

from cleaning.judge_component import Sprayed, gaps_of
from cleaning.parameters.model import PartOverride
from cleaning.prepared_board import prepare
from specs.source import Source

LINE = samples_of([[x, 20.0, 45.0] for x in range(-10, 45, 5)], downward(20.0, 30.0), seconds=4.0)
WASH = stage_of(LINE)
RINSE = replace(stage_of(LINE, use="rinse"), made_by=Source.parse("sequence[1]"))


def by(stage):
    """A stage that sprays the top; what reaches exposed surfaces does not matter under parts."""
    return Sprayed(stage, sprayed(stage), None)


def gaps(*sprayed_by, prepared=None):
    return gaps_of(prepared or prepared_of(), sprayed_by, lambda *_: None)


def test_each_part_with_a_gap_is_followed_through_every_stage_in_each_of_its_cases():
    found = gaps(by(WASH), by(RINSE))
    assert list(found) == [0, 1]
    for row, beneath in found.items():
        assert beneath.underside.component == prepared_of().board.components[row].name
        assert [gap.gap_height_mm for gap in beneath.gaps] == [case.gap_height_mm for case in beneath.underside.cases]
        for gap in beneath.gaps:
            assert all(act is not None and act.entered for act in gap.stages)
            np.testing.assert_array_less(gap.stages[1].residue, gap.stages[0].residue + 1e-9)
            assert 0 < gap.residue < 1


def test_gaps_are_found_by_the_place_of_their_part_on_the_board():
    prepared = prepared_of(("J1", "C1", "U1"))
    found = gaps(by(WASH), prepared=prepared)
    names = [component.name for component in prepared.board.components]
    assert {names[row]: beneath.underside.component for row, beneath in found.items()} == {"C1": "C1", "U1": "U1"}


def test_the_lower_case_comes_first():
    for beneath in gaps(by(WASH)).values():
        standoffs = [gap.gap_height_mm for gap in beneath.gaps]
        assert standoffs == sorted(standoffs)
        assert len(standoffs) == 2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("factor", "change"),
    [
        ("temperature", {"temperature_c": 1.05 * WASH.temperature_c}),
        ("chemistry", {"liquid": WASH.liquid.model_copy(update={"concentration_pct": 15.75})}),
        ("pressure", {"pressure_pa": 1.05 * WASH.pressure_pa}),
    ],
)
def test_what_limits_is_what_an_analysis_of_the_changed_stage_would_tell(factor, change):
    before, after = gaps(by(WASH)), gaps(by(replace(WASH, **change)))
    for row, beneath in before.items():
        wanted = log(after[row].gaps[0].residue / beneath.gaps[0].residue) / log(1.05)
        assert beneath.elasticity[factor] == pytest.approx(wanted, rel=1e-3, abs=1e-6)
        assert set(beneath.elasticity) == {"time", "temperature", "chemistry", "pressure", "standoff"}
        assert wanted < 0


def test_more_time_leaves_less():
    assert all(beneath.elasticity["time"] < 0 for beneath in gaps(by(WASH)).values())


def test_a_stage_on_the_other_side_does_not_act():
    prepared = prepared_of(("U1", "C2"), ("C2",))
    found = gaps(by(WASH), prepared=prepared)
    assert found[0].gaps[0].residue < 1
    assert all(gap.stages == (None,) and gap.residue == 1.0 for gap in found[1].gaps)
    assert not any(found[1].elasticity.values())


def test_stated_venting_leaves_less_in_the_gap():
    vented = PARAMETERS.model_copy(update={"parts": [PartOverride(match=["U1"], paste_factor=0.5)]})
    prepared = prepare(board_of("U1", "C1", "J1"), vented, lambda *_: None)
    usual, found = gaps(by(WASH)), gaps(by(WASH), prepared=prepared)
    assert found[0].gaps[0].fill == pytest.approx(0.5 * usual[0].gaps[0].fill)
    assert found[1].gaps[0].fill == usual[1].gaps[0].fill


def test_progress_goes_on_and_nothing_beneath_is_no_trouble():
    told = []
    gaps_of(prepared_of(), [by(WASH)], lambda _, done: told.append(done))
    assert told[0] == 0.0
    assert all(before <= after for before, after in pairwise(told))
    assert told[-1] <= 1.0
    assert gaps(by(WASH), prepared=prepared_of(())) == {}
