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
from cleaning.uncertainty.criteria import GapNumbers, criteria_of
from cleaning.undersides.residue import exchanges_needed, fill_share, softening_rate
from cleaning.undersides.sensitivity import Pressures
from cleaning.verdicts import rules
from cleaning.verdicts.results import Capability, CleaningReport, Part, PartCapability, Reach
from cleaning.verdicts.rules import Rule
from geometry.arrays import Scalars
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
_VARIED = (*_UNDER_PARTS, "limits")
_OF_LIQUIDS = ("surface_tension_mn_m", "viscosity_mpa_s", "contact_board_deg", "contact_part_deg", "concentration_pct")
"""Density is known well enough, and the others do not act in a gap."""
_BY_FORMULA = ("soil.density_kg_m3", "gap.capacity_kg_m3")
"""What decides only how often a gap must be renewed, which needs no flow."""
_NORMAL_95 = 1.96
_LEAST, _MOST = 1e-12, 1.0 - 1e-9
_SAME = 1e-9
_SOFTENING = ("soil.activation_kj_mol", "soil.half_pct")
"""What acts through the rate of softening alone, if at all."""
_SAMPLED = frozenset({
    rules.UNDER_EXPOSED, rules.DRY_GAP, rules.PLUGGED_GAP, rules.NOT_FLUSHED, rules.RESIDUE_LEFT, rules.ONE_SIDED,
    rules.INCOMPLETE_RINSE, rules.WET_GAP, rules.MODEL_LIMIT, rules.AVOIDED,
})  # fmt: skip
"""Rules that are judged in each sample; WET_GAP is no question of cleanliness. The others hold as they do now."""


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
        block, *liquid, field = keys_of(each.path)
        if block not in _VARIED:
            continue
        if liquid and (field not in _OF_LIQUIDS or (liquids is not None and liquid[0] not in liquids)):
            continue
        try:
            value = float(each.value)
        except ValueError:  # words, or a list
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
    variation = _vary(report, prepared, [each for each in ranges if _acts_under_parts(each, report)], progress)
    progress("judging", 0.95)
    judged = [_judged(part, report, prepared) for part in (*report.parts, report.bare)]

    def judge(positions: Sequence[float]) -> dict[str, Rule | None]:
        """Give by component the rule that it breaks with values at some positions; ``None`` where it is clean."""
        values = {each.path: each.at(position) for each, position in zip(ranges, positions, strict=True)}
        gaps = variation.at({each.path: position for each, position in zip(ranges, positions, strict=True)})
        parameters = with_values(report.parameters, values)
        return {each.name: each.breaks(gaps.get(each.name, ()), parameters) for each in judged}

    def part_capability(part: Part) -> PartCapability:
        broken = Counter(each[part.component] for each in outcomes)
        unjudged = any(each.rule in (rules.MODEL_LIMIT, rules.AVOIDED) for each in part.judgements)
        shares = tuple((rule, count / samples) for rule, count in broken.most_common() if rule is not None)
        clean = None if unjudged else broken[None] / samples
        return PartCapability(part.component, clean, shares, variation.strongest(part.component))

    outcomes = [judge(row) for row in draw_positions(ranges, samples).tolist()]
    parts = tuple(map(part_capability, (*report.parts, report.bare)))
    undecided = {each.component for each in parts if each.clean_share is None}
    as_stated = judge([0.0] * len(ranges))
    left_out = tuple(name for name, rule in as_stated.items() if rule is not None and name not in undecided)
    counted = as_stated.keys() - undecided - {*left_out}
    together = sum(all(each[name] is None for name in counted) for each in outcomes) / samples
    progress("done", 1.0)
    return Capability(samples, tuple(each.path for each in ranges), parts, together, left_out)


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
class _Variation:
    """How the numbers of gaps change with each value: (gaps, 2, 6) at both bounds of the height, on straight scales."""

    names: tuple[str, ...]
    """Components of the gaps."""
    base: _Array
    ends: Mapping[str, tuple[_Array, _Array]]
    """By path: the changes at the low and at the high end."""

    def at(self, positions: Mapping[str, float]) -> dict[str, list[GapNumbers]]:
        """Give the numbers of each gap by its component, with the values at some positions in their ranges."""
        straight = self.base.copy()
        for path, (low, high) in self.ends.items():
            straight += positions[path] * high if positions[path] > 0.0 else -positions[path] * low
        numbers = np.concatenate(
            [np.exp(-np.exp(straight[..., :2])), np.exp(straight[..., 2:4]), straight[..., 4:]], axis=2
        )
        gaps = zip(self.names, numbers.tolist(), strict=True)
        return {name: [GapNumbers(*each) for each in bounds] for name, bounds in gaps}

    def strongest(self, name: str) -> str:
        """Name the value whose range changes the residue under a component most; empty where none does."""
        if name not in self.names:
            return ""
        row = self.names.index(name)
        spans = {path: max(abs(float(end[row, 0, 0])) for end in both) for path, both in self.ends.items()}
        best = max(spans, key=lambda path: spans[path], default="")
        return best if best and spans[best] > _SAME else ""


