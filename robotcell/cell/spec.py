"""What a person writes about a cell: robot, board's place, tools, fixtures, channels. Millimetres and degrees."""

from typing import Annotated, TypeAlias

from pydantic import Field, model_validator

from recipes.recipe import Name
from robotcell.cell.io_spec import InputOutput
from robotcell.cell.robot_spec import JointLimits, RobotSpec
from robotcell.cell.shape_spec import BodySpec, Place, Point
from specs.spec import NonNegativeFloat, PositiveFloat, Spec

ToolNumber: TypeAlias = Annotated[int, Field(ge=0, le=99)]


class PointPair(Spec):
    """One point of the board and where it was measured in the cell."""

    board_mm: Point = Field(description="As the board file has it: x, y, z.")
    cell_mm: Point = Field(description="Where the robot, or a measuring arm, found it in the cell.")


class Touched(Spec):
    """Three places on the board that were touched, as a work object is taught."""

    origin_mm: Point = Field(description="In the cell: the point that board_mm tells.")
    on_x_mm: Point = Field(description="In the cell: a point of the board straight along its +x from the first.")
    on_xy_mm: Point = Field(description="In the cell: a point of the board's top on the side of its +y.")
    board_mm: Point = Field(default=(0, 0, 0), description="The first point, as the board file has it.")


class Hold(Spec):
    """Where the board's own frame, that of its CAD file, is in the cell: one of pose, points, touched."""

    pose: Place | None = Field(default=None, description="Stated as it is.")
    points: list[PointPair] | None = Field(
        default=None, min_length=3, max_length=3, description="Three points, on the board and measured in the cell."
    )
    touched: Touched | None = Field(default=None, description="Origin, a point along +x, a point on the side of +y.")
    largest_residual_mm: PositiveFloat = Field(
        default=0.5, description="How far measured points may lie from where they should be."
    )

    @model_validator(mode="after")
    def _check(self) -> "Hold":
        if sum(each is not None for each in (self.pose, self.points, self.touched)) != 1:
            raise ValueError("give exactly one of pose, points, touched")
        return self


class ToolSpec(Spec):
    """What the flange carries while a nozzle is used."""

    name: Name = Field(description="Such as cone, knife, gripper.")
    tcp: Place = Field(
        description="The orifice on the flange: +z along the jet, +x its reference azimuth (a slot's long way)."
    )
    bodies: dict[Name, BodySpec] = Field(default={}, description="Nozzle body, holder, hose: what can collide.")
    mass_kg: PositiveFloat = Field(default=1.0, description="Of the tool, for the controller's load data.")


class NozzleSpec(Spec):
    """What the cell must know of a nozzle of the recipe."""

    valve: Name = Field(description="Output under io.outputs that opens it.")
    open_lag_s: NonNegativeFloat = Field(default=0.04, description="From the signal to the full jet.")
    close_lag_s: NonNegativeFloat = Field(default=0.02, description="From the signal to no jet.")
    min_pulse_s: NonNegativeFloat = Field(default=0.0, description="The valve follows no shorter signal.")
    round: bool = Field(
        default=False, description="True if the jet is the same all around: the robot may turn it about its axis."
    )


class CellSpec(Spec):
    """A robot cell: one YAML file."""

    cell: Name = Field(description="Name of the cell.")
    description: str = Field(default="", description="What it is, for the engineer who chooses it.")
    robot: str | RobotSpec = Field(description="A robot of the library by name, or a URDF with its limits.")
    base: Place = Field(default=Place(), description="Where the robot's base stands in the cell.")
    joints: dict[str, JointLimits] = Field(
        default={}, description="Limits that are tighter than the robot's own, by joint; all means every joint."
    )
    home_deg_mm: list[float] = Field(
        description="Where a program begins and ends: a number for each joint, degrees or, where it slides, mm."
    )
    board: Hold = Field(description="Where the board is held.")
    placements: dict[Name, Hold] = Field(
        default={}, description="Where the board is after CALL NAME, such as flip_to_bottom."
    )
    tools: dict[ToolNumber, ToolSpec] = Field(min_length=1, description="By the number that a nozzle's `tool` names.")
    fixtures: dict[Name, BodySpec] = Field(default={}, description="What stands in the cell: table, holder, walls.")
    margin_mm: NonNegativeFloat = Field(
        default=5.0, description="That every body of robot and tool keeps from board and fixtures."
    )
    nozzles: dict[Name, NozzleSpec] = Field(default={}, description="By the nozzle's name in the recipe.")
    io: InputOutput = Field(default=InputOutput(), description="What the robot's controller switches and reads.")
