"""The cell and robot files as written: robot, board's pose, tools, fixtures, channels. Millimetres and degrees."""

from typing import Annotated, Literal, TypeAlias

from pydantic import BeforeValidator, Field, model_validator

from programs.motion.installation import Maker
from robotcell.cell.operate_spec import CellPart, OperateSpec
from specs.spec import (
    Acceleration,
    Bounds,
    Coordinate,
    Distance,
    Duration,
    Name,
    PositiveDistance,
    Size,
    ToolNumber,
    Turn,
    TurnAcceleration,
    TurnSpeed,
)

Point: TypeAlias = tuple[Coordinate, Coordinate, Coordinate]
Turns: TypeAlias = tuple[Turn, Turn, Turn]
Sizes: TypeAlias = tuple[Size, Size, Size]
JointAngle: TypeAlias = Annotated[float, Bounds(-36_000, 36_000, "degrees", "positions of a joint that turns")]
JointSpeed: TypeAlias = Annotated[float, Bounds(0.001, 100_000, "mm/s", "speeds of a joint that slides")]
JointAcceleration: TypeAlias = Annotated[
    float, Bounds(0.1, 10_000_000, "mm/s²", "accelerations of a joint that slides")
]
HoseTurns: TypeAlias = Annotated[float, Bounds(0.25, 100, "turns", "turns of a hose")]
Home: TypeAlias = Annotated[float, Bounds(-100_000, 100_000, "degrees or mm", "positions of a joint")]
FileUnit: TypeAlias = Annotated[float, Bounds(1e-6, 1e6, "mm", "units of a file")]
Mass: TypeAlias = Annotated[float, Bounds(0.0001, 10_000, "kg", "masses of a tool")]
Inertia: TypeAlias = Annotated[float, Bounds(0, 1000, "kg m²", "moments of inertia of a tool")]
ChannelNumber: TypeAlias = Annotated[int, Bounds(0, 65535)]
ChannelCounts: TypeAlias = Annotated[int, Bounds(0, 2**32, what="counts of a channel")]
FullScale: TypeAlias = Annotated[float, Bounds(0.001, 1000, "V or mA", "full scales of a channel")]
Timeout: TypeAlias = Annotated[float, Bounds(1, 3000, "s", "time-outs")]
Signal: TypeAlias = Annotated[float, Bounds(-1_000_000, 1_000_000, what="values, scales and offsets of a channel")]
JointShare: TypeAlias = Annotated[float, Bounds(0.001, 1, what="shares of a joint's speed")]
LookAhead: TypeAlias = Annotated[int, Bounds(1, 100_000, "lines", "look-aheads of a controller")]
Positions: TypeAlias = Annotated[int, Bounds(200, 10_000_000, what="positions of a file")]
Length: TypeAlias = Annotated[int, Bounds(1, 10**12, what="lengths of a file")]
Outputs: TypeAlias = dict[Name, Signal]
HeldBy: TypeAlias = Literal["front_left", "front_right", "back_left", "back_right", "centre", "origin"]
HELD_BY: HeldBy = "front_left"
"""Where a file does not state it: what the library's cells have always meant."""


class Place(CellPart):
    """A pose: a position and a rotation about fixed axes, as in URDF."""

    xyz_mm: Point = (0, 0, 0)
    """Position."""
    rpy_deg: Turns = (0, 0, 0)
    """Turned about x, then y, then z of the frame it stands in: roll, pitch, yaw."""


class BoxSpec(CellPart):
    """A box, centred on its pose."""

    kind: Literal["box"] = "box"
    """A box."""
    size_mm: Sizes
    """Along x, y, z."""
    at: Place = Place()
    """Pose of its centre."""


class CapsuleSpec(CellPart):
    """A rod with round ends."""

    kind: Literal["capsule"] = "capsule"
    """A rod with round ends."""
    from_mm: Point
    """Centre of one round end."""
    to_mm: Point
    """Centre of the other."""
    radius_mm: Size
    """Of the rod and its ends."""


