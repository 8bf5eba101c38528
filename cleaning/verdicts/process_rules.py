"""Rules R9, R10 and R13 as far as they concern the whole process: bath, water, temperatures."""

from collections.abc import Sequence

from cleaning.parameters.model import Limits, Parameters
from cleaning.process.stages import Stage
from cleaning.verdicts.results import Judgement, Number
from cleaning.verdicts.rules import INCOMPLETE_RINSE, PROCESS_WINDOW, SPENT_BATH, Verdict


def judge_process(stages: Sequence[Stage], parameters: Parameters) -> list[Judgement]:
    """R9, R10 and R13 as far as they concern the whole process: bath, water, temperatures."""
    limits = parameters.limits
    found: list[Judgement] = []
    for stage in stages:
        found += [*_bath(stage, limits), *_water(stage, limits), *_warmth(stage)]
    found += _age(parameters) if any(stage.use == "wash" for stage in stages) else []
    if any(stage.use == "wash" for stage in stages) and not any(stage.use == "rinse" for stage in stages):
        because = "The board is washed and never rinsed: what the bath carries dries on it."
        found.append(
            Judgement(rule=INCOMPLETE_RINSE, verdict="dirty", because=because, advice="Add a rinse to the sequence.")
        )
    return found


def _age(parameters: Parameters) -> list[Judgement]:
    """R13 for residue that has hardened since it was soldered."""
    age, most = parameters.soil.age_h, parameters.limits.hours_after_reflow
    if age is None or most is None or age <= most:
        return []
    number = Number("hours after reflow", age, "h", most)
    because = f"Washing begins {age:g} h after reflow (limit {most:g} h): residue that has aged gives way less."
    advice = "Wash sooner, or take a parameter set for aged residue."
    return [Judgement(rule=PROCESS_WINDOW, verdict="marginal", numbers=(number,), because=because, advice=advice)]


def _bath(stage: Stage, limits: Limits) -> list[Judgement]:
    if stage.use != "wash" or stage.liquid.bath_nvr_pct <= limits.bath_nvr_pct:
        return []
    number = Number("non-volatile residue", stage.liquid.bath_nvr_pct, "%", limits.bath_nvr_pct)
    because = f"The bath of {stage.solution} carries {number.value:g} % residue (limit {limits.bath_nvr_pct:g} %)."
    return [
        Judgement(
            rule=SPENT_BATH,
            verdict="marginal",
            numbers=(number,),
            because=because,
            advice="Change the bath.",
            stage=stage.made_by,
        )
    ]


def _water(stage: Stage, limits: Limits) -> list[Judgement]:
    resistivity = stage.liquid.resistivity_mohm_cm
    if stage.use != "rinse" or resistivity is None or resistivity >= limits.rinse_warn_mohm:
        return []
    number = Number("resistivity", resistivity, "MOhm cm", limits.rinse_warn_mohm)
    verdict: Verdict = "dirty" if resistivity < limits.rinse_fail_mohm else "marginal"
    because = f"{stage.solution} has {resistivity:g} MOhm cm (limit {limits.rinse_warn_mohm:g} MOhm cm)."
    advice = "Rinse with cleaner water."
    return [
        Judgement(
            rule=INCOMPLETE_RINSE,
            verdict=verdict,
            numbers=(number,),
            because=because,
            advice=advice,
            stage=stage.made_by,
        )
    ]


def _warmth(stage: Stage) -> list[Judgement]:
    window = stage.liquid.window_c
    if window is None or window[0] <= stage.temperature_c <= window[1]:
        return []
    number = Number(
        "temperature", stage.temperature_c, "°C", window[0] if stage.temperature_c < window[0] else window[1]
    )
    because = (
        f"{stage.function} is at {stage.temperature_c:g} °C; {stage.solution} is made for {window[0]:g} to "
        f"{window[1]:g} °C."
    )
    advice = f"Change temperature_c of {stage.function}."
    return [
        Judgement(
            rule=PROCESS_WINDOW,
            verdict="marginal",
            numbers=(number,),
            because=because,
            advice=advice,
            stage=stage.made_by,
        )
    ]
