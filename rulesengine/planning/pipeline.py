"""Planning pipeline: recipe and workpiece to plan and timed program."""

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, TypeAlias

from boards.board import Board, Part, Workpiece
from geometry.coverage.route import Effort
from programs.plan import Command, Dwell, Jet, Origin, Plan, PlanItem, SprayPass
from programs.program import TimedProgram
from recipes.check import check_recipe
from recipes.errors import RecipeError
from recipes.load import recipe_sha256
from recipes.paths import OverFaces
from recipes.recipe import Recipe, Step
from rulesengine.planning.board_job import BoardJob, open_board_job
from rulesengine.planning.fit_recipe import repeats_for_least_times
from rulesengine.strokes.classify import Classified
from rulesengine.strokes.laid import Notices, Ordered, Pose, Ways, stroke_items
from rulesengine.strokes.step_commands import jet_of, repeat_commands, step_commands, transfer_speed
from rulesengine.strokes.stroke import PlanCache
from rulesengine.strokes.workload import require_totals
from rulesengine.timing.robot_pace import RobotTiming
from rulesengine.timing.time_plan import TimedItems, sprayed_s, time_plan
from specs.finding import Finding, worst_first
from specs.progress import Progress, no_progress, subprogress
from specs.source import Source

if TYPE_CHECKING:
    from rulesengine.surface.part_job import Covering, PartJob
_SKETCH_SHARE = 0.2
"""Of the time for a plan."""
_REST = 0.4
"""Share of the work that is left after a program: most recipes have one or three."""
Job: TypeAlias = "BoardJob | PartJob"
"""A recipe on a workpiece: what differs between a board and a part."""


@dataclass(slots=True)
class Assembly:
    """A plan in the making, with the pose of the nozzle, so that every item starts where the last one ended."""

    pose: Pose
    """In the frame of the ways that it is on."""
    ways: Ways | None = None
    """Of the strokes done last."""
    items: list[PlanItem] = field(default_factory=list[PlanItem])
    findings: list[Finding] = field(default_factory=list[Finding])
    settled: bool = True
    """Whether all orders so far are those that the full effort finds."""

    def extend(self, after: "Assembly") -> None:
        """Add what was assembled from this pose on."""
        self.items += after.items
        self.findings += after.findings
        self.settled = self.settled and after.settled
        self.pose, self.ways = after.pose, after.ways

    def park(self, speed_mm_s: float, made_by: Source) -> None:
        """Take the nozzle to its parked pose, jet off."""
        if self.ways is not None:
            items, self.pose = self.ways.park(self.pose, speed_mm_s, made_by)
            self.items += items

    def spray(self, ordered: Ordered, jet: Jet, transfer_speed_mm_s: float) -> None:
        """Do strokes one after the other."""
        self.ways = ordered.ways
        self.findings += ordered.findings
        self.settled = self.settled and ordered.settled
        for stroke in ordered.strokes:
            reached = ordered.ways.reach(self.pose, stroke, transfer_speed_mm_s)
            self.items += [*reached.items, *stroke_items(ordered.ways, reached.stroke, jet)]
            self.findings += reached.findings
            self.pose = reached.stroke.pose(-1)


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """One recipe on one workpiece, all the way to its program: what the command line and the browser show."""

    recipe: Recipe
    """As it was written."""
    fitted: Recipe
    """As it was planned: with heights for this board, without steps for a side that has no components."""
    workpiece: Workpiece
    plan: Plan
    program: TimedProgram
    findings: tuple[Finding, ...] = ()
    """Of the workpiece, the recipe, the plan and the timing; worst first."""
    classified: tuple[Classified, ...] = ()
    """Classes of the components, in their order."""
    coverings: "tuple[Covering, ...]" = ()
    """What each template of each step does to faces, in the order of the sequence."""
    cache: PlanCache = field(default_factory=PlanCache)
    """What was planned, for the next run."""
    robot: RobotTiming | None = None
    """Set where the program is timed for the robot of a cell."""
    again: Mapping[int, int] = field(default_factory=dict[int, int])
    """How often the last path of a step is done again to reach its least time, by the index of the step."""

    @property
    def board(self) -> Board:
        """The workpiece, for what only boards have.

        Raises:
            BoardError: it is none.
        """
        return self.workpiece.require_board("this")


