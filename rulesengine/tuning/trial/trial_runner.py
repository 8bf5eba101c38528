"""Planning and analysing many texts of one recipe on one board; what was asked before is remembered."""

from pathlib import Path

from cleaning.analyse import analyse_on
from cleaning.prepared_board import PreparedBoard
from cleaning.process.split_stages import stages_of
from recipes.load import parse_recipe
from rulesengine.planning.pipeline import Run, run
from rulesengine.tuning.trial.deposits import sprayed_in
from rulesengine.tuning.trial.outcome import Outcome, outcome_of
from rulesengine.tuning.trial.requirements import Goal
from rulesengine.tuning.variables.recipe_edits import Edits, apply_edits
from specs.errors import JobError
from specs.finding import blocking
from specs.progress import Progress, no_progress

_MOST_RUNS = 24
"""Plans that are kept."""


class Bench:
    """Where recipes are tried: one board, one file, one goal, and a count of analyses."""

    def __init__(self, file: Path, prepared: PreparedBoard, goal: Goal, most: int) -> None:
        self.file = file
        self.prepared = prepared
        self.goal: Goal = goal
        self.most = most
        self.used = 0
        self.progress: Progress = no_progress
        self._last: Run | None = None
        self._runs: dict[str, Run | None] = {}
        self._sprayed: dict[str, dict[tuple[str, str], float]] = {}
        self._outcomes: dict[str, Outcome] = {}
        self._errors: frozenset[str] = frozenset()

    @property
    def left(self) -> int:
        """Analyses that may still be made."""
        return self.most - self.used

    def first(self, text: str) -> Outcome:
        """Try the recipe to begin with; errors that its plan has are not held against its successors.

        Raises:
            JobError: it cannot be read, planned or analysed.
        """
        planned = self._carry_out(text)
        self._runs[text] = planned
        self._errors = frozenset(finding.rule.id for finding in blocking(planned.findings, ()))
        return self._analyse(text, planned)

    def edited(self, text: str, edits: Edits) -> str | None:
        """Write edits into a text; ``None`` where that cannot be done or changes nothing."""
        try:
            changed = apply_edits(text, self.file, edits)
        except JobError:
            return None
        return None if changed == text else changed

    def planned(self, text: str) -> Run | None:
        """Plan a text; ``None`` where it is no recipe, sprays nothing, or may not be exported."""
        if text not in self._runs:
            while len(self._runs) >= _MOST_RUNS:
                del self._runs[next(iter(self._runs))]
            try:
                done = self._carry_out(text)
            except JobError:
                self._runs[text] = None
            else:
                stops = {finding.rule.id for finding in blocking(done.findings, ())}
                self._runs[text] = done if stops <= self._errors else None
        return self._runs[text]

    def sprayed_s(self, text: str) -> dict[tuple[str, str], float]:
        """How long each template of each step sprays in the program of a text; nothing where it cannot be planned."""
        if text not in self._sprayed:
            planned = self.planned(text)
            stages = (
                () if planned is None else stages_of(planned.program, planned.recipe, self.prepared.parameters).stages
            )
            self._sprayed[text] = dict(pair for stage in stages for pair in sprayed_in(stage))
        return self._sprayed[text]

    def outcome(self, text: str) -> Outcome | None:
        """Predict what a text does; ``None`` where it cannot be planned or no analysis is left."""
        known = self._outcomes.get(text)
        if known is not None:
            return known
        planned = self.planned(text)
        return None if planned is None or self.left <= 0 else self._analyse(text, planned)

    def _carry_out(self, text: str) -> Run:
        done = run(parse_recipe(text, file=self.file), self.prepared.board, before=self._last)
        self._last = done
        return done

    def _analyse(self, text: str, planned: Run) -> Outcome:
        self.used += 1
        self.progress("tuning", self.used / self.most)
        report = analyse_on(self.prepared, planned.program, planned.recipe, "fast")
        found = outcome_of(planned, report, self.goal, text)
        self._outcomes[text] = found
        return found
