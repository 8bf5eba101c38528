"""What the robot's controller switches and reads, as a person writes it."""

from typing import Literal, TypeAlias

from pydantic import Field

from recipes.recipe import Name
from specs.spec import Spec

Outputs: TypeAlias = dict[Name, float]


class Output(Spec):
    """An output of the controller."""

    kind: Literal["digital", "group", "analog"] = Field(
        description="digital: 0 or 1; group: several bits that hold a whole number; analog: volts or mA."
    )
    number: int = Field(ge=0, le=65535, description="That languages use which number them, such as DO[3].")
    full_scale: float = Field(
        default=10.0, gt=0, description="The most that an analog output carries, in its unit; 20 for one of mA."
    )
    unit: Literal["V", "mA"] = Field(
        default="V", description="Of an analog output. How a language counts volts is not stated here."
    )
    counts: int = Field(
        default=0,
        ge=0,
        description="Its number at full scale in languages of whole ones: FANUC, Denso, Mitsubishi; 0: the usual.",
    )


class Setting(Spec):
    """How a quantity of the recipe is sent to an output."""

    output: Name = Field(description="Under io.outputs.")
    scale: float = Field(default=1.0, description="The output is given scale * quantity + offset, in its unit.")
    offset: float = Field(default=0.0, description="Likewise.")


class Sensor(Spec):
    """An analog input that shows a quantity."""

    input: Name = Field(description="Its name in the controller.")
    number: int = Field(ge=0, le=65535, description="Its number.")
    full_scale: float = Field(default=10.0, gt=0, description="The most that it reads, in its unit; 20 for one of mA.")
    unit: Literal["V", "mA"] = Field(default="V", description="Of the reading.")
    counts: int = Field(
        default=0,
        ge=0,
        description="Its number at full scale in languages of whole ones, as with an output.",
    )
    scale: float = Field(default=1.0, description="The quantity is scale * reading + offset, the reading in its unit.")
    offset: float = Field(default=0.0, description="Likewise.")


class Grip(Spec):
    """What a gripper's commands set."""

    open: Outputs = Field(default={}, description="What GRIP open sets: output and value.")
    close: Outputs = Field(default={}, description="What GRIP close sets: output and value.")


class InputOutput(Spec):
    """The I/O map: what commands of a program mean to the controller."""

    outputs: dict[Name, Output] = Field(default={}, description="By their name in the controller.")
    functions: dict[Name, Outputs] = Field(default={}, description="What FUNCTION NAME sets: output and value.")
    solutions: dict[Name, Outputs] = Field(default={}, description="What SOLUTION NAME sets: output and value.")
    settings: dict[Name, Setting] = Field(
        default={}, description="What SET KEY VALUE sets, by key, such as pressure_bar."
    )
    grip: Grip = Field(default=Grip(), description="What GRIP open and GRIP close set.")
    sensors: dict[Name, Sensor] = Field(
        default={}, description="What shows the quantity of an until, by key, such as resistivity_mohm_cm."
    )
