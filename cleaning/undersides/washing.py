"""What happens under one component while the process goes on: entry, flow, residue, rinse, drying."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from cleaning.gap.edge_segments import SEGMENTS, EdgePressure
from cleaning.gap.flow_field import GapField
from cleaning.gap.flushing import Flushed, FlushSettings, Values, bounded, flush, inertial, reduced_reynolds
from cleaning.parameters.liquid import capillary_pa, density_kg_m3, viscosity_pa_s
from cleaning.parameters.model import Parameters
from cleaning.process.stages import Stage
from cleaning.undersides.residue import (
    GapResult,
    GapStage,
    exchanges_needed,
    fill_share,
    open_share,
    softening_rate,
    step,
)
from cleaning.undersides.rinse import dry_gap, gap_content_g_m3, ionic_ug_cm2
from geometry.arrays import Scalars
from geometry.compiled import compiled

_MM = 1e-3
_TOGETHER_S = 1e-6
_UM = 1e-6
_TENTH = 0.1 - 1e-9
_KEPT = 32
"""Of results that all cases of a gap share: those of the gaps that are being followed, and no more."""
_SAME = 1e-6
"""Shares of residue nearer than this are the same."""


@dataclass(frozen=True, slots=True)
class _State:
    """What is left between two stages."""

    hard: float
    soft: Scalars
    front_m: float
    """How far a plugged gap is opened from its rim."""


@dataclass(frozen=True)
class _Gap:
    """One gap, and what of it stays the same. SI."""

    field: GapField
    height_m: float
    fill: float
    parameters: Parameters

    @cached_property
    def basis(self) -> NDArray[np.float32]:
        """(2, 8, c) velocity times viscosity at this height, one row per component and segment."""
        scale = np.float32((self.height_m / self.field.height_m) ** 2)
        return np.ascontiguousarray(np.moveaxis(self.field.velocity, 2, 0)) * scale

    @cached_property
    def weights(self) -> Scalars:
        """(c,) weight of each cell in a mean over the gap."""
        weights = self.field.weights.astype(np.float64)
        return weights / weights.sum()

    @property
    def plugged(self) -> bool:
        """Whether so much residue is in it that nothing flows through."""
        return self.fill >= self.parameters.gap.plugged

    def residue(self, state: _State) -> Scalars:
        """(c,) share of the residue that is left in each cell."""
        if not self.plugged:
            return state.hard + state.soft
        field = self.field
        centres = np.abs(field.centres)
        rim = np.minimum(0.5 * field.length_m - centres[:, 0], 0.5 * field.width_m - centres[:, 1])
        cell = min(field.length_m / field.shape[1], field.width_m / field.shape[0])
        return 1.0 - np.clip((state.front_m - rim) / cell + 0.5, 0.0, 1.0)

    def mean(self, values: Scalars) -> float:
        """Mean over the gap of what is 1 at most; exactly 1 where all of it is."""
        return 1.0 - float(self.weights @ (1.0 - values))

    def tenth(self, values: Scalars) -> int:
        """Rank, from the least, of the value below which a tenth of the gap lies."""
        passed = np.cumsum(self.weights[np.argsort(values, kind="stable")])
        return min(int(np.searchsorted(passed, _TENTH)), len(values) - 1)


@dataclass(frozen=True, slots=True)
class _Liquid:
    """What a stage brings into a gap. SI."""

    density: float
    viscosity: float
    softening: float


@dataclass(frozen=True, slots=True)
class _Flow:
    """What a stage does in a gap."""

    pressure: EdgePressure
    margin_pa: float
    entered: bool
    wet_s: float
    liquid: _Liquid
    done: Flushed
    after: _State


def simulate_gap(
    field: GapField,
    gap_height_mm: float,
    stages: Sequence[Stage],
    pressures: Sequence[EdgePressure | None],
    parameters: Parameters,
    paste_factor: float | None = None,
) -> GapResult:
    """Follow one gap through all stages.

    A liquid stage acts from the moment at which it gets in until its end: while the jet passes, shear carries off what
    is soft; all the time, the solution softens what is hard. Gas dries.

    Args:
        field: Flow for the joints of the gap; one of another height is scaled.
        gap_height_mm: Height of the gap.
        stages: Of the process.
        pressures: On the edges, one per stage; ``None`` where the stage sprays another side.
        parameters: Everything else.
        paste_factor: Scales the residue at first; left out: the parameters' own.
    """
    gap = _Gap(field, _MM * gap_height_mm, fill_share(parameters.soil, field.coverage, paste_factor), parameters)
    flows, state = _follow(gap, stages, pressures)
    acts = [None if flow is None else _describe(gap, flow) for flow in flows]
    residue = gap.residue(state)
    tenth = np.argsort(-residue, kind="stable")[: gap.tenth(-residue) + 1]
    alike = field.centres[residue >= residue.max() - _SAME]  # of several alike, the nearest to the middle
    x, y = alike[np.argmin(np.round(np.hypot(alike[:, 0], alike[:, 1]) / _UM))] / _MM
    depth = 0.5 * min(field.length_m, field.width_m)
    dried = dry_gap(parameters.drying, stages, pressures, gap.height_m, depth)
    return GapResult(
        gap_height_mm=gap_height_mm,
        field=field,
        fill=gap.fill,
        stages=tuple(acts),
        exchanges_needed=exchanges_needed(parameters.soil, parameters.gap, gap.fill),
        residue=gap.mean(residue),
        residue_worst=1.0 - float(np.average(1.0 - residue[tenth], weights=gap.weights[tenth])),
        worst_at=(float(x), float(y)),
        ionic_ug_cm2=ionic_ug_cm2(gap_content_g_m3(parameters.rinse, stages, acts), gap.height_m / _UM),
        blow_off_um=None if dried is None else dried[0] / _UM,
        dry_s=None if dried is None else dried[1],
    )


def residue_left(
    field: GapField,
    gap_height_mm: float,
    stages: Sequence[Stage],
    pressures: Sequence[EdgePressure | None],
    parameters: Parameters,
    paste_factor: float | None = None,
) -> float:
    """Find the mean share of residue at the end, as ``simulate_gap`` does, and nothing else."""
    gap = _Gap(field, _MM * gap_height_mm, fill_share(parameters.soil, field.coverage, paste_factor), parameters)
    _, state = _follow(gap, stages, pressures)
    return gap.mean(gap.residue(state))


def _follow(
    gap: _Gap, stages: Sequence[Stage], pressures: Sequence[EdgePressure | None]
) -> tuple[list[_Flow | None], _State]:
    """Give what each stage does in a gap, ``None`` where it does not act or dries, and what is left in the end."""
    state = _State(1.0, np.zeros(len(gap.field.cells)), 0.0)
    flows: list[_Flow | None] = []
    for stage, pressure in zip(stages, pressures, strict=True):
        flow = None if pressure is None or stage.use == "dry" else _flow(gap, stage, pressure, state)
        state = state if flow is None else flow.after
        flows.append(flow)
    return flows, state


def _flow(gap: _Gap, stage: Stage, pressure: EdgePressure, state: _State) -> _Flow:
    """Let liquid into a gap and through it, in one stage."""
    parameters = gap.parameters
    height = gap.height_m * open_share(parameters.gap, gap.fill * gap.mean(gap.residue(state)))
    capillary = capillary_pa(stage.liquid, stage.temperature_c, height)
    margin, first = entry_margin(pressure, stage, capillary, parameters.film.hold_s)
    liquid = _Liquid(
        density_kg_m3(stage.liquid, stage.temperature_c),
        viscosity_pa_s(stage.liquid, stage.temperature_c),
        softening_rate(parameters.soil, stage.temperature_c, stage.liquid.concentration_pct),
    )
    done, after, wet_s = Flushed(state.hard, state.soft, np.zeros(len(gap.field.cells)), 0.0, 0.0), state, 0.0
    if first >= 0:
        near = pressure.sample[first:]
        times, lasting = stage.samples.times[near], stage.samples.seconds[near]
        begins, ends = times - 0.5 * lasting, times + 0.5 * lasting
        soaks = np.maximum(begins - np.concatenate([begins[:1], ends[:-1]]), 0.0)
        # The soak before each sample that is near, and the sample itself; and the time to the stage's end.
        seconds, wet_s = np.column_stack([soaks, lasting]), max(stage.end_s - float(begins[0]), 0.0)
        if gap.plugged:
            # Nothing flows; layer by layer softens from the rim, so that a front moves at rate times depth.
            front = liquid.softening * (_UM * parameters.soil.front_um) * wet_s
            after = _State(state.hard, state.soft, state.front_m + front)
        else:
            pulses = np.ascontiguousarray(pressure.pressure_pa[first:])
            done = flush(gap.basis, pulses, seconds, _setting(gap, liquid), state.hard, state.soft)
            rest = wet_s - float(seconds.sum())
            hard, soft = step(done.hard, done.soft, liquid.softening, 0.0, max(rest, 0.0))
            after = _State(float(hard), soft, state.front_m)
    return _Flow(pressure, margin, first >= 0, wet_s, liquid, done, after)


def _describe(gap: _Gap, flow: _Flow) -> GapStage:
    """Sum up what a stage did in a gap."""
    weak = flow.done.shear_pa < gap.parameters.limits.weak_shear_pa
    return GapStage(
        margin_pa=flow.margin_pa,
        entered=flow.entered,
        edge_pa=tuple(_peaks_of(flow.pressure)[:SEGMENTS].tolist()),
        side_shear_pa=_side_shear(gap, flow.liquid, flow.pressure, flow.after),
        shear_pa=flow.done.shear_pa.astype(np.float32),
        weak_share=gap.mean(weak.astype(np.float64)),
        exchanges=2.0 * flow.done.travelled_m / gap.field.path_m,
        reynolds=float(_reynolds(gap, flow.liquid, flow.done.fastest_m_s)),
        wet_s=flow.wet_s,
        residue=gap.residue(flow.after).astype(np.float32),
    )


def _setting(gap: _Gap, liquid: _Liquid) -> FlushSettings:
    soil = gap.parameters.soil
    return FlushSettings(
        weights=gap.weights,
        height_m=gap.height_m,
        path_m=gap.field.path_m,
        fill=gap.fill,
        viscosity_pa_s=liquid.viscosity,
        drag_pa_s2_m2=0.5 * liquid.density * (1.0 + gap.parameters.gap.entrance_loss),
        thin_m_s=gap.parameters.gap.most_reynolds / float(_reynolds(gap, liquid, 1.0)),
        k1_per_s=liquid.softening,
        k2_per_s=soil.k_m_per_s / soil.shear_reference_pa**soil.shear_exponent,
        shear_exponent=soil.shear_exponent,
        shear_threshold_pa=soil.shear_threshold_pa,
    )


def _reynolds(gap: _Gap, liquid: _Liquid, speed_m_s: Values) -> Values:
    return reduced_reynolds(speed_m_s, gap.height_m, gap.field.path_m, liquid.density, liquid.viscosity)


def _side_shear(gap: _Gap, liquid: _Liquid, pressure: EdgePressure, state: _State) -> tuple[float, ...]:
    """(4,) wall shear that nine tenths of the gap exceed if each side alone is pressed as hard as it ever was."""
    if gap.plugged or not len(pressure.sample):
        return (0.0,) * (SEGMENTS // 2)
    best = _peaks_of(pressure)[SEGMENTS:].clip(min=0.0)
    sides = gap.basis.reshape(2, SEGMENTS // 2, 2, -1).sum(axis=2)
    flow = best[:, None] * np.hypot(sides[0], sides[1])
    open_ = 1.0 - gap.fill * gap.mean(gap.residue(state))
    mean = flow @ gap.weights * open_**2 / liquid.viscosity
    loss = gap.parameters.gap.entrance_loss
    slowed = inertial(mean, gap.height_m * open_, gap.field.path_m, liquid.density, liquid.viscosity, loss)
    slowed = bounded(slowed, _reynolds(gap, liquid, slowed), gap.parameters.gap.most_reynolds)
    share = np.divide(slowed, mean, out=np.ones_like(mean), where=mean > 0.0)
    least = [np.sort(each)[gap.tenth(each)] for each in flow]
    shear = share * 6.0 * open_ / gap.height_m * least
    return tuple(float(each) for each in shear)


def entry_margin(pressure: EdgePressure, stage: Stage, capillary_pa: float, hold_s: float) -> tuple[float, int]:
    """Find what is left of the held edge pressure after the gap has taken or given its share, and when it first is.

    A pressure is held if one segment feels no less of it in samples that follow each other without a pause and last
    ``hold_s`` together; a sample that lasts so long by itself will do. Where the film has come at all, it lies at the
    edge with no pressure at least, and a gap that draws liquid in needs no more than that. A component that no film
    reaches (it has no samples) stays dry however its gap draws.

    Args:
        pressure: Of one component in the stage.
        stage: Times the samples.
        capillary_pa: Capillary pressure at the open height h (1 - f).
        hold_s: How long a pressure must be held.

    Returns:
        The margin in Pa, and the first row of ``pressure`` at which the gap is open; -1 where it stays dry. Without
        samples the margin is at most 0.
    """
    if not len(pressure.sample):
        return min(capillary_pa, 0.0), -1
    margins = np.maximum(_held_of(pressure, stage, hold_s), 0.0) + capillary_pa
    opened = np.flatnonzero(margins >= 0.0)
    return float(margins.max()), int(opened[0]) if len(opened) else -1


@lru_cache(maxsize=_KEPT)
def _held_of(pressure: EdgePressure, stage: Stage, hold_s: float) -> Scalars:
    """(k,) as `_held` gives them."""
    times, seconds = stage.samples.times[pressure.sample], stage.samples.seconds[pressure.sample]
    apart = np.diff(times) - 0.5 * (seconds[1:] + seconds[:-1])
    broken = np.append(True, (np.diff(pressure.sample) != 1) | (apart > _TOGETHER_S))
    return np.asarray(_held(np.ascontiguousarray(pressure.pressure_pa), seconds, broken, hold_s), dtype=np.float64)


@lru_cache(maxsize=_KEPT)
def _peaks_of(pressure: EdgePressure) -> Scalars:
    """(12,) as `_peaks` gives them; 0 without samples."""
    return np.asarray(_peaks(np.ascontiguousarray(pressure.pressure_pa)), dtype=np.float64)


@compiled
def _peaks(pressure: NDArray[np.float64]) -> Scalars:
    """(12,) highest pressure on each segment, and highest mean of the two halves of each edge."""
    peaks = np.full(SEGMENTS + SEGMENTS // 2, -np.inf if len(pressure) else 0.0)
    for row in range(len(pressure)):
        for at in range(SEGMENTS):
            peaks[at] = max(peaks[at], pressure[row, at])
        for edge in range(SEGMENTS // 2):
            mean = 0.5 * (pressure[row, 2 * edge] + pressure[row, 2 * edge + 1])
            peaks[SEGMENTS + edge] = max(peaks[SEGMENTS + edge], mean)
    return peaks


@compiled
def _held(pressure: NDArray[np.float64], seconds: Scalars, broken: NDArray[np.bool_], hold_s: float) -> Scalars:
    """(k,) highest pressure of any segment that has been held when each sample ends; minus infinity before any is."""
    held = np.full(len(seconds), -np.inf)
    for last in range(len(seconds)):
        least = np.full(SEGMENTS, np.inf)
        lasted = 0.0
        for at in range(last, -1, -1):
            for segment in range(SEGMENTS):
                least[segment] = min(least[segment], pressure[at, segment])
            lasted += seconds[at]
            if lasted >= hold_s - _TOGETHER_S:
                held[last] = least.max()
                break
            if broken[at]:
                break
    return held
