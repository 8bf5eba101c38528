"""The operating mode as a pure state machine: what happened gives the next state, and the state gives the command.

The order of states is that of the operating mode of Zaki and Eskander (Cairo, section 3): part present, home, one node
after the other, end of trajectory; interlocks, pause and fault are added. The machine has no clock and no link: the
same events give the same states, whoever replays them.
"""

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, assert_never

State: TypeAlias = Literal["idle", "armed", "part present", "homing", "running", "paused", "end", "faulted"]
CommandWord: TypeAlias = Literal["stop", "hold", "home", "run"]
"""To the controller: stand with an empty queue, stand on the path, go home, go from node to node. Valves are shut in
all but the last."""

PART_PRESENT, HOME, HOMED, END = "part_present", "home", "homed", "end"


@dataclass(frozen=True, slots=True)
class Sensed:
    """A condition became met, or is not met any more."""

    name: str
    met: bool


@dataclass(frozen=True, slots=True)
class Arm:
    """The operator starts the operation: the jet is permitted from this node on."""

    first: int


@dataclass(frozen=True, slots=True)
class Home:
    """The robot is sent home."""


@dataclass(frozen=True, slots=True)
class AtHome:
    """The controller reports that the robot stands at home."""


@dataclass(frozen=True, slots=True)
class Reached:
    """The controller reports a node as reached."""

    node: int


@dataclass(frozen=True, slots=True)
class Pause:
    """The operator pauses."""


@dataclass(frozen=True, slots=True)
class Resume:
    """The operator resumes."""


@dataclass(frozen=True, slots=True)
class Stop:
    """The operator ends the operation before its end."""


@dataclass(frozen=True, slots=True)
class Fault:
    """Something is wrong with the link, the controller or a time."""

    reason: str


@dataclass(frozen=True, slots=True)
class Shut:
    """The controller confirms that every valve is shut."""


@dataclass(frozen=True, slots=True)
class Reset:
    """The operator acknowledges a fault or an end."""


Event: TypeAlias = Sensed | Arm | Home | AtHome | Reached | Pause | Resume | Stop | Fault | Shut | Reset


@dataclass(frozen=True, slots=True)
class Rules:
    """The conditions of one operation, by name."""

    interlocks: frozenset[str]
    sensors: frozenset[str]
    """Those of ``part_present``, ``home``, ``homed`` and ``end`` that the cell has."""
    last: int
    """Number of the last node."""

    def held(self, state: State) -> frozenset[str]:
        """Conditions whose loss is a fault in a state."""
        match state:
            case "idle" | "end" | "faulted":
                return frozenset()
            case "armed":
                return self.interlocks
            case "part present" | "homing":
                return self.interlocks | (self.sensors & {PART_PRESENT})
            case "running" | "paused":
                return self.interlocks | (self.sensors & {PART_PRESENT, HOMED})
            case _:
                assert_never(state)


@dataclass(frozen=True, slots=True)
class Operation:
    """Where an operation is."""

    rules: Rules
    state: State = "idle"
    met: frozenset[str] = frozenset()
    """Conditions that are known to be met."""
    node: int = 0
    """The last one reached; 0 before the first."""
    first: int = 1
    """The jet is permitted from this node on."""
    reason: str = ""
    """Why it is faulted, or why it could not be armed."""

    @property
    def command(self) -> CommandWord:
        """Command to the controller."""
        match self.state:
            case "idle" | "armed" | "part present" | "end" | "faulted":
                return "stop"
            case "homing":
                return "home"
            case "running":
                return "run"
            case "paused":
                return "hold"
            case _:
                assert_never(self.state)

    @property
    def jet_permitted(self) -> bool:
        """Whether a valve may be open: while running, with every interlock met and the part in its place."""
        return self.state == "running" and self.rules.held("running") <= self.met

    @property
    def is_over(self) -> bool:
        """Whether nothing more happens until the operator acts."""
        return self.state in ("idle", "end", "faulted")

    @property
    def relevant(self) -> frozenset[str]:
        """Conditions that matter in this state; others may change unseen."""
        match self.state:
            case "idle":
                return self.rules.interlocks
            case "armed":
                return self.rules.interlocks | (self.rules.sensors & {PART_PRESENT})
            case "homing":
                return self.rules.held("running") | (self.rules.sensors & {HOME})
            case "running" if self.node == self.rules.last:
                return self.rules.held("running") | (self.rules.sensors & {END})
            case _:
                return self.rules.held(self.state)


def advance(operation: Operation, event: Event) -> Operation:  # noqa: C901 (one case an event)
    """Give the state after an event. An event that means nothing in a state leaves it as it is."""
    state = operation.state
    match event:
        case Sensed():
            return _sense(operation, event)
        case Arm() if state == "idle":
            return _arm(operation, event)
        case Home() if state == "part present":
            return replace(operation, state="homing")
        case AtHome() if state == "homing":
            return _leave_home(operation)
        case Reached() if state in ("running", "paused"):
            first = 1 if event.node >= operation.first else operation.first  # in a loop smaller numbers follow
            return _end_if_done(replace(operation, node=event.node, first=first))
        case Pause() if state == "running":
            return replace(operation, state="paused")
        case Resume() if state == "paused":
            return _end_if_done(replace(operation, state="running"))
        case Stop() if state not in ("end", "faulted"):
            return replace(operation, state="idle")
        case Fault() if not operation.is_over:
            return replace(operation, state="faulted", reason=event.reason)
        case Reset() if state in ("end", "faulted"):
            return replace(operation, state="idle", reason="")
        case _:
            return operation


def _sense(operation: Operation, event: Sensed) -> Operation:
    met = operation.met | {event.name} if event.met else operation.met - {event.name}
    sensed = replace(operation, met=met)
    if not event.met and event.name in operation.rules.held(operation.state):
        return replace(sensed, state="faulted", reason=f"{event.name} is not met")
    if event.met and event.name == PART_PRESENT and operation.state == "armed":
        return replace(sensed, state="part present")
    return _end_if_done(sensed)


def _arm(operation: Operation, event: Arm) -> Operation:
    """Begin anew; what the sensors showed before is not taken over, but for the interlocks."""
    missing = sorted(operation.rules.interlocks - operation.met)
    if missing:
        return replace(operation, reason=f"{missing[0]} is not met")
    kept = operation.met & operation.rules.interlocks
    return replace(operation, state="armed", met=kept, node=0, first=event.first, reason="")


def _leave_home(operation: Operation) -> Operation:
    needed = operation.rules.held("running") | (operation.rules.sensors & {HOME})
    return replace(operation, state="running") if needed <= operation.met else operation


def _end_if_done(operation: Operation) -> Operation:
    done = operation.state == "running" and operation.node == operation.rules.last
    at_end = operation.rules.sensors & {END} <= operation.met
    return replace(operation, state="end") if done and at_end else operation
