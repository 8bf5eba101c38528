"""What a component bears is judged by the grade that the rule's own line in the table of rules says."""

from judged import evidence

from cleaning.parameters.model import PartOverride
from cleaning.verdicts.judge import judge_part
from cleaning.verdicts.rules import RULES


def test_what_a_part_does_not_bear_has_the_grade_of_its_rule():
    grades = {rule.id: rule.grade for rule in RULES}
    judged = judge_part(evidence(override=PartOverride(match=["U1"], most_kpa=0.2, window_c=(0, 50))))
    found = {each.rule.id: each.grade for each in judged if each.verdict == "dirty"}
    assert found == {"R3": grades["R3"], "R13": grades["R13"]}
