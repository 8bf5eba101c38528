"""Rules on one component: what reaches its exposed surface, what it bears, and the gap under it; the worst first."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from math import ceil

from cleaning.process.stages import Stage
from cleaning.verdicts import rules
from cleaning.verdicts.gap_rules import judge_gaps
from cleaning.verdicts.results import Evidence, ExposedPart, Judgement, Number, Reach, two_digits
from cleaning.verdicts.rules import VERDICTS, Verdict

_FEW = 0.01
"""Share of an exposed surface that may be missed: less than the rays resolve."""
_MANY = 0.05
_HALF = 0.5
"""Below this share of a limit it is missed by far."""
_TRACE_MM = 0.001
"""Less than this mean film is no liquid."""
_NOTHING = 0.01
"""Below this share of a limit the digits of a volume mean nothing, and going slower does not help."""


def judge_part(evidence: Evidence) -> tuple[Judgement, ...]:
    """Judge a component by every rule that applies to it; at least one does. Worst first."""
    placed = (each if each.where is not None else replace(each, where=evidence.place) for each in _judge(evidence))
    return worst_first(list(placed))


def worst_first(judgements: list[Judgement]) -> tuple[Judgement, ...]:
    """Dirty before marginal before no verdict before clean, avoided last; within a verdict as they came.

    Of what is clean, the least sure comes first: one rule is enough to make a part dirty, but clean it is only by all.
    """

    def rank(judgement: Judgement) -> tuple[int, int]:
        sure = -ord(judgement.grade) if judgement.verdict == "clean" else 0
        return VERDICTS.index(judgement.verdict), sure

    return tuple(sorted(judgements, key=rank))


def _judge(evidence: Evidence) -> list[Judgement]:
    if not evidence.reached and not evidence.avoided:
        because = f"No step sprays liquid on the {evidence.side} side."
        advice = f"Add a step to the sequence that sprays a liquid, with side: {evidence.side}."
        return [Judgement(rule=rules.MISSED, variant="not sprayed", verdict="dirty", because=because, advice=advice)]
    acting = [pair for pair in zip(evidence.stages, evidence.exposed, strict=True) if pair[1] is not None]
    loads = [each for stage, exposed in acting if exposed is not None for each in _load(evidence, stage, exposed)]
    if evidence.avoided:
        return [_avoided(evidence), *loads]
    found: list[Judgement] = []
    for reach in evidence.reached:
        if reach.exposed.area_mm2 > 0 and reach.exposed.missed_share > _FEW:
            found.append(_missed(evidence, reach))
        if reach.exposed.area_mm2 > 0 and reach.exposed.missed_share <= _MANY:
            found.append(_amount(evidence, reach))
    found += [*loads, *judge_gaps(evidence)]
    if not found:
        because = "It shows no surface that spray can reach, and no gap under it is known."
        found.append(Judgement(rule=rules.MODEL_LIMIT, verdict="no verdict", because=because, advice="Inspect it."))
    return found


def _avoided(evidence: Evidence) -> Judgement:
    """State what lands on a component, and flows over it, though a mask avoids it."""
    landed = sum(each.exposed.volume_mm[2] for each in evidence.reached)
    flown = sum(each.exposed.supply_mm[2] for each in evidence.reached) - landed
    amounts = {"land on it": landed, "flow over it from its surroundings": flown}
    wet = [f"{two_digits(amount)} mm {how}" for how, amount in amounts.items() if amount >= _TRACE_MM]
    because = f"A mask avoids it; on average {' and '.join(wet)}." if wet else "A mask avoids it, and it stays dry."
    numbers = (Number("landed, mean", landed, "mm"), Number("from its surroundings, mean", flown, "mm"))
    advice = "Cover it where it must stay dry, or raise margin_mm of its mask." if wet else ""
    return Judgement(rule=rules.AVOIDED, verdict="avoided", numbers=numbers, because=because, advice=advice)


def _missed(evidence: Evidence, reach: Reach) -> Judgement:
    percent = 100.0 * reach.exposed.missed_share
    because = f"{percent:.1f} % of its exposed surface is never hit in {reach.functions}"
    blocker = "the board" if evidence.occluder == "board" else evidence.occluder
    if evidence.occluder == evidence.component:
        blocker = "its own body" if evidence.component != "board" else "the board itself"
    return Judgement(
        rule=rules.MISSED,
        variant="shadowed" if evidence.occluder else "",
        verdict="dirty" if reach.exposed.missed_share > _MANY else "marginal",
        numbers=(Number("missed", percent, "%", 100.0 * _FEW),),
        because=because + (f"; {blocker} stands in the way." if blocker else "."),
        advice="Spray it from another side or tilt, or add a perimeter pass around it.",
        stage=reach.made_by,
    )


def _amount(evidence: Evidence, reach: Reach) -> Judgement:
    limits, (_, low, _) = evidence.parameters.limits, reach.exposed.supply_mm
    limit = limits.wash_volume_mm if reach.use == "wash" else limits.rinse_volume_mm
    compared = [f"limits.{reach.use}_volume_mm"]
    landed = reach.exposed.volume_mm[1]
    least = limits.margin * limit
    numbers = [Number("volume on the least wetted places", low, "mm", least), Number("of it landed", landed, "mm")]
    share = low / least
    amount = f"{two_digits(low)} mm" if low / limit >= _NOTHING else f"less than {_NOTHING * limit:g} mm"
    because = (
        f"The least wetted places of its exposed surface get {amount} in {reach.functions}, run-off included "
        f"(limit {limit:g} mm{f', clean from {least:g} mm' if least > limit else ''})."
    )
    if reach.use == "wash" and limits.front_s > 0:
        compared.append("limits.front_s")
        front = reach.exposed.front_s[1]
        longest = limits.margin * limits.front_s
        numbers.append(Number("time in the wave front, least places", front, "s", longest))
        because += f" It is in the wave front for {two_digits(front)} s (limit {limits.front_s:g} s)."
        share = min(share, front / longest)
    if share < 1 and reach.repeats > 1:
        share *= reach.repeats
        often = ceil(reach.repeats / share) if share >= 1 else 0
        because += f" It must be done {often} times" if often else " It is too little even if done"
        because += f", of {reach.repeats} at most." if often else f" {reach.repeats} times, as often as it may be."
    verdict: Verdict = "clean" if share >= 1 else "marginal" if limits.margin * share >= _HALF else "dirty"
    advice = "Go slower or nearer, or add a pass."
    if low / limit < _NOTHING:
        advice = "Hardly any reaches it there: add a pass from another side, or tilt the jet."
    return Judgement(
        rule=rules.UNDER_EXPOSED,
        variant="exposed" if verdict == "clean" else "",
        verdict=verdict,
        numbers=tuple(numbers),
        because=because,
        advice="" if verdict == "clean" else advice,
        # A limit that we propose, or that rests on made-up data, does not raise the grade.
        calibrated=all(evidence.parameters.known(path).known not in ("proposed", "synthetic") for path in compared),
        stage=reach.made_by,
    )


def _load(evidence: Evidence, stage: Stage, exposed: ExposedPart) -> Iterator[Judgement]:
    """What the component itself bears."""
    bears, window = evidence.override.most_kpa, evidence.override.window_c
    judge = partial(Judgement, verdict="dirty", stage=stage.made_by)
    if bears is not None and exposed.peak_pa > 1000.0 * bears:
        peak = Number("peak pressure", exposed.peak_pa / 1000.0, "kPa", bears)
        because = f"{stage.function} presses with {two_digits(peak.value)} kPa on it; it bears {bears:g} kPa."
        advice = "Avoid it with a mask, spray from further away, or lower the pressure."
        yield judge(rule=rules.DAMAGE_RISK, numbers=(peak,), because=because, advice=advice)
    if window is not None and not window[0] <= stage.temperature_c <= window[1]:
        because = f"{stage.function} is at {stage.temperature_c:g} °C; it bears {window[0]:g} to {window[1]:g} °C."
        found = (Number("temperature", stage.temperature_c, "°C", window[1]),)
        advice = f"Change temperature_c of {stage.function}."
        yield judge(rule=rules.PROCESS_WINDOW, numbers=found, because=because, advice=advice)
    attacked = [each for each in evidence.override.materials if each in stage.liquid.attacks]
    if attacked:
        because = f"{stage.solution} attacks {' and '.join(attacked)}, which it has bare."
        advice = f"Choose another solution for {stage.function}, or avoid it with a mask."
        yield judge(rule=rules.PROCESS_WINDOW, variant="material", because=because, advice=advice)
