"""Capability: in how many of 100 processes like this one each part comes out clean, under the stated ranges.

A parameter set states for its values within which factor they hold (``provenance``, ``within_factor``), or the interval
of a fit. Every value that matters under parts is moved to both ends of its range, one at a time, and all gaps are
followed anew; between the ends, and for several values at once, what comes out is interpolated on scales on which it
is nearly straight. Samples of all values together, seeded, are judged by the limits themselves: a margin stands for
what is not known, and here that is stated.
"""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from cleaning.jet.jet import jet_of
from cleaning.judge_component import Sprayed, gaps_under, pressures_of
from cleaning.parameters.liquid import capillary_pa
from cleaning.parameters.model import Parameters
from cleaning.parameters.provenance import assumptions_of, bounds_at, keys_of, with_values
from cleaning.prepared_board import PreparedBoard
from cleaning.process.stages import Stage
from cleaning.undersides.gap_result import GapResult
from cleaning.undersides.residue import exchanges_needed, fill_share, softening_rate
from cleaning.undersides.sensitivity import Pressures
from cleaning.verdicts import rules
from cleaning.verdicts.results import Capability, CleaningReport, Part, PartCapability
from cleaning.verdicts.rules import Rule
from geometry.arrays import Scalars
from recipes.recipe import Use
from specs.progress import Progress, no_progress

_Array: TypeAlias = NDArray[np.float64]

SAMPLES = 200
_SEED = 1
_UNDER_PARTS = ("soil", "film", "gap", "spray", "liquids")
_FILLING = ("soil.retained", "soil.paste_factor")
_NEARLY = 0.99
_OF_CAPILLARIES = ("surface_tension_mn_m", "contact_board_deg", "contact_part_deg")
_ANY_HEIGHT_M = 1e-4
_PRESSING = ("film", "spray")
"""What changes the pressure on the edges."""
_JUDGED = ("limits",)
_OF_LIQUIDS = ("surface_tension_mn_m", "viscosity_mpa_s", "contact_board_deg", "contact_part_deg", "concentration_pct")
"""Density is known well enough, and the others do not act in a gap."""
_BY_FORMULA = ("soil.density_kg_m3", "gap.capacity_kg_m3")
"""What decides only how often a gap must be renewed, which needs no flow."""
_METRICS: tuple[str, ...] = ("residue", "worst", "washed", "rinsed", "margin_pa", "weak_share")
_NORMAL_95 = 1.96
_DRY_PA = -1.0
"""What a gap lacks whose edges nothing reaches."""
_LEAST, _MOST = 1e-12, 1.0 - 1e-9
_SAME = 1e-9
_SOFTENING = ("soil.activation_kj_mol", "soil.half_pct")
"""What acts through the rate of softening alone, if at all."""
_SAMPLED = frozenset({
    rules.UNDER_EXPOSED, rules.DRY_GAP, rules.PLUGGED_GAP, rules.NOT_FLUSHED, rules.RESIDUE_LEFT, rules.ONE_SIDED,
    rules.INCOMPLETE_RINSE, rules.WET_GAP, rules.MODEL_LIMIT, rules.AVOIDED,
})  # fmt: skip
"""Rules that are judged in each sample; WET_GAP is no question of cleanliness. The others hold as they do now."""
_UNJUDGED = (rules.MODEL_LIMIT, rules.AVOIDED)


@dataclass(frozen=True, slots=True)
class ValueRange:
    """One value of a parameter set, and between what it lies."""

    path: str
    """Such as ``"soil.k1_per_s"``."""
    low: float
    value: float
    high: float
    is_interval: bool = False
    """Whether the ends are those of a 95 % interval of a fit, and the value is normal on a logarithmic scale."""

    def at(self, position: float) -> float:
        """Give the value at a position: -1 is the low end, 0 as stated, 1 the high end."""
        end = self.high if position > 0.0 else self.low
        return self.value * (end / self.value) ** abs(position)


