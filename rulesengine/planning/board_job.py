"""A recipe on a board: classes and masks, strokes by path class, their order; an earlier run lends what still holds."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from importlib import import_module
from typing import assert_never

import numpy as np

from boards.board import Board, Side
from boards.errors import BoardError
from geometry.arrays import Directions, Points
from geometry.coverage.route import Effort
from programs.plan import Command, Plan, PlanItem, Transfer
from recipes.classes import ComponentMasks, match_masks
from recipes.errors import RecipeError
from recipes.paths import PathSpec
from recipes.recipe import Limits, Recipe, Step
from rulesengine.modifiers import avoided_zone, keep_out, pause_at_edges, raise_over
from rulesengine.planning.fit_recipe import fit_recipe
from rulesengine.planning.spray_findings import find_spray_beside, find_unserved
from rulesengine.planning.stroke_order import order_strokes, place_on_panel
from rulesengine.strokes.classify import Classified, classify, read_masks
from rulesengine.strokes.laid import LaidStroke, Notices, Ordered, Pose, Reached
from rulesengine.strokes.safe_height import Floors, floors
from rulesengine.strokes.step_commands import jet_of, transfer_speed
from rulesengine.strokes.stroke import PlanCache, Retract, Site, Stroke, StrokeSet, reference_axes, reference_azimuth
from rulesengine.strokes.workload import Work, measure, require_bounds
from specs.finding import Finding
from specs.finding_rules import LEAD_IN_BLOCKED
from specs.progress import Progress
from specs.source import Source

_SAME = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class BoardWays:
    """Ways over one side of a board. Side frame, mm, as of a ``Stroke``: heights count from the bare surface."""

    board: Board
    limits: Limits
    side: Side
    floors: Floors

    @property
    def parked(self) -> Pose:
        """Above the middle of the board, or at the recipe's place, pointing down, above everything."""
        centre = self.board.outline.centroid
        place = np.array([centre.x, centre.y]) if self.limits.park_mm is None else np.array(self.limits.park_mm)
        height = max(self.limits.park_height_mm, self.floors.highest)
        down = np.array([0.0, 0.0, -1.0])
        reference = reference_axes(down[None], reference_azimuth(self.board, self.limits)[None])[0]
        return Pose(np.append(place, height), down, reference)

    def place(self, tcp: Points, approach: Directions, reference: Directions) -> tuple[Points, Directions, Directions]:
        """Side frame to board frame: the bottom side's heights count downwards."""
        up = np.array([1.0, 1.0, 1.0 if self.side == "top" else -1.0])
        place = tcp * up
        place[:, 2] += self.board.surface_z_mm(self.side)
        return place, approach * up, reference * up

    def park(self, pose: Pose, speed_mm_s: float, made_by: Source) -> tuple[list[PlanItem], Pose]:
        """Go to the parked pose."""
        parked = self.parked
        return self._go(pose, parked, "everything", speed_mm_s, made_by), parked

    def reach(self, pose: Pose, stroke: LaidStroke, speed_mm_s: float) -> Reached:
        """Go to the beginning of a stroke, or to where its run-up begins so that the jet opens at speed."""
        made_by = replace(stroke.made_by, motion="transfer")
        begin = stroke.pose(0)
        heading = stroke.tcp[1] - stroke.tcp[0] if len(stroke.tcp) > 1 else np.zeros(3)
        length = float(np.linalg.norm(heading))
        if stroke.lead_in_mm == 0 or length < _SAME or pose.same_as(begin):
            return Reached(self._go(pose, begin, stroke.retract, speed_mm_s, made_by), stroke)
        back = replace(begin, tcp=begin.tcp - heading / length * stroke.lead_in_mm)
        if self.floors.over(np.array([back.tcp[:2], begin.tcp[:2]])) > min(back.tcp[2], begin.tcp[2]):
            message = f"No room for a run-up of {stroke.lead_in_mm:g} mm: a body stands there. The jet opens from rest."
            x, y, z = begin.tcp
            blocked = Finding(LEAD_IN_BLOCKED, message, stroke.made_by, (x, y, z))
            return Reached(self._go(pose, begin, stroke.retract, speed_mm_s, made_by), stroke, (blocked,))
        run_up = self.transfer([back, begin], float(stroke.speeds_mm_s[0]), made_by)
        return Reached([*self._go(pose, back, stroke.retract, speed_mm_s, made_by), run_up], stroke)

    def turn_over(self, before: "BoardWays", pose: Pose, speed_mm_s: float, made_by: Source) -> Transfer:
        """From a pose above the other side to the parked pose of this one, around the edge."""
        start = before.transfer([pose], speed_mm_s, made_by)
        return around_edge(
            self.board, self.limits, start, self.transfer([self.parked], speed_mm_s, made_by), speed_mm_s, made_by
        )

    def transfer(self, poses: list[Pose], speed_mm_s: float, made_by: Source) -> Transfer:
        """A move through poses, in the board frame."""
        rows = [np.array([getattr(pose, name) for pose in poses]) for name in ("tcp", "approach", "reference")]
        return Transfer(*self.place(*rows), speed_mm_s, made_by)

    def _go(self, start: Pose, end: Pose, retract: Retract, speed_mm_s: float, made_by: Source) -> list[PlanItem]:
        poses = free_way(start, end, self.floors, retract)
        return [self.transfer(poses, speed_mm_s, made_by)] if poses else []


