"""One change of a recipe."""

from dataclasses import dataclass

from rulesengine.tuning.edits import Edits
from rulesengine.tuning.knobs import Kind


@dataclass(frozen=True, slots=True)
class Move:
    """One change of a recipe, and what it is believed to gain."""

    kind: Kind
    what: str
    """Such as ``"templates.sweep.speed_mm_s: 60 -> 40"``."""
    edits: Edits
    gain: float
    """Shortfall that it is believed to take away."""
    key: tuple[str, str]
    """Moves of the same key are alike: what one of them did is held for or against the others."""
    steps: tuple[str, ...]
    """Where it acts; empty: on the whole sequence."""