def ranges_of(parameters: Parameters, liquids: Sequence[str] | None = None) -> tuple[ValueRange, ...]:
    """List the values with a stated range; of liquids those that are named, or all.

    A value that a fit gave has its interval; every other one lies, evenly on a logarithmic scale, between itself
    divided and multiplied by ``within_factor`` of its provenance, or up to where it ends: no agent is above 100 %.
    """
    found: list[ValueRange] = []
    for each in assumptions_of(parameters):
        block, _, rest = each.path.partition(".")
        if block not in (*_UNDER_PARTS, *_JUDGED) or "[" in each.value or '"' in each.value:
            continue
        liquid, _, field = rest.rpartition(".")
        if block == "liquids" and (field not in _OF_LIQUIDS or (liquids is not None and liquid not in liquids)):
            continue
        try:
            value = float(each.value)
        except ValueError:
            continue
        factor, interval = each.provenance.within_factor, each.provenance.interval
        if interval is not None and 0.0 < interval[0] <= value <= interval[1]:
            found.append(ValueRange(each.path, interval[0], value, interval[1], is_interval=True))
        elif factor is not None and factor > 1.0 and value > 0.0:
            least, most = bounds_at(each.path)  # a whole block's factor may lead beyond what one of its values can be
            found.append(ValueRange(each.path, max(value / factor, least), value, min(value * factor, most)))
    return tuple(found)


def capability_of(
    report: CleaningReport, prepared: PreparedBoard, progress: Progress = no_progress, samples: int = SAMPLES
) -> Capability:
    """Judge a report under the ranges that its parameter set states.

    Args:
        report: Of any program on the board.
        prepared: The same board with the same parameters.
        progress: Receives the stage and the share done.
        samples: How many sets of values; always the same ones.
    """
    liquids = {name for stage in report.stages if (name := _name_of(stage, report.parameters))}
    ranges = ranges_of(report.parameters, sorted(liquids))
    acting = [each for each in ranges if _acts_under_parts(each, report)]
    pressures = pressures_of(prepared, _sprayed(report, report.parameters))
    open_ = _filled(prepared, 1.0)
    base = _metrics(report, _follow(report, open_, report.parameters, pressures))
    ends: dict[str, tuple[_Array, _Array]] = {}
    for number, each in enumerate(acting):
        progress(f"varying {each.path}", 0.05 + 0.9 * number / len(acting))
        if each.path in _FILLING:
            ends[each.path] = _filling_ends(report, prepared, each, (base, pressures))
            continue
        known = None if each.path.partition(".")[0] in _PRESSING else pressures
        moved = (with_values(report.parameters, {each.path: end}) for end in (each.low, each.high))
        low, high = (_metrics(report, _follow(report, open_, one, known)) - base for one in moved)
        ends[each.path] = low, high
    progress("judging", 0.95)
    found = _Samples.of(report, prepared, base, ends)
    positions = draw_positions(ranges, samples)
    outcomes = [found.judge({each.path: at for each, at in zip(ranges, row, strict=True)}, ranges) for row in positions]
    progress("done", 1.0)
    return _sum_up(found, outcomes, ranges)


def _filled(prepared: PreparedBoard, times: float) -> PreparedBoard:
    """Give the board with so many times the residue under each part, but none plugged: nothing flows there any more.

    Which are is judged in each sample, by its own fill; here the flow of those that are not is looked for.
    """
    overrides = list(prepared.overrides)
    for row, component in enumerate(prepared.rows):
        own = overrides[component]
        factor = _paste_factor(prepared, row) * times
        overrides[component] = own.model_copy(update={"paste_factor": min(factor, _most_factor(prepared, row))})
    return replace(prepared, overrides=tuple(overrides))


def _paste_factor(prepared: PreparedBoard, row: int) -> float:
    own = prepared.overrides[prepared.rows[row]].paste_factor
    return prepared.parameters.soil.paste_factor if own is None else own


def _most_factor(prepared: PreparedBoard, row: int) -> float:
    """Paste factor with which a gap is just not plugged."""
    coverage = max(field.coverage for field in prepared.fields[row])
    parameters = prepared.parameters
    amount = parameters.soil.retained * coverage
    return math.inf if amount <= 0.0 else _NEARLY * parameters.gap.plugged * (1.0 - coverage) / amount


