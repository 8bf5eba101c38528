"""Rules on the gap under a component: entry, plugging, flow, residue, rinse and drying."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from cleaning.process.stages import Stage
from cleaning.undersides.residue import GapResult, GapStage
from cleaning.verdicts import rules
from cleaning.verdicts.results import Evidence, Judgement, Number, two_digits
from cleaning.verdicts.rules import VERDICTS, Rule, Verdict

_DECIDING = frozenset({rules.DRY_GAP, rules.PLUGGED_GAP, rules.MODEL_LIMIT})
_OF_FLOW = frozenset({rules.NOT_FLUSHED, rules.RESIDUE_LEFT, rules.ONE_SIDED})
_LEAST_PERCENT = 0.01
"""Of residue: far below every limit, so that its digits mean nothing."""
_MOST_RINSES = 50
_DRIER = "Blow from nearer or slower, keep the board warm afterwards (drying.dwell_min), or bake it (drying.bake_c)."


def judge_gaps(evidence: Evidence) -> list[Judgement]:
    """Judge the gap at both bounds of its height: each rule as it comes out worse, with the verdict at the other one.

    The first bound is the harder one as a rule, not always: a higher gap holds more of what the rinse leaves, and has
    places that are flushed less. Where it alone is no thin gap, the first decides, since more flows in a higher one.
    """
    if evidence.underside is None or not evidence.gaps:
        return []
    first, *others = [_Gap(evidence, gap).judge() for gap in evidence.gaps]
    if not others:
        return first
    (second,) = others
    lower, higher = evidence.gaps
    if _is_not_thin(second) and not _is_not_thin(first):
        return [_with_bound(each, "no thin gap, which the model does not cover", higher) for each in first]
    found: list[Judgement] = []
    for rule in dict.fromkeys(each.rule for each in (*first, *second)):
        at_lower, at_higher = _verdict(rule, first), _verdict(rule, second)
        of_lower = VERDICTS.index(at_lower) <= VERDICTS.index(at_higher)
        judgements, other, gap = (first, at_higher, higher) if of_lower else (second, at_lower, lower)
        found += [_with_bound(each, other, gap) for each in judgements if each.rule == rule]
    return found


def compass(outward: tuple[float, float]) -> str:
    """Name a direction in the board's plane as seen from the top: right, back, left, front and between."""
    names = ("right", "back right", "back", "back left", "left", "front left", "front", "front right")
    return names[round(float(np.arctan2(outward[1], outward[0])) / (np.pi / 4)) % 8]


def _verdict(rule: Rule, judgements: Sequence[Judgement]) -> Verdict:
    """Verdict of a rule at one bound, ``clean`` where it raises nothing.

    A gap that stays dry, is plugged or is not thin is judged by that alone; one that is none of these, by all rules.
    """
    alone = {rules.DRY_GAP, rules.PLUGGED_GAP} if rule in _OF_FLOW else {rules.DRY_GAP}
    stands = [each for each in judgements if each.rule == rule]
    stands += [each for each in judgements if each.rule in alone or _is_not_thin([each])]
    if stands:
        return stands[0].verdict
    found: list[Verdict] = [each.verdict for each in judgements] if rule in _DECIDING else []
    return min(found, key=VERDICTS.index) if found else "clean"


def _is_not_thin(judgements: Sequence[Judgement]) -> bool:
    return any(each.rule == rules.MODEL_LIMIT and each.numbers for each in judgements)


def _with_bound(judgement: Judgement, other: str, gap: GapResult) -> Judgement:
    if other == judgement.verdict:
        return judgement
    words = "without a verdict" if other == "no verdict" else other
    bound = f" At the other bound, a standoff of {1000 * gap.gap_height_mm:.0f} µm, it is {words}."
    return replace(judgement, because=judgement.because + bound)


def _percent(value: float) -> str:
    """Write percent with two digits, and what is next to nothing as that."""
    return f"less than {_LEAST_PERCENT:g} %" if 0.0 < value < _LEAST_PERCENT else f"{two_digits(value)} %"


