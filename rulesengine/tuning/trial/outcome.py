"""Outcome of one recipe: the requirements that are and are not met, time, liquid, and deposits of each template.

Deposits add up cell by cell, whatever the order.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from boards.board import Board, Side
from cleaning.parameters.model import Use
from cleaning.process.stages import Stage
from cleaning.surface.facets import Facets
from cleaning.verdicts.exposed_area import BARE, cells_of, cells_of_each
from cleaning.verdicts.results import CleaningReport
from geometry.arrays import Indices, Scalars
from programs.program import TimedProgram
from recipes.recipe import Recipe
from rulesengine.planning.pipeline import Run
from rulesengine.strokes.classify import Classified, read_masks
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

SprayTimes: TypeAlias = Mapping[tuple[str, str], float]
"""Seconds by step and template."""
_LEAST_S = 1e-6
_LEAST = 1e-12
_LEAST_NEED = 1e-3


@dataclass(frozen=True, slots=True)
class ProgramTimes:
    """What a program takes."""

    seconds: float
    litres: float
    sprayed: SprayTimes


@dataclass(frozen=True, slots=True)
class RobotRatios:
    """Seconds that a robot takes for a second within the recipe's limits."""

    sprayed: SprayTimes
    """By step and template."""
    all_sprayed: float
    """Of all of them together, for templates that were not sprayed."""
    rest: float
    """With the jet off."""

    def estimate(self, free: ProgramTimes) -> ProgramTimes:
        """Estimate what the robot takes for a program of which the times within the recipe's limits are known."""
        sprayed = {key: self.sprayed.get(key, self.all_sprayed) * seconds for key, seconds in free.sprayed.items()}
        before, after = sum(free.sprayed.values()), sum(sprayed.values())
        seconds = after + self.rest * (free.seconds - before)
        litres = free.litres * after / max(before, _LEAST_S)
        return ProgramTimes(round(seconds, 3), round(litres, 6), sprayed)


def robot_ratios(free: ProgramTimes, robot: ProgramTimes) -> RobotRatios:
    """Compare what one recipe takes within its limits and on a robot."""

    def ratio(longer: float, shorter: float) -> float:
        return longer / shorter if shorter > _LEAST_S else 1.0

    sprayed = {key: ratio(robot.sprayed.get(key, seconds), seconds) for key, seconds in free.sprayed.items()}
    totals = sum(free.sprayed.values()), sum(robot.sprayed.values())
    rest = ratio(robot.seconds - totals[1], free.seconds - totals[0])
    return RobotRatios(sprayed, ratio(totals[1], totals[0]), rest)


@dataclass(frozen=True, slots=True, eq=False)
class Deposit:
    """Liquid that one template leaves in one step, all its repeats together."""

    step: str
    """Such as ``"sequence[0]"``."""
    template: str
    seconds: float
    """Spraying."""
    volume_mm: NDArray[np.float32]
    """(c,) that lands on each cell of the surface or flows over it."""


@dataclass(frozen=True, slots=True, eq=False)
class Deposits:
    """All deposits of a program, and the cells of each component."""

    each: tuple[Deposit, ...]
    areas_mm2: Scalars
    """(c,)"""
    cells: Mapping[tuple[str, Side], Indices]
    """The exposed cells of each component on its own side, and of the bare board on both."""


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
    """Fitted to the board."""
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
    def margin(self) -> float:
        """Least of all amounts (R2) and times (R7) over what a clean verdict needs; 0 where one is not clean."""
        if self.attainable:
            return 0.0
        return round(1.0 / max(_LEAST_NEED, max((met.needed for met in self.met), default=1.0)), 3)

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


@dataclass(frozen=True, slots=True, eq=False)
class ReadProgram:
    """A program that was read, with what a run has besides."""

    recipe: Recipe
    """As it was written."""
    fitted: Recipe
    """As it was planned on this board."""
    board: Board
    classified: tuple[Classified, ...]
    program: TimedProgram
    robot: None = None


Planned: TypeAlias = Run | ReadProgram
"""A recipe on a board with its program."""


