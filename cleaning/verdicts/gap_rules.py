"""Rules R4 to R8, R10 to R12 and R14: the gap under a component."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cleaning.process.stages import Stage
from cleaning.undersides.gap_result import GapResult, GapStage
from cleaning.verdicts.evidence import Evidence
from cleaning.verdicts.results import Judgement, Number
from cleaning.verdicts.rounding import two_digits
from cleaning.verdicts.rules import (
    DRY_GAP,
    INCOMPLETE_RINSE,
    IONIC_RESIDUE,
    MODEL_LIMIT,
    NOT_FLUSHED,
    ONE_SIDED,
    PLUGGED_GAP,
    RESIDUE_LEFT,
    VERDICTS,
    WET_GAP,
    Rule,
    Verdict,
)

_DECIDING = frozenset({DRY_GAP, PLUGGED_GAP, MODEL_LIMIT})
_OF_FLOW = frozenset({NOT_FLUSHED, RESIDUE_LEFT, ONE_SIDED})
_LEAST_PERCENT = 0.01
"""Of residue: far below every limit, so that its digits mean nothing."""


def judge_gaps(evidence: Evidence) -> list[Judgement]:
    """R4 to R8, R10 to R12, R14: the gap in both of its cases; each rule as it comes out worse, the other one is said.

    The first case is the harder one as a rule, not always: a higher gap holds more of what the rinse leaves, and has
    places that are flushed less. Where it alone is no thin gap, the first decides, since more flows in a higher one.
    """
    if evidence.underside is None or not evidence.gaps:
        return []
    first, *others = [_judge_gap(evidence, gap) for gap in evidence.gaps]
    if not others:
        return first
    lower, higher = evidence.gaps
    second = others[0]
    if _is_beyond(second) and not _is_beyond(first):
        return [_with_bound(each, "no thin gap, and nothing is said of it", higher) for each in first]
    found: list[Judgement] = []
    for rule in dict.fromkeys(each.rule for each in (*first, *second)):
        one, other = _of_rule(rule, first), _of_rule(rule, second)
        said, told = _verdict(rule, first), _verdict(rule, second)
        if one is not None and VERDICTS.index(said) <= VERDICTS.index(told):
            found.append(_with_bound(one, told, higher))
        elif other is not None and VERDICTS.index(told) < VERDICTS.index(said):
            found.append(_with_bound(other, said, lower))
    return found


def _of_rule(rule: Rule, judgements: Sequence[Judgement]) -> Judgement | None:
    return next((each for each in judgements if each.rule == rule), None)


def _verdict(rule: Rule, judgements: Sequence[Judgement]) -> Verdict:
    """What one case comes to by a rule: that all is well if it says nothing, unless it was not asked.

    A gap that stays dry, is plugged or is no thin gap is judged by that; one that is none of these, by all the others.
    """
    stands = _of_rule(rule, judgements) or next((each for each in judgements if _stands_for(each, rule)), None)
    if stands is not None:
        return stands.verdict
    found: list[Verdict] = [each.verdict for each in judgements] if rule in _DECIDING else []
    return min(found, key=VERDICTS.index) if found else "clean"


def _stands_for(judgement: Judgement, rule: Rule) -> bool:
    """Whether a rule was not asked because of a judgement."""
    return judgement.rule == DRY_GAP or _is_beyond([judgement]) or (judgement.rule == PLUGGED_GAP and rule in _OF_FLOW)


def _is_beyond(judgements: Sequence[Judgement]) -> bool:
    return any(each.rule == MODEL_LIMIT and each.numbers for each in judgements)


def _with_bound(judgement: Judgement, other: str, gap: GapResult) -> Judgement:
    if other == judgement.verdict:
        return judgement
    told = "without a verdict" if other == "no verdict" else other
    bound = f" At the other bound, a standoff of {1000 * gap.gap_height_mm:.0f} µm, it is {told}."
    return replace(judgement, because=judgement.because + bound)


def _judge_gap(evidence: Evidence, gap: GapResult) -> list[Judgement]:
    acts = [(stage, at) for stage, at in zip(evidence.stages, gap.stages, strict=True) if at is not None]
    beyond = _beyond(evidence, gap, acts)
    if beyond:
        return beyond
    washes = [pair for pair in acts if pair[0].use == "wash"]
    rinses = [pair for pair in acts if pair[0].use == "rinse"]
    if not washes:
        return [_unwashed(evidence), *_dried(evidence, gap)]
    found = [*_entered(evidence, gap, washes), *_plugged(evidence, gap)]
    if not found:
        found = [*_flushed(evidence, gap, washes), *_one_sided(evidence, washes), *_residue(evidence, gap)]
    if any(each.rule == DRY_GAP for each in found):
        return found
    return [*found, *(_rinsed(evidence, gap, rinses) if rinses else []), *_dried(evidence, gap)]


def _unwashed(evidence: Evidence) -> Judgement:
    """R14 for a process without a wash: whether there is anything to be removed is not known."""
    because = "No wash acts on it, so that whatever is in the gap under it stays there."
    advice = "Add a wash if there is something to be removed from there."
    return Judgement(rule=MODEL_LIMIT, verdict="no verdict", because=because, advice=advice, where=evidence.place)


def _gap_text(gap: GapResult) -> str:
    return f"under it, in a gap of {1000 * gap.gap_height_mm:.0f} µm"


def _beyond(evidence: Evidence, gap: GapResult, acts: list[tuple[Stage, GapStage]]) -> list[Judgement]:
    """R14: no thin gap, so that nothing is said of it."""
    limits = evidence.parameters.gap
    reynolds = max((at.reynolds for stage, at in acts if stage.use != "dry"), default=0.0)
    if 1000.0 * gap.gap_height_mm <= limits.thickest_um and reynolds <= limits.most_reynolds:
        return []
    numbers = (
        Number("standoff", 1000.0 * gap.gap_height_mm, "µm", limits.thickest_um),
        Number("reduced Reynolds number", reynolds, "", limits.most_reynolds),
    )
    because = (
        f"A gap of {numbers[0].value:.0f} µm with a reduced Reynolds number of {two_digits(reynolds)} is no thin gap, "
        "so that nothing can be said of the flow under it."
    )
    return [
        Judgement(
            rule=MODEL_LIMIT,
            verdict="no verdict",
            numbers=numbers,
            because=because,
            advice="Inspect it.",
            where=evidence.place,
        )
    ]


def _entered(evidence: Evidence, gap: GapResult, washes: list[tuple[Stage, GapStage]]) -> list[Judgement]:
    """R4: whether the wash gets in at all."""
    stage, at = max(washes, key=lambda pair: pair[1].margin_pa)
    margin = Number("entry margin", at.margin_pa, "Pa", 0.0)
    if any(each.entered for _, each in washes):
        return []
    because = f"{stage.solution} does not get {_gap_text(gap)}: it lacks {-at.margin_pa:.0f} Pa."
    advice = "Lower the surface tension, raise the pressure, or spray its edges from nearer."
    if at.margin_pa >= 0:
        because = f"{stage.solution} never reaches the edges of the gap {_gap_text(gap)}."
        advice = "Add a perimeter pass around it."
    return [
        Judgement(
            rule=DRY_GAP,
            verdict="dirty",
            numbers=(margin,),
            because=because,
            advice=advice,
            stage=stage.made_by,
            where=evidence.place,
        )
    ]


def _plugged(evidence: Evidence, gap: GapResult) -> list[Judgement]:
    """R5: residue fills the gap before the wash begins."""
    most = evidence.parameters.gap.plugged
    if gap.fill < most:
        return []
    fill = Number("fill before washing", 100.0 * gap.fill, "%", 100.0 * most)
    because = f"Residue fills {fill.value:.0f} % of the height {_gap_text(gap)}: nothing flows through."
    advice = "Print less paste, give the pads vents or more standoff, or let it soak for long."
    return [
        Judgement(
            rule=PLUGGED_GAP, verdict="dirty", numbers=(fill,), because=because, advice=advice, where=evidence.place
        )
    ]


def _flushed(evidence: Evidence, gap: GapResult, washes: list[tuple[Stage, GapStage]]) -> list[Judgement]:
    """R6: whether enough liquid passes to carry the residue away."""
    done = sum(at.exchanges for _, at in washes)
    if done >= gap.exchanges_needed:
        return []
    number = Number("exchanges", done, "", gap.exchanges_needed)
    because = f"The liquid {_gap_text(gap)} is renewed {done:.1f} times; the residue needs {gap.exchanges_needed:.1f}."
    verdict: Verdict = "marginal" if done >= 0.5 * gap.exchanges_needed else "dirty"
    advice = "Add perimeter passes or a pause at its edges."
    return [
        Judgement(
            rule=NOT_FLUSHED, verdict=verdict, numbers=(number,), because=because, advice=advice, where=evidence.place
        )
    ]


def _one_sided(evidence: Evidence, washes: list[tuple[Stage, GapStage]]) -> list[Judgement]:
    """R8: a part of the gap sees too little flow; the side that presses least is named."""
    limits = evidence.parameters.limits
    stage, at = min(washes, key=lambda pair: pair[1].weak_share)
    if at.weak_share <= limits.weak_share or evidence.underside is None:
        return []
    weakest = int(np.argmin(at.side_shear_pa))
    angle = evidence.underside.turn_rad + (-0.5 + 0.5 * weakest) * np.pi
    outward = (float(np.cos(angle)), float(np.sin(angle)))
    number = Number("gap with weak flow", 100.0 * at.weak_share, "%", 100.0 * limits.weak_share)
    because = (
        f"In {number.value:.0f} % of the gap the shear stays below {limits.weak_shear_pa:g} Pa; least comes from the "
        f"{compass(outward)}."
    )
    advice = f"Add a pass along its {compass(outward)} edge, leaning towards it."
    return [
        Judgement(
            rule=ONE_SIDED,
            verdict="marginal",
            numbers=(number,),
            because=because,
            advice=advice,
            stage=stage.made_by,
            where=evidence.place,
            sides=(outward,),
        )
    ]


def compass(outward: tuple[float, float]) -> str:
    """Name a direction in the board's plane as seen from the top: right, back, left, front and between."""
    names = ("right", "back right", "back", "back left", "left", "front left", "front", "front right")
    return names[round(float(np.arctan2(outward[1], outward[0])) / (np.pi / 4)) % 8]


