"""Measured cleanliness against prediction: hit rate, rank correlation, which rules were wrong, what to calibrate.

A component is measured clean if it passes by every method that was used on it, and predicted clean if every rule but
drying judges it clean. A component without a verdict is listed and not counted.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite
from shlex import quote

from cleaning.measured.table import Measured, MeasuredTable, Method
from cleaning.undersides.gap_result import GapResult
from cleaning.verdicts import rules
from cleaning.verdicts.cleanliness import cleanliness
from cleaning.verdicts.results import CleaningReport, Number, Part
from cleaning.verdicts.rules import RULES, Rule
from specs.json import Json

_LEAST_PAIRS = 3
"""Two points always lie on a line."""


@dataclass(frozen=True, slots=True)
class Confusion:
    """Components counted by what was predicted and what was measured; their names, in the board's order."""

    clean_within: tuple[str, ...]
    clean_beyond: tuple[str, ...]
    """Escapes: predicted clean, measured not clean."""
    unclean_within: tuple[str, ...]
    """False alarms."""
    unclean_beyond: tuple[str, ...]

    @property
    def count(self) -> int:
        """Components that have both a verdict and a measurement."""
        return self.right + len(self.clean_beyond) + len(self.unclean_within)

    @property
    def right(self) -> int:
        """Components that were predicted as they were measured."""
        return len(self.clean_within) + len(self.unclean_beyond)

    @property
    def hit_rate(self) -> float | None:
        """Share of them; ``None`` where nothing is counted."""
        return self.right / self.count if self.count else None


@dataclass(frozen=True, slots=True)
class RankCorrelation:
    """Spearman's rank correlation of predicted residue and a measured figure, counted so that more is dirtier."""

    method: Method
    pairs: int
    """Components with a gap that were measured so."""
    rho: float | None
    """-1 to 1; ``None`` for fewer than three pairs, or where one of both never changes."""
    p_value: float | None
    """Of no correlation at all, by the t distribution; rough for few pairs."""


@dataclass(frozen=True, slots=True)
class RuleCheck:
    """How often one rule was right: where it found fault, and where it judged a component clean.

    Only components without any fault count for the second: what another rule found is not for this one to find. Of the
    rules that judged a component clean which was not, the one that was nearest to its limit was wrong: the least change
    of the prediction is at it. Rules on surfaces count by methods that see surfaces.
    """

    rule: Rule
    faults_right: tuple[str, ...]
    faults_wrong: tuple[str, ...]
    clean_right: tuple[str, ...]
    clean_wrong: tuple[str, ...]
    """Where it was nearest to its limit of all that judged the component clean."""


@dataclass(frozen=True, slots=True)
class Recalibration:
    """What the errors of one rule point to."""

    rule: Rule
    too_strict: int
    """False alarms."""
    too_lenient: int
    """Escapes."""
    values: tuple[str, ...]
    """Paths of the parameter set, or words for what else decides."""
    raise_values: bool
    """Whether they are too low, by the sign of the errors."""
    calibration: str
    """``"gap"`` or ``"ring"``: the calibration that fits what decides; empty where none does."""


@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """A table of measurements against a report."""

    table: MeasuredTable
    confusion: Confusion
    without_verdict: tuple[str, ...]
    not_measured: int
    """Components of the board that the table does not name."""
    by_method: tuple[tuple[Method, Confusion], ...]
    correlations: tuple[RankCorrelation, ...]
    rules: tuple[RuleCheck, ...]
    """Rules that judged a component that was measured, in the order of the registry."""
    recalibrations: tuple[Recalibration, ...]


def compare_measured(report: CleaningReport, table: MeasuredTable) -> Comparison:
    """Compare measured cleanliness with the prediction.

    Args:
        report: Of the program that cleaned the components.
        table: Its components are of the report's board, or ``board``, the bare board.
    """
    parts = {part.component: part for part in (*report.parts, report.bare)}
    rows: dict[str, list[Measured]] = {}
    for row in table.rows:
        rows.setdefault(row.component, []).append(row)
    passed = {name: all(row.passed for row in rows[name]) for name in parts if name in rows}
    judged = {name: clean for name, clean in passed.items() if cleanliness(parts[name]) in (*_FAULTS, "clean")}
    methods = {row.method.name: row.method for row in table.rows}
    by_method = tuple((method, _confusion(parts, _passed_by(method, table, judged))) for method in methods.values())
    checks = _check_rules(report, parts, judged, _passed_on_surfaces(rows, judged))
    return Comparison(
        table=table,
        confusion=_confusion(parts, judged),
        without_verdict=tuple(name for name in passed if name not in judged),
        not_measured=sum(part.component not in passed for part in report.parts),
        by_method=by_method,
        correlations=tuple(_correlate(method, table, parts) for method in methods.values()),
        rules=checks,
        recalibrations=tuple(filter(None, (_recalibration(check, parts) for check in checks))),
    )