class CylinderSpec(CellPart):
    """A rod with flat ends."""

    kind: Literal["cylinder"] = "cylinder"
    """A rod with flat ends."""
    from_mm: Point
    """Centre of one flat end."""
    to_mm: Point
    """Centre of the other."""
    radius_mm: Size
    """Of the rod."""


class HoseSpec(CellPart):
    """A hose, or the space that it needs, along a line of points."""

    kind: Literal["hose"] = "hose"
    """A hose, or the space that it needs."""
    along_mm: list[Point] = Field(min_length=2, max_length=50)
    """Points on its centre line."""
    radius_mm: Size
    """Of the hose with all its sway."""


class MeshSpec(CellPart):
    """Triangles of a file."""

    kind: Literal["mesh"] = "mesh"
    """Triangles of a file."""
    file: str = Field(min_length=1)
    """STL, OBJ, PLY or STEP; a relative path begins at the cell's file."""
    mm_per_unit: FileUnit = 1.0
    """1000 for a file in metres; STEP states its own unit."""
    at: Place = Place()
    """Pose of the file's own frame."""


BodySpec: TypeAlias = Annotated[BoxSpec | CapsuleSpec | CylinderSpec | HoseSpec | MeshSpec, Field(discriminator="kind")]


class JointLimits(CellPart):
    """Limits of one joint; what is left out stays as it was. A joint that turns takes degrees, one that slides mm."""

    position_deg: tuple[JointAngle, JointAngle] | None = None
    """Lowest and highest."""
    position_mm: tuple[Coordinate, Coordinate] | None = None
    """Lowest and highest."""
    speed_deg_s: TurnSpeed | None = None
    """Greatest."""
    speed_mm_s: JointSpeed | None = None
    """Greatest."""
    acceleration_deg_s2: TurnAcceleration | None = None
    """Greatest."""
    acceleration_mm_s2: JointAcceleration | None = None
    """Greatest."""

    @model_validator(mode="after")
    def _check(self) -> "JointLimits":
        for name in ("position_deg", "position_mm"):
            limits: tuple[float, float] | None = getattr(self, name)
            if limits is not None and limits[0] >= limits[1]:
                raise ValueError(f"{name} gives the lowest position first, then the highest")
        return self


class ControllerJoint(CellPart):
    """How a controller counts one joint: sign * its value here, plus zero, plus shares of other joints' values here."""

    sign: Literal[1, -1] = 1
    """-1 where the controller counts the other way round."""
    zero_deg: JointAngle = 0.0
    """What it shows where the joint is at 0 here, if it turns."""
    zero_mm: Coordinate = 0.0
    """The same, if it slides."""
    plus: dict[str, Literal[1, -1]] = Field(default={})
    """Other joints that are added to it or subtracted: {joint_2: -1} for J3 of FANUC."""


class DhJoint(CellPart):
    """One joint of a table of Denavit-Hartenberg parameters, as the maker prints them."""

    name: Name
    """Of the joint; limits go by it."""
    kind: Literal["revolute", "prismatic"] = "revolute"
    """It turns about z, or slides along."""
    theta_deg: Turn = 0.0
    """Turn about z where the joint is at 0."""
    d_mm: Coordinate = 0.0
    """Way along z where the joint is at 0."""
    a_mm: Coordinate = 0.0
    """Way along x."""
    alpha_deg: Turn = 0.0
    """Turn about x."""
    radius_mm: Size
    """Of the rods around d and a that stand for the arm in collision checks."""


class DhSpec(CellPart):
    """A robot as a table of Denavit-Hartenberg parameters."""

    name: Name = "arm"
    """Name of the robot."""
    convention: Literal["standard", "modified"]
    """standard: a step is Rz Tz Tx Rx; modified, that of Craig: Rx Tx Rz Tz."""
    table: list[DhJoint] = Field(min_length=1, max_length=12)
    """The joints, base first."""
    flange: Place = Place()
    """Pose of the flange in the frame that the table ends in."""