def free_way(start: Pose, end: Pose, floors: Floors, retract: Retract) -> list[Pose]:
    """Poses of a move that keeps clear: straight if it may, else up, across and down; none if it is there already."""
    if start.same_as(end):
        return []
    match retract:
        case "corridor":
            level = floors.over(np.array([start.tcp[:2], end.tcp[:2]]))
        case "everything":
            level = floors.highest
        case _:
            assert_never(retract)
    if np.allclose(start.tcp[:2], end.tcp[:2], rtol=0, atol=_SAME):
        level = 0.0
    poses = [start]
    if level > min(start.tcp[2], end.tcp[2]) + _SAME:
        level = max(level + floors.corner_mm, start.tcp[2], end.tcp[2])
        poses += [
            replace(each, tcp=np.append(each.tcp[:2], level)) for each in (start, end) if level > each.tcp[2] + _SAME
        ]
    return [*poses, end]


def lay(stroke: Stroke, retract: Retract) -> LaidStroke:
    """Give an open stroke its speeds and references; side frame."""
    return LaidStroke(
        tcp=stroke.tcp,
        approach=stroke.approach,
        reference=reference_axes(stroke.approach, stroke.azimuth),
        speeds_mm_s=np.full(len(stroke.tcp) - 1, stroke.speed_mm_s),
        delays=stroke.delays,
        made_by=stroke.made_by,
        pauses=stroke.pauses,
        lead_in_mm=stroke.lead_in_mm,
        retract=retract,
    )


def around_edge(
    board: Board, limits: Limits, start: Transfer, end: Transfer, speed_mm_s: float, made_by: Source
) -> Transfer:
    """Transfer from above one side to above the other past the edge, as turning the board over looks from the board.

    It runs from the end of ``start`` to the beginning of ``end`` and clears all bodies, overhanging ones too.
    """
    along = reference_azimuth(board, limits)
    out = np.array([-along[1], along[0]])
    corners = np.concatenate([body.patches.reshape(-1, 3)[:, :2] for body in board.bodies])
    reach = (
        float((corners @ out).max())
        + limits.clearance_mm
        + limits.blend_mm
        + float(np.ptp([start.tcp[-1, 2], end.tcp[0, 2]])) / 4
    )
    first, last = start.tcp[-1], end.tcp[0]

    def beside(place: Points, height: float) -> Points:
        return np.append(place[:2] + out * (reach - float(place[:2] @ out)), height)

    middle = beside((first + last) / 2, float((first[2] + last[2]) / 2))
    inward = np.append(-out, 0.0)
    flat = np.append(along, 0.0)
    return Transfer(
        tcp=np.array([first, beside(first, first[2]), middle, beside(last, last[2]), last]),
        approach=np.array([start.approach[-1], start.approach[-1], inward, end.approach[0], end.approach[0]]),
        reference=np.tile(flat, (5, 1)),
        speed_mm_s=speed_mm_s,
        made_by=made_by,
    )


