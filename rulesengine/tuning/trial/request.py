"""Request of tuning (goal, limits, permitted changes, worth, budget), its result, and the Pareto front."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import inf, nan, nextafter
from typing import Any, Protocol, TypeVar

from rulesengine.tuning.trial.outcome import Figures, Outcome
from rulesengine.tuning.trial.requirements import Goal
from rulesengine.tuning.variables import ChangeKind, Edits, is_kept
from specs.errors import JobError
from specs.json import Json, content_sha256
from specs.yaml.located import YamlPath, spell_path

_TOLERANCE = 1e-6
T = TypeVar("T")


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

    def excess(self, cost: Cost) -> float:
        """Share by which a program is above its limits, both together; 0 within them."""
        pairs = ((cost.seconds, self.seconds), (cost.litres, self.litres))
        over = (value / most - 1.0 for value, most in pairs if most is not None and value > most * (1.0 + _TOLERANCE))
        return round(sum(over), 6)


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
    name: str
    """Of the robot."""
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
    calibrated: bool = False
    """Whether the kinetics of the parameter set were fitted to measurements."""

    @property
    def within_limits(self) -> bool:
        """Whether the limits are kept."""
        return self.request.limits.excess(self.last) == 0

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


def read_worth(words: Sequence[str]) -> Worth:
    """Parse worths such as ``saving=1`` (percent) and ``requirement=600`` (seconds).

    Raises:
        JobError: an unknown name, one that stands twice, or no number in its range.
    """
    names = {"saving": ("PERCENT", 1, 100.0), "requirement": ("SECONDS", 1800, inf)}
    known, given = _read_numbers("worth", words, names, (0.0, "number from 0 on")), Worth()
    saving = known["saving"] / 100.0 if "saving" in known else given.saving
    return Worth(saving, known.get("requirement", given.requirement_s))


def read_limits(words: Sequence[str]) -> ProgramLimits:
    """Parse limits such as ``time=600`` (seconds) and ``litres=20``.

    Raises:
        JobError: an unknown name, one that stands twice, or no positive number.
    """
    names = {"time": ("SECONDS", 600, inf), "litres": ("LITRES", 600, inf)}
    known = _read_numbers("limit", words, names, (nextafter(0.0, 1.0), "positive number"))
    return ProgramLimits(known.get("time"), known.get("litres"))


def _read_numbers(
    option: str, words: Sequence[str], names: Mapping[str, tuple[str, int, float]], least: tuple[float, str]
) -> dict[str, float]:
    """Parse words as ``NAME=NUMBER``.

    Args:
        option: Name of the option, which names the quantity.
        words: To parse.
        names: Unit, example and what its number has to stay below, by name.
        least: Least number, and words for such a number.

    Raises:
        JobError: an unknown name, one that stands twice, or no number in its range.
    """
    known: dict[str, float] = {}
    for word in words:
        name, _, text = word.partition("=")
        if name not in names or name in known:
            problem = "stands twice" if name in known else f"is no {option}"
            forms = " or ".join(f"{each}={unit}" for each, (unit, _, _) in names.items())
            raise JobError(f"--{option} {word}: {name!r} {problem}; write {forms}, each once")
        try:
            known[name] = float(text)
        except ValueError:
            known[name] = nan
        _, example, most = names[name]
        if not least[0] <= known[name] < most:
            kind = least[1] if most == inf else f"{least[1]} below {most:g}"
            raise JobError(f"--{option} {word}: {text!r} is no {kind}; write it as in {name}={example}")
    return known


def cleanliness(trial: Trial) -> tuple[int, int, float]:
    """How clean a recipe is predicted to leave the board: clean components, requirements met, least margin."""
    figures = trial.figures
    return figures.clean_components, -figures.open_requirements, trial.margin


def non_dominated(items: Iterable[T], costs: Callable[[T], tuple[Any, ...]]) -> tuple[T, ...]:
    """Items than which no other one is as good in all costs and better in one; of equal ones the first stays.

    Args:
        items: What is compared.
        costs: Gives as many costs of each item; less is better.

    Returns:
        The items by ascending costs.
    """
    front: list[tuple[tuple[Any, ...], T]] = []
    for each in sorted(items, key=costs):  # what dominates an item, or is its equal, comes before it
        mine = costs(each)
        if not any(all(a <= b for a, b in zip(other, mine, strict=True)) for other, _ in front):
            front.append((mine, each))
    return tuple(each for _, each in front)


def pareto_front(trials: Sequence[Trial]) -> tuple[Trial, ...]:
    """Recipes that no other one dominates, the quickest first; of equal ones the first that was analysed."""
    return non_dominated(
        trials,
        lambda each: (each.figures.seconds, each.figures.litres, tuple(-part for part in cleanliness(each))),
    )
