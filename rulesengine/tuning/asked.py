"""What tuning is asked for."""

from dataclasses import dataclass

from rulesengine.tuning.goals import Goal
from rulesengine.tuning.moves import Allowed

_INSIDE = 1e-6


@dataclass(frozen=True, slots=True)
class Limits:
    """What the program may take; ``None``: as much as it needs. Loops count once."""

    seconds: float | None = None
    litres: float | None = None

    def excess(self, seconds: float, litres: float) -> float:
        """Say by which share a program is above its limits, both together; 0 within them."""
        over = 0.0
        for value, most in ((seconds, self.seconds), (litres, self.litres)):
            if most is not None and value > most * (1.0 + _INSIDE):
                over += value / most - 1.0
        return round(over, 6)


@dataclass(frozen=True, slots=True)
class Asked:
    """What tuning is asked for."""

    goal: Goal
    limits: Limits
    allowed: Allowed
    analyses: int
    """Most that may be made."""