class RobotSpec(CellPart):
    """A robot that is not in the library: a URDF, or a table of Denavit-Hartenberg parameters."""

    urdf: str | None = Field(default=None, min_length=1)
    """Its URDF; a relative path begins at the file that names it."""
    dh: DhSpec | None = None
    """Or its table of Denavit-Hartenberg parameters."""
    base_link: str | None = None
    """Link that is the base; left out, the root of the URDF."""
    flange_link: str | None = None
    """Link that is the flange; left out, the only end."""
    joints: dict[str, JointLimits] = Field(default={})
    """By joint, or all; a URDF has no accelerations, a table no limits at all: they are needed here."""
    maker: Maker | None = None
    """Whose controller it has: joint values are written in languages of that maker only."""
    controller_joints: Literal["same"] | dict[str, ControllerJoint] | None = None
    """How the controller counts the joints: same as here, or by joint what differs; goes with maker."""

    @model_validator(mode="after")
    def _check(self) -> "RobotSpec":
        if (self.urdf is None) == (self.dh is None):
            raise ValueError("give exactly one of urdf, dh")
        if self.dh is not None and (self.base_link is not None or self.flange_link is not None):
            raise ValueError("base_link and flange_link go with urdf")
        if self.maker not in (None, "other") and self.controller_joints is None:
            raise ValueError(
                "maker goes with controller_joints: same, if the controller shows the joints as the URDF counts them, "
                "or what differs by joint, such as {joint_3: {plus: {joint_2: -1}}}"
            )
        if self.maker is None and self.controller_joints is not None:
            raise ValueError("controller_joints goes with maker: state whose controller counts them so")
        return self


class RobotFile(RobotSpec):
    """A robot of the library: one YAML file beside its URDF."""

    robot: Name
    """Name of the robot."""
    description: str = ""
    """Short description."""
    sources: list[str] = Field(default=[])
    """Sources of the numbers, and which are assumed."""


class Output(CellPart):
    """An output of the controller."""

    kind: Literal["digital", "group", "analog"]
    """digital: 0 or 1; group: several bits that hold a whole number; analog: volts or mA."""
    number: ChannelNumber
    """For languages that number outputs, such as DO[3]."""
    full_scale: FullScale = 10.0
    """Full scale of an analog output, in its unit; 20 for one of mA."""
    unit: Literal["V", "mA"] = "V"
    """Of an analog output. How a language counts volts is not stated here."""
    counts: ChannelCounts = 0
    """Count at full scale in languages with integer channels: FANUC, Denso, Mitsubishi; 0: the usual."""


class OutputSetting(CellPart):
    """How a quantity of the recipe is sent to an output."""

    output: Name
    """Under io.outputs."""
    scale: Signal = 1.0
    """The output carries scale * quantity + offset, in its unit."""
    offset: Signal = 0.0
    """Likewise."""


class Sensor(CellPart):
    """An analog input that measures a quantity."""

    input: Name
    """Its name in the controller."""
    number: ChannelNumber
    """Its number."""
    full_scale: FullScale = 10.0
    """Full scale, in its unit; 20 for one of mA."""
    unit: Literal["V", "mA"] = "V"
    """Of the reading."""
    counts: ChannelCounts = 0
    """Count at full scale in languages with integer channels, as for an output."""
    scale: Signal = 1.0
    """The quantity is scale * reading + offset, the reading in its unit."""
    offset: Signal = 0.0
    """Likewise."""


class DigitalInput(CellPart):
    """A digital input of the controller."""

    number: ChannelNumber
    """For languages that number inputs, such as DI[3]."""


