"""Request of tuning (goal, limits, permitted changes, budget), and its result."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

from rulesengine.tuning.trial.outcome import Figures, Outcome
from rulesengine.tuning.trial.requirements import Goal
from rulesengine.tuning.variables.design_variables import ChangeKind
from rulesengine.tuning.variables.recipe_edits import Edits, is_kept
from specs.errors import JobError
from specs.yaml.located import YamlPath

_TOLERANCE = 1e-6


@dataclass(frozen=True, slots=True)
class ProgramLimits:
    """Most that the program may take; ``None``: as much as it needs. Loops count once."""

    seconds: float | None = None
    litres: float | None = None

    def excess(self, seconds: float, litres: float) -> float:
        """Share by which a program is above its limits, both together; 0 within them."""
        over = 0.0
        for value, most in ((seconds, self.seconds), (litres, self.litres)):
            if most is not None and value > most * (1.0 + _TOLERANCE):
                over += value / most - 1.0
        return round(over, 6)


@dataclass(frozen=True, slots=True)
class AllowedChanges:
    """What may be changed."""

    kinds: frozenset[ChangeKind]
    kept: tuple[YamlPath, ...] = ()

    def permits(self, kind: ChangeKind, edits: Edits) -> bool:
        """Whether a change is of an allowed kind and touches nothing that is kept."""
        return kind in self.kinds and not any(is_kept(path, self.kept) for path, _ in edits)


@dataclass(frozen=True, slots=True)
class TuningRequest:
    """Goal, limits, permitted changes and budget of one tuning."""

    goal: Goal
    limits: ProgramLimits
    allowed: AllowedChanges
    max_analyses: int


@dataclass(frozen=True, slots=True)
class AcceptedChange:
    """One accepted change, with the figures of the analyses before and after it."""

    what: tuple[str, ...]
    """Values from and to; several where they were made at once because they concern different steps."""
    before: Figures
    after: Figures


@dataclass(frozen=True, slots=True)
class RobotTuning:
    """A robot that was tuned for: times are those that it takes."""

    cell: str
    robot: str
    infeasible: int
    """Candidates that were planned for it and that it cannot carry out."""


@dataclass(frozen=True, slots=True, eq=False)
class TuningResult:
    """A request, the outcomes of the first and the best recipe, and the changes between them."""

    request: TuningRequest
    first: Outcome
    last: Outcome
    """Of the best recipe."""
    changes: tuple[AcceptedChange, ...]
    used: int
    """Analyses that were made."""
    robot: RobotTuning | None = None

    @property
    def within_limits(self) -> bool:
        """Whether the limits are kept."""
        return self.request.limits.excess(self.last.seconds, self.last.litres) == 0

    @property
    def out_of_analyses(self) -> bool:
        """Whether tuning ended because no analysis was left."""
        return self.used >= self.request.max_analyses


def read_limits(words: Sequence[str]) -> ProgramLimits:
    """Parse limits such as ``time=600`` (seconds) and ``litres=20``.

    Raises:
        JobError: an unknown name, one that stands twice, or no positive number.
    """
    known: dict[str, float] = {}
    for word in words:
        name, _, text = word.partition("=")
        if name not in ("time", "litres") or name in known:
            problem = "stands twice" if name in known else "is no limit"
            raise JobError(f"--limit {word}: {name!r} {problem}; write time=SECONDS or litres=LITRES, each once")
        try:
            known[name] = float(text)
        except ValueError:
            known[name] = 0.0
        if not (isfinite(known[name]) and known[name] > 0):
            raise JobError(f"--limit {word}: {text!r} is no positive number; write it as in {name}=600")
    return ProgramLimits(known.get("time"), known.get("litres"))
