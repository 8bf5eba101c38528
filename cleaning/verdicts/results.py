"""The results of an analysis: verdicts, each with the numbers that caused it, and the grade of their confidence.

Cleanliness and drying are apart: whether a component comes out clean, and whether it stays wet underneath.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from boards.board import Board, Side
from boards.undersides.underside import Underside
from cleaning.exposure.exposure import Exposure
from cleaning.film.run_off import RunOff
from cleaning.parameters.model import Parameters, PartOverride
from cleaning.process.stages import Stage
from cleaning.surface.facets import Facets
from cleaning.undersides.residue import GapResult
from cleaning.undersides.rinse import RinseWater
from cleaning.verdicts.rules import OUTCOMES, RESIDUE_LEFT, VERDICTS, WET_GAP, Grade, Outcome, Rule, Verdict
from programs.plan import Origin
from recipes.recipe import Use
from specs.finding import Finding
from specs.source import NO_SOURCE, Source

_LEAST = 1e-4
"""Below it a number would need an exponent, finer than sentences are."""


@dataclass(frozen=True, slots=True)
class Number:
    """One number behind a judgement."""

    name: str
    value: float
    unit: str
    limit: float | None = None


def two_digits(value: float) -> str:
    """Write two digits of a number from 0 on, all before the point, and never an exponent: for sentences."""
    if value < _LEAST:
        return "0"
    return f"{value:.0f}" if value >= 10.0 else f"{value:.2g}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Judgement:
    """Result of one rule for one component, or for the whole board."""

    rule: Rule
    verdict: Verdict
    because: str
    """One sentence with the numbers."""
    numbers: tuple[Number, ...] = ()
    advice: str = ""
    """What to do about it; empty where there is nothing to do."""
    variant: str = ""
    """Which of the rule's cases it is, such as ``"shadowed"``; empty if the rule's title names it."""
    calibrated: bool = False
    """Rests on kinetics that were fitted to measurements, or on limits that have a source: raises grade C to B."""
    stage: Source = NO_SOURCE
    """``made_by`` of the stage; empty for all together."""
    where: tuple[float, float, float] | None = None
    """Place in the board frame, mm."""
    sides: tuple[tuple[float, float], ...] = ()
    """Directions, outward in the board's plane, from which a pass is missing."""

    @property
    def name(self) -> str:
        """Such as ``"dry gap"``."""
        return self.variant or self.rule.title

    @property
    def grade(self) -> Grade:
        """What the judgement rests on."""
        return "B" if self.calibrated else self.rule.grade


@dataclass(frozen=True, slots=True)
class ExposedPart:
    """What reaches the exposed surface of one component, or of the bare board, in one stage."""

    area_mm2: float
    """Exposed."""
    hidden_mm2: float
    """Sees no open sky: not judged here."""
    missed_share: float
    """Of the exposed area, never hit."""
    volume_mm: tuple[float, float, float]
    """Least, low, mean of what lands; low stands for the least wetted places (``exposed_area.low_value``)."""
    supply_mm: tuple[float, float, float]
    """Likewise of what lands or flows over it: film, and what runs down its walls from its top."""
    front_s: tuple[float, float, float]
    cone_s: tuple[float, float, float]
    cone_error_s: float
    """The mean of ``cone_s`` is within it of the exact one in 95 % of cases."""
    peak_pa: float


@dataclass(frozen=True, slots=True, eq=False)
class Reach:
    """What all washing, or all rinsing, of one side brings to the exposed surface."""

    use: Use
    functions: str
    """Names of the functions, such as ``"clean"`` or ``"prewash and clean"``."""
    made_by: Source
    """The stage's; empty if there are several."""
    repeats: int
    """How often loops may do it, at most."""
    exposed: ExposedPart


@dataclass(frozen=True, slots=True)
class PartCapability:
    """In which share of samples of the model's values one component comes out clean."""

    component: str
    """Reference designator; ``"board"`` for the bare board."""
    clean_share: float | None
    """0 to 1; ``None`` where the model has no verdict, or a mask avoids it."""
    broken: tuple[tuple[Rule, float], ...]
    """Rules that it breaks first, each with its share of the samples, most first."""
    strongest: str
    """The value whose range changes the residue under it most; empty without a gap."""


@dataclass(frozen=True, slots=True)
class Capability:
    """Verdicts under the ranges that the parameter set states."""

    samples: int
    varied: tuple[str, ...]
    """Paths of the values that have a range."""
    parts: tuple[PartCapability, ...]
    """One per component, in the board's order, and the bare board."""
    together: float
    """Share of the samples in which all come out clean at once, but for those left out, avoided or without verdict."""
    left_out: tuple[str, ...]
    """Components that break a limit with the values as they are stated."""


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """All results for one component."""

    component: str
    """Reference designator; ``"board"`` for the bare board."""
    verdict: Verdict
    grade: Grade
    """Of the judgement that decides."""
    judgements: tuple[Judgement, ...]
    """Worst first; at least one."""
    exposed: tuple[ExposedPart | None, ...]
    """One per stage; ``None`` where the stage sprays the other side."""
    underside: Underside | None
    """``None`` where no thin gap is known."""
    gaps: tuple[GapResult, ...]
    """One per case of the underside, the harder first."""
    elasticity: Mapping[str, float]
    """d ln(residue) / d ln(x) for ``time``, ``temperature``, ``chemistry``, ``pressure``, ``standoff``; empty without a
    gap."""
    limiting: str
    """The factor with the strongest elasticity; empty where there is none."""
    makers: tuple[tuple[Source, float], ...]
    """Who sprays it, and which share of the volume on it each gives, most first; at most 12."""
    reached: tuple[Reach, ...] = ()
    """What washing and rinsing bring to its exposed surface."""

    @property
    def residue(self) -> float | None:
        """Worst share of residue left in its gap; ``None`` without a gap."""
        return max((gap.residue for gap in self.gaps), default=None)


