from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from analysed import PARAMETERS, bodies_of, prepared_of
from hostile import at, body
from small_sprays import downward, samples_of, sprayed, stage_of

from boards.understand import understand
from cleaning.exposure.exposure import expose
from cleaning.judge_component import Sprayed, bare_part, component_part, gaps_of, spraying_of
from cleaning.parameters.model import PartOverride
from cleaning.prepared_board import prepare
from recipes.classes import Mask, match_masks

LINES = np.array([[x, y, 45.0] for y in (0.0, 12.0, 24.0, 36.0) for x in range(-40, 90, 2)])
BOTH = prepared_of(("U1", "J1", "C2"), ("C2",))
NO_MASKS = match_masks([], {})


def spraying(prepared, use="wash", up=1.0, tcp=LINES, axes=None, **samples):
    """A stage from one side and what it leaves."""
    flip = np.diag([1.0, up, up])
    axes = downward() if axes is None else axes
    height = 0.0 if up > 0 else -1.6
    taken = samples_of(tcp * [1, 1, up] + [0, 0, height], flip @ axes, seconds=0.5, **samples)
    stage = stage_of(taken, use=use)
    jet = sprayed(stage)
    return Sprayed(stage, jet, expose(stage, jet, prepared.facets, prepared.scene, 3000))


@cache
def both_sides():
    """A wash of the top, a wash of the bottom, a rinse of the top, a drying of the top."""
    return (spraying(BOTH), spraying(BOTH, up=-1.0), spraying(BOTH, "rinse"), spraying(BOTH, "dry"))


def judged(row, prepared=BOTH, by=None, masks=NO_MASKS):
    by = both_sides() if by is None else by
    underside = gaps_of(prepared, by, lambda *_: None).get(row)
    return component_part(row, prepared, spraying_of(prepared, by), underside, masks)


@pytest.mark.slow
@pytest.mark.parametrize(("row", "name", "acts"), [(0, "U1", [1, 0, 1, 1]), (2, "C2", [0, 1, 0, 0])])
def test_a_part_is_judged_by_what_sprays_its_own_side(row, name, acts):
    part = judged(row)
    assert part.component == name
    assert [each is not None for each in part.exposed] == [bool(act) for act in acts]
    assert [act is not None for act in part.gaps[0].stages] == [bool(act) for act in acts[:3]] + [False]


@pytest.mark.slow
def test_each_use_of_a_side_is_judged_once():
    twice = (*both_sides()[:1], spraying(BOTH), *both_sides()[2:])
    amounts = [each for each in judged(0, by=twice).judgements if each.rule.id == "R2"]
    alone = [each for each in judged(0).judgements if each.rule.id == "R2"]
    assert len(amounts) == len(alone) == 2
    washes = [next(each for each in found if each.stage != "sequence[1]") for found in (amounts, alone)]
    assert washes[0].numbers[0].value == pytest.approx(2 * washes[1].numbers[0].value, rel=1e-6)


def test_what_no_liquid_reaches_is_not_sprayed():
    part = judged(2, by=(both_sides()[0], both_sides()[3]))
    assert [(each.rule.id, each.name) for each in part.judgements] == [("R1", "not sprayed")]
    assert part.makers == ()


def test_a_part_without_a_gap_has_none_to_tell():
    part = judged(1)
    assert (part.component, part.underside, part.gaps, part.elasticity, part.limiting) == ("J1", None, (), {}, "")


def test_who_sprays_a_part_is_told_with_shares_of_the_volume():
    many = [f"sequence[0]/around/C{number}" for number in range(20)]
    made_by = np.arange(len(LINES)) % 20
    part = judged(0, by=(spraying(BOTH, made_by=made_by, makers=tuple(many)),))
    assert len(part.makers) == 12
    shares = [share for _, share in part.makers]
    assert shares == sorted(shares, reverse=True)
    assert 12 / 20 < sum(shares) < 1.0
    assert {str(maker) for maker, _ in part.makers} <= set(many)


@pytest.mark.slow
def test_shares_are_of_all_stages_together():
    first, last = (
        spraying(BOTH, makers=("sweep",)),
        spraying(BOTH, "rinse", tcp=np.tile(LINES, (3, 1)), makers=("flush",)),
    )
    part = judged(0, by=(first, last))
    assert [str(maker) for maker, _ in part.makers] == ["flush", "sweep"]
    assert part.makers[0][1] == pytest.approx(0.75, abs=0.05)


