"""Outcome of one recipe: the requirements that are and are not met, its time and its liquid."""

from collections.abc import Mapping
from dataclasses import dataclass

from cleaning.parameters.model import Use
from cleaning.verdicts.results import CleaningReport
from recipes.recipe import Recipe
from rulesengine.planning.pipeline import Run
from rulesengine.strokes.classify import read_masks
from rulesengine.tuning.trial.deposits import Deposits, deposits_of
from rulesengine.tuning.trial.requirements import (
    BOARD,
    PROCESS,
    Goal,
    MetRequirement,
    UnmetRequirement,
    attainable,
    met_requirements,
    total_shortfall,
    unmet_requirements,
)
from specs.source import Source


@dataclass(frozen=True, slots=True)
class StepSummary:
    """One step of the sequence as it was analysed."""

    made_by: str
    """Such as ``"sequence[0]"``."""
    use: Use
    function: str
    seconds: float
    window_c: tuple[float, float] | None
    """Temperatures at which its liquid may be used."""


@dataclass(frozen=True, slots=True)
class Figures:
    """An outcome summed up."""

    clean_components: int
    open_requirements: int
    worst_residue: float
    seconds: float
    litres: float


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """A recipe, and what it is predicted to do on the board."""

    text: str
    recipe: Recipe
    unmet: tuple[UnmetRequirement, ...]
    met: tuple[MetRequirement, ...]
    steps: tuple[StepSummary, ...]
    classes: Mapping[str, str]
    """Component to class."""
    sides: Mapping[str, str]
    """Component to side."""
    makers: Mapping[str, tuple[tuple[Source, float], ...]]
    """Component to the shares of what sprays it."""
    residues: Mapping[str, float]
    """Component to the share of residue under it; those that have a gap."""
    excluded: frozenset[str]
    """Components that masks take out."""
    total: int
    """Components that are not excluded."""
    seconds: float
    litres: float
    shortfall: float
    deposits: Deposits
    """What each template leaves on the surface."""

    @property
    def clean(self) -> bool:
        """Whether every requirement is met."""
        return not self.unmet

    @property
    def attainable(self) -> tuple[UnmetRequirement, ...]:
        """Requirements that are not met and that a recipe can meet."""
        return attainable(self.unmet)

    @property
    def figures(self) -> Figures:
        """Sum it up."""
        worst = max((share for name, share in self.residues.items() if name not in self.excluded), default=0.0)
        open_components = {each.component for each in self.unmet} - {BOARD, PROCESS}
        clean = self.total - len(open_components)
        return Figures(clean, len(self.unmet), round(worst, 6), self.seconds, self.litres)

    def seconds_in(self, steps: frozenset[str]) -> float:
        """Time of some steps together."""
        return sum(step.seconds for step in self.steps if step.made_by in steps)

    def use_of(self, made_by: str) -> Use | None:
        """Use of a step; ``None`` where it did not spray."""
        return next((step.use for step in self.steps if step.made_by == made_by), None)


def outcome_of(run: Run, report: CleaningReport, goal: Goal, text: str = "") -> Outcome:
    """Extract from an analysis what tuning works with."""
    masks, _ = read_masks(run.recipe, run.board)
    excluded = frozenset(masks.ignored) | {name for name, _ in masks.avoided}
    unmet = unmet_requirements(report, goal, excluded)
    return Outcome(
        text=text,
        recipe=run.recipe,
        unmet=unmet,
        met=met_requirements(report, excluded),
        steps=tuple(
            StepSummary(
                str(each.made_by), each.use, each.function, round(each.end_s - each.begin_s, 3), each.liquid.window_c
            )
            for each in report.stages
        ),
        classes={each.component: each.component_class for each in run.classified},
        sides={each.name: each.side for each in run.board.components},
        makers={part.component: part.makers for part in (*report.parts, report.bare)},
        residues={part.component: part.residue for part in report.parts if part.residue is not None},
        excluded=excluded,
        total=sum(part.component not in excluded for part in report.parts),
        seconds=seconds_of(run),
        litres=litres_of(run),
        shortfall=total_shortfall(unmet),
        deposits=deposits_of(report),
    )


def seconds_of(run: Run) -> float:
    """Duration of the program of a run; loops count once. Rounded, so that the last digits decide nothing."""
    return round(run.program.totals.duration_s, 3)


def litres_of(run: Run) -> float:
    """Liquid that the program of a run sprays; loops count once. Rounded."""
    return round(sum(litres for _, litres in run.program.totals.liquid_l), 6)
