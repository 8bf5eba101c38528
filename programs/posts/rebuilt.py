"""A program rebuilt from its text: steps as they would be executed, each loop once. Board frame, mm, s."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from programs.motion.analog import Counting
from programs.motion.installation import Installation
from programs.motion.lower import Capability
from programs.motion.steps import Line
from programs.pose import Pose
from programs.timing.controller import Controller


@dataclass(frozen=True, slots=True)
class TextPlace:
    """A line of a program's text."""

    file: str
    line: int
    """From 1."""


@dataclass(frozen=True, slots=True)
class ReadSignal:
    """An output that changes during a line."""

    channel: str
    """Its name in the language: ``Channel.name``, or kind and number such as ``digital 3``."""
    value: float
    share: float
    """Place that the time counts from, as a share of the line that was read."""
    offset_s: float
    """When the signal leaves, relative to the moment at that place; negative for before."""


@dataclass(frozen=True, slots=True)
class Axes:
    """Positions of the axes, in languages that have those instead of poses."""

    values: tuple[float, ...]
    """In the order of the cell's joints, degrees or mm."""


@dataclass(frozen=True, slots=True)
class ReadLine:
    """A straight line, or a part of one that is straight in the axes."""

    target: Pose | Axes
    """T_board_tool."""
    stops: bool | None
    """``None`` where the language states times."""
    speed_mm_s: float | None
    """0 if it turns on the spot; ``None`` where the language states times."""
    signals: tuple[ReadSignal, ...] = ()
    duration_s: float | None = None
    """At full speed, where the language states that in place of the speed."""
    zone: float = 0.0
    """How its end is passed, in the terms of its controller's ``Blending``; 0 where it stops."""
    turn_deg_s: float | None = None
    """Greatest rate of the tool's turn; ``None`` where the text states none."""
    acceleration_mm_s2: float | None = None
    """``None`` where the text states none."""
    turn_acceleration_deg_s2: float | None = None
    """``None`` where the text states none."""
    arm: str = ""
    """How the arm stands at the end, in the language's words, where it states that."""
    axes: Axes | None = None
    """Where the axes are at the end, in tables that have them beside the pose: as the cell counts them."""


@dataclass(frozen=True, slots=True)
class ReadReach:
    """A joint motion to a pose."""

    target: Pose | Axes
    joints: tuple[float, ...] = ()
    """Of the motion to joint values that leads there, as the controller counts them, degrees or mm; empty if none."""
    speed_share: float | None = None
    """Of the joints' greatest speeds; ``None`` where the text states none."""
    duration_s: float | None = None
    """From rest to rest, where the text states that."""
    arm: str = ""
    """As of a line."""
    way: "tuple[ReadLine, ...]" = ()
    """The motion in small steps, in tables that have it; with the end."""


@dataclass(frozen=True, slots=True)
class ReadPause:
    """A pause."""

    duration_s: float


@dataclass(frozen=True, slots=True)
class ReadSwitch:
    """An output that changes while the robot stands."""

    channel: str
    value: float


@dataclass(frozen=True, slots=True)
class ReadTool:
    """Another tool is used from now on."""

    label: str
    T_flange_tcp: Pose | None
    """``None`` where the program leaves it to the controller's tool table."""
    load: tuple[float, ...] = ()
    """Mass, kg, and centre of gravity on the flange, mm, as far as the text states them."""


@dataclass(frozen=True, slots=True)
class ReadMount:
    """The program stops until this tool is mounted."""

    number: int


@dataclass(frozen=True, slots=True)
class ReadHold:
    """The program stops until the operator goes on, and names no tool."""


@dataclass(frozen=True, slots=True)
class ReadAwait:
    """An input that is awaited as long as it takes, and watched at no time."""

    channel: str
    """Its name in the language, or its number."""
    state: bool


@dataclass(frozen=True, slots=True)
class ReadBoard:
    """The board lies here from now on."""

    T_base_board: Pose | None
    """``None`` where the program leaves it to the controller's frame table."""


@dataclass(frozen=True, slots=True)
class ReadCall:
    """A routine of the integrator's."""

    label: str


@dataclass(frozen=True, slots=True)
class ReadRepeat:
    """A loop begins."""

    count: int
    least: float | None
    """The quantity, in its own unit, that ends it; ``None`` where it only counts."""
    reading: tuple[float, float] | None = None
    """Scale and offset that turn the input's number into the quantity; ``None`` where the text does not have them."""
    channel: str = ""
    """Name or number of the input; empty where the text does not have it."""