@dataclass(frozen=True, slots=True)
class Fitted:
    """A recipe as it was written, and with numbers for what it leaves to the planner of films."""

    recipe: Recipe
    fitted: Recipe


def run(
    recipe: Recipe | Fitted,
    workpiece: Workpiece,
    progress: Progress = no_progress,
    sketched: Callable[[Plan], None] | None = None,
    before: Run | None = None,
    notices: Notices = "all",
) -> Run:
    """Plan and time a recipe on a workpiece.

    Args:
        recipe: Recipe to plan.
        workpiece: The board, panel or part to plan it on.
        progress: Receives the stage and the share done.
        sketched: Receives a first plan, before it is timed and without what is found on it as a whole; its strokes are
            not in the shortest order yet if a search is needed.
        before: A run whose strokes are taken where nothing changed that they depend on; the result is the same.
        notices: Whether to look for what is merely worth knowing, which takes half of the time of a small board's plan.

    Raises:
        RecipeError: its path classes are for another kind of workpiece, a component matches no class, nothing is left
            to do, no free way is found, or it takes more than a day or 1,000 litres.
    """
    written = recipe.recipe if isinstance(recipe, Fitted) else recipe
    work = _open_work(recipe, workpiece, before)
    job, limits = work.job, work.job.recipe.limits
    plans: dict[tuple[tuple[int, int], ...], Plan] = {}
    motions: TimedItems = {}

    def planned(again: Mapping[int, int]) -> Plan:
        key = tuple(again.items())
        if key not in plans:
            # Each further plan finds its strokes planned and ordered.
            part = subprogress(progress, *(1.0 - _REST**done for done in (len(plans), len(plans) + 1)))
            plans[key] = _plan(work, again, part, sketched if not plans else None)
            part("timing", 1.0)
        return plans[key]

    again, missed = repeats_for_least_times(job.recipe, lambda again: sprayed_s(planned(again), limits, motions))
    program = time_plan(planned(again), limits, motions)
    require_totals(program.totals.duration_s, sum(litres for _, litres in program.totals.liquid_l))
    plan = planned(again)
    plan = replace(plan, findings=(*plan.findings, *job.notice(plan, notices)))
    progress("done", 1.0)
    return Run(
        written,
        job.recipe,
        workpiece,
        plan,
        program,
        worst_first((*workpiece.findings, *check_recipe(written), *plan.findings, *missed, *program.findings)),
        job.classified,
        job.coverings,
        job.cache,
        again=again,
    )


def make_plan(recipe: Recipe, workpiece: Workpiece, progress: Progress = no_progress) -> Plan:
    """Plan a recipe on a workpiece: passes, dwells, transfers and commands, in order; least times are left aside.

    Raises:
        RecipeError: as ``run`` does.
    """
    work = _open_work(recipe, workpiece)
    plan = _plan(work, {}, progress, None)
    return replace(plan, findings=(*plan.findings, *work.job.notice(plan, "all")))


def open_job(recipe: Recipe, workpiece: Workpiece, before: Run | None = None) -> Job:
    """Fit a recipe to a workpiece.

    Raises:
        RecipeError: its path classes are for another kind of workpiece, or a component matches no class.
    """
    require_fit(recipe, workpiece)
    cache = PlanCache(before=before.cache.kept() if before is not None and before.workpiece is workpiece else None)
    if isinstance(workpiece, Part):
        from rulesengine.surface.part_job import PartJob  # late: boards need none of its libraries

        return PartJob(recipe, workpiece, cache)
    return open_board_job(recipe, workpiece.require_board("this"), cache)


def require_fit(recipe: Recipe, workpiece: Workpiece) -> None:
    """Refuse a recipe whose path classes do not fit a workpiece: over faces on a board, over boards on a part.

    Raises:
        RecipeError: one does not.
    """
    over_faces = bool(workpiece.faces)
    for index, step in enumerate(recipe.sequence):
        for name in step.paths if step.enabled else ():
            spec = recipe.templates[name]
            if isinstance(spec, OverFaces) == over_faces:
                continue
            if over_faces:
                message = (
                    f"{name} (path: {spec.path}) is a path over boards, and {workpiece.name} is a part. Open a recipe "
                    "for parts, such as part-degrease"
                )
            else:
                message = (
                    f"{name} (path: {spec.path}) goes over the faces of a part, and {workpiece.name} is a board. Open "
                    "a recipe for boards, such as smt-aqueous, or name a part: a part file, or a mesh"
                )
            raise RecipeError(message, path=f"sequence[{index}].paths")


