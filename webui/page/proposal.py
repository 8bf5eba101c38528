"""What somebody at a page wants of tuning, and what it proposes until it is taken or left."""

from dataclasses import dataclass
from math import isfinite

from boards.board import Board
from rulesengine.tuning.trial.request import Allowed, Asked, Limits
from rulesengine.tuning.trial.requirements import Goal
from rulesengine.tuning.trial.result import Tuned
from rulesengine.tuning.variables.design_variables import KINDS, Kind
from specs.errors import JobError
from webui.page.document import Document

KIND_WORDS: dict[Kind, tuple[str, str]] = {
    "speeds": ("Speeds", "How fast the nozzle goes along a path."),
    "tilts": ("Tilts", "How far the jet leans."),
    "passes": ("Passes", "How often a path is gone, by class of parts where that is enough."),
    "dwells": ("Dwells", "How long the nozzle waits at edges and corners."),
    "heights": ("Heights", "How high the nozzle is above the board."),
    "sides": ("New paths", "Paths that a step does not have yet: around parts, around the rim, across."),
    "wash_time": ("Repeats", "How often a whole step is done."),
    "pressure": ("Pressure", "Of the liquids; the pump has to give it."),
    "temperature": ("Temperature", "Of the liquids, within what they bear."),
}
"""Label and hint of each group of numbers that tuning may change."""
GOALS: dict[str, Goal] = {"Clean": "clean", "Clean and dry": "clean-and-dry"}
_GIVEN = frozenset(KINDS) - {"pressure", "temperature"}


class TuningError(JobError):
    """Tuning cannot be done, or what came of it cannot be used."""


@dataclass(frozen=True, slots=True)
class Wishes:
    """What somebody filled in; ``0`` is no limit."""

    kinds: frozenset[Kind] = _GIVEN
    """Pump and heater are what they are, unless somebody says otherwise."""
    goal: Goal = "clean"
    seconds: float = 0.0
    litres: float = 0.0
    analyses: float = 40.0

    def asked(self) -> Asked:
        """Put it as tuning takes it.

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
        limits = Limits(self.seconds or None, self.litres or None)
        return Asked(self.goal, limits, Allowed(self.kinds), round(self.analyses))


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """A recipe that tuning found, until somebody takes or leaves it."""

    document: Document
    """What was tuned."""
    board: Board
    parameters_name: str
    """As the project lists it."""
    tuned: Tuned

    @property
    def text(self) -> str:
        """The recipe that is proposed."""
        return self.tuned.last.text

    @property
    def changes(self) -> bool:
        """Whether it is another recipe at all."""
        return self.text != self.document.text

    def fits(self, document: Document) -> bool:
        """Say whether a document still says what was tuned."""
        return document.file == self.document.file and document.text == self.document.text
