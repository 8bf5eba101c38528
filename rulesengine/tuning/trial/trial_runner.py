"""Trials: texts of one recipe planned and analysed on one board, within a budget of analyses."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from cleaning.analyse import analyse_on
from cleaning.prepared_board import PreparedBoard
from cleaning.process.split_stages import stages_of
from recipes.load import parse_recipe
from rulesengine.planning.pipeline import Run, run
from rulesengine.tuning.trial.estimate import Estimate
from rulesengine.tuning.trial.outcome import Figures, Outcome, litres_of, outcome_of, seconds_of, spray_durations
from rulesengine.tuning.trial.record import Infeasible, MemoryStore, TrialStore, decode, encode
from rulesengine.tuning.trial.request import RobotTuning
from rulesengine.tuning.trial.requirements import Goal
from rulesengine.tuning.trial.robot_times import ProgramTimes, RobotRatios, SprayTimes, robot_ratios
from rulesengine.tuning.variables.recipe_edits import Edits, apply_edits
from specs.errors import JobError
from specs.finding import blocking
from specs.progress import Progress, no_progress

if TYPE_CHECKING:
    from robotcell.cell.load import LoadedCell

_MOST_RUNS = 24
"""Plans that are kept."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """A text that can be planned, and what its program takes."""

    text: str
    seconds: float
    litres: float


class TrialRunner:
    """Plans and analyses texts of one recipe on one board; results are kept, and analyses are counted.

    With a cell, which has to hold the board, what is analysed is planned for its robot; candidates are estimated.
    """

    def __init__(
        self,
        file: Path,
        prepared: PreparedBoard,
        goal: Goal,
        max_analyses: int,
        progress: Progress = no_progress,
        *,
        cell: "LoadedCell | None" = None,
    ) -> None:
        self.file = file
        self.cell = cell
        self.prepared = prepared
        self.goal: Goal = goal
        self.max_analyses = max_analyses
        self.used = 0
        self.estimate = Estimate()
        self.best: Figures | None = None
        """Of the best recipe so far."""
        self.trials: list[Outcome] = []
        """All that were analysed, in order."""
        self._store: TrialStore = MemoryStore()
        self._progress = progress
        self._share = 0.0
        self._last: Run | None = None
        self._runs: dict[str, Run | None] = {}
        self._free_times: dict[str, ProgramTimes] = {}
        self._robot_times: dict[str, ProgramTimes] = {}
        self._ratios: RobotRatios | None = None
        self._infeasible: set[str] = set()
        self._outcomes: dict[str, Outcome] = {}
        self._errors: frozenset[str] = frozenset()

    @property
    def left(self) -> int:
        """Analyses that may still be made."""
        return self.max_analyses - self.used

    def keep_in(self, store: TrialStore) -> None:
        """Keep records of trials, and take those that are there in place of analyses; they count all the same.

        Args:
            store: Of tunings with the same board, parameters, goal and cell.
        """
        self._store = store

    def first(self, text: str) -> Outcome:
        """Outcome of the initial recipe; errors that its plan has are accepted in its successors.

        Raises:
            JobError: it cannot be read, planned or analysed, or the robot of the cell cannot carry it out.
        """
        planned = self._plan(text)
        self._runs[text] = planned
        self._errors = frozenset(finding.rule.id for finding in blocking(planned.findings, ()))
        found = self._try(text, planned)
        if isinstance(found, Infeasible):
            raise JobError(
                f"the recipe cannot be tuned for a robot that cannot carry it out: {found.reason} `washboard plan -o "
                "OUT.wash` and `washboard check OUT.wash CELL` report all, with a remedy."
            )
        return found

    def planned(self, text: str) -> Run | None:
        """Run of a text; ``None`` where it is no recipe, sprays nothing, or may not be exported."""
        self._report()
        if text not in self._runs:
            while len(self._runs) >= _MOST_RUNS:
                del self._runs[next(iter(self._runs))]
            try:
                done = self._plan(text)
            except JobError:
                self._runs[text] = None
            else:
                errors = {finding.rule.id for finding in blocking(done.findings, ())}
                self._runs[text] = done if errors <= self._errors else None
        return self._runs[text]

    def candidate(self, text: str, edits: Edits = ()) -> Candidate | None:
        """Plan a text with edits; ``None`` where they cannot be written or change nothing, or it cannot be planned."""
        if edits:
            try:
                changed = apply_edits(text, self.file, edits)
            except JobError:
                return None
            if changed == text:
                return None
            text = changed
        planned = self.planned(text)
        if planned is None or text in self._infeasible:
            return None
        if self.cell is None:
            return Candidate(text, seconds_of(planned), litres_of(planned))
        times = self._times(text)
        return None if times is None else Candidate(text, times.seconds, times.litres)

    def spray_durations(self, text: str) -> Mapping[tuple[str, str], float]:
        """Seconds for which each template of each step sprays, by step and template; empty where it has no plan."""
        times = self._times(text)
        return {} if times is None else times.sprayed

    def outcome(self, text: str) -> Outcome | None:
        """Predicted outcome of a text; ``None`` where there is no plan or motion, or no analysis is left."""
        if text in self._outcomes:
            return self._outcomes[text]
        planned = self.planned(text)
        if planned is None or self.left <= 0 or text in self._infeasible:
            return None
        found = self._try(text, planned)
        return None if isinstance(found, Infeasible) else found

    @property
    def robot(self) -> RobotTuning | None:
        """The robot that is tuned for, and how many candidates it cannot carry out."""
        if self.cell is None:
            return None
        return RobotTuning(self.cell.cell.name, self.cell.cell.robot.name, len(self._infeasible))

    def _try(self, text: str, planned: Run) -> Outcome | Infeasible:
        """Plan a run for the robot of a cell and analyse it, or restore what an earlier tuning found."""
        self._report()
        record = self._store.find(text)
        if record is None:
            found = self._carried_out(planned)
            if isinstance(found, Run):
                times = None if self.cell is None else self._program_times(found)
                report = analyse_on(self.prepared, found.program, found.recipe, "fast", sensitivity=False)
                found = outcome_of(found, report, self.goal, text), times
            self._store.add(text, encode(found))
        else:
            found = decode(record, planned, self.prepared, text)
        if isinstance(found, Infeasible):
            self._infeasible.add(text)
            return found
        return self._count(*found, restored=record is not None)

    def _count(self, outcome: Outcome, robot: ProgramTimes | None, *, restored: bool) -> Outcome:
        """Count a trial, and keep its outcome and what the robot takes for it."""
        if robot is not None:
            self._robot_times[outcome.text] = robot
            free = self._times_within_limits(outcome.text)
            if free is not None:
                self._ratios = robot_ratios(free, robot)
        self.used += 1
        self.estimate.made(restored=restored)
        self.trials.append(outcome)
        self._outcomes[outcome.text] = outcome
        return outcome

    def _carried_out(self, planned: Run) -> Run | Infeasible:
        """Plan a run for the robot of the cell, or give the reason why that cannot carry it out."""
        if self.cell is None:
            return planned
        from rulesengine.planning.cell_plan import obstacle_of, plan_for_cell

        done = plan_for_cell(planned, self.cell)
        reason = obstacle_of(done)
        return Infeasible(reason) if reason else done

    def _times(self, text: str) -> ProgramTimes | None:
        """Give what a program takes, with a cell its robot: estimated where that was not planned for."""
        if text in self._robot_times:
            return self._robot_times[text]
        free = self._times_within_limits(text)
        return free if free is None or self._ratios is None else self._ratios.estimate(free)

    def _times_within_limits(self, text: str) -> ProgramTimes | None:
        """Give what a program takes within the recipe's limits; ``None`` where it has no plan."""
        if text not in self._free_times:
            planned = self.planned(text)
            if planned is None:
                return None
            self._free_times[text] = self._program_times(planned)
        return self._free_times[text]

    def _program_times(self, done: Run) -> ProgramTimes:
        stages = stages_of(done.program, done.recipe, self.prepared.parameters).stages
        sprayed: SprayTimes = dict(pair for stage in stages for pair in spray_durations(stage))
        return ProgramTimes(seconds_of(done), litres_of(done), sprayed)

    def _plan(self, text: str) -> Run:
        recipe = parse_recipe(text, file=self.file)
        self._last = run(recipe, self.prepared.board, before=self._last, notices="errors and warnings")
        return self._last

    def _report(self) -> None:
        """Report the analyses, what is reached, and how long it will still take; the share never falls."""
        self._share = max(self._share, min(1.0, self.estimate.share(self.used, self.left)))
        what = [f"tuning, {self.used} of at most {self.max_analyses} analyses"]
        if self.best is not None:
            what.append(f"{self.best.clean_components} of {self.trials[0].total} clean in {self.best.seconds:.0f} s")
        more = self.estimate.describe(self.left)
        self._progress("; ".join([*what, more] if more else what), self._share)
