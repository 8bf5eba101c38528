"""Request of tuning (goal, limits, permitted changes, worth, budget), and its result."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Protocol

from rulesengine.tuning.trial.outcome import Figures, Outcome
from rulesengine.tuning.trial.requirements import Goal
from rulesengine.tuning.variables.design_variables import ChangeKind
from rulesengine.tuning.variables.recipe_edits import Edits, is_kept
from specs.errors import JobError
from specs.json import Json, content_sha256
from specs.yaml.located import YamlPath, spell_path

_TOLERANCE = 1e-6
_ALL_PERCENT = 100.0


class Cost(Protocol):
    """What a program takes: a candidate, an outcome or its figures."""

    @property
    def seconds(self) -> float:
        """Of the program."""
        ...

    @property
    def litres(self) -> float:
        """That it sprays."""
        ...


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
class Worth:
    """Least that a change has to gain for what it costs; tuning ends where none does.

    Time and liquid count half each: a program that is 2 % shorter and sprays 4 % less saves 3 %.
    """

    saving: float = 0.01
    """Share of time and liquid that a change has to save which does nothing else."""
    requirement_s: float = 1800.0
    """Most seconds that the program may take longer for one more requirement that is met."""

    def saved(self, before: Cost, after: Cost) -> float:
        """Share of time and liquid that is saved; negative where it takes more."""
        shares = (
            1.0 - now / then if then > 0 else 0.0
            for then, now in ((before.seconds, after.seconds), (before.litres, after.litres))
        )
        return 0.5 * sum(shares)

    def added_s(self, before: Cost, after: Cost) -> float:
        """Seconds that a program costs more, liquid by the time in which the one before sprays it."""
        return max(0.0, -self.saved(before, after) * before.seconds)


@dataclass(frozen=True, slots=True)
class TuningRequest:
    """Goal, limits, permitted changes, worth and budget of one tuning."""

    goal: Goal
    limits: ProgramLimits
    allowed: AllowedChanges
    max_analyses: int
    worth: Worth = Worth()


@dataclass(frozen=True, slots=True)
class AcceptedChange:
    """One accepted change, with the figures of the analyses before and after it."""

    what: tuple[str, ...]
    """Values from and to; several where they were made at once because they concern different steps."""
    before: Figures
    after: Figures


@dataclass(frozen=True, slots=True)
class Trial:
    """One recipe that was analysed, with what it was predicted to do."""

    text: str
    figures: Figures
    margin: float
    """Least of all amounts and times over what they have to be; 0 where a component or the board is not clean."""


@dataclass(frozen=True, slots=True)
class RobotTuning:
    """A robot that was tuned for: times are those that it takes."""

    cell: str
    robot: str
    infeasible: int
    """Candidates that were planned for it and that it cannot carry out."""


@dataclass(frozen=True, slots=True, eq=False)
class TuningResult:
    """A request, the outcomes of the first and the best recipe, and the changes between them.

    The result of a tuning that goes on is that of the best recipe so far.
    """

    request: TuningRequest
    first: Outcome
    last: Outcome
    """Of the best recipe."""
    changes: tuple[AcceptedChange, ...]
    used: int
    """Analyses that were made."""
    robot: RobotTuning | None = None
    ended: tuple[str, ...] = ()
    """Sentences on why tuning ended."""
    trials: tuple[Trial, ...] = ()
    """All recipes that were analysed, in order; the texts of the Pareto front have no templates that nothing uses."""

    @property
    def within_limits(self) -> bool:
        """Whether the limits are kept."""
        return self.request.limits.excess(self.last.seconds, self.last.litres) == 0

    @property
    def out_of_analyses(self) -> bool:
        """Whether tuning ended because no analysis was left."""
        return self.used >= self.request.max_analyses


def request_sha256(request: TuningRequest) -> str:
    """Hash a request."""
    content: dict[str, Json] = {
        "goal": request.goal,
        "limits": [request.limits.seconds, request.limits.litres],
        "kinds": list[Json](sorted(request.allowed.kinds)),
        "kept": list[Json](sorted(spell_path(path) for path in request.allowed.kept)),
        "analyses": request.max_analyses,
        "worth": [request.worth.saving, request.worth.requirement_s],
    }
    return content_sha256(content)


_WORTH = {"saving": "saving=1", "requirement": "requirement=1800"}


def read_worth(words: Sequence[str]) -> Worth:
    """Parse worths such as ``saving=1`` (percent) and ``requirement=600`` (seconds).

    Raises:
        JobError: an unknown name, one that stands twice, or no number in its range.
    """
    known: dict[str, float] = {}
    for word in words:
        name, _, text = word.partition("=")
        if name not in _WORTH or name in known:
            problem = "stands twice" if name in known else "is no worth"
            raise JobError(
                f"--worth {word}: {name!r} {problem}; write saving=PERCENT or requirement=SECONDS, each once"
            )
        try:
            known[name] = float(text)
        except ValueError:
            known[name] = -1.0
        if not (isfinite(known[name]) and known[name] >= 0 and (name != "saving" or known[name] < _ALL_PERCENT)):
            most = " below 100" if name == "saving" else ""
            raise JobError(f"--worth {word}: {text!r} is no number from 0 on{most}; write it as in {_WORTH[name]}")
    given = Worth()
    saving = known["saving"] / _ALL_PERCENT if "saving" in known else given.saving
    return Worth(saving, known.get("requirement", given.requirement_s))


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
