"""Which side of Sinner's circle limits the cleaning of a gap: time, temperature, chemistry, or mechanics.

Mechanics are the pressure and the nozzle's distance. Each factor is made five per cent larger, one at a time, and the
residue compared: the elasticity d ln(residue) / d ln(x). Temperature counts in degrees Celsius.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import log
from typing import TypeAlias

from cleaning.film.edge_pressure import edge_pressures, pressing_samples
from cleaning.gap.edge_segments import EdgePressure, Edges
from cleaning.jet.jet import Jet
from cleaning.parameters.model import Parameters
from cleaning.process.stages import Stage
from geometry.disc_grid import DiscGrid

_STEP = 1.05
FLOOR = 1e-4
"""Share of residue below which nothing is left to limit."""

Pressures: TypeAlias = Sequence[Sequence[EdgePressure]]
"""Per stage one per row of the edges."""


@dataclass(frozen=True, slots=True, eq=False)
class VariedStages:
    """Stages with five per cent more of each factor; they serve all gaps of the edges that they were made for."""

    stages: tuple[Stage, ...]
    """As they are."""
    jets: tuple[Jet, ...]
    more: Mapping[str, tuple[Stage, ...]]
    """With more time, a higher temperature or more chemistry, by that name; the pressures on edges stay."""
    farther: Mapping[float, tuple[Stage, ...]]
    """By the height of the edges, mm."""
    near: Mapping[float, tuple[DiscGrid, ...]]
    """``pressing_samples`` of the farther stages, likewise."""


def vary(stages: Sequence[Stage], jets: Sequence[Jet], edges: Edges, parameters: Parameters) -> VariedStages:
    """Make the stages anew with five per cent more of each factor, for the gaps of some edges."""
    longer, stronger = list[Stage](), list[Stage]()
    for stage in stages:
        samples = replace(stage.samples, seconds=_STEP * stage.samples.seconds, times=_STEP * stage.samples.times)
        longer.append(replace(stage, begin_s=_STEP * stage.begin_s, end_s=_STEP * stage.end_s, samples=samples))
        liquid = stage.liquid.model_copy(update={"concentration_pct": _STEP * stage.liquid.concentration_pct})
        stronger.append(replace(stage, liquid=liquid))

    def farther_of(stage: Stage, height_mm: float) -> Stage:
        """Draw the nozzle back along its jet by a twentieth of its height over the edges."""
        samples, height = stage.samples, stage.samples.tcp[:, 2] - height_mm
        away = samples.tcp - (_STEP - 1.0) * abs(height)[:, None] * samples.axes[:, :, 2]
        return replace(stage, samples=replace(samples, tcp=away))

    farther = {each: tuple(farther_of(stage, each) for stage in stages) for each in sorted({*_heights(edges)})}
    near = {
        each: tuple(pressing_samples(stage, jet, edges, parameters.film) for stage, jet in zip(some, jets, strict=True))
        for each, some in farther.items()
    }
    warmer = tuple(replace(stage, temperature_c=_STEP * stage.temperature_c) for stage in stages)
    more = {"time": tuple(longer), "temperature": warmer, "chemistry": tuple(stronger)}
    return VariedStages(tuple(stages), tuple(jets), more, farther, near)


def variants(
    varied: VariedStages, pressures: Pressures, edges: Edges, parameters: Parameters
) -> dict[str, tuple[tuple[Stage, ...], Pressures]]:
    """Give stages and edge pressures with five per cent more of each factor, by its name.

    Args:
        varied: The stages.
        pressures: Of the stages as they are.
        edges: One row, or rows of one side.
        parameters: Everything else.
    """
    harder, farther = list[list[EdgePressure]](), list[list[EdgePressure]]()
    heights = _heights(edges)
    for at, (stage, jet, rows) in enumerate(zip(varied.stages, varied.jets, pressures, strict=True)):
        # Stress goes with flow times speed, and speed with the root of the pressure.
        gain = float(_STEP ** (parameters.spray.exponent_of(stage.nozzle.pattern) + 0.5))
        harder.append([replace(each, pressure_pa=gain * each.pressure_pa) for each in rows])
        found: list[EdgePressure] = []
        if heights:
            back, near = varied.farther[heights[0]][at], varied.near[heights[0]][at]
            found = edge_pressures(back, jet, edges, parameters.film, near)
        farther.append(found)
    mechanics = {"pressure": (varied.stages, harder), "standoff": (varied.stages, farther)}
    return {name: (stages, pressures) for name, stages in varied.more.items()} | mechanics


def _heights(edges: Edges) -> list[float]:
    """Mean height of the edges of each row, mm."""
    return [float(each.mean()) for each in edges.middles[:, :, 2]]


def elasticity(before: float, after: float) -> float:
    """Give d ln(residue) / d ln(x) of a change by five per cent; 0 where there is nothing left to lose."""
    return log(max(after, FLOOR) / max(before, FLOOR)) / log(_STEP)


def limiting(elasticities: Mapping[str, float]) -> str:
    """Name the factor that matters most; empty where none does."""
    strongest = max(elasticities, key=lambda name: abs(elasticities[name]), default="")
    return strongest if strongest and abs(elasticities[strongest]) > 0 else ""
