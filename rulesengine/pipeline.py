"""Recipe and board in; plan and timed program out."""

from dataclasses import dataclass, replace

import numpy as np

from boards.board import Board, Side
from geometry.finding import Finding, worst_first
from geometry.progress import Progress, part_of
from programs.plan import Dwell, Jet, Origin, Plan, SprayPass
from programs.program import TimedProgram
from recipes.check import check_recipe
from recipes.errors import RecipeError
from recipes.load import recipe_sha256
from recipes.nozzles import AirKnife
from recipes.paths import PathSpec, StepFunction
from recipes.recipe import Recipe, Step
from rulesengine.assemble import Assembly
from rulesengine.classify import Classified, Service, classify, service
from rulesengine.clearance import Floors, floors
from rulesengine.modifiers.keep_out import avoided_zone, keep_out
from rulesengine.modifiers.pause_at_edges import edges_of, pause_at_edges
from rulesengine.modifiers.raise_over import raise_over
from rulesengine.order import order_strokes
from rulesengine.plan_path import plan_path
from rulesengine.served import find_unserved
from rulesengine.stroke import Site, Stroke, StrokeSet
from rulesengine.timing import time_plan
from rulesengine.transfers import parked


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """One recipe on one board, all the way to its program: what the command line and the browser show."""

    recipe: Recipe
    board: Board
    classified: tuple[Classified, ...]
    plan: Plan
    program: TimedProgram
    findings: tuple[Finding, ...]
    """Of the board, the recipe, the plan and the timing; worst first."""


@dataclass(frozen=True, slots=True, eq=False)
class _Job:
    """What does not change from step to step."""

    recipe: Recipe
    board: Board
    classes: dict[str, str]
    service: Service
    floors: dict[Side, Floors]


def run(recipe: Recipe, board: Board, progress: Progress | None = None) -> Run:
    """Plan and time a recipe on a board.

    Raises:
        RecipeError: a component matches no class, or nothing is left to do.
    """
    tell = progress or _tell_nobody
    classified, _ = classify(recipe, board)
    plan = make_plan(recipe, board, part_of(tell, 0.0, 0.6))
    tell("timing", 0.6)
    program = time_plan(plan, recipe.limits)
    tell("done", 1.0)
    findings = worst_first((*board.findings, *check_recipe(recipe), *plan.findings, *program.findings))
    return Run(recipe, board, classified, plan, program, findings)


def make_plan(recipe: Recipe, board: Board, progress: Progress | None = None) -> Plan:
    """Turn a recipe into passes, dwells, transfers and commands on a board, in order.

    Raises:
        RecipeError: a component matches no class, or nothing is left to do.
    """
    classified, class_findings = classify(recipe, board)
    masks, mask_findings = service(recipe, board)
    sides: tuple[Side, ...] = ("top", "bottom")
    job = _Job(
        recipe=recipe,
        board=board,
        classes={each.component: each.component_class for each in classified},
        service=masks,
        floors={side: floors(board, side, recipe.limits.clearance_mm, recipe.limits.blend_mm) for side in sides},
    )
    steps = [(index, step) for index, step in enumerate(recipe.sequence) if step.enabled]
    first = steps[0][1]
    assembly = Assembly(
        board,
        recipe.limits,
        first.side,
        job.floors[first.side],
        parked(board, recipe.limits, job.floors[first.side]),
        findings=[*class_findings, *mask_findings],
    )
    tell = progress or _tell_nobody
    for done, (index, step) in enumerate(steps):
        tell(f"planning {step.function}", done / len(steps))
        _do_step(job, assembly, index, step)
    if not any(isinstance(item, SprayPass | Dwell) for item in assembly.items):
        raise RecipeError(_idle(board, steps), path="sequence")
    assembly.findings += find_unserved(recipe, board, masks, [step for _, step in steps], assembly.items)
    origin = Origin(board.name, board.sha256, recipe.recipe, recipe_sha256(recipe))
    return Plan(origin, tuple(assembly.items), tuple(assembly.findings))


