"""What tuning is asked for."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

from rulesengine.tuning.trial.requirements import Goal
from rulesengine.tuning.variables.design_variables import Kind
from rulesengine.tuning.variables.recipe_edits import Edits, is_kept
from specs.errors import JobError
from specs.yaml.located import YamlPath

_INSIDE = 1e-6


@dataclass(frozen=True, slots=True)
class Limits:
    """What the program may take; ``None``: as much as it needs. Loops count once."""

    seconds: float | None = None
    litres: float | None = None

    @property
    def any(self) -> bool:
        """Whether there is a limit."""
        return self.seconds is not None or self.litres is not None

    def excess(self, seconds: float, litres: float) -> float:
        """Say by which share a program is above its limits, both together; 0 within them."""
        over = 0.0
        for value, most in ((seconds, self.seconds), (litres, self.litres)):
            if most is not None and value > most * (1.0 + _INSIDE):
                over += value / most - 1.0
        return round(over, 6)


@dataclass(frozen=True, slots=True)
class Allowed:
    """What may be changed."""

    kinds: frozenset[Kind]
    kept: tuple[YamlPath, ...] = ()

    def may(self, kind: Kind, edits: Edits) -> bool:
        """Say whether a change keeps to what is allowed."""
        return kind in self.kinds and not any(is_kept(path, self.kept) for path, _ in edits)


@dataclass(frozen=True, slots=True)
class Asked:
    """What tuning is asked for."""

    goal: Goal
    limits: Limits
    allowed: Allowed
    analyses: int
    """Most that may be made."""


def read_limits(words: Sequence[str]) -> Limits:
    """Read limits such as ``time=600`` (seconds) and ``litres=20``.

    Raises:
        JobError: an unknown name, one that stands twice, or no positive number.
    """
    known: dict[str, float] = {}
    for word in words:
        name, _, text = word.partition("=")
        if name not in ("time", "litres") or name in known:
            again = "stands twice" if name in known else "is no limit"
            raise JobError(f"--limit {word}: {name!r} {again}; write time=SECONDS or litres=LITRES, each once")
        try:
            known[name] = float(text)
        except ValueError:
            known[name] = 0.0
        if not (isfinite(known[name]) and known[name] > 0):
            raise JobError(f"--limit {word}: {text!r} is no positive number; write it as in {name}=600")
    return Limits(known.get("time"), known.get("litres"))
