"""The whole recipe: the six elements of Sandia 1993, typed."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, model_validator

from recipes.classes import ComponentClass, Mask
from recipes.nozzles import AirKnife, Nozzle
from recipes.paths import Film, OverFaces, PathSpec, Slices
from specs.spec import (
    Acceleration,
    Bounds,
    Coordinate,
    Distance,
    Duration,
    Name,
    PositiveDistance,
    Pressure,
    Repeats,
    Resistivity,
    Size,
    Spec,
    Speed,
    Temperature,
    Turn,
    TurnAcceleration,
    TurnSpeed,
)

Use: TypeAlias = Literal["wash", "rinse", "dry"]
"""What a solution is for."""


class Function(Spec):
    """A cleaning function: its solution and its maximum nozzle speed."""

    solution: Name = Field(description="Name of the solution or gas.")
    temperature_c: Temperature | None = Field(default=None, description="Of the solution.")
    pressure_bar: Pressure = Field(description="At the nozzle, above ambient.")
    max_speed_mm_s: Speed = Field(description="No move of this function is faster.")
    solution_kind: Literal["liquid", "gas"] | None = Field(
        default=None,
        description="Counted in litres if liquid; left out, an air knife sprays gas and all others liquid.",
    )


def use_of(name: str, function: Function, nozzle: Nozzle) -> Use:
    """Use of a function, judged by the names: ``rinse`` or ``water`` in its own or its solution's rinse, gases dry."""
    kind = function.solution_kind or ("gas" if isinstance(nozzle, AirKnife) else "liquid")
    names = f"{name} {function.solution}".lower()
    return "dry" if kind == "gas" else "rinse" if "rinse" in names or "water" in names else "wash"


class Until(Spec):
    """Repeat until a sensor reaches its limit."""

    resistivity_mohm_cm: Resistivity | None = Field(default=None, description="Of the rinse water that runs off.")
    temperature_c: Temperature | None = Field(default=None, description="Of the board.")
    max_repeats: Repeats = Field(description="Never more often than this.")

    @model_validator(mode="after")
    def _check(self) -> "Until":
        if (self.resistivity_mohm_cm is None) == (self.temperature_c is None):
            raise ValueError("give exactly one of resistivity_mohm_cm, temperature_c")
        return self


class Step(Spec):
    """One step of the sequence: a function, with a nozzle, along templates."""

    function: Name = Field(description="Cleaning function, by its name under functions.")
    nozzle: Name = Field(description="Nozzle, by its name under nozzles.")
    paths: list[Name] = Field(min_length=1, description="Templates to follow, in this order.")
    side: Literal["top", "bottom"] = Field(
        default="top", description="Side that is sprayed; a change turns the board over."
    )
    repeat: Repeats = Field(default=1, description="How often all its paths are done.")
    least_time_s: Duration | None = Field(
        default=None,
        description="Least time of spraying, with the steps right before of the same function and side; the last of "
        "its paths is done again as often as that takes.",
    )
    until: Until | None = Field(default=None, description="Repeat until a sensor reaches its limit.")
    only_with_parts: bool = Field(
        default=False, description="True leaves the step out on a board whose components are all on the other side."
    )
    enabled: bool = Field(default=True, description="False leaves the step out.")

    @model_validator(mode="after")
    def _check(self) -> "Step":
        if self.until is not None and self.repeat != 1:
            raise ValueError("give repeat or until, not both; until has max_repeats")
        if self.until is not None and self.least_time_s is not None:
            raise ValueError("give least_time_s or until, not both: how often a sensor repeats it is not known before")
        return self


class Limits(Spec):
    """What the motion must keep to."""

    acceleration_mm_s2: Acceleration = Field(default=500, description="Of the orifice.")
    rotation_deg_s: TurnSpeed = Field(default=180, description="Of the nozzle.")
    rotation_acceleration_deg_s2: TurnAcceleration = Field(default=1800, description="Of the nozzle.")
    transfer_speed_mm_s: Speed = Field(
        default=250, description="Between passes; never above the function's maximum either."
    )
    tilt_band_deg: Annotated[float, Bounds(0, 45, "degrees", "tilts that a robot may add")] = Field(
        default=0,
        description="Largest tilt that a robot may add to the jet while it sprays, to avoid collisions and limits.",
    )
    blend_mm: Distance = Field(default=0.5, description="How far a corner may be cut so that the nozzle need not stop.")
    clearance_mm: PositiveDistance = Field(default=5, description="Orifice to every body, always.")
    park_height_mm: Size = Field(default=110, description="Orifice above the board at the beginning and the end.")
    park_mm: tuple[Coordinate, Coordinate] | None = Field(
        default=None, description="Where it parks, board frame; left out, above the middle of the board."
    )
    tool_azimuth_deg: Turn | None = Field(
        default=None,
        description="Where the reference of a round nozzle points, from +X; left out, along the board's longest edge.",
    )


class Recipe(Spec):
    """A recipe: one YAML file."""

    recipe: Name = Field(description="Name of the recipe.")
    description: str = Field(default="", description="What it is good for, for the engineer who chooses it.")
    extends: str | None = Field(default=None, description="Recipe whose keys are inherited: a library name or a file.")
    functions: dict[Name, Function] = Field(description="Cleaning functions, by name.")
    nozzles: dict[Name, Nozzle] = Field(description="Nozzles and what they spray, by name.")
    classes: dict[Name, ComponentClass] = Field(description="Ordered: the first that matches takes the component.")
    masks: list[Mask] = Field(default=[], description="Components that are treated apart.")
    templates: dict[Name, PathSpec] = Field(description="Path templates, by name: a path class with its values.")
    limits: Limits = Field(default=Limits(), description="What the motion must keep to.")
    sequence: list[Step] = Field(min_length=1, description="Steps, in the order in which they are done.")

    @property
    def over_faces(self) -> bool:
        """Whether a step follows the faces of parts."""
        return any(
            isinstance(self.templates.get(name), OverFaces)
            for step in self.sequence
            if step.enabled
            for name in step.paths
        )


def film_in(spec: PathSpec | OverFaces | None) -> Film | None:
    """The film that a path template is to lay; none of other classes, and where there is no such template."""
    return spec.film if isinstance(spec, Slices) else None


def film_of(recipe: Recipe, index: int) -> Film | None:
    """The film that the paths of a step are to lay."""
    films = (film_in(recipe.templates[name]) for name in recipe.sequence[index].paths)
    return next(filter(None, films), None)


def has_film(recipe: Recipe) -> bool:
    """Whether a step of a recipe lays a film."""
    return any(step.enabled and film_of(recipe, index) is not None for index, step in enumerate(recipe.sequence))
