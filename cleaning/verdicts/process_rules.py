"""Rules on the whole process: bath, water and temperatures, and the range in which the model of the spray holds."""

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from boards.board import Board
from cleaning.parameters.model import Limits, Parameters
from cleaning.process.stages import Stage
from cleaning.undersides.rinse import water_resistivity
from cleaning.verdicts.results import Judgement, Number
from cleaning.verdicts.rules import INCOMPLETE_RINSE, MODEL_LIMIT, PROCESS_WINDOW, SPENT_BATH
from geometry.arrays import Scalars
from recipes.footprint import mid_angles
from recipes.nozzles import FullCone, HollowCone, Radial

_CLEANER_TANK = "Add a tank before it, or more fresh water (rinse.cascade)."
NEAREST_MM, FARTHEST_MM = 20.0, 200.0
"""Heights of the orifice over the board at which the spray is taken to be as at the height of its data sheet."""
_ROUNDED_MM = 0.1
"""A place that a log or joints give is not that of the plan to the last digit."""
_SHARE = 0.05
"""Share of the spraying time that may lie outside of the model: entering and leaving the board."""


def judge_process(stages: Sequence[Stage], parameters: Parameters) -> list[Judgement]:
    """Judge bath, rinse water, temperatures and the age of the residue."""
    limits, age, most = parameters.limits, parameters.soil.age_h, parameters.limits.hours_after_reflow
    found = [judgement for stage in stages for judgement in (*_solution(stage, limits), *_suits(stage, parameters))]
    uses = {stage.use for stage in stages}
    if "wash" in uses and age is not None and most is not None and age > most:
        because = f"Washing begins {age:g} h after reflow (limit {most:g} h): residue that has aged gives way less."
        advice = "Wash sooner, or take a parameter set for aged residue."
        aged = (Number("hours after reflow", age, "h", most),)
        found.append(Judgement(rule=PROCESS_WINDOW, verdict="marginal", numbers=aged, because=because, advice=advice))
    if "wash" in uses and "rinse" not in uses:
        because = "The board is washed and never rinsed: what the bath carries dries on it."
        advice = "Add a rinse to the sequence."
        found.append(Judgement(rule=INCOMPLETE_RINSE, verdict="dirty", because=because, advice=advice))
    return found


def judge_range(stages: Sequence[Stage], board: Board) -> list[Judgement]:
    """Judge where sprays of liquid are outside of the model: open on the board, too near or too far."""
    return [judgement for stage in stages if stage.use != "dry" for judgement in _range(stage, board)]


def _solution(stage: Stage, limits: Limits) -> Iterator[Judgement]:
    """The bath of a wash, the water of a rinse, and the temperature window of either."""
    liquid, judge = stage.liquid, partial(Judgement, stage=stage.made_by)
    if stage.use == "wash" and liquid.bath_nvr_pct > limits.bath_nvr_pct:
        most = limits.bath_nvr_pct
        found = (Number("non-volatile residue", liquid.bath_nvr_pct, "%", most),)
        because = f"The bath of {stage.solution} carries {liquid.bath_nvr_pct:g} % residue (limit {most:g} %)."
        yield judge(rule=SPENT_BATH, verdict="marginal", numbers=found, because=because, advice="Change the bath.")
    resistivity = water_resistivity(stage) if stage.use == "rinse" else None
    if resistivity is not None and resistivity < limits.rinse_warn_mohm:
        least, verdict = limits.rinse_warn_mohm, "dirty" if resistivity < limits.rinse_fail_mohm else "marginal"
        of_tank = "." if stage.water_g_m3 is None else ": boards carry the bath over into its tank."
        because = f"{stage.solution} has {resistivity:.3g} MOhm cm (limit {least:g} MOhm cm)" + of_tank
        advice = "Rinse with cleaner water." if stage.water_g_m3 is None else _CLEANER_TANK
        found = (Number("resistivity", resistivity, "MOhm cm", least),)
        yield judge(rule=INCOMPLETE_RINSE, verdict=verdict, numbers=found, because=because, advice=advice)
    window, celsius = liquid.window_c, stage.temperature_c
    if window is not None and (limit := _beyond(celsius, window)) is not None:
        made_for = f"{stage.solution} is made for {window[0]:g} to {window[1]:g} °C"
        because = f"{stage.function} is at {celsius:g} °C; {made_for}."
        found = (Number("temperature", celsius, "°C", limit),)
        advice = f"Change temperature_c of {stage.function}."
        yield judge(rule=PROCESS_WINDOW, verdict="marginal", numbers=found, because=because, advice=advice)


