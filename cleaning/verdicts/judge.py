"""Rules R1 to R14 applied to one component: every judgement, the worst first."""

from cleaning.verdicts.evidence import Case
from cleaning.verdicts.gap_rules import judge_gaps
from cleaning.verdicts.results import Judgement
from cleaning.verdicts.rules import VERDICTS
from cleaning.verdicts.surface_rules import judge_load, judge_reach, not_judged, not_sprayed


def judge_part(case: Case) -> tuple[Judgement, ...]:
    """Apply every rule that has something to say about a component; at least one does. Worst first."""
    if not case.reached:
        return (not_sprayed(case),)
    judgements = [each for reach in case.reached for each in judge_reach(case, reach)]
    for stage, exposed in zip(case.stages, case.exposed, strict=True):
        if exposed is not None:
            judgements += judge_load(case, stage, exposed)
    return worst_first([*judgements, *judge_gaps(case)] or [not_judged(case)])


def worst_first(judgements: list[Judgement]) -> tuple[Judgement, ...]:
    """Dirty before marginal before no verdict before clean; within a verdict in the order in which they came.

    Of what is clean, the least sure comes first: one rule is enough to make a part dirty, but clean it is only by all.
    """

    def rank(judgement: Judgement) -> tuple[int, int]:
        sure = -ord(judgement.grade) if judgement.verdict == "clean" else 0
        return VERDICTS.index(judgement.verdict), sure

    return tuple(sorted(judgements, key=rank))
