"""Measured cleanliness against prediction: hit rate, rank correlation, which rules were wrong, what to calibrate.

A component is measured clean if it passes by every method that was used on it, and predicted clean if every rule but
drying judges it clean. A component without a verdict is listed and not counted.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from math import inf, isfinite
from shlex import quote

from cleaning.report import pick
from cleaning.uncertainty.criteria import GapNumbers, criteria_of
from cleaning.uncertainty.measured_table import Measured, MeasuredTable, Method
from cleaning.verdicts import rules
from cleaning.verdicts.results import CleaningReport, Part, cleanliness
from cleaning.verdicts.rules import RULES, Rule
from specs.json import Json, plain_data

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
    seen = {name: [row.passed for row in rows[name] if row.method.sees_surface] for name in judged}
    methods = {row.method.name: row.method for row in table.rows}
    checks = _check_rules(report, parts, judged, {name: all(each) for name, each in seen.items() if each})
    return Comparison(
        table=table,
        confusion=_confusion(parts, judged),
        without_verdict=tuple(name for name in passed if name not in judged),
        not_measured=sum(part.component not in passed for part in report.parts),
        by_method=tuple(
            (each, _confusion(parts, {name: row.passed for name in judged for row in rows[name] if row.method is each}))
            for each in methods.values()
        ),
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
        **pick(found.table, "file sha256 synthetic"),
        **_confusion_data(found.confusion),
        **pick(found, "without_verdict not_measured"),
        "methods": {method.name: _confusion_data(each) for method, each in found.by_method},
        "rank_correlations": [
            {"method": each.method.name, **pick(each, "pairs rho"), "p": plain_data(each.p_value)}
            for each in found.correlations
        ],
        "rules": [plain_data(asdict(each) | {"rule": each.rule.id}) for each in found.rules],
        "recalibrations": [
            {
                "rule": each.rule.id,
                **pick(each, "too_strict too_lenient values"),
                "direction": "raise" if each.raise_values else "lower",
                "command": command or None,
            }
            for each, command in zip(found.recalibrations, commands, strict=True)
        ],
        "rows": [
            {
                "component": row.component,
                "method": row.method.name,
                **pick(row, "value limit"),
                "unit": row.method.unit,
                "passed": row.passed,
            }
            for row in found.table.rows
        ],
    }


def _confusion_data(found: Confusion) -> dict[str, Json]:
    counted: dict[str, object] = {"compared": found.count, "hit_rate": found.hit_rate, **asdict(found)}
    return {key: plain_data(each) for key, each in counted.items()}


def _confusion(parts: Mapping[str, Part], passed: Mapping[str, bool]) -> Confusion:
    found: dict[tuple[bool, bool], list[str]] = {(clean, good): [] for clean in (True, False) for good in (True, False)}
    for name, good in passed.items():
        found[cleanliness(parts[name]) == "clean", good].append(name)
    return Confusion(*map(tuple, found.values()))


def _correlate(method: Method, table: MeasuredTable, parts: Mapping[str, Part]) -> RankCorrelation:
    rows = [row for row in table.rows if row.method is method]
    pairs = [(residue, row.dirt) for row in rows if (residue := parts[row.component].residue) is not None]
    predicted, measured = [each for each, _ in pairs], [each for _, each in pairs]
    if len(pairs) < _LEAST_PAIRS or len({*predicted}) < 2 or len({*measured}) < 2:
        return RankCorrelation(method, len(pairs), None, None)
    from scipy.stats import spearmanr  # takes half a second, and few commands compare

    rho, p_value = map(float, spearmanr(predicted, measured))
    return RankCorrelation(method, len(pairs), rho, p_value if isfinite(p_value) else None)


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
            (fault, good): [] for fault, good in ((True, False), (True, True), (False, True), (False, False))
        }
        for name, good in (passed_on_surfaces if rule in _ON_SURFACES else passed).items():
            fault = any(each.rule == rule and each.verdict in _FAULTS for each in parts[name].judgements)
            room = rooms[name].get(rule)
            if fault or (room is not None and (good or room <= min(rooms[name].values()))):
                lists[fault, good].append(name)
        if any(lists.values()):
            found.append(RuleCheck(rule, *map(tuple, lists.values())))
    return tuple(found)


def _rooms(part: Part, report: CleaningReport, *, surface: bool) -> dict[Rule, float]:
    """Give for each rule that judged a clean part by how many times its nearest number is from its limit.

    Rules on gaps that find fault or nothing are judged by the numbers of the gap. Nothing of a part that is not clean.
    """
    if cleanliness(part) != "clean":
        return {}
    found: dict[Rule, float] = {}

    def note(rule: Rule, room: float) -> None:
        found[rule] = min(room, found.get(rule, inf))

    for each in part.judgements:
        if each.verdict == "clean" and each.rule != rules.WET_GAP:
            pairs = [(abs(number.value), abs(number.limit)) for number in each.numbers if number.limit]
            # A clean judgement's number is on the good side of its limit, whichever side that is.
            note(each.rule, min((max(pair) / min(pair) if min(pair) else inf for pair in pairs), default=inf))
    for gap in part.gaps:
        if any(at is not None and stage.use == "wash" for stage, at in zip(report.stages, gap.stages, strict=True)):
            numbers = GapNumbers.of(gap, report.stages)
            for each in criteria_of(numbers, gap.fill, gap.exchanges_needed, report.parameters):
                if each.room is not None:
                    note(each.rule, each.room)
    return found if surface else {rule: room for rule, room in found.items() if rule not in _ON_SURFACES}


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
