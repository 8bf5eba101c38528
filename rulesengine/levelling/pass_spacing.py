"""Which spacings of parallel passes are even for a nozzle of a recipe, and which of them its speeds allow."""

from dataclasses import dataclass

from cleaning.exposure.segment_rates import film_of_pass
from cleaning.jet.jet import form_of
from cleaning.parameters.load import load_parameters
from geometry.arrays import Scalars
from geometry.coverage.spacing import Spacing, find_spacings
from recipes.errors import RecipeError
from recipes.nozzles import AirKnife, Radial
from recipes.recipe import Recipe
from specs.yaml.schema import name_nearest

_LEAST_SHARE = 0.1
"""Of the pattern's width: narrower spacings overlap ten times and more."""


@dataclass(frozen=True, slots=True)
class AllowedSpacing:
    """A valley of the ripple, and the speed that lays the film there."""

    spacing: Spacing
    """mm, and um mm/s."""
    speed_mm_s: float
    """At which the middle between the extremes is the film to lay."""
    allowed: bool
    """Whether the maximum speed allows that."""
    overlapping: int
    """Passes that a place gets something from, at most."""


@dataclass(frozen=True, slots=True, eq=False)
class SpacingTable:
    """The valleys of one nozzle at one height."""

    nozzle: str
    height_mm: float
    film_um: float
    flow_lpm: float
    """At the function's pressure."""
    max_speed_mm_s: float
    max_speed_of: str
    """What states it, such as ``"functions.coat"``."""
    across_mm: Scalars
    """(n,) places across a pass."""
    film_um_mm_s: Scalars
    """(n,) film of one pass there, times its speed."""
    valleys: tuple[AllowedSpacing, ...]
    """Widest first."""

    @property
    def best(self) -> AllowedSpacing | None:
        """The allowed valley with the least ripple; ``None`` where no speed is high enough."""
        return min((each for each in self.valleys if each.allowed), key=lambda each: each.spacing.ripple, default=None)


def find_pass_spacings(
    recipe: Recipe,
    nozzle_name: str,
    film_um: float,
    height_mm: float | None = None,
    max_speed_mm_s: float | None = None,
) -> SpacingTable:
    """Find every even spacing of straight parallel passes over a flat plate, nozzle at right angles to it.

    Args:
        recipe: Has the nozzle, and the functions that use it.
        nozzle_name: Of the recipe.
        film_um: Thickness to lay, um of liquid.
        height_mm: Orifice above the plate; left out, that at which a radial pattern was measured.
        max_speed_mm_s: Left out, the least of the functions that spray with the nozzle.

    Raises:
        RecipeError: there is no such nozzle, it blows gas, or its height or speed must be stated.
    """
    if nozzle_name not in recipe.nozzles:
        message = f"there is no nozzle {nozzle_name!r}; {name_nearest(nozzle_name, recipe.nozzles)}"
        raise RecipeError(message, path="nozzles")
    nozzle = recipe.nozzles[nozzle_name]
    if isinstance(nozzle, AirKnife):
        raise RecipeError("an air knife lays no film; name a nozzle that sprays", path=f"nozzles.{nozzle_name}")
    height = height_mm or (nozzle.at_mm if isinstance(nozzle, Radial) else None)
    if height is None:
        raise RecipeError("from which height? state --height-mm", path=f"nozzles.{nozzle_name}")
    users = [recipe.functions[step.function] for step in recipe.sequence if step.nozzle == nozzle_name]
    names = [step.function for step in recipe.sequence if step.nozzle == nozzle_name]
    if not users and max_speed_mm_s is None:
        raise RecipeError("no step uses it, so state --max-speed-mm-s", path=f"nozzles.{nozzle_name}")
    spray = load_parameters("default").spray
    flow = nozzle.flow_lpm
    if users:
        flow *= (users[0].pressure_bar / nozzle.at_bar) ** spray.exponent_of(nozzle.pattern)
    slowest = min(range(len(users)), key=lambda at: users[at].max_speed_mm_s, default=-1)
    fastest = max_speed_mm_s if max_speed_mm_s is not None else users[slowest].max_speed_mm_s
    across, film = film_of_pass(form_of(nozzle, flow, spray), height)
    width = float(across[-1] - across[0])
    valleys: list[AllowedSpacing] = []
    for each in find_spacings(across, film, _LEAST_SHARE * width):
        speed = each.middle / film_um
        valleys.append(AllowedSpacing(each, speed, speed <= fastest, int(width // each.spacing) + 1))
    return SpacingTable(
        nozzle=nozzle_name,
        height_mm=height,
        film_um=film_um,
        flow_lpm=flow,
        max_speed_mm_s=fastest,
        max_speed_of="--max-speed-mm-s" if max_speed_mm_s is not None else f"functions.{names[slowest]}",
        across_mm=across,
        film_um_mm_s=film,
        valleys=tuple(valleys),
    )
