"""Planning pipeline: recipe and board to plan and timed program."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias

from boards.board import Board
from geometry.coverage.route import Effort
from programs.plan import Dwell, Origin, Plan, SprayPass
from programs.program import TimedProgram
from recipes.check import check_recipe
from recipes.errors import RecipeError
from recipes.recipe import Recipe, Step
from rulesengine.planning.assemble import Assembly
from rulesengine.planning.fit_recipe import repeats_for_least_times
from rulesengine.planning.landed_spray import find_spray_beside
from rulesengine.planning.step_commands import jet_of, repeat_commands, step_commands
from rulesengine.planning.stroke_cache import PlanningJob, StrokeCache, new_job
from rulesengine.planning.stroke_order import order_strokes
from rulesengine.planning.transfers import parked
from rulesengine.planning.unserved import find_unserved
from rulesengine.strokes.classify import Classified
from rulesengine.strokes.workload import Work, measure, require_bounds, require_totals
from rulesengine.timing.robot_pace import RobotTiming
from rulesengine.timing.time_plan import TimedItems, sprayed_s, time_plan
from specs.finding import Finding, worst_first
from specs.progress import Progress, no_progress, subprogress
from specs.source import Source

Notices: TypeAlias = Literal["all", "errors and warnings"]
"""Findings on a plan: all of them, or without those of severity info that take long to find."""
_SKETCH_SHARE = 0.2
"""Of the time for a plan."""
_REST = 0.4
"""Share of the work that is left after a program: most recipes have one or three."""


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """One recipe on one board, all the way to its program: what the command line and the browser show."""

    recipe: Recipe
    """As it was written."""
    fitted: Recipe
    """As it was planned: with heights for this board, without steps for a side that has no components."""
    board: Board
    classified: tuple[Classified, ...]
    plan: Plan
    program: TimedProgram
    findings: tuple[Finding, ...]
    """Of the board, the recipe, the plan and the timing; worst first."""
    cache: StrokeCache = field(default_factory=StrokeCache)
    """Floors and strokes for the next run."""
    robot: RobotTiming | None = None
    """Set where the program is timed for the robot of a cell."""
    again: Mapping[int, int] = field(default_factory=dict[int, int])
    """How often the last path of a step is done again to reach its least time, by the index of the step."""

    @property
    def workpiece(self) -> Board:
        """What the program is for, by the name that runs over boards and parts share."""
        return self.board


def run(
    recipe: Recipe,
    board: Board,
    progress: Progress = no_progress,
    sketched: Callable[[Plan], None] | None = None,
    before: Run | None = None,
    notices: Notices = "all",
) -> Run:
    """Plan and time a recipe on a board.

    Args:
        recipe: Recipe to plan.
        board: Board to plan it on.
        progress: Receives the stage and the share done.
        sketched: Receives a first plan, before it is timed and without what is found on it as a whole; its strokes are
            not in the shortest order yet if a search is needed.
        before: A run whose strokes are taken where nothing changed that they depend on; the result is the same.
        notices: Whether to look for what is merely worth knowing, which takes half of the time of a small board's plan.

    Raises:
        RecipeError: a component matches no class, nothing is left to do, or it takes more than a day or 1,000 litres.
    """
    job = new_job(recipe, board, before.cache if before is not None and before.board is board else StrokeCache())
    plans: dict[tuple[tuple[int, int], ...], Plan] = {}
    motions: TimedItems = {}

    def planned(again: Mapping[int, int]) -> Plan:
        key = tuple(again.items())
        if key not in plans:
            # Each further plan finds its strokes planned and ordered.
            part = subprogress(progress, *(1.0 - _REST**done for done in (len(plans), len(plans) + 1)))
            plans[key] = _plan(job, again, part, sketched if not plans else None)
            part("timing", 1.0)
        return plans[key]

    limits = job.recipe.limits
    again, missed = repeats_for_least_times(job.recipe, lambda again: sprayed_s(planned(again), limits, motions))
    program = time_plan(planned(again), limits, motions)
    require_totals(program.totals.duration_s, sum(litres for _, litres in program.totals.liquid_l))
    plan = _with_findings(job, planned(again), notices)
    progress("done", 1.0)
    findings = worst_first((*board.findings, *check_recipe(recipe), *plan.findings, *missed, *program.findings))
    return Run(recipe, job.recipe, board, job.classified, plan, program, findings, job.cache, again=again)


def make_plan(recipe: Recipe, board: Board, progress: Progress = no_progress) -> Plan:
    """Plan a recipe on a board: passes, dwells, transfers and commands, in order; least times are left aside.

    Raises:
        RecipeError: a component matches no class, nothing is left to do, or it takes more than a day or 1,000 litres.
    """
    job = new_job(recipe, board, StrokeCache())
    return _with_findings(job, _plan(job, {}, progress, None))


def _with_findings(job: PlanningJob, plan: Plan, notices: Notices = "all") -> Plan:
    """Add what is to be noticed on a whole plan."""
    steps = [step for step in job.recipe.sequence if step.enabled]
    unserved = find_unserved(job.recipe, job.board, job.masks, steps, plan.items)
    beside = find_spray_beside(job.recipe, job.board, plan.items) if notices == "all" else []
    return replace(plan, findings=(*plan.findings, *unserved, *beside))


def _plan(
    job: PlanningJob, again: Mapping[int, int], progress: Progress, sketched: Callable[[Plan], None] | None
) -> Plan:
    """Plan all steps, the last path of some of them again so many times; findings on the whole plan are left aside."""
    _require_bounds(job, again, progress)
    if sketched is None:
        return _assemble(job, again, "full", progress)[0]
    sketch, settled = _assemble(job, again, "sketch", subprogress(progress, 0.0, _SKETCH_SHARE))
    sketched(sketch)
    if settled:
        return sketch
    return _assemble(job, again, "full", subprogress(progress, _SKETCH_SHARE, 1.0))[0]


def _assemble(job: PlanningJob, again: Mapping[int, int], effort: Effort, progress: Progress) -> tuple[Plan, bool]:
    """A plan, and whether the full effort would give the same."""
    recipe, board = job.recipe, job.board
    steps = [(index, step) for index, step in enumerate(recipe.sequence) if step.enabled]
    if not steps:
        raise RecipeError(
            f"no step is left for {board.name}: all have only_with_parts and spray the side without components. Add a "
            "step for the other side, or take only_with_parts out.",
            path="sequence",
        )
    first = steps[0][1].side
    floors = job.floors(first)
    assembly = Assembly(
        board, recipe.limits, first, floors, parked(board, recipe.limits, floors), findings=list(job.findings)
    )
    for done, (index, step) in enumerate(steps):
        part = subprogress(progress, done / len(steps), (done + 1) / len(steps))
        part(f"planning {step.function}", 0.0)
        paths = [*step.paths * step.repeat, *[step.paths[-1]] * again.get(index, 0)]
        _do_step(job, assembly, (index, step, paths), effort, part)
    if not any(isinstance(item, SprayPass | Dwell) for item in assembly.items):
        counts = {side: sum(component.side == side for component in board.components) for side in ("top", "bottom")}
        listed = ", ".join(f"{name} on the {step.side}" for _, step in steps for name in step.paths)
        raise RecipeError(
            f"there is nothing to spray on {board.name}, which has {counts['top']} components on the top and "
            f"{counts['bottom']} on the bottom: {listed} all come out empty. Add a template that covers the board, "
            "such as a raster, or look at side, repeats, passes, only and masks.",
            path="sequence",
        )
    origin = Origin(board.name, board.sha256, recipe.recipe, job.recipe_sha256)
    return Plan(origin, tuple(assembly.items), tuple(assembly.findings)), assembly.settled


def _require_bounds(job: PlanningJob, again: Mapping[int, int], progress: Progress) -> None:
    """Plan the strokes of all enabled steps; before they are ordered and timed, refuse what takes more than a plan may.

    Raises:
        RecipeError: it does.
    """
    work: list[Work] = []
    for index, step in enumerate(job.recipe.sequence):
        if not step.enabled:
            continue
        progress(f"planning {step.function}", 0.0)
        jet = jet_of(job.recipe, step)
        for place, name in enumerate(step.paths):
            made_by = Source(index, name)
            times = step.repeat + (again.get(index, 0) if place == len(step.paths) - 1 else 0)
            work.append(measure(job.strokes(step, jet, name, made_by).strokes, jet, made_by, times))
    require_bounds(work)


def _do_step(
    job: PlanningJob, assembly: Assembly, todo: tuple[int, Step, list[str]], effort: Effort, progress: Progress
) -> None:
    """Add a step, given by its index, itself and the templates to follow in their order."""
    index, step, names = todo
    made_by = Source(index)
    function = job.recipe.functions[step.function]
    speed = min(job.recipe.limits.transfer_speed_mm_s, function.max_speed_mm_s)
    # First, so that the way around the edge keeps this function's speed.
    assembly.items += step_commands(job.recipe, step, made_by)
    jet = jet_of(job.recipe, step)
    if step.side != assembly.side:
        assembly.turn_over(step.side, job.floors(step.side), speed, Source(index, motion="turn"))
    sets = {name: job.strokes(step, jet, name, Source(index, name)) for name in step.paths}
    assembly.findings += [finding for name in step.paths for finding in sets[name].findings]
    assembly.items += repeat_commands(step, made_by)
    for done, name in enumerate(names):
        part = subprogress(progress, done / len(names), (done + 1) / len(names))
        # From the second repeat on each begins where it began before.
        pose = assembly.pose
        begun = (index, name, pose.tcp.tobytes(), pose.approach.tobytes(), pose.azimuth.tobytes(), effort)
        if begun not in job.done:
            ordered = order_strokes(sets[name], pose.tcp, Source(index, name), effort, part)
            own = replace(assembly, items=[], findings=list(ordered.findings), settled=ordered.settled)
            own.spray(ordered.strokes, jet, sets[name].retract, speed)
            job.done[begun] = own
        assembly.extend(job.done[begun])
    assembly.park(speed, Source(index, motion="park"))
    if step.until is not None:
        assembly.command("ENDREPEAT", made_by=made_by)