def calibrate_command(offer: Recalibration, report: CleaningReport, recipe: str, parameters: str) -> str:
    """Write the command that fits what decides a rule; empty where no calibration does.

    Args:
        offer: What the errors point to.
        report: Of the prediction; the nozzle and the liquid of its first wash were measured.
        recipe: Name or file of its recipe.
        parameters: Name or file of its parameter set.
    """
    wash = next((stage for stage in report.stages if stage.use == "wash"), None)
    if wash is None or not offer.calibration:
        return ""
    nozzle = f"--recipe {quote(recipe)} --nozzle {quote(wash.nozzle_name)}"
    if offer.calibration == "ring":
        return f"washboard calibrate ring PATTERN.csv {nozzle} -o measured.yaml"
    known = f"--parameters {quote(parameters)} {nozzle} --solution {quote(wash.solution)}"
    return f"washboard calibrate gap COUPONS.csv {known} -o our-line.yaml"


def comparison_data(found: Comparison, commands: Sequence[str]) -> dict[str, Json]:
    """Collect a comparison as plain data.

    Args:
        found: The comparison.
        commands: For each of its recalibrations; empty where there is none.
    """
    return {
        "file": found.table.file,
        "sha256": found.table.sha256,
        "synthetic": found.table.synthetic,
        **_confusion_data(found.confusion),
        "without_verdict": list(found.without_verdict),
        "not_measured": found.not_measured,
        "methods": {method.name: _confusion_data(each) for method, each in found.by_method},
        "rank_correlations": [
            {"method": each.method.name, "pairs": each.pairs, "rho": _digits(each.rho), "p": _digits(each.p_value)}
            for each in found.correlations
        ],
        "rules": [
            {
                "rule": each.rule.id,
                "faults_right": list(each.faults_right),
                "faults_wrong": list(each.faults_wrong),
                "clean_right": list(each.clean_right),
                "clean_wrong": list(each.clean_wrong),
            }
            for each in found.rules
        ],
        "recalibrations": [
            {
                "rule": each.rule.id,
                "too_strict": each.too_strict,
                "too_lenient": each.too_lenient,
                "values": list(each.values),
                "direction": "raise" if each.raise_values else "lower",
                "command": command or None,
            }
            for each, command in zip(found.recalibrations, commands, strict=True)
        ],
        "rows": [
            {
                "component": row.component,
                "method": row.method.name,
                "value": _digits(row.value),
                "limit": _digits(row.limit),
                "unit": row.method.unit,
                "passed": row.passed,
            }
            for row in found.table.rows
        ],
    }


def _digits(value: float | None) -> float | None:
    return None if value is None else float(f"{value:.6g}")


def _confusion_data(found: Confusion) -> dict[str, Json]:
    return {
        "compared": found.count,
        "hit_rate": _digits(found.hit_rate),
        "clean_within": list(found.clean_within),
        "clean_beyond": list(found.clean_beyond),
        "unclean_within": list(found.unclean_within),
        "unclean_beyond": list(found.unclean_beyond),
    }


def _passed_by(method: Method, table: MeasuredTable, judged: Mapping[str, bool]) -> dict[str, bool]:
    found = {row.component: row.passed for row in table.rows if row.method is method}
    return {name: found[name] for name in judged if name in found}


def _confusion(parts: Mapping[str, Part], passed: Mapping[str, bool]) -> Confusion:
    def named(*, clean: bool, good: bool) -> tuple[str, ...]:
        return tuple(
            name for name, kept in passed.items() if kept == good and (cleanliness(parts[name]) == "clean") == clean
        )

    return Confusion(
        named(clean=True, good=True),
        named(clean=True, good=False),
        named(clean=False, good=True),
        named(clean=False, good=False),
    )


def _correlate(method: Method, table: MeasuredTable, parts: Mapping[str, Part]) -> RankCorrelation:
    pairs = [
        (residue, row.dirt)
        for row in table.rows
        if row.method is method and (residue := parts[row.component].residue) is not None
    ]
    predicted, measured = [each for each, _ in pairs], [each for _, each in pairs]
    if len(pairs) < _LEAST_PAIRS or len({*predicted}) < 2 or len({*measured}) < 2:
        return RankCorrelation(method, len(pairs), None, None)
    from scipy.stats import spearmanr  # takes half a second, and few commands compare

    rho, p_value = map(float, spearmanr(predicted, measured))
    return RankCorrelation(method, len(pairs), rho, p_value if isfinite(p_value) else None)


def _passed_on_surfaces(rows: Mapping[str, Sequence[Measured]], judged: Mapping[str, bool]) -> dict[str, bool]:
    """Give whether a component passed by what sees surfaces; without those on which nothing of the kind was used."""
    seen = {name: [row.passed for row in rows[name] if row.method.sees_surface] for name in judged}
    return {name: all(each) for name, each in seen.items() if each}


