"""A robot as a person writes it: its URDF, and the limits that a URDF does not know."""

from pydantic import Field, model_validator

from recipes.recipe import Name
from specs.spec import PositiveFloat, Spec


class JointLimits(Spec):
    """Limits of one joint; what is left out stays as it was. A joint that turns takes degrees, one that slides mm."""

    position_deg: tuple[float, float] | None = Field(default=None, description="Lowest and highest.")
    position_mm: tuple[float, float] | None = Field(default=None, description="Lowest and highest.")
    speed_deg_s: PositiveFloat | None = Field(default=None, description="Greatest.")
    speed_mm_s: PositiveFloat | None = Field(default=None, description="Greatest.")
    acceleration_deg_s2: PositiveFloat | None = Field(default=None, description="Greatest.")
    acceleration_mm_s2: PositiveFloat | None = Field(default=None, description="Greatest.")

    @model_validator(mode="after")
    def _check(self) -> "JointLimits":
        for name in ("position_deg", "position_mm"):
            limits: tuple[float, float] | None = getattr(self, name)
            if limits is not None and limits[0] >= limits[1]:
                raise ValueError(f"{name} gives the lowest position first, then the highest")
        return self


class RobotSpec(Spec):
    """A robot that is not in the library."""

    urdf: str = Field(min_length=1, description="Its URDF; a relative path begins at the file that names it.")
    base_link: str | None = Field(default=None, description="Link that is the base; left out, the root of the URDF.")
    flange_link: str | None = Field(default=None, description="Link that is the flange; left out, the only end.")
    joints: dict[str, JointLimits] = Field(
        default={}, description="By joint, or all; a URDF knows no accelerations, so they are needed here."
    )


class RobotFile(RobotSpec):
    """A robot of the library: one YAML file beside its URDF."""

    robot: Name = Field(description="Name of the robot.")
    description: str = Field(default="", description="What it is.")
    sources: list[str] = Field(default=[], description="Where the numbers come from, and which are assumed.")
