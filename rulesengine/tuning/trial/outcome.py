"""What one recipe is predicted to do: what is wanting, how long it takes, how much it sprays."""

from collections.abc import Mapping
from dataclasses import dataclass

from cleaning.parameters.model import Use
from cleaning.verdicts.results import CleaningReport
from recipes.recipe import Recipe
from rulesengine.planning.pipeline import Run
from rulesengine.strokes.classify import service
from rulesengine.tuning.trial.deposits import Deposits, deposits_of
from rulesengine.tuning.trial.requirements import (
    BOARD,
    PROCESS,
    Goal,
    Spare,
    Want,
    mendable,
    shortfall_of,
    spares_of,
    wants_of,
)


@dataclass(frozen=True, slots=True)
class Did:
    """One step of the sequence as it was analysed."""

    made_by: str
    """Such as ``"sequence[0]"``."""
    use: Use
    function: str
    seconds: float
    """How long it takes."""
    window_c: tuple[float, float] | None
    """Temperatures at which its liquid may be used."""


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """A recipe, and what it is predicted to do on the board."""

    text: str
    recipe: Recipe
    wants: tuple[Want, ...]
    spares: tuple[Spare, ...]
    """Judgements that hold, with what they need."""
    steps: tuple[Did, ...]
    classes: Mapping[str, str]
    """Component to class."""
    sides: Mapping[str, str]
    """Component to side."""
    makers: Mapping[str, tuple[tuple[str, float], ...]]
    """Component to who sprays it."""
    limiting: Mapping[str, str]
    """Component to the factor that its residue depends on most."""
    residues: Mapping[str, float]
    """Component to the share of residue under it; those that have a gap."""
    left_out: frozenset[str]
    """Components that masks take out."""
    total: int
    """Components that are asked for."""
    seconds: float
    litres: float
    shortfall: float
    deposits: Deposits
    """What each template leaves on the surface."""

    @property
    def clean(self) -> bool:
        """Whether nothing is wanting."""
        return not self.wants

    @property
    def mendable(self) -> tuple[Want, ...]:
        """What is wanting and may be mended by a recipe."""
        return mendable(self.wants)

    @property
    def worst_residue(self) -> float:
        """The largest share of residue under a component; 0 where none has a gap."""
        return max((share for name, share in self.residues.items() if name not in self.left_out), default=0.0)

    @property
    def held(self) -> int:
        """How many of the components that are asked for lack nothing."""
        lacking = {want.component for want in self.wants} - {BOARD, PROCESS}
        return self.total - len(lacking)

    def seconds_in(self, steps: frozenset[str]) -> float:
        """How long some steps take together."""
        return sum(step.seconds for step in self.steps if step.made_by in steps)

    def use_of(self, made_by: str) -> Use | None:
        """Say what a step is for; nothing where it did not spray."""
        return next((step.use for step in self.steps if step.made_by == made_by), None)


def outcome_of(run: Run, report: CleaningReport, goal: Goal, text: str = "") -> Outcome:
    """Keep of an analysis what tuning looks at."""
    masks, _ = service(run.recipe, run.board)
    left_out = frozenset(masks.ignored) | {name for name, _ in masks.avoided}
    wants = wants_of(report, goal, left_out)
    parts = (*report.parts, report.bare)
    return Outcome(
        text=text,
        recipe=run.recipe,
        wants=wants,
        spares=spares_of(report, left_out),
        steps=tuple(
            Did(each.made_by, each.use, each.function, round(each.end_s - each.begin_s, 3), each.liquid.window_c)
            for each in report.stages
        ),
        classes={each.component: each.component_class for each in run.classified},
        sides={each.name: each.side for each in run.board.components},
        makers={part.component: part.makers for part in parts},
        limiting={part.component: part.limiting for part in parts if part.limiting},
        residues={part.component: part.residue for part in report.parts if part.residue is not None},
        left_out=left_out,
        total=sum(part.component not in left_out for part in report.parts),
        seconds=seconds_of(run),
        litres=litres_of(run),
        shortfall=shortfall_of(wants),
        deposits=deposits_of(report),
    )


def seconds_of(run: Run) -> float:
    """How long the program of a run takes; loops count once. Rounded, so that the last digits decide nothing."""
    return round(run.program.totals.duration_s, 3)


def litres_of(run: Run) -> float:
    """How much liquid the program of a run sprays; loops count once. Rounded."""
    return round(sum(litres for _, litres in run.program.totals.liquid_l), 6)
