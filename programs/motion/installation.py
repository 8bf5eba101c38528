"""What a robot program must know of the cell it runs in: frames, tools, valves, channels. Millimetres, seconds."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from programs.pose import IDENTITY, Pose, Position

ChannelKind: TypeAlias = Literal["digital", "group", "analog"]
AnalogUnit: TypeAlias = Literal["V", "mA"]
JointKind: TypeAlias = Literal["revolute", "prismatic"]
Maker: TypeAlias = Literal[
    "abb", "denso", "epson", "fanuc", "kuka", "mitsubishi", "staubli", "universal-robots", "yaskawa", "other"
]
"""Whose controller a robot has; ``other`` is none of those whose languages are written."""
MAKER_NAMES: Mapping[str, str] = {
    "abb": "ABB",
    "denso": "DENSO",
    "epson": "Epson",
    "fanuc": "FANUC",
    "kuka": "KUKA",
    "mitsubishi": "Mitsubishi",
    "staubli": "Staubli",
    "universal-robots": "Universal Robots",
    "yaskawa": "Yaskawa",
    "other": "another maker",
}
"""As messages and reports write them; ASCII."""


@dataclass(frozen=True, slots=True)
class Channel:
    """One output of the controller, by the name and the number that its I/O configuration gives it."""

    kind: ChannelKind
    name: str
    """For languages that call signals by name, such as ``doWash``."""
    number: int
    """For languages that number them, such as ``DO[3]``."""
    full_scale: float = 10.0
    """Largest value of an analog channel, in its unit; how a language counts that is up to its post."""
    unit: AnalogUnit = "V"
    """Of an analog channel."""
    counts: int = 0
    """Its number at full scale in languages of whole numbers; 0 for what is usual in the language."""

    def is_called(self, label: str) -> bool:
        """Whether a text means it: by its name, or by kind and number."""
        return label.lower() in (self.name.lower(), f"{self.kind} {self.number}")


@dataclass(frozen=True, slots=True)
class Assignment:
    """An output and the value it is given: 0 or 1, a whole number, or an analog channel's volts or mA."""

    channel: Channel
    value: float


@dataclass(frozen=True, slots=True)
class Setting:
    """The output that carries a quantity of the recipe: ``scale * quantity + offset``, in volts or mA if analog."""

    channel: Channel
    scale: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class Sensor:
    """The analog input that shows a quantity: ``scale * reading + offset``, the reading in its unit."""

    name: str
    number: int
    scale: float = 1.0
    offset: float = 0.0
    full_scale: float = 10.0
    """Largest reading, in its unit."""
    unit: AnalogUnit = "V"
    counts: int = 0
    """As with an output."""


@dataclass(frozen=True, slots=True)
class Contact:
    """A digital input of the controller."""

    name: str
    number: int


@dataclass(frozen=True, slots=True)
class Wait:
    """A condition that a program waits for before the robot moves: a contact's state, or a sensor's least value."""

    name: str
    contact: Contact | None
    """Either a contact or a sensor."""
    state: bool
    """Of the contact."""
    sensor: Sensor | None
    least: float
    """Of the quantity that the sensor shows."""
    timeout_s: float
    message: str = ""
    """What the controller shows when that is over; empty for the name."""
    watched: bool = False
    """Whether the program also stops when the contact leaves its state."""
    quantity: str = ""
    """The key of what the sensor shows, such as ``supply_bar``."""

    @property
    def words(self) -> str:
        """The name in words."""
        return self.name.replace("_", " ")

    @property
    def shown(self) -> str:
        """What the controller shows."""
        return self.message or f"no {self.words}"


USUAL_WAITS = ("part_present", "door_closed", "temperature", "pressure")
"""What a production program waits for; a header states which of them it does not."""


@dataclass(frozen=True, slots=True)
class Valve:
    """The output that opens a nozzle, and how the jet follows it."""

    channel: Channel
    open_lag_s: float
    """From the signal to the full jet."""
    close_lag_s: float
    """From the signal to no jet."""
    min_pulse_s: float = 0.0
    """The valve follows no signal, on or off, that is shorter."""


@dataclass(frozen=True, slots=True)
class Payload:
    """What a tool weighs, for the controller's load data."""

    mass_kg: float = 1.0
    centre_mm: Position | None = None
    """Of gravity, on the flange; ``None`` for half way to the orifice."""
    inertia_kg_m2: Position = (0.0, 0.0, 0.0)
    """About axes along the flange's, through the centre."""
    is_stated: bool = False
    """Whether the cell states it; if not, only languages that cannot do without have it."""