def _filling_ends(
    report: CleaningReport, prepared: PreparedBoard, value: ValueRange, known: tuple[_Array, Sequence[Pressures]]
) -> tuple[_Array, _Array]:
    """Move what fills gaps to both its ends, or so far that a gap is just not plugged; lengthened to the end then."""
    base, pressures = known
    found: list[_Array] = []
    for end in (value.low, value.high):
        times = end / value.value
        if times == 1.0:  # the range ends at the value
            found.append(np.zeros_like(base))
            continue
        change = _metrics(report, _follow(report, _filled(prepared, times), report.parameters, pressures)) - base
        for row in range(len(prepared.rows)):
            begin, most = _paste_factor(prepared, row), _most_factor(prepared, row)
            moved = math.log(min(begin * times, most) / min(begin, most)) / math.log(times)
            change[row] = change[row] / moved if moved > _SAME else 0.0
        found.append(change)
    low, high = found
    return low, high


def _acts_under_parts(value: ValueRange, report: CleaningReport) -> bool:
    """Whether a value changes what happens in gaps, so that they have to be followed anew."""
    if value.path.partition(".")[0] not in _UNDER_PARTS or value.path in _BY_FORMULA:
        return False
    moved = [with_values(report.parameters, {value.path: end}) for end in (value.low, value.high)]
    *_, liquid, field = ("", *keys_of(value.path))
    if field in _OF_CAPILLARIES:  # a gap that draws the liquid in is open as soon as that is at its edge
        return any(
            capillary_pa(one.liquids[liquid], stage.temperature_c, _ANY_HEIGHT_M) < 0.0
            for one in (report.parameters, *moved)
            for stage in report.stages
            if _name_of(stage, report.parameters) == liquid
        )
    if value.path not in _SOFTENING:
        return True
    low, high = (one.soil for one in moved)
    washes = [(stage.temperature_c, stage.liquid.concentration_pct) for stage in report.stages if stage.use == "wash"]
    return any(abs(softening_rate(low, *each) / softening_rate(high, *each) - 1.0) > _SAME for each in washes)


def _sprayed(report: CleaningReport, parameters: Parameters) -> list[Sprayed]:
    """Give the stages with other parameters; what lands on the board stays."""
    named = [(stage, _name_of(stage, report.parameters)) for stage in report.stages]
    stages = [replace(stage, liquid=parameters.liquids[name]) if name else stage for stage, name in named]
    return [
        Sprayed(stage, jet_of(stage, parameters.spray), exposure)
        for stage, exposure in zip(stages, report.exposures, strict=True)
    ]


def _follow(
    report: CleaningReport, prepared: PreparedBoard, parameters: Parameters, pressures: Sequence[Pressures] | None
) -> list[tuple[GapResult, ...]]:
    """Follow all gaps with other parameters; without pressures these are found anew too."""
    varied, sprayed = replace(prepared, parameters=parameters), _sprayed(report, parameters)
    known = pressures_of(varied, sprayed) if pressures is None else pressures
    return gaps_under(varied, [each.stage for each in sprayed], known)


def _name_of(stage: Stage, parameters: Parameters) -> str:
    return next((name for name, liquid in parameters.liquids.items() if liquid is stage.liquid), "")


def _metrics(report: CleaningReport, gaps: Sequence[tuple[GapResult, ...]]) -> _Array:
    """(gaps, 2, 6) what is judged of each gap at both bounds of its height, on nearly straight scales."""
    rows = [[_metrics_of(report, gap) for gap in (cases * 2)[:2]] for cases in gaps]
    return np.array(rows, dtype=np.float64).reshape(-1, 2, len(_METRICS))