@dataclass(frozen=True, slots=True, eq=False)
class _Work:
    """A job, and what was assembled of it."""

    job: Job
    origin: Origin
    done: dict[Hashable, Assembly] = field(default_factory=dict[Hashable, Assembly])
    """Templates in order, by the step and by where the nozzle stands before them."""


def _open_work(recipe: Recipe | Fitted, workpiece: Workpiece, before: Run | None = None) -> _Work:
    written, fitted = (recipe.recipe, recipe.fitted) if isinstance(recipe, Fitted) else (recipe, recipe)
    origin = Origin(workpiece.name, workpiece.sha256, written.recipe, recipe_sha256(written))
    return _Work(open_job(fitted, workpiece, before), origin)


def _plan(work: _Work, again: Mapping[int, int], progress: Progress, sketched: Callable[[Plan], None] | None) -> Plan:
    """Plan all steps, the last path of some of them again so many times; findings on the whole plan are left aside."""
    work.job.require_bounds(again, progress)
    if sketched is None:
        return _assemble(work, again, "full", progress)[0]
    sketch, settled = _assemble(work, again, "sketch", subprogress(progress, 0.0, _SKETCH_SHARE))
    sketched(sketch)
    if settled:
        return sketch
    return _assemble(work, again, "full", subprogress(progress, _SKETCH_SHARE, 1.0))[0]


def _assemble(work: _Work, again: Mapping[int, int], effort: Effort, progress: Progress) -> tuple[Plan, bool]:
    """A plan, and whether the full effort would give the same."""
    job = work.job
    steps = [(index, step) for index, step in enumerate(job.recipe.sequence) if step.enabled]
    if not steps:
        raise job.nothing_to_spray()
    assembly = Assembly(job.start(steps[0][1]), findings=[*job.findings])
    before = steps[0][1]
    for done, (index, step) in enumerate(steps):
        part = subprogress(progress, done / len(steps), (done + 1) / len(steps))
        part(f"planning {step.function}", 0.0)
        names = [*step.paths * step.repeat, *[step.paths[-1]] * again.get(index, 0)]
        _do_step(work, assembly, before, (index, step, names), effort, part)
        before = step
    if not any(isinstance(item, SprayPass | Dwell) for item in assembly.items):
        raise job.nothing_to_spray()
    return Plan(work.origin, tuple(assembly.items), tuple(assembly.findings)), assembly.settled


def _do_step(
    work: _Work, assembly: Assembly, before: Step, todo: tuple[int, Step, list[str]], effort: Effort, progress: Progress
) -> None:
    """Add a step, given by its index, itself and the templates to follow in their order."""
    (index, step, names), job = todo, work.job
    made_by = Source(index)
    # First, so that the way around the edge keeps this function's speed.
    assembly.items += step_commands(job.recipe, step, made_by)
    turned, assembly.pose = job.turn(before, step, assembly.pose, made_by)
    assembly.items += turned
    assembly.findings += job.begin(index, step, assembly.pose, progress)
    assembly.items += repeat_commands(step, made_by)
    jet, speed = jet_of(job.recipe, step), transfer_speed(job.recipe, step)
    for done, name in enumerate(names):
        part = subprogress(progress, done / len(names), (done + 1) / len(names))
        pose = assembly.pose
        # From the second repeat on each begins where it began before.
        begun = (index, name, *(each.tobytes() for each in (pose.tcp, pose.approach, pose.reference)), effort)
        if begun not in work.done:
            work.done[begun] = Assembly(pose)
            work.done[begun].spray(job.order(index, step, name, pose, effort, part), jet, speed)
        assembly.extend(work.done[begun])
    assembly.park(speed, Source(index, motion="park"))
    if step.until is not None:
        assembly.items.append(Command("ENDREPEAT", (), made_by))