def test_what_stands_in_the_way_is_named():
    wall = body("W1", "component", at(9, 14, 1, 9), 0.0, 25.0, package="Shield", pins=2, side="top")
    prepared = prepare(understand(bodies_of("U1", more=(wall,)), "small"), PARAMETERS, lambda *_: None)
    from_left = np.array([[-25.0, y, 30.0] for y in range(10, 28)])
    by = (spraying(prepared, tcp=from_left, axes=downward(55.0, 0.0)),)
    shadowed = next(each for each in judged(0, prepared, by).judgements if each.rule.id == "R1")
    assert shadowed.name == "shadowed"
    assert "W1 stands in the way" in shadowed.because
    free = (spraying(prepared, tcp=from_left + np.array([90, 0, 0]), axes=downward(55.0, 180.0)),)
    assert not any("W1" in each.because for each in judged(0, prepared, free).judgements)


@pytest.mark.slow
def test_the_bare_board_is_judged_on_the_sides_that_are_sprayed_and_without_fixtures():
    clamp = body("F1", "fixture", at(-6, 10, 8, 10), -3.0, 6.0)
    clamped = prepare(understand(bodies_of("U1", more=(clamp,)), "small"), PARAMETERS, lambda *_: None)
    free = prepared_of(("U1",))
    areas = {
        name: bare_part(prepared, spraying_of(prepared, [spraying(prepared)]), NO_MASKS).exposed[0].area_mm2
        for name, prepared in (("clamped", clamped), ("free", free))
    }
    assert areas["clamped"] < areas["free"] <= 48 * 36 + 2 * (48 + 36) * 1.6
    top, turned, *_ = bare_part(BOTH, spraying_of(BOTH, both_sides()), NO_MASKS).exposed
    assert top.area_mm2 == pytest.approx(turned.area_mm2, rel=0.05)
    bare = bare_part(free, spraying_of(free, [spraying(free)]), NO_MASKS)
    assert (bare.component, bare.gaps, bare.underside) == ("board", (), None)


def test_a_part_that_bears_little_is_at_risk():
    known = PARAMETERS.model_copy(update={"parts": [PartOverride(match=["U1"], most_kpa=0.05)]})
    prepared = replace(BOTH, parameters=known, overrides=(known.parts[0], *BOTH.overrides[1:]))
    part = judged(0, prepared)
    assert (part.verdict, part.judgements[0].rule.id) == ("dirty", "R3")
    assert part.judgements[0].numbers[0].value > 0.05
    assert judged(0).judgements[0].rule.id != "R3"


def test_the_worst_judgement_decides():
    for row in range(3):
        part = judged(row)
        assert (part.verdict, part.grade) == (part.judgements[0].verdict, part.judgements[0].grade)


def test_what_a_mask_avoids_is_not_judged_clean_or_dirty_but_by_what_it_bears():
    names = BOTH.board.own_names
    masks = match_masks([Mask(avoid=["u1"])], names)
    part, other = judged(0, masks=masks), judged(1, masks=masks)
    assert [(each.rule.id, each.verdict) for each in part.judgements] == [("R15", "avoided")]
    landed, flown = part.judgements[0].numbers
    liquids = part.exposed[0], part.exposed[2]
    assert landed.value == pytest.approx(sum(each.volume_mm[2] for each in liquids))
    assert landed.value + flown.value == pytest.approx(sum(each.supply_mm[2] for each in liquids))
    assert other.judgements == judged(1).judgements
    dry = judged(0, by=(both_sides()[1],), masks=masks)
    assert "stays dry" in dry.judgements[0].because
    assert dry.verdict == "avoided"
    frail = PARAMETERS.model_copy(update={"parts": [PartOverride(match=["U1"], most_kpa=0.05)]})
    prepared = replace(BOTH, parameters=frail, overrides=(frail.parts[0], *BOTH.overrides[1:]))
    assert judged(0, prepared, masks=masks).verdict == "dirty"


def test_the_bare_board_is_not_judged_within_the_margin_of_what_is_avoided():
    stages = spraying_of(BOTH, both_sides())
    whole = bare_part(BOTH, stages, NO_MASKS).exposed
    names = BOTH.board.own_names
    outline = BOTH.board.components[0].outline
    for margin_mm in (0.0, 4.0):
        masks = match_masks([Mask(avoid=["U1"], margin_mm=margin_mm)], names)
        kept = bare_part(BOTH, stages, masks).exposed
        missing_mm2 = whole[0].area_mm2 - kept[0].area_mm2
        around_mm2 = outline.buffer(margin_mm).area - outline.area
        assert missing_mm2 == pytest.approx(around_mm2, abs=0.25 * around_mm2 + 6.0)
        assert kept[1].area_mm2 == whole[1].area_mm2  # it lies on the other side