def _metrics_of(report: CleaningReport, gap: GapResult) -> tuple[float, ...]:
    """Residue and its worst tenth as ln(-ln r): a decay with time has its rate there; renewals as logarithms."""
    pairs = [(stage, at) for stage, at in zip(report.stages, gap.stages, strict=True) if at is not None]
    washes = [at for stage, at in pairs if stage.use == "wash"]
    rinsed = sum(stage.repeats * at.exchanges for stage, at in pairs if stage.use == "rinse")
    return (
        _straight(gap.residue),
        _straight(gap.residue_worst),
        math.log(max(sum(at.exchanges for at in washes), _LEAST)),
        math.log(max(rinsed, _LEAST)),
        max((at.margin_pa if at.entered else min(at.margin_pa, _DRY_PA) for at in washes), default=0.0),
        min((at.weak_share for at in washes), default=0.0),
    )


def _straight(residue: float) -> float:
    return math.log(-math.log(min(max(residue, _LEAST), _MOST)))


def draw_positions(ranges: Sequence[ValueRange], samples: int) -> Scalars:
    """(samples, ranges) position in its range of each value; the same ones every time."""
    random = np.random.default_rng(_SEED)
    drawn = np.empty((samples, len(ranges)))
    for column, each in enumerate(ranges):
        if each.is_interval:
            drawn[:, column] = random.normal(0.0, 1.0 / _NORMAL_95, samples)
        else:  # one in each of as many equal parts, in random order
            at = (random.permutation(samples) + random.random(samples)) / samples
            below = math.log(each.value / each.low) / math.log(each.high / each.low)
            drawn[:, column] = (at - below) / np.where(at < below, below, 1.0 - below)
    return drawn


@dataclass(frozen=True, slots=True, eq=False)
class _Judged:
    """What does not change of one component, or of the bare board."""

    name: str
    always: Rule | None
    """That it breaks whatever the values."""
    reached: tuple[tuple[Use, float, float], ...]
    """Use, volume on the least wetted places in mm, and time in the wave front in s, as often as it may be done."""
    row: int
    """Of its gap; -1 where it has none, or none that is judged."""
    coverages: tuple[float, ...] = ()
    """At each bound of the gap's height that is judged."""
    paste_factor: float | None = None
    rinsed: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class _Samples:
    """A report, and how its gaps change with each value."""

    report: CleaningReport
    prepared: PreparedBoard
    judged: tuple[_Judged, ...]
    base: _Array
    ends: Mapping[str, tuple[_Array, _Array]]

    @classmethod
    def of(
        cls, report: CleaningReport, prepared: PreparedBoard, base: _Array, ends: Mapping[str, tuple[_Array, _Array]]
    ) -> "_Samples":
        row_of = {component: row for row, component in enumerate(prepared.rows)}
        parts = [(part, row_of.get(number, -1)) for number, part in enumerate(report.parts)]
        judged = tuple(_judged(report, prepared, part, row) for part, row in (*parts, (report.bare, -1)))
        return cls(report, prepared, judged, base, ends)

    def judge(self, positions: Mapping[str, float], ranges: Sequence[ValueRange]) -> dict[str, Rule | None]:
        """Give by component the rule that it breaks with some values, ``None`` where it comes out clean."""
        parameters = with_values(self.report.parameters, {each.path: each.at(positions[each.path]) for each in ranges})
        metrics = self.base.copy()
        for path, (low, high) in self.ends.items():
            at = positions[path]
            metrics += at * high if at > 0.0 else -at * low
        rows = metrics.tolist()
        return {each.name: _broken_by(each, rows, parameters) for each in self.judged}


def _judged(report: CleaningReport, prepared: PreparedBoard, part: Part, row: int) -> _Judged:
    others = (each for each in part.judgements if each.rule not in _SAMPLED and each.verdict in ("dirty", "marginal"))
    reached: tuple[tuple[Use, float, float], ...] = tuple(
        (each.use, each.repeats * each.exposed.supply_mm[1], each.repeats * each.exposed.front_s[1])
        for each in part.reached
        if each.exposed.area_mm2 > 0.0
    )
    always = next((each.rule for each in others), None)
    if row < 0 or not part.gaps:
        return _Judged(part.component, always, reached, -1)
    uses = {stage.use for stage, at in zip(report.stages, part.gaps[0].stages, strict=True) if at is not None}
    thickest = report.parameters.gap.thickest_um
    thin = [gap for gap in part.gaps if 1000.0 * gap.gap_height_mm <= thickest and "wash" in uses]
    coverages = tuple(gap.field.coverage for gap in thin)  # what is not thin at one bound is so at the second
    factor = prepared.overrides[prepared.rows[row]].paste_factor
    return _Judged(part.component, always, reached, row, coverages, factor, "rinse" in uses)