def outcome_of(run: Planned, report: CleaningReport, goal: Goal, text: str = "") -> Outcome:
    """Extract from an analysis what tuning works with."""
    excluded = _excluded(run)
    return assemble_outcome(
        run,
        text,
        deposits_of(report),
        unmet=unmet_requirements(report, goal, excluded),
        met=met_requirements(report, excluded),
        steps=tuple(
            StepSummary(
                str(each.made_by), each.use, each.function, round(each.end_s - each.begin_s, 3), each.liquid.window_c
            )
            for each in report.stages
        ),
        makers={part.component: part.makers for part in (*report.parts, report.bare)},
        residues={part.component: part.residue for part in report.parts if part.residue is not None},
        total=sum(part.component not in excluded for part in report.parts),
        seconds=seconds_of(run),
        litres=litres_of(run),
    )


def assemble_outcome(run: Planned, text: str, deposits: Deposits, **found: Any) -> Outcome:
    """Join what an analysis found, by the fields of an outcome, with what the plan gives."""
    return Outcome(
        text=text,
        recipe=run.fitted,
        classes={each.component: each.component_class for each in run.classified},
        sides={each.name: each.side for each in run.board.components},
        excluded=_excluded(run),
        shortfall=total_shortfall(found["unmet"]),
        deposits=deposits,
        **found,
    )


def _excluded(run: Planned) -> frozenset[str]:
    masks, _ = read_masks(run.fitted, run.board)
    return frozenset(masks.ignored) | {name for name, _ in masks.avoided}


def seconds_of(run: Planned) -> float:
    """Duration of a run's program, on the robot that it is planned for; loops count once.

    Rounded, so that the last digits decide nothing.
    """
    return round(run.program.totals.duration_s if run.robot is None else run.robot.robot_s, 3)


def litres_of(run: Planned) -> float:
    """Liquid that the program of a run sprays; loops count once. Rounded."""
    return round(sum(litres for _, litres in run.program.totals.liquid_l), 6)


def judged_cells(facets: Facets, board: Board, sides: Iterable[Side]) -> dict[tuple[str, Side], Indices]:
    """Exposed cells of each component on its own side, and of the bare board on some sides."""
    cells: dict[tuple[str, Side], Indices] = {
        (component.name, component.side): own
        for component, own in zip(board.components, cells_of_each(facets, board), strict=True)
    }
    for side in sides:
        if (BOARD, side) not in cells:
            cells[BOARD, side] = cells_of(facets, board, BARE, side)
    return {key: own[facets.cell_exposed[own]] for key, own in cells.items()}


def deposits_of(report: CleaningReport) -> Deposits:
    """Deposits of an analysis by step and template."""
    facets = report.facets
    shown = judged_cells(facets, report.board, (stage.side for stage in report.stages))
    found: list[Deposit] = []
    for stage, exposure in zip(report.stages, report.exposures, strict=True):
        samples, growth, volume = stage.samples, exposure.growth, exposure.volume_mm
        last = np.searchsorted(samples.times, growth.until_s) - 1
        of_entry = np.repeat(samples.templates[last], np.diff(growth.start))
        grown = np.bincount(growth.cell, growth.volume_mm, minlength=len(volume))
        for (step, template), seconds in spray_durations(stage):
            mine = of_entry == template
            own = np.bincount(growth.cell[mine], growth.volume_mm[mine], minlength=len(volume))
            # Cells that few rays hit have been refined since they grew: the shares are kept all the same.
            overall = np.full(len(volume), own.sum() / max(grown.sum(), _LEAST))
            share = np.divide(own, grown, out=overall, where=grown > 0)
            supply = share * volume
            if len(growth.film_mm):
                film_mm = growth.film_mm[samples.templates[last] == template].sum(axis=0, dtype=np.float64)
                supply += report.run_off[stage.side].on_cells(supply, film_mm)
            found.append(Deposit(step, template, seconds, supply.astype(np.float32)))
    return Deposits(tuple(found), facets.cell_areas_mm2, shown)


def spray_durations(stage: Stage) -> Iterator[tuple[tuple[str, str], float]]:
    """Seconds for which each template sprays in a stage, by step and template."""
    of_sample = stage.samples.templates
    for template in dict.fromkeys(of_sample.tolist()):
        yield (str(stage.made_by), template), float(stage.samples.seconds[of_sample == template].sum())
