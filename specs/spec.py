"""What all parts of a recipe share: frozen, unknown keys refused, values by class."""

from typing import Annotated, TypeAlias, TypeVar

from pydantic import BaseModel, ConfigDict, Field

T = TypeVar("T", int, float)


class Spec(BaseModel):
    """A part of a recipe: describes, never plans."""

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        populate_by_name=True,
        allow_inf_nan=False,
        use_attribute_docstrings=False,
        validate_default=True,  # a default of 0 becomes 0.0, so that stated and left out are the same value
    )


PositiveFloat: TypeAlias = Annotated[float, Field(gt=0)]
NonNegativeFloat: TypeAlias = Annotated[float, Field(ge=0)]
Tilt: TypeAlias = Annotated[float, Field(ge=0, lt=90)]
Count: TypeAlias = Annotated[int, Field(ge=0, le=1000)]

# One value, or one by component class with an optional `default`: `passes: {small: 2, large: 4, default: 2}`.
SpeedByClass: TypeAlias = PositiveFloat | dict[str, PositiveFloat]
LengthByClass: TypeAlias = float | dict[str, float]
HeightByClass: TypeAlias = PositiveFloat | dict[str, PositiveFloat]
SecondsByClass: TypeAlias = NonNegativeFloat | dict[str, NonNegativeFloat]
TiltByClass: TypeAlias = Tilt | dict[str, Tilt]
CountByClass: TypeAlias = Count | dict[str, Count]


def for_class(value: T | dict[str, T], component_class: str) -> T:
    """Pick the value of a class; the recipe's own check has made sure that there is one.

    Raises:
        KeyError: neither the class nor ``default`` is listed.
    """
    if not isinstance(value, dict):
        return value
    return value[component_class] if component_class in value else value["default"]
