"""A cleaning report in words and tables: grades, limits of the model, headline, producer, rows."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import TYPE_CHECKING

from cleaning.parameters.model import Known
from cleaning.parameters.provenance import assumptions_of
from cleaning.report import mean_residue, to_error
from cleaning.undersides.rinse import film_exchanges
from cleaning.verdicts.results import (
    CleaningReport,
    Judgement,
    Part,
    PartCapability,
    cleanliness,
    count_cleanliness,
    deciding_judgement,
    outcome,
    report_cleanliness,
    rests_on_uncalibrated_kinetics,
    stays_wet,
)
from cleaning.verdicts.rules import RULES, VERDICTS, Grade, Outcome, Rule, Verdict
from cleaning.verify import Verified
from reports.tables.similar_components import Description, Group, describe
from reports.tables.table import Cell, Line, Lines, Table, Text
from reports.tables.wording import amount, clock, name_some, number_text, short_number
from specs.json import Json

if TYPE_CHECKING:
    from cleaning.analyse import Effort

GRADES: dict[Grade, str] = {
    "A": "geometry and balances",
    "B": "physics, with parameters from the literature or proposed",
    "C": "removal kinetics, or a limit that is only proposed: for ranking only, until calibrated",
}

VERDICT_WORDS: dict[Verdict, str] = {
    "dirty": "is predicted to stay dirty",
    "marginal": "is near a limit",
    "no verdict": "is outside of what the model holds for",
    "clean": "is predicted to be clean",
    "avoided": "is avoided by a mask",
}

OUTCOME_WORDS: dict[Outcome, str] = {
    "dirty": "Dirty",
    "marginal": "Marginal",
    "clean, wet": "Clean, wet underneath",
    "no verdict": "No verdict",
    "clean": "Clean",
    "avoided": "Avoided",
}

KNOWN_WORDS: dict[Known, str] = {
    "source": "read in a source",
    "derived": "calculated",
    "literature": "believed from the literature, unchecked",
    "proposed": "proposed by us",
    "calibrated": "fitted to your measurements",
    "synthetic": "fitted to made-up data",
}

CAVEAT = (
    "This is a prediction and no proof of cleanliness. Qualify the process by surface insulation resistance (SIR) or "
    "ion chromatography (IC) on coupons that stand for the board."
)
UNCALIBRATED = "Its removal kinetics are uncalibrated: take it as a ranking of components, not as amounts."
CALIBRATED = "Its removal kinetics were fitted to measurements that the parameter set names."
SYNTHETIC = "Some of its parameters were fitted to made-up data: it demonstrates the method and nothing else."

LIMITS: tuple[str, ...] = (
    "No constant of the kinetics and none of the edge pressure has been checked by experiment. The pressure that the "
    "film raises at the edge of a component is the most uncertain link; film depth, its decay and its retention can "
    "change a residue by a factor of two to four.",
    "Contact angles and surface tensions are typical values. Measure those of your solution, board and flux.",
    "Not in the model: foam and splashing, bubbles that are trapped, puddles around tall parts, residue that settles "
    "again elsewhere, a cleaning agent that is used up, flux that hardened in a long reflow, flux that flows unlike "
    "water, capillary bridges at the necks of balls, a board that bends.",
    "Solder balls count as cylinders of their mean diameter.",
    "The ionic index is an estimate from dilution. It cannot be compared with an extract (ROSE) or with IC.",
    "Surfaces inside of connectors, under shields and in blind holes are not judged; their area is given as hidden.",
    "The influence of washing time on residue is stronger here than in the one published study of it.",
)
_MOST_NAMES = 8
_MOST_BROKEN = 3
_LEAST_BROKEN = 0.005
"""Share of the sets of values below which a rule is not named."""
"""In the narrow column; more stand in the wide one."""
_MOST_PACKAGES = 3
_MUCH_MORE = 10.0
"""Times what is needed from which on a stage does more than it has to."""


@dataclass(frozen=True, slots=True)
class Producer:
    """Version of Washboard and effort of an analysis."""

    version: str
    effort: "Effort"

    def __str__(self) -> str:
        """Write both as a person reads them."""
        return f"Washboard {self.version}, effort {self.effort}"

    def add_to(self, report: dict[str, Json]) -> dict[str, Json]:
        """Add both to a report as plain data, after its first key, which is the version of the data."""
        (first, of_data), *rest = report.items()
        return {first: of_data, "washboard": self.version, "effort": self.effort, **dict(rest)}


def this_producer(effort: "Effort") -> Producer:
    """Give the running Washboard as the producer."""
    return Producer(version("washboard"), effort)


def headline(report: CleaningReport) -> str:
    """One sentence: how clean the worst component is, never an average, and how many stay wet."""
    wet = wet_count(report)
    worst, components = report_cleanliness(report), amount(len(report.parts), "component")
    counts = count_cleanliness(report.parts)
    count, avoided = counts.get(worst, 0), counts.get("avoided", 0)
    verdict = "without verdict" if worst == "no verdict" else worst
    if not report.parts:
        clean = "no components to judge"
    elif worst == "clean":
        clean = f"{count} of {components} clean" if avoided else f"all of {components} clean"
    else:
        clean = f"{count} of {components} {verdict}" if count else f"{verdict}, for the process or the bare board"
    more = [f"{wet} {_stay(wet)} wet underneath"] if wet else []
    more += [f"{avoided} avoided"] if avoided else []
    return "; ".join([f"Predicted: {clean}", *more])


def main_cause(report: CleaningReport) -> str:
    """One sentence for the whole board: the rule that most components that are not clean fail by, and what helps most.

    Empty where all are clean but for water.
    """
    failing = [deciding_judgement(part) for part in report.parts if cleanliness(part) in ("dirty", "marginal")]
    if not failing:
        return ""
    functions = {str(stage.made_by): stage.function for stage in report.stages}
    causes = Counter((each.rule, functions.get(str(each.stage), "")) for each in failing)
    (rule, function), count = causes.most_common(1)[0]
    alike = [each for each in failing if (each.rule, functions.get(str(each.stage), "")) == (rule, function)]
    advice, _ = Counter(each.advice for each in alike).most_common(1)[0]
    place = f" in {function}" if function else ""
    return f"{count} of {len(failing)} that are not clean fail by {rule.id} {rule.title}{place}. {advice}".rstrip()


def grade_words(part: Part) -> str:
    """Grade of what decides a component, and whether its verdict stands on kinetics that nothing fitted."""
    return deciding_judgement(part).grade + ", uncalibrated" * rests_on_uncalibrated_kinetics(part)


def kinetics_words(report: CleaningReport) -> str:
    """One sentence: how many verdicts stand on kinetics that nothing fitted; empty where none does."""
    count = sum(map(rests_on_uncalibrated_kinetics, report.parts))
    return f"{count} of {amount(len(report.parts), 'verdict')} rest on uncalibrated kinetics." if count else ""


def count_words(parts: Iterable[Part]) -> str:
    """Number of components by their verdict, such as ``3 dirty, 40 clean``."""
    return ", ".join(f"{count} {verdict}" for verdict, count in count_cleanliness(parts).items()) or "none"


def wet_count(report: CleaningReport) -> int:
    """Count the components under which water stays."""
    return sum(map(stays_wet, report.parts))


def wet_words(count: int) -> str:
    """What becomes of so many components that are not dried, and what helps."""
    return f"{_stay(count)} wet underneath: bake, or blow harder"


def _stay(count: int) -> str:
    return "stays" if count == 1 else "stay"


def caveat(report: CleaningReport) -> str:
    """Limits of the prediction: no proof, calibrated or not, synthetic data."""
    known = {each.known for each in assumptions_of(report.parameters)}
    texts = [CAVEAT, CALIBRATED if report.parameters.calibrated else UNCALIBRATED]
    return " ".join([*texts, *([SYNTHETIC] * ("synthetic" in known))])


def remarks(report: CleaningReport) -> list[str]:
    """Findings that are no judgement, such as a liquid that the parameter set does not have."""
    others = (finding for finding in report.findings if not finding.rule.verdict)
    return [f"{each.made_by}: {each.message}" if each.made_by else each.message for each in others]


def renewals(report: CleaningReport) -> list[str]:
    """How often each rinse renews the film on the bare board."""
    texts: list[str] = []
    for stage, bare in zip(report.stages, report.bare.exposed, strict=True):
        if stage.use == "rinse" and bare is not None:
            low, mean = (film_exchanges(report.parameters.rinse, volume) for volume in bare.volume_mm[1:])
            texts.append(
                f"{stage.made_by}: {stage.function} renews the film on the bare board {short_number(mean)} times on "
                f"average, on its least wetted places {short_number(low)} times."
            )
    return texts


def surplus_words(report: CleaningReport) -> list[str]:
    """By how many times washing and rinsing renew even the least renewed gap, where that is much more than needed."""
    texts: list[str] = []
    for use, what in (("wash", "Washing"), ("rinse", "Rinsing")):
        times: list[float] = []
        for gap in (gap for part in report.parts for gap in part.gaps):
            needed = gap.exchanges_needed if use == "wash" else report.parameters.limits.exchanges
            acts = [(stage, at) for stage, at in zip(report.stages, gap.stages, strict=True) if at and stage.use == use]
            if acts and needed > 0:
                times.append(sum(stage.repeats * at.exchanges for stage, at in acts) / needed)
        least = min(times, default=0.0)
        if least >= _MUCH_MORE:
            advice = "it may be shorter" if use == "rinse" else "time of contact and temperature count, not flow"
            often = f"at least {short_number(round(least))} times as often as needed"
            texts.append(f"{what} renews every gap {often}: {advice}.")
    return texts


def board_judgements(report: CleaningReport) -> Iterator[tuple[str, Judgement]]:
    """Judgements of the process as a whole and of the bare board, with the name of what is judged."""
    yield from (("process", each) for each in report.process)
    yield from (("bare board", each) for each in report.bare.judgements)


def capability_words(report: CleaningReport) -> str:
    """One sentence: in how many of 100 sets of values all is clean; empty where that was not worked out."""
    found = report.capability
    if found is None:
        return ""
    but = f" but {name_some(found.left_out, _MOST_NAMES)}" if found.left_out else ""
    return (
        f"All components{but} come out clean in {100 * found.together:.0f} of 100 sets of values, with "
        f"{amount(len(found.varied), 'value')} within their stated ranges"
    )


def sure_words(capability: PartCapability) -> str:
    """In how many of 100 sets of values one component comes out clean, what it fails by else, and what matters."""
    if capability.clean_share is None:
        return "not judged, whatever the values"
    words = f"clean in {100 * capability.clean_share:.0f} of 100 sets of values"
    if capability.broken:
        broken = (f"{rule.id} ({100 * share:.0f})" for rule, share in capability.broken[:_MOST_BROKEN])
        words += f"; else {', '.join(broken)}"
    return words + (f"; {capability.strongest} matters most" if capability.strongest and capability.broken else "")


def capability_table(report: CleaningReport, most_names: int | None = None) -> Table:
    """List components that do not come out clean in all sets of values, the least sure first; alike ones in one row."""
    found = report.capability
    unsure = [] if found is None else [each for each in found.parts if each.broken and each.clean_share is not None]
    groups: dict[tuple[tuple[Rule, ...], str], list[PartCapability]] = {}
    for each in sorted(unsure, key=lambda each: each.clean_share or 0.0):
        failing = tuple(rule for rule, share in each.broken if share >= _LEAST_BROKEN)
        groups.setdefault((failing or (each.broken[0][0],), each.strongest), []).append(each)
    rows: list[tuple[Cell, ...]] = []
    for (failing, strongest), group in groups.items():
        names = [each.component for each in group]
        listed = ", ".join(names) if most_names is None else name_some(names, most_names)
        shares = [dict(each.broken) for each in group]
        counts = ((rule, _of_100(each.get(rule, 0.0) for each in shares)) for rule in failing)
        broken = ", ".join(f"{rule.id} {rule.title} {count}" for rule, count in counts)
        rows.append((listed, _of_100(each.clean_share or 0.0 for each in group), broken, strongest))
    return Table.of(("component", ">clean, of 100", "else fails by", "depends most on"), rows)


def _of_100(shares: Iterable[float]) -> str:
    whole = sorted(round(100 * share) for share in shares)
    return f"{whole[0]}" if whole[0] == whole[-1] else f"{whole[0]} to {whole[-1]}"


def parts_table(report: CleaningReport, groups: Sequence[Group]) -> Table:
    """List groups of components that are not clean, with what decides and what to do."""
    packages = {component.name: component.package for component in report.board.components}
    headings = ("component", "verdict", "what decides", "what to do")
    return Table.of(headings, [_group_row(group, packages) for group in groups])


def _group_row(group: Group, packages: Mapping[str, str]) -> tuple[Cell, ...]:
    first, count = group.parts[0], len(group.parts)
    advice: list[Line] = [text for text in dict.fromkeys(each.advice for each in group.descriptions) if text]
    makers = ", ".join(f"{made_by} {share:.0%}" for made_by, share in first.makers[:2])
    if makers and count == 1:
        advice.append(Text(f"sprayed by {makers}", "quiet"))
    kinds = list(dict.fromkeys(packages[name] for name in group.names if packages.get(name)))
    names, many = ", ".join(group.names), count > _MOST_NAMES
    decides = [line for each in group.descriptions for line in _description_lines(each)]
    heading = Text(amount(count, "component") if many else names, "strong")
    verdict, grade = Text(outcome(first), tone=outcome(first)), Text(f"grade {grade_words(first)}", "quiet")
    below = (*decides, *([Text(names, "small")] if many else []))
    package = Text(name_some(kinds, _MOST_PACKAGES), "quiet")
    return (Lines(heading, (package,)), Lines(verdict, (grade,)), Lines("", below), Lines("", tuple(advice)))


def _description_lines(description: Description) -> tuple[Line, Line]:
    """What a rule found, and the numbers below it."""
    title = Text(f"{description.rule} {description.name}", "strong")
    numbers = "; ".join(number_text(low, high) for low, high in description.numbers)
    found = f", {description.verdict}, {description.grade}: {description.because}"
    return (title, found), Text(numbers, "quiet")


def process_table(report: CleaningReport) -> Table:
    """List what holds for the process as a whole, and for the bare board."""
    rows = [
        (name, Text(each.verdict, tone=each.verdict), Lines("", _description_lines(describe(each))), each.advice)
        for name, each in board_judgements(report)
    ]
    return Table.of(("of the", "verdict", "what decides", "what to do"), rows)


def stage_table(report: CleaningReport, *, bare_board: bool = False) -> Table:
    """List the stages in order; with the volume that lands on the bare board, if requested, mm."""
    litres = dict(report.litres)
    rows: list[tuple[str, ...]] = []
    for stage, exposure, bare in zip(report.stages, report.exposures, report.bare.exposed, strict=True):
        landed = exposure.landed_mm3 / exposure.sprayed_mm3 if exposure.sprayed_mm3 > 0 else 0.0
        liquid = litres.pop(stage.function, None)  # litres are known by function: they stand where it comes first
        volumes = "" if bare is None or stage.use == "dry" else " / ".join(map(short_number, bare.volume_mm))
        rows.append((
            stage.function, stage.solution, stage.nozzle_name, f"{stage.pressure_pa / 1e5:.3g}",
            f"{stage.temperature_c:.3g}", clock(stage.end_s - stage.begin_s), clock(stage.spray_s),
            "" if liquid is None else f"{liquid:.2f}", "" if stage.use == "dry" else f"{landed:.0%}",
            *((volumes,) if bare_board else ()),
        ))  # fmt: skip
    headings = ("function", "solution", "nozzle", ">bar", ">°C", ">time", ">spraying", ">litres", ">lands")
    return Table.of((*headings, *((">bare board, mm: least / low / mean",) if bare_board else ())), rows)


def gap_table(report: CleaningReport, part: Part) -> Table:
    """List the numbers of each case of a gap, stage by stage."""
    rows: list[tuple[str, ...]] = []
    for gap in part.gaps:
        for stage, result in zip(report.stages, gap.stages, strict=True):
            if result is not None:
                needed = gap.exchanges_needed if stage.use == "wash" else report.parameters.limits.exchanges
                rows.append((
                    f"{1000 * gap.gap_height_mm:.0f}", stage.function, "yes" if result.entered else "no",
                    short_number(result.margin_pa), "" if needed <= 0 else short_number(result.exchanges / needed),
                    short_number(needed),
                    f"{result.weak_share:.0%}", f"{short_number(100 * mean_residue(result, gap.field))}%",
                    clock(result.wet_s),
                ))  # fmt: skip
    headings = (
        ">gap, µm", "stage", "entered", ">margin, Pa", ">renewed, times needed", ">needed", ">weak area",
        ">residue left", ">wet for",
    )  # fmt: skip
    return Table.of(headings, rows)


def verified_table(verified: Sequence[Verified]) -> Table:
    """List what rays gave for chosen components, and what the exact sum gives."""
    rows: list[tuple[str, ...]] = []
    for each in verified:
        off = (each.rays_mm - each.exact_mm) / each.exact_mm if each.exact_mm > 0 else 0.0
        rays, exact, worst = map(short_number, (each.rays_mm, each.exact_mm, each.worst_mm))
        cone, error, exact_cone = (
            f"{to_error(value, each.cone_error_s):g}" for value in (each.cone_s, each.cone_error_s, each.exact_cone_s)
        )
        rows.append(
            (each.component, each.function, rays, exact, f"{off:+z.1%}", worst, f"{cone} ± {error}", exact_cone)
        )
    headings = (">rays, mm", ">exact, mm", ">difference", ">worst cell, mm", ">cone, s", ">exact, s")
    return Table.of(("component", "stage", *headings), rows)


def rules_table(report: CleaningReport) -> Table:
    """List all rules with what each found."""
    judged = [each for part in (report.bare, *report.parts) for each in part.judgements] + list(report.process)
    rows: list[tuple[Cell, ...]] = []
    for rule in RULES:
        found = Counter(each.verdict for each in judged if each.rule == rule)
        tally = ", ".join(f"{found[verdict]} {verdict}" for verdict in VERDICTS if verdict in found)
        rows.append((rule.id, rule.meaning, rule.grade, tally or Text("nothing", "quiet")))
    return Table.of(("rule", "looks for", "grade", "found"), rows)


def assumptions_table(report: CleaningReport) -> Table:
    """List every parameter of the model with its value and its source."""
    rows: list[tuple[Cell, ...]] = []
    for each in assumptions_of(report.parameters):
        entry = each.provenance
        source = f"{entry.source} ({entry.date})" if entry.date else entry.source
        if entry.samples is not None:
            source += f"; {amount(entry.samples, 'sample')}"
        if entry.rms is not None:  # of a fitted value also how well it was fitted
            source += f", rms {entry.rms:.3g}"
        if entry.interval is not None:
            source += f", 95 % {entry.interval[0]:.4g} to {entry.interval[1]:.4g}"
        rows.append((Text(each.path, "code"), each.value, KNOWN_WORDS[each.known], source))
    return Table.of(("parameter", "value", "known how", "from"), rows)