def _vary(
    report: CleaningReport, prepared: PreparedBoard, acting: Sequence[ValueRange], progress: Progress
) -> _Variation:
    """Follow all gaps with each value at both its ends."""
    pressures = pressures_of(prepared, _sprayed(report, report.parameters))
    open_ = _filled(prepared, 1.0)
    base = _follow(report, open_, report.parameters, pressures)
    ends: dict[str, tuple[_Array, _Array]] = {}
    for number, each in enumerate(acting):
        progress(f"varying {each.path}", 0.05 + 0.9 * number / len(acting))
        if each.path in _FILLING:
            low, high = (
                _refill(report, prepared, end / each.value, (base, pressures)) for end in (each.low, each.high)
            )
        else:
            known = None if each.path.partition(".")[0] in _PRESSING else pressures
            moved = (with_values(report.parameters, {each.path: end}) for end in (each.low, each.high))
            low, high = (_follow(report, open_, one, known) - base for one in moved)
        ends[each.path] = low, high
    return _Variation(tuple(each.component for each in prepared.undersides), base, ends)


def _follow(
    report: CleaningReport, prepared: PreparedBoard, parameters: Parameters, pressures: Sequence[Pressures] | None
) -> _Array:
    """(gaps, 2, 6) numbers of all gaps with other parameters; without pressures these are found anew too.

    Residue and its worst tenth are ln(-ln r), since a decay with time has its rate there, and renewals logarithms.
    """
    varied, sprayed = replace(prepared, parameters=parameters), _sprayed(report, parameters)
    known = pressures_of(varied, sprayed) if pressures is None else pressures
    stages = [each.stage for each in sprayed]
    rows = [[GapNumbers.of(gap, stages) for gap in (cases * 2)[:2]] for cases in gaps_under(varied, stages, known)]
    found = np.array(rows, dtype=np.float64).reshape(-1, 2, len(GapNumbers._fields))
    found[..., :2] = np.log(-np.log(np.clip(found[..., :2], _LEAST, _MOST)))
    found[..., 2:4] = np.log(np.maximum(found[..., 2:4], _LEAST))
    return found


def _sprayed(report: CleaningReport, parameters: Parameters) -> list[Sprayed]:
    """Give the stages with other parameters; what lands on the board stays."""
    named = [(stage, _name_of(stage, report.parameters)) for stage in report.stages]
    stages = [replace(stage, liquid=parameters.liquids[name]) if name else stage for stage, name in named]
    pairs = zip(stages, report.exposures, strict=True)
    return [Sprayed(stage, jet_of(stage, parameters.spray), exposure) for stage, exposure in pairs]


def _name_of(stage: Stage, parameters: Parameters) -> str:
    return next((name for name, liquid in parameters.liquids.items() if liquid is stage.liquid), "")


