"""Base of the models of YAML files."""

from typing import Annotated, TypeAlias

from pydantic import BaseModel, ConfigDict, Field


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


PositiveFloat: TypeAlias = Annotated[float, Field(gt=0)]
NonNegativeFloat: TypeAlias = Annotated[float, Field(ge=0)]