class Wait(CellPart):
    """A condition that a program waits for before the robot moves: an input's state, or a least value of a quantity."""

    input: Name | None = None
    """Under io.inputs; or give sensor and least."""
    state: Literal[0, 1] = 1
    """State of the input to wait for."""
    sensor: Name | None = None
    """Under io.sensors."""
    least: Signal | None = None
    """Least value of the sensor's quantity, in its unit."""
    timeout_s: Timeout = 30.0
    """After so long the program shows the message and ends."""
    message: str = Field(default="", max_length=60)
    """What it shows then; left out, the name of the wait."""
    watched: bool = False
    """Whether the program also stops, valves shut, when the input leaves that state."""

    @model_validator(mode="after")
    def _check(self) -> "Wait":
        if (self.input is None) == (self.sensor is None):
            raise ValueError("give an input, with its state, or a sensor, with its least value")
        if (self.sensor is None) != (self.least is None):
            raise ValueError("sensor and least go together")
        if self.sensor is not None and (self.watched or "state" in self.model_fields_set):
            raise ValueError("state and watched go with an input; a sensor has a least value")
        return self


class Grip(CellPart):
    """Outputs set by a gripper's commands."""

    open: Outputs = Field(default={})
    """Outputs set by GRIP open: output and value."""
    close: Outputs = Field(default={})
    """Outputs set by GRIP close: output and value."""


class Handshake(CellPart):
    """Signals between a program and the line that brings what is washed; those that it has."""

    start: Name | None = None
    """Digital input, under io.inputs, that starts a cycle: the program waits for it before anything else."""
    busy: Name | None = None
    """Digital output that is on from the first motion to the last."""
    done: Name | None = None
    """Digital output that is on at the end, until part_present of io.waits is as before the part came."""
    fault: Name | None = None
    """Digital output that is on where the program stops itself, until it is started again."""


class InputOutput(CellPart):
    """The I/O map: from a program's commands to the controller's channels."""

    outputs: dict[Name, Output] = Field(default={})
    """By their name in the controller."""
    functions: dict[Name, Outputs] = Field(default={})
    """Outputs set by FUNCTION NAME: output and value."""
    solutions: dict[Name, Outputs] = Field(default={})
    """Outputs set by SOLUTION NAME: output and value."""
    settings: dict[Name, OutputSetting] = Field(default={})
    """Outputs set by SET KEY VALUE, by key, such as pressure_bar."""
    grip: Grip = Grip()
    """Outputs set by GRIP open and GRIP close."""
    sensors: dict[Name, Sensor] = Field(default={})
    """Inputs that measure a quantity, of an until or a wait, by key, such as resistivity_mohm_cm."""
    inputs: dict[Name, DigitalInput] = Field(default={})
    """Digital inputs, by their name in the controller."""
    handshake: Handshake = Handshake()
    """Signals to and from the line; left out, a program has none of them."""
    first_run_lamp: Name | None = None
    """Digital output that a first run switches in place of the valves; left out, nothing shows where jets would be."""
    waits: dict[Name, Wait] = Field(default={})
    """Conditions for the start, in their order: part_present, door_closed, temperature, pressure, and any others."""


class PointPair(CellPart):
    """One point of the board and where it was measured in the cell."""

    board_mm: Point
    """In the board file: x, y, z."""
    cell_mm: Point
    """Where the robot, or a measuring arm, found it in the cell."""


class Touched(CellPart):
    """Three points on the board that were touched, as a work object is taught."""

    origin_mm: Point
    """In the cell: the point given by board_mm."""
    on_x_mm: Point
    """In the cell: a point of the board straight along its +x from the first."""
    on_xy_mm: Point
    """In the cell: a point of the board's top on the side of its +y."""
    board_mm: Point | None = None
    """The first point, in the board file; left out, the point that `hold` names."""


