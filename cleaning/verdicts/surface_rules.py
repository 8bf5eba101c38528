"""Rules R1, R2, R3 and R13: what reaches the exposed surface of a component, and what it bears."""

from math import ceil

from cleaning.process.stages import Stage
from cleaning.verdicts.evidence import Evidence, Reach
from cleaning.verdicts.results import ExposedPart, Judgement, Number
from cleaning.verdicts.rounding import two_digits
from cleaning.verdicts.rules import DAMAGE_RISK, MISSED, MODEL_LIMIT, PROCESS_WINDOW, UNDER_EXPOSED, Verdict

_FEW = 0.01
"""Share of an exposed surface that may be missed without a word: less than the rays can tell."""
_MANY = 0.05
_HALF = 0.5
"""Below this share of a limit it is missed by far."""
_NOTHING = 0.01
"""Below this share of a limit the digits of a volume mean nothing, and going slower does not help."""


def not_sprayed(evidence: Evidence) -> Judgement:
    """R1 for a side that no liquid reaches."""
    because = f"No step sprays liquid on the {evidence.side} side."
    advice = f"Add a step to the sequence that sprays a liquid, with side: {evidence.side}."
    return Judgement(
        rule=MISSED, variant="not sprayed", verdict="dirty", because=because, advice=advice, where=evidence.place
    )


def judge_reach(evidence: Evidence, reach: Reach) -> list[Judgement]:
    """R1 and R2: exposed surfaces that are missed, or get too little. A component that shows nothing has none."""
    exposed = reach.exposed
    if exposed.area_mm2 == 0:
        return []
    missed = _missed(evidence, reach)
    return missed if exposed.missed_share > _MANY else [*missed, _amount(evidence, reach)]


def _missed(evidence: Evidence, reach: Reach) -> list[Judgement]:
    if reach.exposed.missed_share <= _FEW:
        return []
    share = Number("missed", 100.0 * reach.exposed.missed_share, "%", 100.0 * _FEW)
    because = f"{share.value:.1f} % of its exposed surface is never hit in {reach.functions}"
    because += f"; {_blocker(evidence)} stands in the way." if evidence.occluder else "."
    advice = "Spray it from another side or tilt, or add a perimeter pass around it."
    verdict: Verdict = "dirty" if reach.exposed.missed_share > _MANY else "marginal"
    return [
        Judgement(
            rule=MISSED,
            variant="shadowed" if evidence.occluder else "",
            verdict=verdict,
            numbers=(share,),
            because=because,
            advice=advice,
            stage=reach.made_by,
            where=evidence.place,
        )
    ]


def _blocker(evidence: Evidence) -> str:
    if evidence.occluder == evidence.component:
        return "its own body" if evidence.component != "board" else "the board itself"
    return "the board" if evidence.occluder == "board" else evidence.occluder


def _amount(evidence: Evidence, reach: Reach) -> Judgement:
    limits, (least, low, _) = evidence.parameters.limits, reach.exposed.volume_mm
    limit = limits.wash_volume_mm if reach.use == "wash" else limits.rinse_volume_mm
    numbers = [Number("volume, 5th percentile", low, "mm", limit), Number("volume, least", least, "mm")]
    share = low / limit
    most = f"at most {two_digits(low)} mm" if share >= _NOTHING else f"less than {_NOTHING * limit:g} mm"
    because = (
        f"The least wetted twentieth of its exposed surface gets {most} in {reach.functions} (limit {limit:g} mm)."
    )
    if reach.use == "wash" and limits.front_s > 0:
        front = reach.exposed.front_s[1]
        numbers.append(Number("time in the wave front, 5th percentile", front, "s", limits.front_s))
        because += f" It is in the wave front for {two_digits(front)} s (limit {limits.front_s:g} s)."
        share = min(share, front / limits.front_s)
    if share < 1 and reach.repeats > 1:
        share *= reach.repeats
        often = ceil(reach.repeats / share) if share >= 1 else 0
        because += f" It must be done {often} times" if often else " It is too little even if done"
        because += f", of {reach.repeats} at most." if often else f" {reach.repeats} times, as often as it may be."
    verdict: Verdict = "clean" if share >= 1 else "marginal" if share >= _HALF else "dirty"
    return Judgement(
        rule=UNDER_EXPOSED,
        variant="exposed" if verdict == "clean" else "",
        verdict=verdict,
        numbers=tuple(numbers),
        because=because,
        advice="" if verdict == "clean" else _more(low / limit),
        stage=reach.made_by,
        where=evidence.place,
    )


def _more(share: float) -> str:
    """Say what brings more volume to where this share of the limit lands."""
    if share < _NOTHING:
        return "Hardly any reaches it there: add a pass from another side, or tilt the jet."
    return "Go slower or nearer, or add a pass."


def judge_load(evidence: Evidence, stage: Stage, exposed: ExposedPart) -> list[Judgement]:
    """R3 and R13: what the component itself bears."""
    found: list[Judgement] = []
    bears, window = evidence.override.most_kpa, evidence.override.window_c
    if bears is not None and exposed.peak_pa > 1000.0 * bears:
        peak = Number("peak pressure", exposed.peak_pa / 1000.0, "kPa", bears)
        because = f"{stage.function} presses with {two_digits(peak.value)} kPa on it; it bears {bears:g} kPa."
        advice = "Avoid it with a mask, spray from further away, or lower the pressure."
        found.append(
            Judgement(
                rule=DAMAGE_RISK,
                verdict="dirty",
                numbers=(peak,),
                because=because,
                advice=advice,
                stage=stage.made_by,
                where=evidence.place,
            )
        )
    if window is not None and not window[0] <= stage.temperature_c <= window[1]:
        warmth = Number("temperature", stage.temperature_c, "°C", window[1])
        because = f"{stage.function} is at {stage.temperature_c:g} °C; it bears {window[0]:g} to {window[1]:g} °C."
        advice = f"Change temperature_c of {stage.function}."
        found.append(
            Judgement(
                rule=PROCESS_WINDOW,
                verdict="dirty",
                numbers=(warmth,),
                because=because,
                advice=advice,
                stage=stage.made_by,
                where=evidence.place,
            )
        )
    return found


def not_judged(evidence: Evidence) -> Judgement:
    """R14 for a component that shows nothing and has no gap that is known."""
    because = "It shows no surface that spray can reach, and no gap under it is known."
    return Judgement(
        rule=MODEL_LIMIT, verdict="no verdict", because=because, advice="Inspect it.", where=evidence.place
    )
