"""Trials: texts of one recipe planned and analysed on one board, within a budget of analyses."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from cleaning.analyse import analyse_on
from cleaning.prepared_board import PreparedBoard
from cleaning.process.split_stages import stages_of
from recipes.load import parse_recipe
from rulesengine.planning.pipeline import Run, run
from rulesengine.tuning.trial.outcome import Outcome, litres_of, outcome_of, seconds_of, spray_durations
from rulesengine.tuning.trial.request import TuningRequest
from rulesengine.tuning.trial.requirements import Goal
from rulesengine.tuning.variables.recipe_edits import Edits, apply_edits
from specs.errors import JobError
from specs.finding import blocking
from specs.progress import Progress, no_progress
from specs.yaml.located import YamlPath

_MOST_RUNS = 24
"""Plans that are kept."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """A text that can be planned, and what its program takes."""

    text: str
    seconds: float
    litres: float


class TrialRunner:
    """Plans and analyses texts of one recipe on one board; results are kept, and analyses are counted."""

    def __init__(
        self, file: Path, prepared: PreparedBoard, goal: Goal, max_analyses: int, progress: Progress = no_progress
    ) -> None:
        self.file = file
        self.prepared = prepared
        self.goal: Goal = goal
        self.max_analyses = max_analyses
        self.used = 0
        self._progress = progress
        self._last: Run | None = None
        self._runs: dict[str, Run | None] = {}
        self._durations: dict[str, dict[tuple[str, str], float]] = {}
        self._outcomes: dict[str, Outcome] = {}
        self._errors: frozenset[str] = frozenset()

    @property
    def left(self) -> int:
        """Analyses that may still be made."""
        return self.max_analyses - self.used

    def first(self, text: str) -> Outcome:
        """Outcome of the initial recipe; errors that its plan has are accepted in its successors.

        Raises:
            JobError: it cannot be read, planned or analysed.
        """
        planned = self._plan(text)
        self._runs[text] = planned
        self._errors = frozenset(finding.rule.id for finding in blocking(planned.findings, ()))
        return self._analyse(text, planned)

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
        return None if planned is None else Candidate(text, seconds_of(planned), litres_of(planned))

    def spray_durations(self, text: str) -> Mapping[tuple[str, str], float]:
        """Seconds for which each template of each step sprays, by step and template; empty where it has no plan."""
        if text not in self._durations:
            planned = self.planned(text)
            stages = (
                () if planned is None else stages_of(planned.program, planned.recipe, self.prepared.parameters).stages
            )
            self._durations[text] = dict(pair for stage in stages for pair in spray_durations(stage))
        return self._durations[text]

    def outcome(self, text: str) -> Outcome | None:
        """Predicted outcome of a text; ``None`` where it cannot be planned or no analysis is left."""
        if text in self._outcomes:
            return self._outcomes[text]
        planned = self.planned(text)
        return None if planned is None or self.left <= 0 else self._analyse(text, planned)

    def _plan(self, text: str) -> Run:
        self._last = run(parse_recipe(text, file=self.file), self.prepared.board, before=self._last)
        return self._last

    def _analyse(self, text: str, planned: Run) -> Outcome:
        self.used += 1
        self._report()
        report = analyse_on(self.prepared, planned.program, planned.recipe, "fast")
        self._outcomes[text] = outcome_of(planned, report, self.goal, text)
        return self._outcomes[text]

    def _report(self) -> None:
        share = min(1.0, self.used / self.max_analyses)
        self._progress(f"tuning, {self.used} of at most {self.max_analyses} analyses", share)


@dataclass(frozen=True, slots=True, eq=False)
class TuningContext:
    """The runner of trials, the request, and the values that tuning began with."""

    runner: TrialRunner
    request: TuningRequest
    initial_values: Mapping[YamlPath, float]

    def excess(self, of: Candidate | Outcome) -> float:
        """Share by which a program is above the limits that are requested; 0 within them."""
        return self.request.limits.excess(of.seconds, of.litres)
