"""Trials: texts of one recipe planned and analysed on one board, within a budget of analyses."""

import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from math import ceil, log
from pathlib import Path
from typing import TYPE_CHECKING

from cleaning.analyse import analyse_on
from cleaning.prepared_board import PreparedBoard
from cleaning.process.stages import stages_of
from recipes.load import parse_recipe
from rulesengine.planning.pipeline import Run, run
from rulesengine.tuning.trial.outcome import (
    Figures,
    Outcome,
    ProgramTimes,
    RobotRatios,
    SprayTimes,
    litres_of,
    outcome_of,
    robot_ratios,
    seconds_of,
    spray_durations,
)
from rulesengine.tuning.trial.record import Infeasible, MemoryStore, TrialStore, decode, encode
from rulesengine.tuning.trial.request import RobotTuning
from rulesengine.tuning.trial.requirements import Goal
from rulesengine.tuning.variables import Edits, apply_edits
from specs.errors import JobError
from specs.finding import blocking
from specs.progress import Progress, no_progress

if TYPE_CHECKING:
    from robotcell.cell.load import LoadedCell

_MOST_RUNS = 24
"""Plans that are kept."""
_TYPICAL_SHORTENING = 8
"""Analyses that shortening took on the sample boards, most of them."""
_LEAST_RATE = 0.1
"""Of the logarithm of the shortfall by an analysis."""
_BASE = 0.1
"""Shortfall of one requirement that is nearly met."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """A text that can be planned, and what its program takes."""

    text: str
    seconds: float
    litres: float


class Estimate:
    """How many analyses are expected, and how long one takes with the plans before it; shown, it decides nothing."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Begin.

        Args:
            clock: Gives seconds.
        """
        self._clock, self._mark = clock, clock()
        self._spent, self._made = 0.0, 0
        self.expected: int | None = None
        """Analyses that are still to be made, as far as it can be known."""

    def made(self, *, restored: bool) -> None:
        """Count one analysis; one that was only read again takes no time."""
        now = self._clock()
        if not restored:
            self._spent += now - self._mark
            self._made += 1
        self._mark = now

    def improving(self, shortfalls: tuple[float, float], used: int, left: int) -> None:
        """Expect the shortfall to fall on as it did, and the recipe to be shortened then.

        Args:
            shortfalls: The first one, and that of now.
            used: Analyses so far.
            left: Analyses that the stage may still make.
        """
        first, now = shortfalls
        rate = max(log(max(first, _BASE) / max(now, _BASE)) / max(used, 1), _LEAST_RATE)
        self.expected = min(left, ceil(log(max(now, _BASE) / _BASE) / rate)) + _TYPICAL_SHORTENING

    def shortening(self, done: int) -> None:
        """Expect what is left of a shortening that has made so many analyses."""
        self.expected = max(1, _TYPICAL_SHORTENING - done)

    def describe(self, left: int) -> str:
        """Name the analyses and the time that are still expected, such as ``"about 7 more, 1:10"``; empty at first."""
        if self.expected is None or not left:
            return ""
        more = min(self.expected, left)
        if not self._made:
            return f"about {more} more"
        seconds = round(more * self._spent / self._made)
        return f"about {more} more, {seconds // 60}:{seconds % 60:02d}"

    def share(self, used: int, left: int) -> float:
        """Share of the tuning that is done, as far as it can be known."""
        more = left if self.expected is None else min(self.expected, left)
        return used / max(used + more, 1)


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
            self._runs[text] = None
            with suppress(JobError):
                done = self._plan(text)
                if self._errors >= {finding.rule.id for finding in blocking(done.findings, ())}:
                    self._runs[text] = done
        return self._runs[text]

    def candidate(self, text: str, edits: Edits = ()) -> Candidate | None:
        """Plan a text with edits; ``None`` where they cannot be written or change nothing, or it cannot be planned."""
        before = text
        try:
            text = apply_edits(text, self.file, edits)
        except JobError:
            return None
        if edits and text == before:
            return None
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
        """Count a trial: analyse a run, or restore what an earlier tuning found of it."""
        self._report()
        record = self._store.find(text)
        if record is None:
            found = self._analyse(text, planned)
            self._store.add(text, encode(found))
        else:
            found = decode(record, planned, self.prepared, text)
        if isinstance(found, Infeasible):
            self._infeasible.add(text)
            return found
        outcome, robot = found
        free = None if robot is None else self._times_within_limits(text)
        if robot is not None and free is not None:
            self._robot_times[text], self._ratios = robot, robot_ratios(free, robot)
        self.used += 1
        self.estimate.made(restored=record is not None)
        self.trials.append(outcome)
        self._outcomes[text] = outcome
        return outcome

    def _analyse(self, text: str, planned: Run) -> Infeasible | tuple[Outcome, ProgramTimes | None]:
        """Plan a run for the robot of a cell, which also gives what that takes, and analyse it."""
        done = planned
        if self.cell is not None:
            from rulesengine.planning.cell_plan import obstacle_of, plan_for_cell

            done = plan_for_cell(planned, self.cell)
            if reason := obstacle_of(done):
                return Infeasible(reason)
        report = analyse_on(self.prepared, done.program, done.recipe, "fast", sensitivity=False)
        times = None if self.cell is None else self._program_times(done)
        return outcome_of(done, report, self.goal, text), times

    def _times(self, text: str) -> ProgramTimes | None:
        """Give what a program takes, with a cell its robot: estimated where that was not planned for."""
        if text in self._robot_times:
            return self._robot_times[text]
        free = self._times_within_limits(text)
        return free if free is None or self._ratios is None else self._ratios.estimate(free)

    def _times_within_limits(self, text: str) -> ProgramTimes | None:
        """Give what a program takes within the recipe's limits; ``None`` where it has no plan."""
        planned = None if text in self._free_times else self.planned(text)
        if planned is not None:
            self._free_times[text] = self._program_times(planned)
        return self._free_times.get(text)

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