def _beyond(value: float, window: tuple[float, float]) -> float | None:
    """The end of a window that a value lies beyond; ``None`` within it."""
    return window[0] if value < window[0] else window[1] if value > window[1] else None


def _suits(stage: Stage, parameters: Parameters) -> Iterator[Judgement]:
    """Whether a washing solution removes this kind of flux, and has a concentration at which it may be used."""
    liquid, kind = stage.liquid, parameters.soil.flux
    judge = partial(Judgement, rule=PROCESS_WINDOW, variant="solution", stage=stage.made_by)
    if stage.use != "wash":
        return
    if kind is not None and liquid.dissolves and kind not in liquid.dissolves:
        removed = " and ".join(each.replace("_", "-") for each in liquid.dissolves)
        made_for = f"the parameter set {parameters.parameters} is for {kind.replace('_', '-')} flux"
        because = f"{stage.solution} removes {removed} flux; {made_for}, whose rates do not hold for it."
        advice = f"Choose another solution for {stage.function}, or the parameter set for the flux on the board."
        yield judge(verdict="dirty", because=because, advice=advice)
    window, percent = liquid.concentration_window_pct, liquid.concentration_pct
    if window is not None and (limit := _beyond(percent, window)) is not None:
        because = f"{stage.solution} has {percent:g} % of agent; it is made for {window[0]:g} to {window[1]:g} %."
        found = (Number("concentration", percent, "%", limit),)
        yield judge(verdict="marginal", numbers=found, because=because, advice="Change its concentration.")


def _range(stage: Stage, board: Board) -> Iterator[Judgement]:
    up = 1.0 if stage.side == "top" else -1.0
    heights = up * (stage.samples.tcp[:, 2] - board.surface_z_mm(stage.side))
    near, far = heights < NEAREST_MM - _ROUNDED_MM, heights > FARTHEST_MM + _ROUNDED_MM
    outside = (
        ("its spray does not close on the board", _opening(stage, up) <= 0.0, "Tilt it less."),
        (f"its nozzle is nearer than {NEAREST_MM:g} mm", near, "Spray from further away."),
        (f"its nozzle is farther than {FARTHEST_MM:g} mm", far, "Spray from nearer."),
    )
    judge = partial(Judgement, rule=MODEL_LIMIT, verdict="no verdict", stage=stage.made_by)
    for what, samples, advice in outside:
        share = float(stage.samples.seconds[samples].sum()) / stage.spray_s if stage.spray_s > 0 else 0.0
        if share > _SHARE:
            where = f"In {100.0 * share:.0f} % of the spraying time of {stage.function}"
            found = (Number("time outside of the model", 100.0 * share, "%", 100.0 * _SHARE),)
            yield judge(numbers=found, because=f"{where} {what}: the model does not hold.", advice=advice)


def _opening(stage: Stage, up: float) -> Scalars:
    """(samples,) least fall towards the board of the rays around the spray, per length along its axis.

    At or below 0 a ray never meets the board. For a cone of half angle a that leans by b it is cos b - sin b tan a,
    which has the sign of cos² b - sin² a, the discriminant of its footprint.
    """
    x, y, along = (-up * stage.samples.axes[:, 2, axis] for axis in range(3))
    nozzle = stage.nozzle
    if isinstance(nozzle, HollowCone | FullCone | Radial):
        widest = mid_angles(nozzle, np.linspace(0.0, 2.0 * np.pi, 360, endpoint=False, dtype=np.float64)).max()
        return np.asarray(along - np.hypot(x, y) * np.tan(widest), dtype=np.float64)
    wide, thin = np.tan(np.radians([nozzle.half_angle_deg, nozzle.thickness_half_angle_deg]))
    return np.asarray(along - np.abs(x) * wide - np.abs(y) * thin, dtype=np.float64)
