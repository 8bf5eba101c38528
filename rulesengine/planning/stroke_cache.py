"""Strokes of the templates of a run, planned by path class; those of an earlier run are taken where nothing changed."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import TypeVar

from boards.board import Board, Side
from programs.plan import Jet
from recipes.errors import RecipeError
from recipes.load import recipe_sha256
from recipes.masks import ComponentMasks, match_masks
from recipes.paths import OverFaces, PathSpec
from recipes.recipe import Recipe, Step
from rulesengine.modifiers.keep_out import avoided_zone, keep_out
from rulesengine.modifiers.pause_at_edges import pause_at_edges
from rulesengine.modifiers.raise_over import raise_over
from rulesengine.planning.assemble import Assembly
from rulesengine.planning.fit_recipe import fit_recipe
from rulesengine.planning.panel_strokes import place_on_panel
from rulesengine.strokes.classify import Classified, classify, read_masks
from rulesengine.strokes.safe_height import Floors, floors
from rulesengine.strokes.stroke import Site, StrokeSet
from rulesengine.strokes.workload import measure, require_bounds
from specs.finding import Finding
from specs.source import Source

T = TypeVar("T", Floors, StrokeSet)


@dataclass(frozen=True, slots=True, eq=False)
class StrokeCache:
    """Floors and strokes of a run, by all that they depend on besides the board."""

    floors: dict[Hashable, Floors] = field(default_factory=dict[Hashable, Floors])
    strokes: dict[Hashable, StrokeSet] = field(default_factory=dict[Hashable, StrokeSet])


@dataclass(frozen=True, slots=True, eq=False)
class PlanningJob:
    """Recipe and board with what does not change from step to step."""

    recipe: Recipe
    """Fitted to the board."""
    recipe_sha256: str
    """Of the recipe as it was written."""
    board: Board
    classified: tuple[Classified, ...]
    classes: dict[str, str]
    """Component name to class name."""
    masks: ComponentMasks
    findings: tuple[Finding, ...]
    """Of classes and masks."""
    before: StrokeCache
    """Of an earlier run on the same board."""
    cache: StrokeCache = field(default_factory=StrokeCache)
    """Of this run."""
    done: dict[Hashable, Assembly] = field(default_factory=dict[Hashable, Assembly])
    """Templates in order, by the step and by where the nozzle stands before them."""
    faces: tuple["PlanningJob", ...] = ()
    """Of a panel, the job of the board of each instance, in their order; boards that lie alike have one."""

    def floors(self, side: Side) -> Floors:
        """Least heights of the orifice over a side."""
        limits = self.recipe.limits
        reach = limits.clearance_mm, limits.blend_mm
        return _cached(self.cache.floors, self.before.floors, (side, *reach), lambda: floors(self.board, side, *reach))

    def serves(self, step: Step) -> bool:
        """Whether a step is for this board: where it has ``only_with_parts``, one with components on its side."""
        sides = {component.side for component in self.board.components}
        return not step.only_with_parts or not sides or step.side in sides

    def strokes(self, step: Step, jet: Jet, template: str, made_by: Source) -> StrokeSet:
        """Plan one template in its step, raise it over what is in the way, and cut it where it must not spray.

        Raises:
            RecipeError: it takes more than a plan may.
        """
        if self.faces:
            bare = StrokeSet((), "fixed")
            sets = [face.strokes(step, jet, template, made_by) if face.serves(step) else bare for face in self.faces]
            panel = place_on_panel(self.board.instances, sets, self.floors(step.side))
            require_bounds([measure(panel.strokes, jet, made_by, 1)])
            return panel
        spec, nozzle = self.recipe.templates[template], self.recipe.nozzles[step.nozzle]
        # All that planners and modifiers use besides the board, whose components come in one order.
        texts = (each.model_dump_json() for each in (spec, nozzle, self.recipe.limits))
        key = (step.side, jet, made_by, *texts, *self.classes.values(), self.masks)

        def make() -> StrokeSet:
            skipped = self.masks.ignored | dict(self.masks.avoided).keys()
            here = frozenset(component.name for component in self.board.components if component.side == step.side)
            site = Site(self.board, step.side, nozzle, self.recipe.limits, jet, self.classes, here - skipped, made_by)
            planned = plan_path(spec, site)
            require_bounds([measure(planned.strokes, jet, made_by, 1)])
            paused = pause_at_edges(raise_over(planned, self.floors(step.side)), self.board)
            return keep_out(paused, avoided_zone(self.board, step.side, self.masks), nozzle, made_by)

        return _cached(self.cache.strokes, self.before.strokes, key, make)


def new_job(recipe: Recipe, board: Board, before: StrokeCache) -> PlanningJob:
    """Fit the recipe to the board, classify the components and read the masks.

    Raises:
        RecipeError: a component matches no class, or a step follows the faces of parts.
    """
    _refuse_surfaces(recipe, board)
    fitted = fit_recipe(recipe, board)
    if board.instances:
        return _panel_job(recipe, fitted, board, before)
    return _single_job(recipe, fitted, board, before)


def _single_job(recipe: Recipe, fitted: Recipe, board: Board, before: StrokeCache) -> PlanningJob:
    classified, class_findings = classify(fitted, board)
    masks, mask_findings = read_masks(fitted, board)
    classes = {each.component: each.component_class for each in classified}
    findings = (*class_findings, *mask_findings)
    return PlanningJob(fitted, recipe_sha256(recipe), board, classified, classes, masks, findings, before)


def _panel_job(recipe: Recipe, fitted: Recipe, panel: Board, before: StrokeCache) -> PlanningJob:
    """Let the recipe hold for the board of each instance; the panel's names are theirs with those of the instances."""
    alike = {id(each.board): each.board for each in panel.instances}
    jobs = {key: _single_job(recipe, fitted, board, StrokeCache()) for key, board in alike.items()}
    faces = tuple(jobs[id(each.board)] for each in panel.instances)
    pairs = list(zip(panel.instances, faces, strict=True))
    classified = tuple(
        replace(each, component=own.rename(each.component)) for own, job in pairs for each in job.classified
    )
    masks = match_masks(fitted.masks, panel.own_names)
    classes = {each.component: each.component_class for each in classified}
    findings = faces[0].findings
    digest = recipe_sha256(recipe)
    return PlanningJob(fitted, digest, panel, classified, classes, masks, findings, before, faces=faces)


def _refuse_surfaces(recipe: Recipe, board: Board) -> None:
    """Refuse steps over the faces of a part.

    Raises:
        RecipeError: there is one.
    """
    for index, step in enumerate(recipe.sequence):
        for name in step.paths:
            spec = recipe.templates[name]
            if step.enabled and isinstance(spec, OverFaces):
                message = (
                    f"{name} goes over the faces of a part (path: {spec.path}); {board.name} is planned as a board. "
                    "Name a part: a part file, or a mesh"
                )
                raise RecipeError(message, path=f"sequence[{index}].paths")


def plan_path(spec: PathSpec, site: Site) -> StrokeSet:
    """Plan one template: ``path: raster`` is planned by ``plan_raster`` of ``rulesengine/paths/raster.py``."""
    module = import_module(f"rulesengine.paths.{spec.path}")
    planner: Callable[[PathSpec, Site], StrokeSet] = getattr(module, f"plan_{spec.path}")
    return planner(spec, site)


def _cached(known: dict[Hashable, T], before: dict[Hashable, T], key: Hashable, make: Callable[[], T]) -> T:
    if key not in known:
        known[key] = before[key] if key in before else make()
    return known[key]