@dataclass(frozen=True, slots=True)
class Handshake:
    """Signals between a program and the line; ``None`` for those that there are not."""

    start: Contact | None = None
    """Starts a cycle."""
    busy: Channel | None = None
    done: Channel | None = None
    fault: Channel | None = None
    present: Contact | None = None
    """Shows that what is washed is there, by the ``state`` that it has then."""
    state: bool = True


@dataclass(frozen=True, slots=True)
class Tool:
    """A nozzle on the flange."""

    name: str
    T_flange_tcp: Pose
    """The orifice: +Z along the jet, +X the nozzle's reference azimuth."""
    payload: Payload = Payload()

    @property
    def centre_mm(self) -> Position:
        """Centre of gravity on the flange; half way to the orifice where it is not known."""
        return self.payload.centre_mm or (0.0, 0.0, 0.5 * self.T_flange_tcp.position[2])


@dataclass(frozen=True, slots=True)
class Joint:
    """A moving joint; angles in radians, lengths in millimetres."""

    name: str
    kind: JointKind
    speed: float = math.inf
    """Greatest, rad/s or mm/s; infinite if not known."""
    acceleration: float = math.inf
    """Greatest, rad/s² or mm/s²; infinite if not known."""


@dataclass(frozen=True, slots=True)
class JointConvention:
    """How a controller counts the joints of its robot: ``rows @ q + zeros``, q and the result in degrees and mm."""

    rows: tuple[tuple[float, ...], ...]
    """(dof, dof) with full rank: signs on the diagonal, couplings beside it."""
    zeros: tuple[float, ...]
    """(dof,) what the controller shows where every joint of the model is at 0."""

    def count(self, values: tuple[float, ...]) -> tuple[float, ...]:
        """Give the controller's values (dof,) for those of the model (dof,), both in degrees and mm."""
        return tuple(
            sum(share * value for share, value in zip(row, values, strict=True)) + zero
            for row, zero in zip(self.rows, self.zeros, strict=True)
        )

    def recover(self, counted: tuple[float, ...]) -> tuple[float, ...]:
        """Give the model's values (dof,) for those of the controller (dof,): the inverse of ``count``."""
        shifted = np.subtract(counted, self.zeros)
        return tuple(np.linalg.solve(np.array(self.rows), shifted).tolist())


@dataclass(frozen=True, slots=True)
class ToolPointMachine:
    """A machine whose controller derives the carriage from the tool point: LinuxCNC's ``5axiskins``.

    The joints are X, Y and Z along the base's axes, then two that turn, in either order: C about z, B the tilt. In
    machine coordinates the tool point is ``X + R sin B cos C``, ``Y + R sin B sin C``, ``Z + R (1 - cos B)``.
    """

    pivot_mm: float
    """R: from the axis of B to the orifice."""
    base: tuple[float, float, float]
    """Machine coordinates of a tool point in the origin of the robot's base, mm."""
    swing: int
    """Index among the joints of C; the other one that turns is B."""
    swing_zero: float
    """rad that the controller's C counts where the cell's is 0."""
    signs: tuple[float, float]
    """1, or -1 where the controller counts the other way round: of C, of B."""
    tilt_zero: float
    """rad that the controller's B counts where the cell's is 0."""

    def axes(self, joints: NDArray[np.float64]) -> NDArray[np.float64]:
        """Give tool points and the controller's angles (n, 5), mm and rad, in the joints' order, of joints (n, 5)."""
        c = self.signs[0] * joints[:, self.swing] + self.swing_zero
        b = self.signs[1] * joints[:, 7 - self.swing] + self.tilt_zero
        reach = self.pivot_mm * np.sin(b)
        axes = np.empty_like(joints)
        axes[:, 0] = joints[:, 0] + reach * np.cos(c)
        axes[:, 1] = joints[:, 1] + reach * np.sin(c)
        axes[:, 2] = joints[:, 2] + self.pivot_mm * (1.0 - np.cos(b))
        axes[:, self.swing], axes[:, 7 - self.swing] = c, b
        return axes

    def jet_angle(self, one: Sequence[float], other: Sequence[float]) -> float:
        """Give the angle between the jets of two rows of axes (5,), rad."""
        (b, c), (d, e) = ((row[7 - self.swing], row[self.swing]) for row in (one, other))
        cosine = math.sin(b) * math.sin(d) * math.cos(c - e) + math.cos(b) * math.cos(d)
        return math.acos(min(max(cosine, -1.0), 1.0))

    def joints(self, axes: NDArray[np.float64]) -> NDArray[np.float64]:
        """Give the joints (n, 5) of tool points and the controller's angles (n, 5): the inverse of ``axes``."""
        c, b = axes[:, self.swing], axes[:, 7 - self.swing]
        reach = self.pivot_mm * np.sin(b)
        joints = np.empty_like(axes)
        joints[:, 0] = axes[:, 0] - reach * np.cos(c)
        joints[:, 1] = axes[:, 1] - reach * np.sin(c)
        joints[:, 2] = axes[:, 2] - self.pivot_mm * (1.0 - np.cos(b))
        joints[:, self.swing] = (c - self.swing_zero) / self.signs[0]
        joints[:, 7 - self.swing] = (b - self.tilt_zero) / self.signs[1]
        return joints