class Hold(CellPart):
    """Where the board is held in the cell: one of pose, points, touched. Axes are those of its CAD file."""

    hold: HeldBy = Field(
        default=HELD_BY,
        description="Point of the board that pose and touched place: a corner or the centre of the rectangle around "
        "its outline, on its top surface, named as seen from the top, also of a board that was turned over; or the "
        "origin of its file.",
    )
    pose: Place | None = None
    """The pose of that point, with the axes of the board's file."""
    points: list[PointPair] | None = Field(default=None, min_length=2, max_length=100)
    """Fiducials or corners, on the board and measured in the cell: two, three or more."""
    fit: Literal["rigid", "scaled", "affine"] = Field(
        default="rigid",
        description="Whether the board has kept its size, is larger or smaller, or stretched and sheared in its plane. "
        "The stretch is found so that it does not spoil the place; the program is not stretched.",
    )
    normal: Point | None = None
    """Of two points: direction of the board's +z in the cell; left out, straight up."""
    noise_mm: PositiveDistance = 0.05
    """Standard deviation of one coordinate of a measured point, for the stated accuracy."""
    touched: Touched | None = None
    """Origin, a point along +x, a point on the side of +y."""
    largest_residual_mm: PositiveDistance = 0.5
    """Largest distance of a measured point from where the fit puts it."""

    @model_validator(mode="after")
    def _check(self) -> "Hold":
        if sum(each is not None for each in (self.pose, self.points, self.touched)) != 1:
            raise ValueError("give exactly one of pose, points, touched")
        count = len(self.points or ())
        if count < 3 and self.fit == "affine":
            raise ValueError("an affine fit needs three points or more")
        if self.normal is not None and (count != 2 or not any(self.normal)):
            raise ValueError("give normal, not all zero, with two points and leave it out otherwise")
        if self.points is None and self.fit != "rigid":
            raise ValueError("fit is for points")
        if "hold" in self.model_fields_set and self.is_measured:
            raise ValueError("leave out hold: the points state where they are on the board")
        return self

    @property
    def is_measured(self) -> bool:
        """Whether points were measured whose coordinates in the board's file are given."""
        return self.points is not None or (self.touched is not None and self.touched.board_mm is not None)

    @property
    def held_by(self) -> HeldBy:
        """The point of the board that is placed."""
        return "origin" if self.is_measured else self.hold


class ToolSpec(CellPart):
    """The tool on the flange while a nozzle is used."""

    name: Name
    """Such as cone, knife, gripper."""
    tcp: Place
    """The orifice on the flange: +z along the jet, +x its reference azimuth (a slot's long way)."""
    bodies: dict[Name, BodySpec] = Field(default={})
    """Collision bodies: nozzle body, holder, hose."""
    mass_kg: Mass = 1.0
    """Of the tool with hose and cables, for the controller's load data; where it is stated programs select it."""
    centre_mm: Point | None = None
    """Centre of gravity on the flange; left out, half way to the orifice along the flange's z is assumed."""
    inertia_kg_m2: tuple[Inertia, Inertia, Inertia] | None = None
    """Moments of inertia about axes along the flange's through that centre; left out, 0."""


class ToolChangeRoutine(CellPart):
    """A routine of the controller that changes tools."""

    routine: Name
    """Beginning of its name: NAME_2 mounts tool 2, and returns when that is on the flange."""


class NozzleSpec(CellPart):
    """The cell's side of a nozzle of the recipe."""

    valve: Name
    """Output under io.outputs that opens it."""
    open_lag_s: Duration = 0.04
    """From the signal to the full jet."""
    close_lag_s: Duration = 0.02
    """From the signal to no jet."""
    min_pulse_s: Duration = 0.0
    """Shortest signal that the valve follows."""
    round: bool = False
    """True if the jet is the same all around: the robot may turn it about its axis."""