def _residue(evidence: Evidence, gap: GapResult) -> list[Judgement]:
    """R7: what is left, as a mean and in the worst tenth."""
    limits = evidence.parameters.limits
    mean, worst = 100.0 * gap.residue, 100.0 * gap.residue_worst
    numbers = (
        Number("residue", mean, "%", 100.0 * limits.gap_marginal),
        Number("residue, worst tenth", worst, "%", 100.0 * limits.pocket),
    )
    pocket = gap.residue_worst > limits.pocket
    verdict: Verdict = "dirty" if gap.residue > limits.gap_dirty else "marginal"
    if gap.residue <= limits.gap_marginal and not pocket:
        verdict = "clean"
    because = f"{_percent(mean)} of the residue is left {_gap_text(gap)}; in its worst tenth {_percent(worst)}."
    advice = "" if verdict == "clean" else "Soak longer, wash warmer, or add perimeter passes."
    return [
        Judgement(
            rule=RESIDUE_LEFT,
            variant="pocket" if pocket and gap.residue <= limits.gap_dirty else "",
            verdict=verdict,
            calibrated=evidence.parameters.calibrated,
            numbers=numbers,
            because=because,
            advice=advice,
            where=_pocket_place(evidence, gap),
        )
    ]


def _percent(value: float) -> str:
    """Write percent with two digits, and what is next to nothing as that."""
    if 0.0 < value < _LEAST_PERCENT:
        return f"less than {_LEAST_PERCENT:g} %"
    return f"{two_digits(value)} %"