@dataclass(frozen=True, slots=True, eq=False)
class BoardJob:
    """Recipe and board with what does not change from step to step."""

    recipe: Recipe
    """Fitted to the board."""
    workpiece: Board
    classified: tuple[Classified, ...]
    classes: dict[str, str]
    """Component name to class name."""
    masks: ComponentMasks
    findings: tuple[Finding, ...]
    """Of classes and masks."""
    cache: PlanCache
    instances: tuple["BoardJob", ...] = ()
    """Of a panel, the job of the board of each instance, in their order; boards that lie alike have one."""
    coverings: tuple[()] = ()

    def ways(self, side: Side) -> BoardWays:
        """Ways over a side, above the least heights of the orifice there."""
        limits = self.recipe.limits
        reach = limits.clearance_mm, limits.blend_mm
        found = self.cache.take(("floors", side, *reach), lambda: floors(self.workpiece, side, *reach))
        return BoardWays(self.workpiece, limits, side, found)

    def start(self, step: Step) -> Pose:
        """The parked pose over the side of a step."""
        return self.ways(step.side).parked

    def turn(self, before: Step, step: Step, pose: Pose, made_by: Source) -> tuple[list[PlanItem], Pose]:
        """Turn the board over between steps on different sides; the nozzle is parked before and after."""
        if before.side == step.side:
            return [], pose
        made_by, ways = replace(made_by, motion="turn"), self.ways(step.side)
        call = Command("CALL", (f"flip_to_{step.side}",), made_by)
        around = ways.turn_over(self.ways(before.side), pose, transfer_speed(self.recipe, step), made_by)
        return [call, around], ways.parked

    def require_bounds(self, again: Mapping[int, int], progress: Progress) -> None:
        """Plan the strokes of all enabled steps; before they are ordered and timed, refuse more than a plan may take.

        Raises:
            RecipeError: it does.
        """
        work: list[Work] = []
        for index, step in enumerate(self.recipe.sequence):
            if not step.enabled:
                continue
            progress(f"planning {step.function}", 0.0)
            for place, name in enumerate(step.paths):
                times = step.repeat + (again.get(index, 0) if place == len(step.paths) - 1 else 0)
                strokes = self.strokes(index, step, name).strokes
                work.append(measure(strokes, jet_of(self.recipe, step), Source(index, name), times))
        require_bounds(work)

    def begin(self, index: int, step: Step, pose: Pose, progress: Progress) -> list[Finding]:
        """Findings on the strokes of a step's templates."""
        return [finding for name in step.paths for finding in self.strokes(index, step, name).findings]

    def order(self, index: int, step: Step, name: str, pose: Pose, effort: Effort, progress: Progress) -> Ordered:
        """Order the strokes of a template from a pose."""
        planned = self.strokes(index, step, name)
        found = order_strokes(planned, pose.tcp, Source(index, name), effort, progress)
        laid = tuple(lay(stroke, planned.retract) for stroke in found.strokes)
        return Ordered(laid, self.ways(step.side), found.findings, found.settled)

    def notice(self, plan: Plan, notices: Notices) -> list[Finding]:
        """What is to be noticed on a whole plan."""
        steps = [step for step in self.recipe.sequence if step.enabled]
        unserved = find_unserved(self.recipe, self.workpiece, self.masks, steps, plan.items)
        return [*unserved, *(find_spray_beside(self.recipe, self.workpiece, plan.items) if notices == "all" else ())]

    def nothing_to_spray(self) -> RecipeError:
        """Error where no step is left, or all templates come out empty."""
        steps, board = [step for step in self.recipe.sequence if step.enabled], self.workpiece
        if not steps:
            return RecipeError(
                f"no step is left for {board.name}: all have only_with_parts and spray the side without components. "
                "Add a step for the other side, or take only_with_parts out.",
                path="sequence",
            )
        counts = {side: sum(component.side == side for component in board.components) for side in ("top", "bottom")}
        listed = ", ".join(f"{name} on the {step.side}" for step in steps for name in step.paths)
        return RecipeError(
            f"there is nothing to spray on {board.name}, which has {counts['top']} components on the top and "
            f"{counts['bottom']} on the bottom: {listed} all come out empty. Add a template that covers the board, "
            "such as a raster, or look at side, repeats, passes, only and masks.",
            path="sequence",
        )

    def serves(self, step: Step) -> bool:
        """Whether a step is for this board: where it has ``only_with_parts``, one with components on its side."""
        sides = {component.side for component in self.workpiece.components}
        return not step.only_with_parts or not sides or step.side in sides

    def strokes(self, index: int, step: Step, name: str) -> StrokeSet:
        """Plan one template in its step, raise it over what is in the way, and cut it where it must not spray.

        Raises:
            RecipeError: it takes more than a plan may.
        """
        made_by, jet, board = Source(index, name), jet_of(self.recipe, step), self.workpiece
        if self.instances:
            bare = StrokeSet((), "fixed")
            sets = [own.strokes(index, step, name) if own.serves(step) else bare for own in self.instances]
            panel = place_on_panel(board.instances, sets, self.ways(step.side).floors)
            require_bounds([measure(panel.strokes, jet, made_by, 1)])
            return panel
        spec, nozzle = self.recipe.templates[name], self.recipe.nozzles[step.nozzle]
        # All that planners and modifiers use besides the board, whose components come in one order.
        texts = (each.model_dump_json() for each in (spec, nozzle, self.recipe.limits))
        key = (step.side, *texts, *self.classes.values(), self.masks)

        def make() -> StrokeSet:
            skipped = self.masks.ignored | dict(self.masks.avoided).keys()
            here = frozenset(component.name for component in board.components if component.side == step.side)
            served = here - skipped
            site = Site(board, step.side, nozzle, self.recipe.limits, self.classes, served, made_by, self.cache)
            planned = self.cache.take(("planned", *key), lambda: plan_path(spec, site))
            require_bounds([measure(planned.strokes, jet, made_by, 1)])
            floors = self.ways(step.side).floors
            raised = self.cache.take(("raised", *key), lambda: pause_at_edges(raise_over(planned, floors), board))
            return keep_out(raised.for_template(made_by), avoided_zone(board, step.side, self.masks), nozzle, made_by)

        return self.cache.take(("strokes", jet, made_by, *key), make)


