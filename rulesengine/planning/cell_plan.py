"""Planning for a cell: the program at the pace of its robot.

The robot carries out the program that the recipe's limits allow; where it is slower, its pace along the path becomes a
limit, and the same path is timed anew. The robot's search may choose another configuration for the slower program, so
that is repeated until the robot takes no longer than planned.
"""

from dataclasses import dataclass, replace

from programs.program import TimedProgram
from robotcell.cell.load import LoadedCell, cell_sha256
from robotcell.track import CellReport, terms_of, track
from rulesengine.planning.pipeline import Run
from rulesengine.strokes.workload import require_totals
from rulesengine.timing.limit_intervals import FREE, Pace
from rulesengine.timing.robot_pace import RobotTiming, robot_pace, robot_times, seconds_by_kind
from rulesengine.timing.time_plan import TimedPath, time_path
from specs.finding import Finding, worst_first
from specs.finding_rules import ROBOT_LIMITS
from specs.progress import Progress, no_progress, subprogress

_ROUNDS = 4
"""How often a plan is timed anew at most."""
_ENOUGH = 1.03
"""Times the planned time that the robot may take: each further round may lead to another, slower configuration."""
_DIFFERENT = 1.05
"""Times the planned time from which on a finding warns that the robot takes longer."""


@dataclass(frozen=True, slots=True, eq=False)
class _Carried:
    """A timing of a plan, and what the robot does with it."""

    timed: TimedPath
    report: CellReport

    @property
    def robot_s(self) -> float:
        """Seconds that the robot takes for the program's own motions: from home, and back, and to tools left out."""
        added = self.report.added
        return self.report.program.totals.duration_s - added.from_home - added.tool_changes - added.to_home

    @property
    def ratio(self) -> float:
        return self.robot_s / max(self.timed.program.totals.duration_s, 1e-9)


def plan_for_cell(run: Run, loaded: LoadedCell, progress: Progress = no_progress) -> Run:
    """Time a run anew at the pace of the robot of a cell, which has to hold the run's board.

    Strokes and their order stay. Where the robot cannot carry out the program the times are those of the recipe's
    limits, and a finding of the rule ``robot-limits`` gives the reason. A run that is timed for a robot is timed anew.

    Raises:
        CellError: the cell lacks a tool or a placement that the program names, or ``washboard[robot]`` is missing.
        RecipeError: it takes more than a day or 1,000 litres at this pace.
    """
    free = _carry_out(run, loaded, FREE, subprogress(progress, 0.0, 0.3))
    if not free.report.possible or free.timed.path is None:
        reason = free.report.findings[0].message if free.report.findings else "there is no motion."
        message = (
            f"the robot of {free.report.cell.name} cannot carry out the program, so its limits are not known and the "
            f"times are those of the recipe's limits: {reason}"
        )
        return _with_program(run, free.timed.program, [Finding(ROBOT_LIMITS, message)])
    best, last, pace = free, free, FREE
    for number in range(_ROUNDS):
        if last.ratio <= _ENOUGH:
            break
        pace = pace.within(robot_pace(robot_times(last.timed, free.timed.path, last.report)))
        part = subprogress(progress, 0.3 + 0.7 * number / _ROUNDS, 0.3 + 0.7 * (number + 1) / _ROUNDS)
        slower = _carry_out(run, loaded, pace, part)
        if not slower.report.possible:
            break
        last = slower
        best = min(best, last, key=lambda each: each.ratio)
    progress("timed for the robot", 1.0)
    return _with_timing(run, loaded, free, best)


def obstacle_of(run: Run) -> str:
    """Why the robot cannot carry out a run that was planned for it; empty where it can."""
    if run.robot is not None:
        return run.robot.obstacle
    return next((each.message for each in run.findings if each.rule == ROBOT_LIMITS), "")


def _carry_out(run: Run, loaded: LoadedCell, pace: Pace, progress: Progress) -> _Carried:
    timed = time_path(run.plan, run.recipe.limits, pace)
    terms = replace(terms_of(loaded), remedies=False)
    return _Carried(timed, track(timed.program, loaded.cell, run.workpiece, terms=terms, progress=progress))


def _with_timing(run: Run, loaded: LoadedCell, free: _Carried, last: _Carried) -> Run:
    written = last.timed.program
    origin = replace(written.origin, cell=loaded.cell.name, cell_sha256=cell_sha256(loaded))
    program = replace(written, origin=origin)
    require_totals(program.totals.duration_s, sum(litres for _, litres in program.totals.liquid_l))
    before, after = seconds_by_kind(free.timed), seconds_by_kind(last.timed)
    # Warn where the robot keeps to the times, and cannot be allowed to.
    wrong = [each for each in last.report.findings if each.severity == "error"][:1]
    errors = [
        Finding(
            ROBOT_LIMITS,
            f"the program cannot be carried out in {last.report.cell.name} as it is: {each.message} `washboard check` "
            "reports all.",
            each.made_by,
            each.where,
        )
        for each in wrong
    ]
    timing = RobotTiming(
        cell=loaded.cell.name,
        robot=loaded.cell.robot.name,
        free_s=free.timed.program.totals.duration_s,
        planned_s=program.totals.duration_s,
        robot_s=last.robot_s,
        added_s=last.report.program.totals.duration_s - last.robot_s,
        price_s=tuple((kind, after[kind] - before[kind]) for kind in after),
        obstacle="".join(each.message for each in errors),
    )
    return _with_program(run, program, [_describe(timing), *errors], timing)


def _with_program(run: Run, program: TimedProgram, about: list[Finding], timing: RobotTiming | None = None) -> Run:
    """Give a run another program, with its findings and those about the robot in place of the old ones."""
    own = set(run.program.findings)
    findings = [each for each in run.findings if each not in own and each.rule != ROBOT_LIMITS]
    return replace(run, program=program, findings=worst_first([*findings, *program.findings, *about]), robot=timing)


def _describe(timing: RobotTiming) -> Finding:
    """Report what the robot's limits cost, and where the robot still takes longer."""
    parts = ", ".join(f"{seconds:.1f} s {kind}" for kind, seconds in timing.price_s if seconds >= 0.05)
    message = (
        f"the limits of {timing.robot} in {timing.cell} cost {timing.planned_s - timing.free_s:.1f} s: "
        f"{timing.planned_s:.1f} s, {timing.free_s:.1f} s within those of the recipe alone"
        + (f" ({parts})." if parts else ".")
    )
    if timing.robot_s <= _DIFFERENT * timing.planned_s:
        return Finding(ROBOT_LIMITS, message, override="info")
    message += (
        f" The robot takes {timing.robot_s:.1f} s for it, {timing.robot_s / timing.planned_s:.2f} times as long: "
        "another configuration is chosen for each timing. Place the board elsewhere."
    )
    return Finding(ROBOT_LIMITS, message)