@dataclass(frozen=True, slots=True)
class ReadEndRepeat:
    """The innermost loop ends."""


ReadStep: TypeAlias = (
    ReadLine
    | ReadReach
    | ReadPause
    | ReadSwitch
    | ReadMount
    | ReadHold
    | ReadAwait
    | ReadTool
    | ReadBoard
    | ReadCall
    | ReadRepeat
    | ReadEndRepeat
)


EXACT = Capability(controller_class=3, timing="boundary", cycle_s=0.0)
"""Of a language whose steps are as small as can be."""


@dataclass(frozen=True, slots=True)
class ReadWait:
    """A condition that is waited for before the robot moves."""

    channel: str
    """Name of the input in the language, or its number."""
    state: bool | None
    """Of a digital input; ``None`` for a quantity."""
    timeout_s: float
    condition: tuple[float, float, float] | None = None
    """Scale and offset that turn the input's number into the quantity, and its least value."""


@dataclass(frozen=True, slots=True)
class ReadPart:
    """A part of main that the program may start at."""

    number: int
    begins: int
    """Number of steps before it."""
    entry: tuple[ReadStep, ...] = ()
    """What is done where the program starts there, before the part's own steps."""


@dataclass(frozen=True, slots=True)
class ReadFrame:
    """The production frame around a program."""

    waits: tuple[ReadWait, ...]
    watched: tuple[tuple[str, bool], ...] | None
    """Inputs that are watched while the program runs, by name or number, and the state that they are to keep.

    ``None`` where the language leaves them to the integrator."""
    parts: tuple[ReadPart, ...]
    shut: tuple[str, ...]
    """Outputs that the fault routine shuts."""
    guards_override: bool | None
    """Whether the program refuses to start, or takes no notice, where the speed override is not 100 %.

    ``None`` where the language cannot read it."""
    reads_sensors: bool = True
    """Whether the language can wait for a quantity."""
    faults: frozenset[str] = frozenset()
    """Outputs that show that the program stopped itself, one for each place; empty for a place without."""


@dataclass(frozen=True, slots=True)
class ReadHome:
    """A joint motion to joint values from which the program does not go on to a pose: home."""

    after: int
    """Number of steps before it."""
    joints: tuple[float, ...]
    """As the controller counts them, degrees or mm."""
    speed_share: float | None = None
    """Of the joints' greatest speeds; ``None`` where the text states none."""


@dataclass(frozen=True, slots=True)
class Due:
    """What the text of a planned line has to state beside its end and speed; ``None`` where the language states none.

    It follows from the plan apart from the writer, which is compared with it.
    """

    zone: float | None = None
    """In the terms of ``ReadLine.zone``, of a line that is passed."""
    turn_deg_s: float | None = None
    duration_s: float | None = None


Dues: TypeAlias = Callable[[Line, Line | None], Due]
"""Gives what is due for a line as it was lowered, and the one right after it if that is passed to."""


@dataclass(frozen=True, slots=True)
class Rebuilt:
    """A program as its text executes."""

    steps: tuple[ReadStep, ...]
    places: tuple[TextPlace | None, ...] = ()
    """Statement of each step, as far as they are known."""
    frame: ReadFrame | None = None
    """``None`` where the language has none, such as a table."""
    capability: Capability = EXACT
    """What its language can time, and in which steps it counts."""
    states_loads: bool = False
    """Whether the text states what a tool weighs."""
    has_joints: bool = True
    """Whether a joint motion goes to joint values, where they are known."""
    arm_due: Callable[[tuple[float, ...], Installation], str | None] | None = None
    """Gives what its positions have to state of the arm at joints, nothing where that is not compared."""
    dues: Dues | None = None
    """What its lines have to state; ``None`` in languages of axes, whose blocks are no lines of the plan."""
    rise_mm: float | None = None
    """Height above the base to which the orifice is raised before anything else moves; ``None`` if it is not."""
    homes: tuple[ReadHome, ...] | None = None
    """Motions home, in order; ``None`` where the language has none."""
    home_in_tool_points: bool = True
    """Whether home is read as a tool point, where the controller takes those."""
    controller: Controller | None = None
    """The model by which joint motions are given their speed."""

    @property
    def analog(self) -> Counting:
        """How its analog values and readings count."""
        return self.capability.analog

    def place(self, step: int) -> TextPlace | None:
        """Statement of a step; that of the last one for what comes after the end."""
        return self.places[min(step, len(self.places) - 1)] if self.places else None