def _idle(board: Board, steps: list[tuple[int, Step]]) -> str:
    counts = {side: sum(component.side == side for component in board.components) for side in ("top", "bottom")}
    asked = ", ".join(f"{name} on the {step.side}" for _, step in steps for name in step.paths)
    return (
        f"there is nothing to spray on {board.name}, which has {counts['top']} components on the top and "
        f"{counts['bottom']} on the bottom: {asked} all come out empty. Add a template that covers the board, such as "
        "a raster, or look at side, repeats, passes, only and masks."
    )


def _tell_nobody(_what: str, _done: float) -> None:
    pass


def _do_step(job: _Job, assembly: Assembly, index: int, step: Step) -> None:
    made_by = f"sequence[{index}]"
    function = job.recipe.functions[step.function]
    speed = min(job.recipe.limits.transfer_speed_mm_s, function.max_speed_mm_s)
    _announce(job, assembly, step, made_by)  # first, so that the way around the edge keeps this function's speed
    if step.side != assembly.side:
        assembly.turn_over(step.side, job.floors[step.side], speed, f"{made_by}/turn")
    jet = _jet(job.recipe, step)
    sets = [_strokes(job, step, jet, name, f"{made_by}/{name}") for name in step.paths]
    assembly.findings += [finding for strokes in sets for finding in strokes.findings]
    if step.until is not None:
        limits = step.until.model_dump(exclude_none=True, exclude={"max_repeats"})
        for key, value in limits.items():
            assembly.command("REPEAT", str(step.until.max_repeats), "UNTIL", key, ">=", f"{value:.3f}", made_by=made_by)
    for _ in range(step.repeat):
        for name, strokes in zip(step.paths, sets, strict=True):
            ordered = order_strokes(strokes, assembly.pose.tcp, f"{made_by}/{name}")
            assembly.findings += ordered.findings
            assembly.spray(ordered.strokes, jet, strokes.retract, speed)
    assembly.park(speed, f"{made_by}/park")
    if step.until is not None:
        assembly.command("ENDREPEAT", made_by=made_by)


def _announce(job: _Job, assembly: Assembly, step: Step, made_by: str) -> None:
    function, nozzle = job.recipe.functions[step.function], job.recipe.nozzles[step.nozzle]
    assembly.command("FUNCTION", step.function, made_by=made_by)
    assembly.command("NOZZLE", step.nozzle, "TOOL", str(nozzle.tool), made_by=made_by)
    assembly.command("SOLUTION", function.solution, made_by=made_by)
    assembly.command("SET", "pressure_bar", f"{function.pressure_bar:.3f}", made_by=made_by)
    if function.temperature_c is not None:
        assembly.command("SET", "temperature_c", f"{function.temperature_c:.3f}", made_by=made_by)


def _jet(recipe: Recipe, step: Step) -> Jet:
    function, nozzle = recipe.functions[step.function], recipe.nozzles[step.nozzle]
    kind = function.solution_kind or ("gas" if isinstance(nozzle, AirKnife) else "liquid")
    flow = nozzle.flow_lpm * float(np.sqrt(function.pressure_bar / nozzle.at_bar))
    return Jet(step.function, step.nozzle, function.solution, flow, kind == "liquid")


def _strokes(job: _Job, step: Step, jet: Jet, template: str, made_by: str) -> StrokeSet:
    """Plan one template, raise it over what is in the way, and cut it where it must not spray."""
    served = frozenset(
        component.name
        for component in job.board.components
        if component.side == step.side
        and component.name not in job.service.ignored
        and component.name not in dict(job.service.avoided)
    )
    nozzle = job.recipe.nozzles[step.nozzle]
    site = Site(job.board, step.side, nozzle, job.recipe.limits, jet, job.classes, served, made_by)
    spec = job.recipe.templates[template]
    clear_set = _cleared(plan_path(spec, site), spec, site, job.floors[step.side])
    return keep_out(clear_set, avoided_zone(job.board, step.side, job.service), nozzle, made_by)


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
