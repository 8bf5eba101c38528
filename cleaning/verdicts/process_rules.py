"""Rules on the whole process: bath, water and temperatures, and the range in which the model of the spray holds."""

from collections.abc import Iterator, Sequence

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
        number = Number("hours after reflow", age, "h", most)
        found.append(
            Judgement(rule=PROCESS_WINDOW, verdict="marginal", numbers=(number,), because=because, advice=advice)
        )
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
    liquid, low, high = stage.liquid, limits.rinse_fail_mohm, limits.rinse_warn_mohm
    if stage.use == "wash" and liquid.bath_nvr_pct > limits.bath_nvr_pct:
        most = limits.bath_nvr_pct
        yield Judgement(
            rule=SPENT_BATH,
            verdict="marginal",
            numbers=(Number("non-volatile residue", liquid.bath_nvr_pct, "%", most),),
            because=f"The bath of {stage.solution} carries {liquid.bath_nvr_pct:g} % residue (limit {most:g} %).",
            advice="Change the bath.",
            stage=stage.made_by,
        )
    resistivity = water_resistivity(stage) if stage.use == "rinse" else None
    if resistivity is not None and resistivity < high:
        of_tank = "." if stage.water_g_m3 is None else ": boards carry the bath over into its tank."
        yield Judgement(
            rule=INCOMPLETE_RINSE,
            verdict="dirty" if resistivity < low else "marginal",
            numbers=(Number("resistivity", resistivity, "MOhm cm", high),),
            because=f"{stage.solution} has {resistivity:.3g} MOhm cm (limit {high:g} MOhm cm)" + of_tank,
            advice="Rinse with cleaner water." if stage.water_g_m3 is None else _CLEANER_TANK,
            stage=stage.made_by,
        )
    window, celsius = liquid.window_c, stage.temperature_c
    if window is not None and not window[0] <= celsius <= window[1]:
        made_for = f"{stage.solution} is made for {window[0]:g} to {window[1]:g} °C"
        yield Judgement(
            rule=PROCESS_WINDOW,
            verdict="marginal",
            numbers=(Number("temperature", celsius, "°C", window[0] if celsius < window[0] else window[1]),),
            because=f"{stage.function} is at {celsius:g} °C; {made_for}.",
            advice=f"Change temperature_c of {stage.function}.",
            stage=stage.made_by,
        )


def _suits(stage: Stage, parameters: Parameters) -> Iterator[Judgement]:
    """Whether a washing solution removes this kind of flux, and has a concentration at which it may be used."""
    liquid, kind = stage.liquid, parameters.soil.flux
    if stage.use != "wash":
        return
    if kind is not None and liquid.dissolves and kind not in liquid.dissolves:
        removed = " and ".join(each.replace("_", "-") for each in liquid.dissolves)
        yield Judgement(
            rule=PROCESS_WINDOW,
            variant="solution",
            verdict="dirty",
            because=f"{stage.solution} removes {removed} flux; the parameter set {parameters.parameters} is for "
            f"{kind.replace('_', '-')} flux, whose rates do not hold for it.",
            advice=f"Choose another solution for {stage.function}, or the parameter set for the flux on the board.",
            stage=stage.made_by,
        )
    window, percent = liquid.concentration_window_pct, liquid.concentration_pct
    if window is not None and not window[0] <= percent <= window[1]:
        number = Number("concentration", percent, "%", window[0] if percent < window[0] else window[1])
        yield Judgement(
            rule=PROCESS_WINDOW,
            variant="solution",
            verdict="marginal",
            numbers=(number,),
            because=f"{stage.solution} has {percent:g} % of agent; it is made for {window[0]:g} to {window[1]:g} %.",
            advice="Change its concentration.",
            stage=stage.made_by,
        )


def _range(stage: Stage, board: Board) -> Iterator[Judgement]:
    up = 1.0 if stage.side == "top" else -1.0
    heights = up * (stage.samples.tcp[:, 2] - board.surface_z_mm(stage.side))
    outside = (
        ("its spray does not close on the board", _opening(stage, up) <= 0.0, "Tilt it less."),
        (f"its nozzle is nearer than {NEAREST_MM:g} mm", heights < NEAREST_MM, "Spray from further away."),
        (f"its nozzle is farther than {FARTHEST_MM:g} mm", heights > FARTHEST_MM, "Spray from nearer."),
    )
    for what, samples, advice in outside:
        share = float(stage.samples.seconds[samples].sum()) / stage.spray_s if stage.spray_s > 0 else 0.0
        if share > _SHARE:
            where = f"In {100.0 * share:.0f} % of the spraying time of {stage.function}"
            yield Judgement(
                rule=MODEL_LIMIT,
                verdict="no verdict",
                numbers=(Number("time outside of the model", 100.0 * share, "%", 100.0 * _SHARE),),
                because=f"{where} {what}: the model does not hold.",
                advice=advice,
                stage=stage.made_by,
            )


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
