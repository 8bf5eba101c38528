"""What one run works with from step to step, and the strokes of its templates: only what is new is planned."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np

from boards.board import Board, Side
from programs.plan import Jet
from recipes.paths import PathSpec, StepFunction
from recipes.recipe import Recipe, Step
from rulesengine.modifiers.keep_out import avoided_zone, keep_out
from rulesengine.modifiers.pause_at_edges import edges_of, pause_at_edges
from rulesengine.modifiers.raise_over import raise_over
from rulesengine.planning.plan_path import plan_path
from rulesengine.strokes.classify import Classified, Service, classify, service
from rulesengine.strokes.safe_height import Floors, floors
from rulesengine.strokes.stroke import Site, Stroke, StrokeSet
from specs.finding import Finding

T = TypeVar("T", Floors, StrokeSet)


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """What a run is made of, by what each part depends on besides the board: the next run need not make it again."""

    floors: dict[Hashable, Floors] = field(default_factory=dict[Hashable, Floors])
    strokes: dict[Hashable, StrokeSet] = field(default_factory=dict[Hashable, StrokeSet])


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """What does not change from step to step."""

    recipe: Recipe
    board: Board
    classified: tuple[Classified, ...]
    classes: dict[str, str]
    """Component name to class name."""
    service: Service
    findings: tuple[Finding, ...]
    """Of classes and masks."""
    before: Parts
    """Of an earlier run on the same board."""
    parts: Parts = field(default_factory=Parts)
    """Of this run."""

    def floors(self, side: Side) -> Floors:
        """Say how high the orifice must be over a side."""
        limits = self.recipe.limits
        reach = limits.clearance_mm, limits.blend_mm
        return _again(self.parts.floors, self.before.floors, (side, *reach), lambda: floors(self.board, side, *reach))

    def strokes(self, step: Step, jet: Jet, template: str, made_by: str) -> StrokeSet:
        """Plan one template in its step, raise it over what is in the way, and cut it where it must not spray."""
        spec, nozzle = self.recipe.templates[template], self.recipe.nozzles[step.nozzle]
        # All that planners and modifiers look at besides the board, whose components come in one order.
        texts = (each.model_dump_json() for each in (spec, nozzle, self.recipe.limits))
        question = (step.side, jet, made_by, *texts, *self.classes.values(), self.service)
        return _again(
            self.parts.strokes,
            self.before.strokes,
            question,
            lambda: self._planned(spec, self._site(step, jet, made_by)),
        )

    def _site(self, step: Step, jet: Jet, made_by: str) -> Site:
        avoided = dict(self.service.avoided)
        served = frozenset(
            component.name
            for component in self.board.components
            if component.side == step.side
            and component.name not in self.service.ignored
            and component.name not in avoided
        )
        nozzle = self.recipe.nozzles[step.nozzle]
        return Site(self.board, step.side, nozzle, self.recipe.limits, jet, self.classes, served, made_by)

    def _planned(self, spec: PathSpec, site: Site) -> StrokeSet:
        clear_set = _cleared(plan_path(spec, site), spec, site, self.floors(site.side))
        return keep_out(clear_set, avoided_zone(self.board, site.side, self.service), site.nozzle, site.made_by)


def new_job(recipe: Recipe, board: Board, before: Parts) -> Job:
    """Classify the components and read the masks.

    Raises:
        RecipeError: a component matches no class.
    """
    classified, class_findings = classify(recipe, board)
    masks, mask_findings = service(recipe, board)
    classes = {each.component: each.component_class for each in classified}
    return Job(recipe, board, classified, classes, masks, (*class_findings, *mask_findings), before)


def _again(known: dict[Hashable, T], before: dict[Hashable, T], question: Hashable, work: Callable[[], T]) -> T:
    """Take an answer from this run or the one before; else work it out."""
    if question not in known:
        known[question] = before[question] if question in before else work()
    return known[question]


def _cleared(planned: StrokeSet, spec: PathSpec, site: Site, zones: Floors) -> StrokeSet:
    """Raise strokes over what is in the way; a tilted jet then meets edges elsewhere, so pauses are placed anew."""
    edges = edges_of(spec, site) if isinstance(spec, StepFunction) else None
    raised: list[Stroke] = []
    findings = list(planned.findings)
    for stroke in planned.strokes:
        bare = stroke if edges is None else replace(stroke.pick(np.array([0, -1])), pauses=())
        clear, noticed = raise_over(bare, zones)
        if clear is bare:
            raised.append(stroke)
        else:
            raised.append(clear if edges is None else pause_at_edges(clear, edges))
        findings += noticed
    return replace(planned, strokes=tuple(raised), findings=tuple(findings))
