"""Rules R1 to R14 applied to one component: every judgement, the worst first."""

from cleaning.verdicts.evidence import Evidence
from cleaning.verdicts.gap_rules import judge_gaps
from cleaning.verdicts.results import Judgement
from cleaning.verdicts.rules import VERDICTS
from cleaning.verdicts.surface_rules import judge_load, judge_reach, not_judged, not_sprayed


def judge_part(evidence: Evidence) -> tuple[Judgement, ...]:
    """Apply every rule that has something to say about a component; at least one does. Worst first."""
    if not evidence.reached:
        return (not_sprayed(evidence),)
    judgements = [each for reach in evidence.reached for each in judge_reach(evidence, reach)]
    for stage, exposed in zip(evidence.stages, evidence.exposed, strict=True):
        if exposed is not None:
            judgements += judge_load(evidence, stage, exposed)
    return worst_first([*judgements, *judge_gaps(evidence)] or [not_judged(evidence)])


def worst_first(judgements: list[Judgement]) -> tuple[Judgement, ...]:
    """Dirty before marginal before no verdict before clean; within a verdict in the order in which they came.

    Of what is clean, the least sure comes first: one rule is enough to make a part dirty, but clean it is only by all.
    """

    def rank(judgement: Judgement) -> tuple[int, int]:
        sure = -ord(judgement.grade) if judgement.verdict == "clean" else 0
        return VERDICTS.index(judgement.verdict), sure

    return tuple(sorted(judgements, key=rank))
