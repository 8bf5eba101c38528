"""Which side of Sinner's circle limits the cleaning of a gap: time, temperature, chemistry, or mechanics.

Mechanics are the pressure and the nozzle's distance. Each factor is made five per cent larger, one at a time, and the
residue compared: the elasticity d ln(residue) / d ln(x). Temperature counts in degrees Celsius.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import log
from typing import TypeAlias

from cleaning.film.edge_pressure import edge_pressures
from cleaning.gap.edge_segments import EdgePressure, Edges
from cleaning.jet.jet import Jet
from cleaning.parameters.model import Parameters
from cleaning.process.stages import Stage

_STEP = 1.05
FLOOR = 1e-4
"""Share of residue below which nothing is left to limit."""

Pressures: TypeAlias = Sequence[Sequence[EdgePressure]]
"""Per stage one per row of the edges."""


def variants(
    stages: Sequence[Stage], jets: Sequence[Jet], pressures: Pressures, edges: Edges, parameters: Parameters
) -> dict[str, tuple[tuple[Stage, ...], Pressures]]:
    """Make the stages and the edge pressures anew with five per cent more of each factor, by its name."""
    longer, stronger = list[Stage](), list[Stage]()
    harder, farther = list[list[EdgePressure]](), list[list[EdgePressure]]()
    for stage, jet, rows in zip(stages, jets, pressures, strict=True):
        samples = replace(stage.samples, seconds=_STEP * stage.samples.seconds, times=_STEP * stage.samples.times)
        longer.append(replace(stage, begin_s=_STEP * stage.begin_s, end_s=_STEP * stage.end_s, samples=samples))
        liquid = stage.liquid.model_copy(update={"concentration_pct": _STEP * stage.liquid.concentration_pct})
        stronger.append(replace(stage, liquid=liquid))
        # Stress goes with flow times speed, and speed with the root of the pressure.
        gain = float(_STEP ** (parameters.spray.flow_exponent[stage.nozzle.pattern] + 0.5))
        harder.append([replace(each, pressure_pa=gain * each.pressure_pa) for each in rows])
        farther.append(edge_pressures(_farther(stage, edges), jet, edges, parameters.film))
    warmer = tuple(replace(stage, temperature_c=_STEP * stage.temperature_c) for stage in stages)
    return {
        "time": (tuple(longer), pressures),
        "temperature": (warmer, pressures),
        "chemistry": (tuple(stronger), pressures),
        "pressure": (tuple(stages), harder),
        "standoff": (tuple(stages), farther),
    }


def elasticity(before: float, after: float) -> float:
    """Give d ln(residue) / d ln(x) of a change by five per cent; 0 where there is nothing left to lose."""
    return log(max(after, FLOOR) / max(before, FLOOR)) / log(_STEP)


def limiting(elasticities: Mapping[str, float]) -> str:
    """Name the factor that matters most; empty where none does."""
    strongest = max(elasticities, key=lambda name: abs(elasticities[name]), default="")
    return strongest if strongest and abs(elasticities[strongest]) > 0 else ""


def _farther(stage: Stage, edges: Edges) -> Stage:
    """Draw the nozzle back along its jet by a twentieth of its height over the edges."""
    if not len(edges.middles):
        return stage
    samples = stage.samples
    height = samples.tcp[:, 2] - float(edges.middles[:, :, 2].mean())
    away = samples.tcp - (_STEP - 1.0) * abs(height)[:, None] * samples.axes[:, :, 2]
    return replace(stage, samples=replace(samples, tcp=away))
