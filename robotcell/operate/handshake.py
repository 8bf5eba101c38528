"""Orders to a controller and its status: the words of the handshake, whatever the link that carries them.

An order has a node and its sequence number until the controller has accepted it; the controller answers with that
number and the checksum of what it received, so that a node is neither lost, nor taken twice, nor changed on its way.
"""

import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol, TypeAlias

from robotcell.operate.nodes import Job, Node
from robotcell.operate.states import CommandWord
from specs.errors import LocatedError

Mode: TypeAlias = Literal["stopped", "held", "homing", "home", "running"]
COMMANDS: tuple[CommandWord, ...] = ("stop", "hold", "home", "run")
"""Their numbers on a link are their places."""
MODES: tuple[Mode, ...] = ("stopped", "held", "homing", "home", "running")
MOST_INPUTS = 64


class OperateError(LocatedError):
    """An operation cannot be begun, or its log is none."""


class LinkError(Exception):
    """A link did not carry an order or a status; the operation becomes faulted."""


@dataclass(frozen=True, slots=True)
class Order:
    """What the controller is to do."""

    command: CommandWord
    jet_permitted: bool
    """Without it every valve is shut, whatever the outputs of a node."""
    heartbeat: int
    """Another number with every order, 0 to 65535."""
    watchdog_ms: int
    """After so long without a new heartbeat the controller stops and shuts every valve."""
    run: int
    """Of this operation; with another one the controller's queue is empty and sequence numbers begin at 1 again."""
    sequence: int
    """Of the node, from 1; 0 while there is none."""
    node: Node
    check: int
    """``check_of`` run, sequence and node."""


@dataclass(frozen=True, slots=True)
class Status:
    """What the controller reports."""

    epoch: int
    """Another number after each start of the controller's program."""
    mode: Mode
    jet_on: bool
    """Whether any valve is open."""
    heartbeat: int
    """Of the last order that the controller's program has taken: it stands still where that has halted."""
    accepted: int
    """Sequence number of the last node that was accepted."""
    check: int
    """``check_of`` that node, as it was received."""
    reached: int
    """Sequence number of the last node that was reached."""
    inputs: int
    """Digital inputs: bit n is input number n."""
    readings: tuple[int, ...] = ()
    """Of the cell's sensors in their order, 1e-6 V or mA."""


def check_of(run: int, sequence: int, node: Node) -> int:
    """CRC-32 of run, sequence, number, duration, routine, outputs and joints, each 32 bits, the high byte first."""
    words = (run, sequence, node.number, node.lasts_us, node.routine, *node.outputs, *node.joints)
    return zlib.crc32(struct.pack(f">5I{len(words) - 5}i", *words))


def order_values(order: Order) -> dict[str, Any]:
    """Give the values of an order by their names on links, in the order of registers; a command is its place."""
    node = order.node
    return {
        "Heartbeat": order.heartbeat,
        "Command": COMMANDS.index(order.command),
        "JetPermitted": order.jet_permitted,
        "WatchdogMs": order.watchdog_ms,
        "Run": order.run,
        "Sequence": order.sequence,
        "Node": node.number,
        "DurationUs": node.lasts_us,
        "Check": order.check,
        "Routine": node.routine,
        "Outputs": [*node.outputs],
        "Joints": [*node.joints],
    }


def read_status(values: Sequence[Any]) -> Status:
    """Read a status from its values in order, the mode as its place.

    Raises:
        LinkError: the mode has no meaning.
    """
    epoch, mode, jet_on, heartbeat, accepted, check, reached, inputs, readings = values
    if not 0 <= mode < len(MODES):
        raise LinkError(f"the status has mode {mode}; there are 0 to {len(MODES) - 1}")
    return Status(epoch, MODES[mode], bool(jet_on), heartbeat, accepted, check, reached, inputs, tuple(readings))


@dataclass(frozen=True, slots=True)
class Found:
    """A controller as another operation has it, or nobody."""

    status: Status
    run: int
    """Of the last order."""
    heartbeat: int


class Link(Protocol):
    """A connection to a controller."""

    def look(self) -> Found | None:
        """Read the status and whose the last order was, without an order.

        Returns:
            ``None`` where the link itself is of one operation at a time.

        Raises:
            LinkError: the controller cannot be reached, or what it reports cannot be read.
        """
        ...

    def exchange(self, order: Order) -> Status:
        """Write an order and read the status after it.

        Raises:
            LinkError: the controller cannot be reached, or what it reports cannot be read.
        """
        ...

    def close(self) -> None:
        """End the connection."""
        ...


@dataclass(frozen=True, slots=True)
class Planned:
    """A controller that does at once what it is ordered, with every condition met: for a run without one."""

    job: Job
    inputs: int
    """All conditions met."""
    readings: tuple[int, ...]
    """That end every loop after one turn."""

    def look(self) -> None:
        """Nobody else has it."""

    def exchange(self, order: Order) -> Status:
        """Accept and reach the node of an order."""
        modes: dict[CommandWord, Mode] = {"stop": "stopped", "hold": "held", "home": "home", "run": "running"}
        done = order.sequence if order.command in ("run", "hold") else 0
        jet_on = order.jet_permitted and bool(self.job.open_valves(order.node))
        return Status(
            1, modes[order.command], jet_on, order.heartbeat, done, order.check, done, self.inputs, self.readings
        )

    def close(self) -> None:
        """There is no connection."""