@dataclass(frozen=True, slots=True)
class _Gap:
    """One gap at one bound of its height, through all stages."""

    evidence: Evidence
    gap: GapResult

    def judge(self) -> list[Judgement]:
        """Apply the rules in the order in which they decide: a gap that is not thin, dry or plugged has no flow."""
        washes, rinses = self._stages("wash"), self._stages("rinse")
        no_model = list(self._model_limit(washes))
        if no_model:
            return no_model if no_model[0].numbers else [*no_model, *self._wet()]
        found = list(self._dry(washes))
        found += self._plugged()
        if not found:
            found = [*self._not_flushed(washes), *self._one_sided(washes), *self._residue()]
        if any(each.rule == rules.DRY_GAP for each in found):
            return found
        return [*found, *self._not_rinsed(rinses), *self._wet()]

    def _stages(self, use: str) -> list[tuple[Stage, GapStage]]:
        pairs = zip(self.evidence.stages, self.gap.stages, strict=True)
        return [(stage, at) for stage, at in pairs if at is not None and stage.use == use]

    @property
    def _height_um(self) -> float:
        return 1000.0 * self.gap.gap_height_mm

    @property
    def _place(self) -> str:
        return f"under it, in a gap of {1000 * self.gap.gap_height_mm:.0f} µm"

    def _model_limit(self, washes: list[tuple[Stage, GapStage]]) -> Iterator[Judgement]:
        """A gap that is not thin, or one that no wash acts on, so that nothing shows what is to be removed."""
        thickest = self.evidence.parameters.gap.thickest_um
        judge = partial(Judgement, rule=rules.MODEL_LIMIT, verdict="no verdict")
        if self._height_um > thickest:
            because = f"A gap of {self._height_um:.0f} µm is no thin gap, which the model does not cover."
            found = (Number("standoff", self._height_um, "µm", thickest),)
            yield judge(numbers=found, because=because, advice="Inspect it.")
        elif not washes:
            because = "No wash acts on it, so that whatever is in the gap under it stays there."
            advice = "Add a wash if there is something to be removed from there."
            yield judge(because=because, advice=advice)

    def _dry(self, washes: list[tuple[Stage, GapStage]]) -> Iterator[Judgement]:
        if any(each.entered for _, each in washes):
            return
        stage, at = max(washes, key=lambda pair: pair[1].margin_pa)
        because = f"{stage.solution} does not get {self._place}: it lacks {-at.margin_pa:.0f} Pa."
        advice = "Lower the surface tension, raise the pressure, or spray its edges from nearer."
        if at.margin_pa >= 0:
            because = f"{stage.solution} never reaches the edges of the gap {self._place}."
            advice = "Add a perimeter pass around it."
        found = (Number("entry margin", at.margin_pa, "Pa", 0.0),)
        judge = partial(Judgement, rule=rules.DRY_GAP, verdict="dirty", stage=stage.made_by)
        yield judge(numbers=found, because=because, advice=advice)

    def _plugged(self) -> Iterator[Judgement]:
        if self.gap.fill < self.evidence.parameters.gap.plugged:
            return
        fill = Number("fill before washing", 100.0 * self.gap.fill, "%", 100.0 * self.evidence.parameters.gap.plugged)
        because = f"Residue fills {fill.value:.0f} % of the height {self._place}: nothing flows through."
        advice = "Print less paste, give the pads vents or more standoff, or let it soak for long."
        yield Judgement(rule=rules.PLUGGED_GAP, verdict="dirty", numbers=(fill,), because=because, advice=advice)

    def _not_flushed(self, washes: list[tuple[Stage, GapStage]]) -> Iterator[Judgement]:
        done, needed = sum(at.exchanges for _, at in washes), self.gap.exchanges_needed
        if done < needed:
            verdict: Verdict = "marginal" if done >= 0.5 * needed else "dirty"
            because = f"The liquid {self._place} is renewed {done:.1f} times; the residue needs {needed:.1f}."
            advice, found = "Add perimeter passes or a pause at its edges.", (Number("exchanges", done, "", needed),)
            yield Judgement(rule=rules.NOT_FLUSHED, verdict=verdict, numbers=found, because=because, advice=advice)

    def _one_sided(self, washes: list[tuple[Stage, GapStage]]) -> Iterator[Judgement]:
        """Weak flow in a part of the gap; the side that presses least is named."""
        limits, underside = self.evidence.parameters.limits, self.evidence.underside
        stage, at = min(washes, key=lambda pair: pair[1].weak_share)
        if at.weak_share <= limits.weak_share or underside is None:
            return
        angle = underside.turn_rad + (-0.5 + 0.5 * int(np.argmin(at.side_shear_pa))) * np.pi
        outward = (float(np.cos(angle)), float(np.sin(angle)))
        found = (Number("gap with weak flow", 100.0 * at.weak_share, "%", 100.0 * limits.weak_share),)
        low = f"In {100.0 * at.weak_share:.0f} % of the gap the shear stays below {limits.weak_shear_pa:g} Pa"
        because = f"{low}; least comes from the {compass(outward)}."
        advice = f"Add a pass along its {compass(outward)} edge, leaning towards it."
        judge = partial(Judgement, rule=rules.ONE_SIDED, verdict="marginal", stage=stage.made_by, sides=(outward,))
        yield judge(numbers=found, because=because, advice=advice)

    def _residue(self) -> Iterator[Judgement]:
        """Residue that is left, as a mean and in the worst tenth."""
        limits, gap, underside = self.evidence.parameters.limits, self.gap, self.evidence.underside
        mean, worst = 100.0 * gap.residue, 100.0 * gap.residue_worst
        pocket = gap.residue_worst > limits.pocket
        verdict: Verdict = "dirty" if gap.residue > limits.gap_dirty else "marginal"
        most = limits.gap_marginal / limits.margin
        if gap.residue <= most and not pocket:
            verdict = "clean"
        where = None
        if underside is not None:
            (x, y), cos, sin = gap.worst_at, float(np.cos(underside.turn_rad)), float(np.sin(underside.turn_rad))
            where = (underside.x_mm + cos * x - sin * y, underside.y_mm + sin * x + cos * y, self.evidence.place[2])
        yield Judgement(
            rule=rules.RESIDUE_LEFT,
            variant="pocket" if pocket and gap.residue <= limits.gap_dirty else "",
            verdict=verdict,
            calibrated=self.evidence.parameters.calibrated,
            numbers=(
                Number("residue", mean, "%", 100.0 * most),
                Number("residue, worst tenth", worst, "%", 100.0 * limits.pocket),
            ),
            because=f"{_percent(mean)} of the residue is left {self._place}; in its worst tenth {_percent(worst)}."
            + self._reservations(limits.gap_marginal, most),
            advice="" if verdict == "clean" else "Soak longer, wash warmer, or add perimeter passes.",
            where=where,
        )

    def _reservations(self, limit: float, most: float) -> str:
        """State that the limit is kept without the margin of a clean part, and that the flow was at its lower bound."""
        words = ""
        if most < self.gap.residue <= limit:
            words = f" That is within the limit of {100.0 * limit:g} %; clean with a margin is {100.0 * most:g} %."
        thin = self.evidence.parameters.gap.most_reynolds
        reynolds = max((at.reynolds for _, at in self._stages("wash")), default=0.0)
        if reynolds > thin:
            number = f"{two_digits(reynolds)} (a thin gap: {thin:g} at most)"
            words += f" With a reduced Reynolds number of {number} the flow was taken at its lower bound."
        return words

    def _not_rinsed(self, rinses: list[tuple[Stage, GapStage]]) -> Iterator[Judgement]:
        """Whether the wash is diluted away; a process without a rinse is judged as a whole."""
        if not rinses:
            return
        limits, ionic = self.evidence.parameters.limits, self.gap.ionic_ug_cm2
        once = sum(at.exchanges for _, at in rinses)
        done = sum(stage.repeats * at.exchanges for stage, at in rinses)
        if done < limits.exchanges:
            more = int(np.ceil(limits.exchanges / done)) if done > 0 else 0
            because = f"Rinsing renews the liquid {self._place} {once:.1f} times (limit {limits.exchanges:g})"
            because += f"; {done:.1f} times if it is repeated as often as it may be." if done > once else "."
            advice = "Rinse along its edges."
            if 0 < more <= _MOST_RINSES:
                advice = f"Rinse {more} times as long, or repeat the rinse."
            verdict: Verdict = "marginal" if done >= 0.25 * limits.exchanges else "dirty"
            found = (Number("exchanges in rinsing", done, "", limits.exchanges),)
            judge = partial(Judgement, rule=rules.INCOMPLETE_RINSE, stage=rinses[-1][0].made_by)
            yield judge(verdict=verdict, numbers=found, because=because, advice=advice)
        if limits.ionic_ug_cm2 is not None and ionic > limits.ionic_ug_cm2:
            because = f"An estimated {two_digits(ionic)} µg/cm² stays {self._place}; your limit is "
            because += f"{limits.ionic_ug_cm2:g}."
            found = (Number("estimated ionic index", ionic, "µg/cm²", limits.ionic_ug_cm2),)
            judge = partial(Judgement, rule=rules.IONIC_RESIDUE, verdict="dirty")
            yield judge(numbers=found, because=because, advice="Rinse more.")

    def _wet(self) -> Iterator[Judgement]:
        """Water that blow-off leaves, against the time in which it may evaporate."""
        least, dry_s = self.gap.blow_off_um, self.gap.dry_s
        if least is None or dry_s is None or self._height_um >= least:
            return
        warm_s, warm_c = self._warmth()
        dry = dry_s <= warm_s
        clears = f"gaps from {least:.0f} µm on" if np.isfinite(least) else "no gap here"
        needs = f"needs {two_digits(dry_s)} s to evaporate" if np.isfinite(dry_s) else "does not evaporate"
        because = (
            f"Drying blows clear {clears}; this one is {self._height_um:.0f} µm high. What is left {needs}, "
            f"if the board is as warm as the air, {warm_c:g} °C; it is warm for {two_digits(warm_s)} s."
        )
        yield Judgement(
            rule=rules.WET_GAP,
            variant="dry" if dry else "",
            verdict="clean" if dry else "marginal",
            numbers=(
                Number("gap", self._height_um, "µm"),
                Number("least gap that is blown clear", least, "µm"),
                Number("time to evaporate", dry_s, "s", warm_s),
            ),
            because=because,
            advice="" if dry else _DRIER,
        )

    def _warmth(self) -> tuple[float, float]:
        """How long the board is at the temperature at which the rest evaporates, s, and that temperature, °C."""
        drying = self.evidence.parameters.drying
        if drying.bake_c is not None:
            return 60.0 * drying.bake_min, drying.bake_c
        gases = [stage for stage in self.evidence.stages if stage.use == "dry"]
        warmest = max((stage.temperature_c for stage in gases), default=drying.room_c)
        blown_s = sum(stage.end_s - stage.begin_s for stage in gases if stage.temperature_c == warmest)
        return blown_s + 60.0 * drying.dwell_min, warmest
