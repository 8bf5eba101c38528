"""Evidence on one component: the numbers that the rules judge."""

from collections.abc import Sequence
from dataclasses import dataclass

from boards.undersides.underside import Underside
from cleaning.parameters.model import Parameters, PartOverride
from cleaning.process.stages import Stage
from cleaning.undersides.gap_result import GapResult
from cleaning.verdicts.results import ExposedPart
from recipes.recipe import Use
from specs.source import Source


@dataclass(frozen=True, slots=True, eq=False)
class Reach:
    """What all washing, or all rinsing, of one side brings to the exposed surface."""

    use: Use
    functions: str
    """Names of the functions, such as ``"clean"`` or ``"prewash and clean"``."""
    made_by: Source
    """The stage's; empty if there are several."""
    repeats: int
    """How often loops may do it, at most."""
    exposed: ExposedPart


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
