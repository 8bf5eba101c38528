"""Evidence on one component: the numbers that the rules judge."""

from collections.abc import Sequence
from dataclasses import dataclass

from boards.undersides.underside import Underside
from cleaning.parameters.model import Parameters, PartOverride
from cleaning.process.stages import Stage
from cleaning.undersides.gap_result import GapResult
from cleaning.verdicts.results import ExposedPart, Reach


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """One component after all stages: the numbers that the rules look at."""

    component: str
    side: str
    place: tuple[float, float, float]
    stages: Sequence[Stage]
    exposed: Sequence[ExposedPart | None]
    """One per stage."""
    reached: Sequence[Reach]
    """Liquids only."""
    underside: Underside | None
    gaps: Sequence[GapResult]
    override: PartOverride
    """Empty where nothing special is known of the component."""
    occluder: str
    """What stands before the places that are missed; empty if nothing does."""
    parameters: Parameters
    avoided: bool = False
    """By a mask of the recipe."""