class ControllerSpec(CellPart):
    """What is known of the cell's own controller, for the prediction of times; what is left out stays as it was."""

    acceleration_mm_s2: Acceleration | None = None
    """Greatest, of the orifice."""
    rise_s: Duration | None = None
    """Time in which an acceleration builds up."""
    turn_speed_deg_s: TurnSpeed | None = None
    """Greatest, of the tool."""
    turn_acceleration_deg_s2: TurnAcceleration | None = None
    """Greatest, of the tool."""
    joint_speed_share: JointShare | None = None
    """Of the joints' greatest speeds, in joint motions that state none."""
    settle_s: Duration | None = None
    """From a stop until the next motion begins."""
    look_ahead: LookAhead | None = None
    """Lines planned after the one that runs: within them it must be able to stop."""
    least_line_s: Duration | None = None
    """Shortest time of a line."""
    most_positions: Positions | None = None
    """Motions that a file may have: longer programs are divided."""
    most_lines: Length | None = None
    """Lines of text that a file may have."""
    most_bytes: Length | None = None
    """Bytes that a file may have."""
    source: str = Field(default="the cell", min_length=1)
    """Where these numbers come from."""


def _refuse_tables(value: object) -> object:
    """Refuse the kinematics of machines whose table turns the board.

    Raises:
        ValueError: the value names them.
    """
    if value in ("xyzbc-trt", "xyzbc-trt-kins"):
        raise ValueError(
            "a table that tilts the board is no cell: here the board rests while the tool moves; use 5axiskins where "
            "the head tilts, or wash on a robot that turns the tool"
        )
    return value


class CellSpec(CellPart):
    """A robot cell: one YAML file."""

    cell: Name
    """Name of the cell."""
    description: str = ""
    """Short description, for the engineer who chooses it."""
    robot: str | RobotSpec
    """A robot of the library by name, or a URDF or a DH table with limits."""
    base: Place = Place()
    """Pose of the robot's base in the cell."""
    joints: dict[str, JointLimits] = Field(default={})
    """Limits that are tighter than the robot's own, by joint; all means every joint."""
    hose_turns: HoseTurns = Field(
        default=1.5,
        description="Whole turns that the hose allows each joint either way from 0, where it hangs unwound; only where "
        "the joint's own limits are wider.",
    )
    home_deg_mm: list[Home]
    """Joints at the beginning and end of a program: a number for each, degrees or, where it slides, mm."""
    tool_change_deg_mm: list[Home] | None = None
    """Joints where the tool is changed, away from the board; left out, those of home."""
    at_tool_change: Literal["stop"] | ToolChangeRoutine = Field(
        default="stop",
        description="What a robot's program does where it needs another tool, and before its first motion if it uses "
        "several. stop: it stops with a message that names the tool, and goes on when it is started again. "
        "{routine: mount}: it calls mount_2 of the controller to have tool 2 mounted. In G-code both are T2 M6.",
    )
    board: Hold
    """Pose of the board."""
    placements: dict[Name, Hold] = Field(default={})
    """Pose of the board after CALL NAME, such as flip_to_bottom."""
    kinematics: Annotated[Literal["trivial", "5axiskins"], BeforeValidator(_refuse_tables)] = Field(
        default="trivial",
        description="Kinematics of a machine that is programmed in G-code. trivial: each axis is a joint. 5axiskins: "
        "tool points, in LinuxCNC by the module of that name; joints X, Y, Z slide along the base's axes, C turns "
        "about z, B tilts the tool across C.",
    )
    tools: dict[ToolNumber, ToolSpec] = Field(min_length=1)
    """By the number that a nozzle's `tool` names."""
    fixtures: dict[Name, BodySpec] = Field(default={})
    """Bodies that stand in the cell: table, holder, walls."""
    margin_mm: Distance = 5.0
    """Distance that every body of robot and tool keeps from board and fixtures."""
    nozzles: dict[Name, NozzleSpec] = Field(default={})
    """By the nozzle's name in the recipe."""
    controller: ControllerSpec = ControllerSpec()
    """Numbers of the robot's controller in place of those that are assumed."""
    io: InputOutput = InputOutput()
    """Outputs and inputs of the robot's controller."""
    operate: OperateSpec | None = None
    """How `washboard operate` feeds the robot's controller node by node."""
