"""One change of a recipe."""

from dataclasses import dataclass

from rulesengine.tuning.trial.lower_bound import Key
from rulesengine.tuning.variables.design_variables import Kind
from rulesengine.tuning.variables.recipe_edits import Edits


@dataclass(frozen=True, slots=True)
class Move:
    """One change of a recipe, and what it is believed to gain."""

    kind: Kind
    what: str
    """Such as ``"templates.sweep.speed_mm_s: 60 -> 40"``."""
    edits: Edits
    gain: float
    """Shortfall that it is believed to take away, however long it takes."""
    key: tuple[str, str]
    """Moves of the same key are alike: what one of them did is held for or against the others."""
    steps: tuple[str, ...]
    """Where it acts; empty: on the whole sequence."""
    soak: float = 0.0
    """Shortfall that is a matter of time: it goes if the program becomes ``soak_s`` longer, in part before."""
    soak_s: float = 0.0

    aims: frozenset[Key] = frozenset()
    """What it is to help against."""

    @property
    def most(self) -> float:
        """What it gains if it takes long enough."""
        return self.gain + self.soak

    def gain_in(self, seconds: float) -> float:
        """What it is believed to gain if it makes the program so much longer."""
        return self.gain + (self.soak * min(1.0, max(0.0, seconds) / self.soak_s) if self.soak_s > 0 else 0.0)
