"""Settings of tuning on the page, and its proposal until it is applied or discarded."""

from dataclasses import dataclass
from math import isfinite

from boards.board import Board
from rulesengine.tuning.trial.request import AllowedChanges, ProgramLimits, TuningRequest, TuningResult, Worth
from rulesengine.tuning.trial.requirements import Goal
from rulesengine.tuning.variables import CHANGE_KINDS, ChangeKind
from specs.errors import JobError
from webui.page.document import Document

KIND_WORDS: dict[ChangeKind, tuple[str, str]] = {
    "speeds": ("Speeds", "How fast the nozzle goes along a path."),
    "tilts": ("Tilts", "Tilt of the jet."),
    "passes": ("Passes", "Repeats of a path, by class of parts where that is enough."),
    "dwells": ("Dwells", "How long the nozzle waits at edges and corners."),
    "heights": ("Heights", "How high the nozzle is above the board."),
    "sides": ("New paths", "Paths that a step does not have yet: around parts, around the rim, across."),
    "wash_time": ("Washing time", "How often a whole step is done, or its least time."),
    "pressure": ("Pressure", "Of the liquids; the pump has to give it."),
    "temperature": ("Temperature", "Of the liquids, within their windows."),
}
"""Label and hint of each group of numbers that tuning may change."""
GOALS: dict[str, Goal] = {"Clean": "clean", "Clean and dry": "clean-and-dry"}
_ALL_PERCENT = 100.0
_GIVEN = frozenset(CHANGE_KINDS) - {"pressure", "temperature"}


class TuningError(JobError):
    """Tuning cannot be done, or its proposal cannot be used."""


@dataclass(frozen=True, slots=True)
class TuningSettings:
    """Settings of the form; ``0`` is no limit."""

    kinds: frozenset[ChangeKind] = _GIVEN
    """Pressure and temperature change only where they are ticked."""
    goal: Goal = "clean"
    seconds: float = 0.0
    litres: float = 0.0
    analyses: float = 40.0
    saving: float = 1.0
    """Percent of time and liquid that an analysis has to promise."""
    for_robot: bool = False
    """Whether times are those of the cell's robot."""

    def request(self) -> TuningRequest:
        """Convert to a request.

        Raises:
            TuningError: it leaves nothing to do, or a number cannot be.
        """
        if not self.kinds:
            raise TuningError("Nothing may be changed; tick at least one group of numbers.")
        for name, value in (("Time at most", self.seconds), ("Liquid at most", self.litres)):
            if not isfinite(value) or value < 0:
                raise TuningError(f"{name}: {value:g} is no limit; give a number above 0, or 0 for none.")
        if not isfinite(self.analyses) or self.analyses < 2:
            raise TuningError(f"Analyses: {self.analyses:g} are too few; allow at least 2.")
        if not (isfinite(self.saving) and 0 <= self.saving < _ALL_PERCENT):
            raise TuningError(f"Worth an analysis: {self.saving:g} is no percentage; give one from 0 on below 100.")
        limits = ProgramLimits(self.seconds or None, self.litres or None)
        worth = Worth(saving=self.saving / _ALL_PERCENT)
        return TuningRequest(self.goal, limits, AllowedChanges(self.kinds), round(self.analyses), worth)


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """A recipe that tuning found, until it is applied or discarded."""

    document: Document
    """The recipe before tuning."""
    board: Board
    parameters_name: str
    """As the project lists it."""
    tuned: TuningResult
    chosen: str = ""
    """Text of the recipe that was chosen of the Pareto front; empty for the one that tuning found."""
    interrupted: bool = False
    """Whether tuning was cancelled: it is the best until then."""

    @property
    def text(self) -> str:
        """The recipe that is proposed."""
        return self.chosen or self.tuned.last.text

    @property
    def changes(self) -> bool:
        """Whether it is another recipe at all."""
        return self.text != self.document.text

    def fits(self, document: Document) -> bool:
        """Whether a document still has the text that was tuned."""
        return document.file == self.document.file and document.text == self.document.text