@dataclass(frozen=True, slots=True, eq=False)
class CleaningReport:
    """What a program cleans on a board."""

    origin: Origin
    board: Board
    parameters: Parameters
    parameters_sha256: str
    stages: tuple[Stage, ...]
    facets: Facets
    exposures: tuple[Exposure, ...]
    """One per stage."""
    run_off: Mapping[Side, RunOff]
    """How film and run-off of tops spread over the cells of each side."""
    bare: Part
    """The bare board."""
    parts: tuple[Part, ...]
    """One per component, in the board's order."""
    process: tuple[Judgement, ...]
    """What holds for the whole process: bath, water, temperatures, limits of the model."""
    verdict: Verdict
    """Of the worst component: never an average."""
    duration_s: float
    litres: tuple[tuple[str, float], ...]
    """By function, in the order of first use."""
    findings: tuple[Finding, ...]
    """Worst first."""
    capability: Capability | None = None
    """``None`` where it was not worked out."""
    rinse_water: RinseWater | None = None
    """``None`` where the parameter set has no cascade of tanks, or nothing is washed."""

    def worst_first(self) -> tuple[Part, ...]:
        """Components, the worst verdict first; then by residue, then in the board's order."""
        rank = {verdict: index for index, verdict in enumerate(VERDICTS)}
        return tuple(sorted(self.parts, key=lambda part: (rank[part.verdict], -(part.residue or 0.0))))


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """One component after all stages: the numbers that the rules look at."""

    component: str
    side: str
    place: tuple[float, float, float]
    stages: Sequence[Stage]
    exposed: Sequence[ExposedPart | None]
    """One per stage."""
    reached: Sequence[Reach]
    """Liquids only."""
    underside: Underside | None
    gaps: Sequence[GapResult]
    override: PartOverride
    """Empty where nothing special is known of the component."""
    occluder: str
    """What stands before the places that are missed; empty if nothing does."""
    parameters: Parameters
    avoided: bool = False
    """By a mask of the recipe."""


def cleanliness(part: Part) -> Verdict:
    """Give the verdict on a component by all rules but drying."""
    return _worst(each.verdict for each in part.judgements if each.rule != WET_GAP)


def stays_wet(part: Part) -> bool:
    """Whether drying leaves water under a component."""
    return any(each.rule == WET_GAP and each.verdict != "clean" for each in part.judgements)


def outcome(part: Part) -> Outcome:
    """Give the verdict on a component by all rules but drying; ``clean, wet`` where only water is left."""
    clean = cleanliness(part)
    return "clean, wet" if clean == "clean" and stays_wet(part) else clean


def deciding_judgement(part: Part) -> Judgement:
    """Give the judgement that decides what becomes of a component: that it stays wet counts where nothing else does."""
    wet = outcome(part) == "clean, wet"
    return next((each for each in part.judgements if (each.rule == WET_GAP) == wet), part.judgements[0])


def rests_on_uncalibrated_kinetics(part: Part) -> bool:
    """Whether residue decides what becomes of a component, or it is clean by it, and nothing fitted the kinetics."""
    residues = [each for each in part.judgements if each.rule == RESIDUE_LEFT and not each.calibrated]
    return bool(residues) and (cleanliness(part) == "clean" or deciding_judgement(part).rule == RESIDUE_LEFT)


def report_cleanliness(report: CleaningReport) -> Verdict:
    """Give the verdict on a board and its process by all rules but drying."""
    return _worst([*map(cleanliness, (report.bare, *report.parts)), *(each.verdict for each in report.process)])


def report_outcome(report: CleaningReport) -> Outcome:
    """Give the verdict on a board and its process by all rules but drying; ``clean, wet`` where only water is left."""
    clean = report_cleanliness(report)
    return "clean, wet" if clean == "clean" and any(map(stays_wet, report.parts)) else clean


def count_cleanliness(parts: Iterable[Part]) -> dict[Verdict, int]:
    """Count components by their cleanliness, the worst first; a verdict that none has is left out."""
    found = [cleanliness(part) for part in parts]
    return {verdict: found.count(verdict) for verdict in VERDICTS if verdict in found}


def parts_by_instance(report: CleaningReport) -> dict[str, list[Part]]:
    """Components of each board of a panel, by the board's number; empty for a single board."""
    parts = {part.component: part for part in report.parts}
    found: dict[str, list[Part]] = {}
    for instance in report.board.instances:
        names = (instance.rename(component.name) for component in instance.board.components)
        found[instance.name] = [parts[name] for name in names if name in parts]
    return found


def rank_parts(report: CleaningReport) -> list[Part]:
    """Give the components by what becomes of them, the worst first; then by residue, then in the board's order."""
    return sorted(report.parts, key=lambda part: (OUTCOMES.index(outcome(part)), -(part.residue or 0.0)))


def unclean_parts(report: CleaningReport) -> list[Part]:
    """Give the components that lack something, the worst first."""
    return [part for part in rank_parts(report) if part.verdict not in ("clean", "avoided")]


def _worst(verdicts: Iterable[Verdict]) -> Verdict:
    found = list(verdicts)
    return min(found, key=VERDICTS.index) if found else "clean"