def open_board_job(recipe: Recipe, board: Board, cache: PlanCache) -> BoardJob:
    """Fit the recipe to the board, classify the components and read the masks.

    The recipe of a panel holds for the board of each instance; the panel's names are theirs with those of the
    instances.

    Raises:
        RecipeError: a component matches no class.
        BoardError: what was read cannot be a board, by one of its findings.
    """
    if (doubt := next((each for each in board.findings if each.severity == "error"), None)) is not None:
        raise BoardError(f"{board.name} is not planned: {doubt.message} ({doubt.rule})")
    fitted = fit_recipe(recipe, board)
    if not board.instances:
        return _single_job(fitted, board, cache)
    alike = {id(each.board): each.board for each in board.instances}
    jobs = {key: _single_job(fitted, own, PlanCache()) for key, own in alike.items()}
    instances = tuple(jobs[id(each.board)] for each in board.instances)
    classified = tuple(
        replace(each, component=own.rename(each.component))
        for own, job in zip(board.instances, instances, strict=True)
        for each in job.classified
    )
    masks, classes = match_masks(fitted.masks, board.own_names), _classes(classified)
    return BoardJob(fitted, board, classified, classes, masks, instances[0].findings, cache, instances=instances)


def _single_job(fitted: Recipe, board: Board, cache: PlanCache) -> BoardJob:
    classified, class_findings = classify(fitted, board)
    masks, mask_findings = read_masks(fitted, board)
    return BoardJob(fitted, board, classified, _classes(classified), masks, (*class_findings, *mask_findings), cache)


def _classes(classified: tuple[Classified, ...]) -> dict[str, str]:
    return {each.component: each.component_class for each in classified}


def plan_path(spec: PathSpec, site: Site) -> StrokeSet:
    """Plan one template: ``path: raster`` is planned by ``plan_raster`` of ``rulesengine/paths/raster.py``."""
    module = import_module(f"rulesengine.paths.{spec.path}")
    planner: Callable[[PathSpec, Site], StrokeSet] = getattr(module, f"plan_{spec.path}")
    return planner(spec, site)
