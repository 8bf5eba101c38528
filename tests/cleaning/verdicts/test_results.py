from dataclasses import replace

import pytest
from cleaning_report import WET, small_report, soaked, soaked_report

from cleaning.report import cleaning_report
from cleaning.verdicts.component_rules import worst_first
from cleaning.verdicts.results import (
    Judgement,
    cleanliness,
    count_cleanliness,
    deciding_judgement,
    outcome,
    rank_parts,
    report_cleanliness,
    report_outcome,
    rests_on_uncalibrated_kinetics,
    stays_wet,
    two_digits,
    unclean_parts,
)
from cleaning.verdicts.rules import MISSED, OUTCOMES, RESIDUE_LEFT


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"), (3e-5, "0"), (0.00012, "0.00012"), (0.0531, "0.053"), (1.05, "1.1"), (9.96, "10"), (99.6, "100"),
        (142.3, "142"), (12345.6, "12346"), (3e7, "30000000"),
    ],
)  # fmt: skip
def test_numbers_in_sentences_have_two_digits_and_no_exponent(value: float, text: str) -> None:
    assert two_digits(value) == text


@pytest.mark.parametrize("part", small_report().parts, ids=lambda part: part.component)
def test_water_that_is_left_says_nothing_of_cleanliness(part):
    assert cleanliness(part) == part.verdict == cleanliness(soaked(part))
    assert (stays_wet(part), stays_wet(soaked(part))) == (False, True)


def test_water_is_told_apart_where_nothing_else_is_lacking():
    parts = small_report().parts
    assert [outcome(part) for part in parts] == [part.verdict for part in parts]
    said = {part.verdict: outcome(soaked(part)) for part in parts}
    assert said == {"dirty": "dirty", "marginal": "marginal", "no verdict": "no verdict", "clean": "clean, wet"}
    assert {*said.values(), "clean", "avoided"} == set(OUTCOMES)


def test_components_are_counted_by_cleanliness():
    parts = small_report().parts
    assert count_cleanliness(map(soaked, parts)) == {"dirty": 1, "marginal": 1, "no verdict": 1, "clean": 2}
    assert count_cleanliness([]) == {}


def test_the_process_and_the_bare_board_count_too():
    clean = replace(
        small_report(), parts=tuple(soaked(part) for part in small_report().parts if part.verdict == "clean")
    )
    assert report_cleanliness(clean) == "clean"
    near = replace(clean.process[0], verdict="marginal")
    assert report_cleanliness(replace(clean, process=(near,))) == "marginal"
    bare = replace(clean.bare, judgements=(replace(near, verdict="dirty"),))
    assert report_cleanliness(replace(clean, bare=bare)) == "dirty"


def test_what_is_only_wet_comes_after_what_is_near_a_limit():
    report = small_report()
    parts = tuple(soaked(part) if part.component == "C1" else part for part in report.parts)
    order = [part.component for part in unclean_parts(replace(report, parts=parts))]
    assert order == ["U1", "R1", "C1", "J1"]
    told = [part.component for part in rank_parts(soaked_report())]
    assert (told[:2], {*told[2:4]}, told[4]) == (["U1", "R1"], {"C1", "R2"}, "J1")
    assert [part.component for part in rank_parts(report)] == [part.component for part in report.worst_first()]


def as_judged(part):
    """The part with water left under it, its judgements and its verdict as the rules would have them."""
    judgements = worst_first([*part.judgements, WET])
    return replace(part, judgements=judgements, verdict=judgements[0].verdict, grade=judgements[0].grade)


def test_what_decides_is_of_what_a_component_is_called():
    parts = {part.verdict: as_judged(part) for part in small_report().parts}
    assert {each: deciding_judgement(part).rule.id for each, part in parts.items()} == {
        "dirty": "R7", "marginal": "R10", "no verdict": "R14", "clean": "R12",
    }  # fmt: skip
    assert parts["no verdict"].verdict == "marginal"
    for part in (*parts.values(), *small_report().parts):
        assert deciding_judgement(part).verdict == ("marginal" if outcome(part) == "clean, wet" else outcome(part))


def test_what_has_no_verdict_ranks_by_its_residue_whether_it_stays_wet_or_not():
    report = small_report()
    u1, j1 = (next(part for part in report.parts if part.component == name) for name in ("U1", "J1"))
    more = replace(j1, component="J2", gaps=u1.gaps)
    ranked = rank_parts(replace(report, parts=(*map(soaked, report.parts), as_judged(j1), more)))
    assert [part.component for part in ranked[-3:]] == ["J2", "J1", "J1"]


def test_the_report_is_called_wet_where_it_lacks_nothing_else():
    assert report_outcome(soaked_report()) == report_outcome(small_report()) == "dirty"
    clean = tuple(part for part in small_report().parts if part.verdict == "clean")
    assert report_outcome(replace(small_report(), parts=clean)) == "clean"
    assert report_outcome(replace(small_report(), parts=(clean[0], soaked(clean[1])))) == "clean, wet"


def test_the_data_tell_both_apart():
    report = small_report()
    told = cleaning_report(soaked_report())
    assert told["cleanliness"] == {"dirty": 1, "marginal": 1, "no verdict": 1, "clean": 2}
    assert told["stay_wet"] == 5
    assert [each["cleanliness"] for each in told["components"]] == [part.verdict for part in report.parts]
    assert all(each["stays_wet"] for each in told["components"])


def test_a_verdict_rests_on_kinetics_where_residue_decides_or_makes_it_clean() -> None:
    """Never hit stays never hit, whatever the kinetics; what is clean by a small residue may not be."""
    part = next(part for part in small_report().parts if part.verdict == "clean")
    residue = next(each for each in small_report().parts[0].judgements if each.rule == RESIDUE_LEFT)
    clean, fitted = replace(residue, verdict="clean"), replace(residue, verdict="clean", calibrated=True)
    missed = Judgement(rule=MISSED, verdict="dirty", because="")
    judged = {
        (clean,): True, (fitted,): False, (WET, clean): True, (residue,): True, (missed, residue): False,
        (missed, clean): False, (missed,): False,
    }  # fmt: skip
    for judgements, rests in judged.items():
        assert rests_on_uncalibrated_kinetics(replace(part, judgements=judgements)) is rests
