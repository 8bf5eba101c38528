"""The operating mode as a pure state machine: what happened gives the next state, and the state gives the command.

The order of states is that of the operating mode of Zaki and Eskander (Cairo, section 3): part present, home, one node
after the other, end of trajectory; interlocks, pause and fault are added. The machine has no clock and no link: the
same events give the same states, whoever replays them.
"""

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

State: TypeAlias = Literal["idle", "armed", "part present", "homing", "running", "paused", "end", "faulted"]
CommandWord: TypeAlias = Literal["stop", "hold", "home", "run"]
"""To the controller: stand with an empty queue, stand on the path, go home, go from node to node. Valves are shut in
all but the last."""

PART_PRESENT, HOME, HOMED, END = "part_present", "home", "homed", "end"
_HELD: dict[State, tuple[str, ...]] = {
    "armed": (),
    "part present": (PART_PRESENT,),
    "homing": (PART_PRESENT,),
    "running": (PART_PRESENT, HOMED),
    "paused": (PART_PRESENT, HOMED),
}
"""Sensors whose loss is a fault in a state, beside the interlocks; in the other states nothing is."""
_COMMANDS: dict[State, CommandWord] = {"homing": "home", "running": "run", "paused": "hold"}
"""In all other states the controller stops."""


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
class Reached:
    """The controller reports a node as reached."""

    node: int


@dataclass(frozen=True, slots=True)
class Fault:
    """Something is wrong with the link, the controller or a time."""

    reason: str


@dataclass(frozen=True, slots=True)
class Unmet:
    """A loop was done as often as it may be, and its sensor did not show what was to be reached."""

    what: str


@dataclass(frozen=True, slots=True)
class NotShut:
    """The controller did not confirm that every valve is shut."""

    reason: str


Word: TypeAlias = Literal["home", "at home", "pause", "resume", "stop", "shut", "reset"]
"""Events without a value: the robot is sent home, the controller reports that it stands there, the operator pauses,
resumes, ends the operation before its end; the controller confirms that every valve is shut; the operator acknowledges
a fault or an end."""
Event: TypeAlias = Sensed | Arm | Reached | Fault | Unmet | NotShut | Word


@dataclass(frozen=True, slots=True)
class Rules:
    """The conditions of one operation, by name."""

    interlocks: frozenset[str]
    sensors: frozenset[str]
    """Those of ``part_present``, ``home``, ``homed`` and ``end`` that the cell has."""
    last: int
    """Number of the last node."""
    awaited: frozenset[str] = frozenset()
    """Further conditions for the start: the waits of the cell's ``io``."""
    watched: frozenset[str] = frozenset()
    """Those of them whose loss is a fault from then on."""

    def needed(self, *sensors: str) -> frozenset[str]:
        """Interlocks, and those of some sensors that the cell has."""
        return self.interlocks | (self.sensors & {*sensors})

    @property
    def start(self) -> frozenset[str]:
        """Conditions that are to be met before the robot moves."""
        return self.needed(PART_PRESENT) | self.awaited

    def held(self, state: State) -> frozenset[str]:
        """Conditions whose loss is a fault in a state."""
        if state not in _HELD:
            return frozenset()
        return self.needed(*_HELD[state]) | (frozenset() if state == "armed" else self.watched)


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
    unmet: tuple[str, ...] = ()
    """What loops did not reach."""
    not_shut: str = ""
    """Why it is not known that every valve is shut; empty where that was confirmed, or is not over."""

    @property
    def command(self) -> CommandWord:
        """Command to the controller."""
        return _COMMANDS.get(self.state, "stop")

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
        rules = self.rules
        held = rules.held(self.state)
        match self.state:
            case "idle":
                return rules.interlocks
            case "armed":
                return rules.start
            case "homing":
                return held | rules.needed(*_HELD["running"], HOME)
            case "running" if self.node == rules.last:
                return held | rules.needed(END)
            case _:
                return held


def advance(operation: Operation, event: Event) -> Operation:  # noqa: C901, PLR0912 (one case an event)
    """Give the state after an event. An event that means nothing in a state leaves it as it is."""
    state, rules = operation.state, operation.rules
    match event:
        case Sensed():
            return _sense(operation, event)
        case Arm(first) if state == "idle":
            if missing := sorted(rules.interlocks - operation.met):
                return replace(operation, reason=f"{missing[0]} is not met")
            # Anew: what the sensors showed before is not taken over, but for the interlocks.
            return Operation(rules, "armed", rules.interlocks, first=first)
        case "home" if state == "part present":
            return replace(operation, state="homing")
        case "at home" if state == "homing" and rules.needed(*_HELD["running"], HOME) <= operation.met:
            return replace(operation, state="running")
        case Reached(node) if state in ("running", "paused"):
            first = 1 if node >= operation.first else operation.first  # in a loop smaller numbers follow
            return _end_if_done(replace(operation, node=node, first=first))
        case "pause" if state == "running":
            return replace(operation, state="paused")
        case "resume" if state == "paused":
            return _end_if_done(replace(operation, state="running"))
        case "stop" if state not in ("end", "faulted"):
            return replace(operation, state="idle")
        case Fault(reason) if not operation.is_over:
            return replace(operation, state="faulted", reason=reason)
        case Unmet(what) if state == "running":
            return replace(operation, unmet=(*operation.unmet, what))
        case NotShut(reason):
            return replace(operation, not_shut=reason)
        case "reset" if state in ("end", "faulted"):
            return replace(operation, state="idle", reason="")
        case _:
            return operation


def _sense(operation: Operation, event: Sensed) -> Operation:
    name, state, rules = event.name, operation.state, operation.rules
    sensed = replace(operation, met=operation.met | {name} if event.met else operation.met - {name})
    if not event.met and name in rules.held(state):
        return replace(sensed, state="faulted", reason=f"{name} is not met")
    if state == "armed" and rules.start <= sensed.met:
        return replace(sensed, state="part present")
    return _end_if_done(sensed)


def _end_if_done(operation: Operation) -> Operation:
    done = operation.state == "running" and operation.node == operation.rules.last
    at_end = operation.rules.sensors & {END} <= operation.met
    return replace(operation, state="end") if done and at_end else operation
