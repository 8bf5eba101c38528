"""Base of the models of YAML files, and the ranges of the quantities in them."""

from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

Name: TypeAlias = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_.-]*$")]
"""A word that can stand in a program file and in a robot's program."""
OUT_OF_BOUNDS = "out_of_bounds"
"""Type of the error of a number outside its bounds; its context has the bound in words."""


class Spec(BaseModel):
    """A part of a YAML file, as its author states it: frozen, unknown keys refused."""

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        populate_by_name=True,
        allow_inf_nan=False,
        use_attribute_docstrings=False,
        validate_default=True,  # a default of 0 becomes 0.0, so that stated and left out are the same value
    )

    def __hash__(self) -> int:
        """Hash the values, which may be lists."""
        return hash((type(self), self.model_dump_json()))


@dataclass(frozen=True, slots=True)
class Bounds:
    """Range of a number, to stand in ``Annotated[float, Bounds(...)]``; the refusal names the bound and the range.

    Every number of a model has one: what is far beyond all machines is a slip of the keyboard, and what follows from
    it would be paths without end.
    """

    least: float
    most: float
    unit: str = ""
    what: str = ""
    """What the range is of, in the plural, such as ``"heights of the orifice"``; empty where the bound needs no reason,
    as for a share."""
    above: bool = False
    """Whether ``least`` itself is refused."""
    below: bool = False
    """Whether ``most`` itself is refused."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Check the number after its type."""
        return core_schema.no_info_after_validator_function(self.check, handler(source))

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """State the bounds, for editors and for the tables of keys."""
        low, high = ("exclusiveMinimum" if self.above else "minimum"), ("exclusiveMaximum" if self.below else "maximum")
        return {**handler(core), low: self.least, high: self.most}

    def check(self, value: float) -> float:
        """Give the value.

        Raises:
            PydanticCustomError: it is out of bounds.
        """
        if value < self.least or (self.above and value == self.least):
            bound = f"{'above' if self.above else 'at least'} {self._with_unit(self.least)}"
        elif value > self.most or (self.below and value == self.most):
            bound = f"{'below' if self.below else 'at most'} {self._with_unit(self.most)}"
        else:
            return value
        reason = (
            f": {self.what} range from {write_number(self.least)} to {self._with_unit(self.most)}" if self.what else ""
        )
        raise PydanticCustomError(OUT_OF_BOUNDS, "out of bounds", {"bound": bound, "reason": reason})

    def _with_unit(self, bound: float) -> str:
        return f"{write_number(bound)} {self.unit}".rstrip()


def write_number(number: float) -> str:
    """Write a bound for people: ``10,000``, ``0.01``, ``1e-06``."""
    return f"{number:,.10g}"


Share: TypeAlias = Annotated[float, Bounds(0, 1)]
Percent: TypeAlias = Annotated[float, Bounds(0, 100)]
Count: TypeAlias = Annotated[int, Bounds(0, 1000)]
Repeats: TypeAlias = Annotated[int, Bounds(1, 1000)]
ToolNumber: TypeAlias = Annotated[int, Bounds(0, 99)]

Coordinate: TypeAlias = Annotated[float, Bounds(-100_000, 100_000, "mm", "places in a cell or on a board")]
Size: TypeAlias = Annotated[float, Bounds(0.001, 100_000, "mm", "sizes of bodies")]
OrificeHeight: TypeAlias = Annotated[float, Bounds(0.1, 1000, "mm", "heights from which a nozzle sprays")]
Distance: TypeAlias = Annotated[float, Bounds(0, 1000, "mm", "distances on a board")]
PositiveDistance: TypeAlias = Annotated[float, Bounds(0.01, 1000, "mm", "distances on a board")]
Offset: TypeAlias = Annotated[float, Bounds(-1000, 1000, "mm", "distances on a board, inwards or outwards,")]

Turn: TypeAlias = Annotated[float, Bounds(-360, 360, "degrees", "directions")]
Tilt: TypeAlias = Annotated[float, Bounds(0, 90, "degrees", below=True)]
HalfAngle: TypeAlias = Annotated[float, Bounds(0.05, 85, "degrees", "half angles of a spray", below=True)]
Spread: TypeAlias = Annotated[float, Bounds(0.01, 45, "degrees", "spreads of a spray's edge")]
CornerAngle: TypeAlias = Annotated[float, Bounds(0, 180, "degrees", above=True)]

Duration: TypeAlias = Annotated[float, Bounds(0, 3600, "s", "pauses and delays")]
Speed: TypeAlias = Annotated[float, Bounds(0.01, 10_000, "mm/s", "speeds of a robot")]
Acceleration: TypeAlias = Annotated[float, Bounds(0.1, 1_000_000, "mm/s²", "accelerations of a robot")]
TurnSpeed: TypeAlias = Annotated[float, Bounds(0.01, 100_000, "degrees/s", "speeds of turning")]
TurnAcceleration: TypeAlias = Annotated[float, Bounds(0.1, 10_000_000, "degrees/s²", "accelerations of turning")]

Pressure: TypeAlias = Annotated[float, Bounds(0.001, 1000, "bar", "pressures of a spray")]
Flow: TypeAlias = Annotated[float, Bounds(0.0001, 10_000, "l/min", "flows through a nozzle")]
Temperature: TypeAlias = Annotated[float, Bounds(-50, 500, "°C", "temperatures of a process")]
Resistivity: TypeAlias = Annotated[float, Bounds(0.0001, 1000, "MΩ·cm", "resistivities of water")]