def _broken_by(judged: _Judged, rows: Sequence[Sequence[Sequence[float]]], parameters: Parameters) -> Rule | None:
    """Give the rule that a component breaks: on its surface, or under it at a bound of the gap's height."""
    if judged.always is not None:
        return judged.always
    limits = parameters.limits
    for use, volume_mm, front_s in judged.reached:
        least = limits.wash_volume_mm if use == "wash" else limits.rinse_volume_mm
        if volume_mm < least or (use == "wash" and front_s < limits.front_s):
            return rules.UNDER_EXPOSED
    for coverage, metrics in zip(judged.coverages, rows[judged.row], strict=False):
        fill = fill_share(parameters.soil, coverage, judged.paste_factor)
        broken = _broken(dict(zip(_METRICS, metrics, strict=True)), fill, parameters, rinsed=judged.rinsed)
        if broken is not None:
            return broken
    return None


def _broken(reached: Mapping[str, float], fill: float, parameters: Parameters, *, rinsed: bool) -> Rule | None:
    """Give the first rule that a gap breaks, in the order in which they decide."""
    limits = parameters.limits
    if reached["margin_pa"] < 0.0:
        return rules.DRY_GAP
    if fill >= parameters.gap.plugged:
        return rules.PLUGGED_GAP
    if reached["washed"] < math.log(max(exchanges_needed(parameters.soil, parameters.gap, fill), _LEAST)):
        return rules.NOT_FLUSHED
    if reached["weak_share"] > limits.weak_share:
        return rules.ONE_SIDED
    if reached["residue"] < _straight(limits.gap_marginal) or reached["worst"] < _straight(limits.pocket):
        return rules.RESIDUE_LEFT
    if rinsed and reached["rinsed"] < math.log(limits.exchanges):
        return rules.INCOMPLETE_RINSE
    return None


def _sum_up(found: _Samples, outcomes: Sequence[Mapping[str, Rule | None]], ranges: Sequence[ValueRange]) -> Capability:
    report, row_of = found.report, {component: row for row, component in enumerate(found.prepared.rows)}
    parts: list[PartCapability] = []
    for number, part in enumerate((*report.parts, report.bare)):
        broken = Counter(each[part.component] for each in outcomes)
        no_verdict = any(each.rule in _UNJUDGED for each in part.judgements)
        shares = tuple((rule, count / len(outcomes)) for rule, count in broken.most_common() if rule is not None)
        strongest = _strongest(found, row_of[number]) if number in row_of else ""
        parts.append(
            PartCapability(part.component, None if no_verdict else broken[None] / len(outcomes), shares, strongest)
        )
    as_stated = found.judge({each.path: 0.0 for each in ranges}, ranges)
    undecided = {each.component for each in parts if each.clean_share is None}
    left_out = tuple(name for name, rule in as_stated.items() if rule is not None and name not in undecided)
    counted = as_stated.keys() - undecided - {*left_out}
    together = sum(all(each[name] is None for name in counted) for each in outcomes) / len(outcomes)
    return Capability(len(outcomes), tuple(each.path for each in ranges), tuple(parts), together, left_out)


def _strongest(found: _Samples, row: int) -> str:
    """Name the value whose range changes the residue under a part most; empty where none does."""
    spans = {path: max(abs(float(end[row, 0, 0])) for end in both) for path, both in found.ends.items()}
    best = max(spans, key=lambda path: spans[path], default="")
    return best if best and spans[best] > _SAME else ""