def _filled(prepared: PreparedBoard, times: float) -> PreparedBoard:
    """Give the board with so many times the residue under each part, but none plugged: nothing flows there any more.

    Which are is judged in each sample, by its own fill; here the flow of those that are not is looked for.
    """
    overrides = list(prepared.overrides)
    for component, (factor, most) in zip(prepared.rows, _paste_factors(prepared), strict=True):
        overrides[component] = overrides[component].model_copy(update={"paste_factor": min(factor * times, most)})
    return replace(prepared, overrides=tuple(overrides))


def _paste_factors(prepared: PreparedBoard) -> list[tuple[float, float]]:
    """Paste factor of each gap, and that with which it is just not plugged."""
    soil, gap = prepared.parameters.soil, prepared.parameters.gap
    found: list[tuple[float, float]] = []
    for component, fields in zip(prepared.rows, prepared.fields, strict=True):
        own, coverage = prepared.overrides[component].paste_factor, max(field.coverage for field in fields)
        amount = soil.retained * coverage
        most = math.inf if amount <= 0.0 else _NEARLY * gap.plugged * (1.0 - coverage) / amount
        found.append((soil.paste_factor if own is None else own, most))
    return found


def _refill(
    report: CleaningReport, prepared: PreparedBoard, times: float, known: tuple[_Array, Sequence[Pressures]]
) -> _Array:
    """Give what changes with so many times the residue: found where a gap is just not plugged, lengthened to there."""
    base, pressures = known
    if times == 1.0:  # the range ends at the value
        return np.zeros_like(base)
    change = _follow(report, _filled(prepared, times), report.parameters, pressures) - base
    for row, (begin, most) in enumerate(_paste_factors(prepared)):
        moved = math.log(min(begin * times, most) / min(begin, most)) / math.log(times)
        change[row] = change[row] / moved if moved > _SAME else 0.0
    return change


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


@dataclass(frozen=True, slots=True, eq=False)
class _Judged:
    """What does not change of one component, or of the bare board."""

    name: str
    always: Rule | None
    """That it breaks whatever the values."""
    reached: tuple[Reach, ...]
    coverages: tuple[float, ...]
    """At each bound of the gap's height that is judged; empty where none is."""
    paste_factor: float | None

    def breaks(self, gap: Sequence[GapNumbers], parameters: Parameters) -> Rule | None:
        """Give the rule that it breaks: on its surface, or under it at a bound of the gap's height."""
        if self.always is not None:
            return self.always
        limits = parameters.limits
        for each in self.reached:
            volume_mm, front_s = (each.repeats * low[1] for low in (each.exposed.supply_mm, each.exposed.front_s))
            least = limits.wash_volume_mm if each.use == "wash" else limits.rinse_volume_mm
            if volume_mm < least or (each.use == "wash" and front_s < limits.front_s):
                return rules.UNDER_EXPOSED
        for coverage, numbers in zip(self.coverages, gap, strict=False):
            fill = fill_share(parameters.soil, coverage, self.paste_factor)
            needed = exchanges_needed(parameters.soil, parameters.gap, fill)
            for each in criteria_of(numbers, fill, needed, parameters):
                if not each.kept:
                    return each.rule
        return None


def _judged(part: Part, report: CleaningReport, prepared: PreparedBoard) -> _Judged:
    others = (each for each in part.judgements if each.rule not in _SAMPLED and each.verdict in ("dirty", "marginal"))
    reached = tuple(each for each in part.reached if each.exposed.area_mm2 > 0.0)
    override = next((prepared.overrides[row] for row, each in enumerate(report.parts) if each is part), None)
    washed = bool(part.gaps) and "wash" in {
        stage.use for stage, at in zip(report.stages, part.gaps[0].stages, strict=True) if at is not None
    }
    thickest = report.parameters.gap.thickest_um
    # What is not thin at one bound is so at the second.
    coverages = [gap.field.coverage for gap in part.gaps if washed and 1000.0 * gap.gap_height_mm <= thickest]
    factor = None if override is None else override.paste_factor
    return _Judged(part.component, next((each.rule for each in others), None), reached, tuple(coverages), factor)
