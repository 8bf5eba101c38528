"""The ``operate`` block of a cell's file: how a controller is fed node by node, and what has to hold meanwhile."""

from typing import Annotated, Literal, TypeAlias

from pydantic import ConfigDict, Field, model_validator

from specs.spec import Bounds, Name, Spec

Port: TypeAlias = Annotated[int, Bounds(1, 65535)]
StreamNumber: TypeAlias = Annotated[int, Bounds(0, 7)]
Unit: TypeAlias = Annotated[int, Bounds(0, 255)]
Register: TypeAlias = Annotated[int, Bounds(0, 65_000)]
Watchdog: TypeAlias = Annotated[float, Bounds(0.02, 10, "s", "times of a watchdog")]
Acknowledge: TypeAlias = Annotated[float, Bounds(0.02, 60, "s", "times for an acknowledgement")]
Patience: TypeAlias = Annotated[float, Bounds(0.1, 3000, "s", "time-outs")]
Queue: TypeAlias = Annotated[int, Bounds(1, 10_000, "nodes", "queues of a controller")]
Routine: TypeAlias = Annotated[int, Bounds(100, 65_535, what="numbers of a routine")]


class CellPart(Spec):
    """A part of a cell's file; the docstring under each key is its description in the schema and the tables."""

    model_config = ConfigDict(use_attribute_docstrings=True)


class ModbusLink(CellPart):
    """Modbus TCP: orders and status as blocks of holding registers."""

    kind: Literal["modbus"] = "modbus"
    """Modbus TCP; needs the extra `operate`."""
    host: str = Field(min_length=1, max_length=253)
    """Address of the controller."""
    port: Port = 502
    """Its port."""
    unit: Unit = 1
    """Its unit identifier."""
    orders_at: Register = 0
    """First holding register of the orders, which are written."""
    status_at: Register = 200
    """First holding register of the status, which is read."""


class OpcuaLink(CellPart):
    """OPC UA: orders and status as variables of one object."""

    kind: Literal["opcua"] = "opcua"
    """OPC UA; needs the extra `operate`."""
    url: str = Field(min_length=1, max_length=1000, pattern=r"^opc\.tcp://")
    """Endpoint, such as opc.tcp://10.0.0.5:4840."""
    namespace: str = Field(default="urn:washboard", min_length=1)
    """URI of the object's namespace."""
    object: Name = "Washboard"
    """Browse name of the object under Objects."""


class LinuxcncLink(CellPart):
    """LinuxCNC's real-time layer on this machine: joints are streamed into HAL in every servo cycle."""

    kind: Literal["linuxcnc"] = "linuxcnc"
    """LinuxCNC's HAL on this machine."""
    python: str = Field(default="/usr/bin/python3", min_length=1)
    """Python that has LinuxCNC's module `hal`."""
    streamer: StreamNumber = 0
    """Number of the HAL component `streamer` that is fed."""


LinkSpec: TypeAlias = Annotated[ModbusLink | OpcuaLink | LinuxcncLink, Field(discriminator="kind")]


class Condition(CellPart):
    """A digital input and the state in which a condition is met."""

    input: Name
    """Under io.inputs."""
    state: Literal[0, 1] = 1
    """State in which it is met."""
    message: str = Field(default="", max_length=60)
    """What is shown where it is not met; left out, its name."""


class OperateSensors(CellPart):
    """The sensors that gate an operation."""

    part_present: Condition
    """The board is in its place; held from the start to the end."""
    home: Condition | None = None
    """The robot stands at home; needed before the first node."""
    homed: Condition | None = None
    """The robot's axes know where they are; held while it moves along the program."""
    end: Condition | None = None
    """The end of the trajectory; needed after the last node."""


class OperateSpec(CellPart):
    """How `washboard operate` feeds the controller: the link, interlocks, sensors and time-outs."""

    link: LinkSpec
    """To the controller."""
    interlocks: dict[Name, Condition] = Field(min_length=1)
    """By name, such as emergency_stop: no jet while one of them is not met."""
    sensors: OperateSensors
    """Proximity sensors."""
    routines: dict[Name, Routine] = Field(default={})
    """Number of the controller's routine for CALL NAME; up to 99 are changes of the tool."""
    queue: Queue = 50
    """Nodes that the controller holds ahead of the one it has reached."""
    watchdog_s: Watchdog = 0.1
    """The controller shuts every valve when no order came for so long."""
    acknowledge_s: Acknowledge = 1.0
    """Longest time until a node is acknowledged."""
    part_s: Patience = 60.0
    """Longest wait for the part."""
    home_s: Patience = 60.0
    """Longest wait for home, and for the end of the trajectory."""

    @model_validator(mode="after")
    def _check(self) -> "OperateSpec":
        taken: dict[int, str] = {}
        for name, number in self.routines.items():
            if (other := taken.setdefault(number, name)) != name:
                raise ValueError(f"routines {other} and {name} have the same number")
        for name in self.interlocks:
            if name in OperateSensors.model_fields:
                raise ValueError(f"{name} is the name of a sensor; give the interlock another")
        if isinstance(self.link, ModbusLink) and abs(self.link.orders_at - self.link.status_at) < 130:
            raise ValueError("orders_at and status_at are at least 130 registers apart")
        return self

    @property
    def conditions(self) -> dict[str, Condition]:
        """All conditions by name: interlocks, then sensors."""
        sensors = {name: getattr(self.sensors, name) for name in OperateSensors.model_fields}
        return {**self.interlocks, **{name: each for name, each in sensors.items() if each is not None}}