@dataclass(frozen=True, slots=True)
class ArmBranch:
    """How an arm of six turning joints stands, in the terms that makers have in common."""

    is_front: bool = True
    """Whether the wrist is in front of the first axis, where it is when the arm reaches forth."""
    is_above: bool = True
    """Whether the elbow is above the line from the shoulder to the wrist."""


_NO_OUTPUTS: Mapping[str, tuple[Assignment, ...]] = {}


@dataclass(frozen=True, slots=True)
class Installation:
    """One cell as a program sees it. What is not mapped here becomes a comment in the program, and a finding."""

    cell: str
    robot: str
    T_base_board: Pose
    """Where the board's CAD frame is, seen from the robot's base: the work object."""
    tools: Mapping[int, Tool]
    """By the number in ``NOZZLE name TOOL number``."""
    valves: Mapping[str, Valve]
    """By the nozzle's name."""
    functions: Mapping[str, tuple[Assignment, ...]] = field(default_factory=lambda: _NO_OUTPUTS)
    """What ``FUNCTION name`` sets."""
    solutions: Mapping[str, tuple[Assignment, ...]] = field(default_factory=lambda: _NO_OUTPUTS)
    """What ``SOLUTION name`` sets."""
    settings: Mapping[str, Setting] = field(default_factory=dict[str, Setting])
    """What ``SET key value`` sets."""
    grips: Mapping[str, tuple[Assignment, ...]] = field(default_factory=lambda: _NO_OUTPUTS)
    """What ``GRIP open`` and ``GRIP close`` set."""
    sensors: Mapping[str, Sensor] = field(default_factory=dict[str, Sensor])
    """What shows the quantity of ``UNTIL key``."""
    waits: tuple[Wait, ...] = ()
    """What a program waits for before the robot moves, in this order."""
    workpiece: Literal["board", "part"] = "board"
    """What it holds, as texts for people call it."""
    held: str = ""
    """The point of the board that the cell holds it by, in words; empty for the origin of its CAD frame."""
    placements: Mapping[str, Pose] = field(default_factory=dict[str, Pose])
    """``T_base_board`` after ``CALL name`` has moved the board, such as ``flip_to_bottom``."""
    joints: tuple[Joint, ...] = ()
    home: tuple[float, ...] = ()
    """Joint values where a program begins and ends, radians or millimetres; empty if the cell has none."""
    is_upright: bool = True
    """Whether z of the robot's base points up in the cell."""
    maker: Maker | None = None
    """Whose controller the robot has; ``None`` if that is not stated."""
    convention: JointConvention | None = None
    """How that controller counts the joints; ``None`` if it counts them as the cell does."""
    controller: Mapping[str, float] = field(default_factory=dict[str, float])
    """Numbers of the cell for the ``Controller`` that predicts times, by the names of its attributes."""
    controller_source: str = ""
    """Where these come from."""

    cell_sha256: str = ""
    """Of what places and outputs depend on in the cell's file; empty where there is none."""
    tool_point: ToolPointMachine | None = None
    """Where the controller takes tool points in place of the joints of its carriage."""

    tool_routine: str = ""
    """Beginning of the names of the routines that mount a tool, such as ``mount`` of ``mount_2``; empty where a program
    stops for a person to do that."""

    handshake: Handshake | None = None
    """``None`` where the line has no signals."""

    lamp: Channel | None = None
    """Output that a first run switches in place of the valves; ``None`` where nothing shows when a jet would be on."""

    branch_at: Callable[[tuple[float, ...]], ArmBranch] | None = None
    """Branch at joints (radians); ``None`` where the robot has others than six turning joints, or is not known."""

    def branch(self, joints: tuple[float, ...]) -> ArmBranch:
        """Give the branch at joints; in front and above is assumed where it is not known."""
        return ArmBranch() if self.branch_at is None or not joints else self.branch_at(joints)

    def joint_kinds(self, dof: int) -> list[JointKind]:
        """Kinds of the joints; so many revolute ones where the cell describes none."""
        return [joint.kind for joint in self.joints] or ["revolute"] * dof

    def tool(self, number: int) -> Tool:
        """Tool by its number; one that the cell lacks is the flange itself."""
        return self.tools.get(number) or Tool(f"tool{number}", IDENTITY)
