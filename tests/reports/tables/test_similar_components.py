from dataclasses import replace

from cleaning_report import small_report
from hypothesis import given, settings
from hypothesis import strategies as st

from cleaning.verdicts.results import Judgement, Number
from cleaning.verdicts.rules import INCOMPLETE_RINSE, IONIC_RESIDUE, MODEL_LIMIT, WET_GAP
from reports.tables.similar_components import deciding, group_alike, unclean
from reports.tables.wording import name_some

R1 = next(part for part in small_report().parts if part.component == "R1")


def wet(component, clear_um, gap_um, **changes):
    """A component whose gap stays wet."""
    numbers = (Number("gap", gap_um, "um"), Number("least gap", clear_um, "um", 10.0))
    because = f"Drying blows clear gaps from {clear_um:g} um on; this one is {gap_um:g} um high."
    told = Judgement(rule=WET_GAP, verdict="marginal", numbers=numbers, because=because, advice="Bake it.")
    return replace(R1, component=component, judgements=(replace(told, **changes),), verdict="marginal", grade="B")


def test_numbers_that_differ_become_ranges():
    (group,) = group_alike([wet("R1", 57, 25), wet("R2", 133, 50), wet("R3", 60, 25)], deciding)
    assert group.names == ("R1", "R2", "R3")
    (told,) = group.descriptions
    assert told.because == "Drying blows clear gaps from 57 to 133 um on; this one is 25 to 50 um high."
    assert [(low.value, high.value) for low, high in told.numbers] == [(25, 50), (57, 133)]
    assert told.numbers[1][0].limit == told.numbers[1][1].limit == 10.0


def test_what_is_said_of_one_is_said_as_it_is():
    (group,) = group_alike([wet("R1", 57, 25)], deciding)
    judgement = group.parts[0].judgements[0]
    assert (group.descriptions[0].because, group.descriptions[0].advice) == (judgement.because, judgement.advice)


def test_what_differs_in_more_than_numbers_stands_apart():
    unlike = [
        {"rule": INCOMPLETE_RINSE}, {"variant": "soaked"}, {"verdict": "dirty"}, {"rule": IONIC_RESIDUE},
        {"stage": "sequence[1]"}, {"advice": "Blow harder."}, {"because": "It stays wet."}, {"numbers": ()},
    ]  # fmt: skip
    parts = [wet("R1", 57, 25), *(wet(f"R{at}", 57, 25, **change) for at, change in enumerate(unlike, start=2))]
    assert [len(group.parts) for group in group_alike(parts, deciding)] == [1] * len(parts)


def test_what_is_clean_and_stays_wet_stands_apart_from_what_lacks_more():
    wet_only = wet("R2", 57, 25)
    unknown = replace(R1.judgements[0], rule=MODEL_LIMIT, verdict="no verdict")
    undecided = replace(wet_only, component="R3", judgements=(*wet_only.judgements, unknown))
    groups = group_alike([R1, wet_only, undecided], deciding)
    assert [(group.names, group.descriptions[0].rule.id) for group in groups] == [
        (("R1",), "R10"), (("R2",), "R12"), (("R3",), "R14"),
    ]  # fmt: skip
    assert [each.rule.id for each in unclean(undecided)] == ["R14", "R12"], "what decides is said first"


def test_numbers_far_from_each_other_are_not_put_together():
    groups = group_alike([wet("R1", 57, 25), wet("R2", 57, 250), wet("R3", 58, 30), wet("R4", 58, 240)], deciding)
    assert [group.names for group in groups] == [("R1", "R3"), ("R2", "R4")]


def test_digits_of_names_are_no_numbers():
    parts = [
        wet(name, 57, 25, because=f"{blocker} stands in the way.") for name, blocker in (("R1", "U7"), ("R2", "U8"))
    ]
    assert len(group_alike(parts, deciding)) == 2


def test_all_that_is_found_must_be_alike_where_all_is_told():
    more = replace(R1, component="R2", judgements=(*R1.judgements, *wet("R2", 57, 25).judgements))
    assert len(group_alike([R1, more], deciding)) == 1
    assert [len(group.descriptions) for group in group_alike([R1, more], unclean)] == [1, 2]


@given(values=st.lists(st.tuples(st.floats(0, 500), st.floats(1, 500)), min_size=1, max_size=30))
@settings(max_examples=40)
def test_every_component_is_in_one_group_in_the_order_given_and_ranges_hold_its_numbers(values):
    parts = [wet(f"R{at}", *pair) for at, pair in enumerate(values)]
    groups = group_alike(parts, deciding)
    order = {part.component: at for at, part in enumerate(parts)}
    assert sorted(name for group in groups for name in group.names) == sorted(order)
    assert [order[group.names[0]] for group in groups] == sorted(order[group.names[0]] for group in groups)
    for group in groups:
        assert [order[name] for name in group.names] == sorted(order[name] for name in group.names)
        for part in group.parts:
            for number, (low, high) in zip(part.judgements[0].numbers, group.descriptions[0].numbers, strict=True):
                assert low.value <= number.value <= high.value


def test_long_lists_of_names_are_counted():
    assert name_some(("R1", "R2"), 2) == "R1, R2"
    assert name_some(("R1", "R2", "R3", "R4"), 2) == "R1, R2 and 2 more"