def _check_rules(
    report: CleaningReport,
    parts: Mapping[str, Part],
    passed: Mapping[str, bool],
    passed_on_surfaces: Mapping[str, bool],
) -> tuple[RuleCheck, ...]:
    rooms = {name: _rooms(parts[name], report, surface=name in passed_on_surfaces) for name in passed}
    found: list[RuleCheck] = []
    for rule in RULES:
        if rule == rules.WET_GAP:  # whether it is dry is not what cleanliness is measured for
            continue
        lists: dict[tuple[bool, bool], list[str]] = {
            (fault, good): [] for fault in (True, False) for good in (True, False)
        }
        for name, good in (passed_on_surfaces if rule in _ON_SURFACES else passed).items():
            fault = any(each.rule == rule and each.verdict in _FAULTS for each in parts[name].judgements)
            room = rooms[name].get(rule)
            if fault or (room is not None and (good or room <= min(rooms[name].values()))):
                lists[fault, good].append(name)
        if any(lists.values()):
            found.append(
                RuleCheck(
                    rule,
                    faults_right=tuple(lists[True, False]),
                    faults_wrong=tuple(lists[True, True]),
                    clean_right=tuple(lists[False, True]),
                    clean_wrong=tuple(lists[False, False]),
                )
            )
    return tuple(found)


def _rooms(part: Part, report: CleaningReport, *, surface: bool) -> dict[Rule, float]:
    """Give for each rule that judged a clean part by how many times its nearest number is from its limit.

    Rules on gaps that find fault or nothing are judged by the numbers of the gap. Nothing of a part that is not clean.
    """
    if cleanliness(part) != "clean":
        return {}
    found: dict[Rule, float] = {}
    for each in part.judgements:
        if each.verdict == "clean" and each.rule != rules.WET_GAP:
            room = min((_times(number) for number in each.numbers if number.limit), default=inf)
            found[each.rule] = min(room, found.get(each.rule, inf))
    for gap in part.gaps:
        for rule, room in _rooms_of(gap, report):
            found[rule] = min(room, found.get(rule, inf))
    return found if surface else {rule: room for rule, room in found.items() if rule not in _ON_SURFACES}


def _rooms_of(gap: GapResult, report: CleaningReport) -> Iterator[tuple[Rule, float]]:
    """The same for a gap that a wash acts on: renewals in washing and rinsing, and places of weak flow."""
    limits = report.parameters.limits
    acts = [(stage, at) for stage, at in zip(report.stages, gap.stages, strict=True) if at is not None]
    washes = [at for stage, at in acts if stage.use == "wash"]
    rinsed = [stage.repeats * at.exchanges for stage, at in acts if stage.use == "rinse"]
    if washes and gap.exchanges_needed > 0.0:
        yield rules.NOT_FLUSHED, sum(at.exchanges for at in washes) / gap.exchanges_needed
    if washes:
        weak = min(at.weak_share for at in washes)
        yield rules.ONE_SIDED, limits.weak_share / weak if weak > 0.0 else inf
    if rinsed:
        yield rules.INCOMPLETE_RINSE, sum(rinsed) / limits.exchanges


def _times(number: Number) -> float:
    """How many times a number of a clean judgement is on the good side of its limit, whichever side that is."""
    value, limit = abs(number.value), abs(number.limit or 0.0)
    return inf if min(value, limit) == 0.0 else max(value / limit, limit / value)


_FAULTS = ("dirty", "marginal")
_ON_SURFACES = frozenset({rules.MISSED, rules.UNDER_EXPOSED})
_DECIDING: dict[Rule, tuple[tuple[str, ...], bool, str]] = {
    rules.MISSED: ((), False, "ring"),
    rules.UNDER_EXPOSED: (("limits.wash_volume_mm", "limits.rinse_volume_mm"), False, "ring"),
    rules.DRY_GAP: (("film.retention", "film.decay_mm"), True, ""),
    rules.PLUGGED_GAP: (("soil.retained", "soil.paste_factor"), False, ""),
    rules.NOT_FLUSHED: (("gap.capacity_kg_m3",), True, ""),
    rules.RESIDUE_LEFT: (("soil.k1_per_s", "soil.k_m_per_s"), True, "gap"),
    rules.ONE_SIDED: (("limits.weak_share",), True, ""),
    rules.INCOMPLETE_RINSE: (("limits.exchanges",), False, ""),
    rules.IONIC_RESIDUE: (("limits.ionic_ug_cm2",), True, ""),
}
"""What decides a rule, whether it is to be raised where the rule finds fault in what is clean, and what fits it."""
_BY_SHEAR = ("pressure", "standoff")
"""Factors by which removal limits a gap, not softening."""


def _recalibration(check: RuleCheck, parts: Mapping[str, Part]) -> Recalibration | None:
    """Read the sign of a rule's errors; nothing where it made none, or as many of both, or nothing decides it."""
    strict, lenient = len(check.faults_wrong), len(check.clean_wrong)
    if strict == lenient or check.rule not in _DECIDING:
        return None
    values, raised, calibration = _DECIDING[check.rule]
    if check.rule == rules.RESIDUE_LEFT:
        wrong = check.faults_wrong if strict > lenient else check.clean_wrong
        sheared = sum(parts[name].limiting in _BY_SHEAR for name in wrong)
        values = values[1:] if 2 * sheared > len(wrong) else values[:1]
    return Recalibration(check.rule, strict, lenient, values, raised == (strict > lenient), calibration)