def _pocket_place(evidence: Evidence, gap: GapResult) -> tuple[float, float, float]:
    if evidence.underside is None:
        return evidence.place
    x, y = gap.worst_at
    cos, sin = float(np.cos(evidence.underside.turn_rad)), float(np.sin(evidence.underside.turn_rad))
    return evidence.underside.x_mm + cos * x - sin * y, evidence.underside.y_mm + sin * x + cos * y, evidence.place[2]


def _rinsed(evidence: Evidence, gap: GapResult, rinses: list[tuple[Stage, GapStage]]) -> list[Judgement]:
    """R10 and R11: whether the wash is diluted away."""
    limits = evidence.parameters.limits
    once = sum(at.exchanges for _, at in rinses)
    done = sum(stage.repeats * at.exchanges for stage, at in rinses)
    number = Number("exchanges in rinsing", done, "", limits.exchanges)
    found: list[Judgement] = []
    because = f"Rinsing renews the liquid {_gap_text(gap)} {once:.1f} times (limit {limits.exchanges:g})"
    because += f"; {done:.1f} times if it is repeated as often as it may be." if done > once else "."
    if done < limits.exchanges:
        verdict: Verdict = "marginal" if done >= 0.25 * limits.exchanges else "dirty"
        more = int(np.ceil(limits.exchanges / done)) if done > 0 else 0
        advice = f"Rinse {more} times as long, or repeat the rinse." if 0 < more <= 50 else "Rinse along its edges."
        found.append(
            Judgement(
                rule=INCOMPLETE_RINSE,
                verdict=verdict,
                numbers=(number,),
                because=because,
                advice=advice,
                stage=rinses[-1][0].made_by,
                where=evidence.place,
            )
        )
    if limits.ionic_ug_cm2 is not None and gap.ionic_ug_cm2 > limits.ionic_ug_cm2:
        ionic = Number("estimated ionic index", gap.ionic_ug_cm2, "µg/cm²", limits.ionic_ug_cm2)
        because = (
            f"An estimated {two_digits(ionic.value)} µg/cm² stays {_gap_text(gap)}; your limit is {ionic.limit:g}."
        )
        found.append(
            Judgement(
                rule=IONIC_RESIDUE,
                verdict="dirty",
                numbers=(ionic,),
                because=because,
                advice="Rinse more.",
                where=evidence.place,
            )
        )
    return found


def _dried(evidence: Evidence, gap: GapResult) -> list[Judgement]:
    """R12: water that blow-off leaves, without a bake that takes it."""
    drying = evidence.parameters.drying
    if gap.blow_off_um is None or 1000.0 * gap.gap_height_mm >= gap.blow_off_um:
        return []
    if drying.bake_c is not None and gap.dry_s is not None and gap.dry_s <= 60.0 * drying.bake_min:
        return []
    standoff = 1000.0 * gap.gap_height_mm
    numbers = (Number("gap", standoff, "µm"), Number("least gap that is blown clear", gap.blow_off_um, "µm"))
    clears = f"gaps from {gap.blow_off_um:.0f} µm on" if np.isfinite(gap.blow_off_um) else "no gap here"
    because = f"Drying blows clear {clears}; this one is {standoff:.0f} µm high."
    advice = "Blow from nearer or slower, or bake the board afterwards (drying.bake_c)."
    return [
        Judgement(
            rule=WET_GAP, verdict="marginal", numbers=numbers, because=because, advice=advice, where=evidence.place
        )
    ]
