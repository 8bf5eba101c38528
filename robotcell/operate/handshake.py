"""Orders to a controller and its status: the words of the handshake, whatever the link that carries them.

An order has a node and its sequence number until the controller has accepted it; the controller answers with that
number and the checksum of what it received, so that a node is neither lost, nor taken twice, nor changed on its way.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, Protocol, TypeAlias

from robotcell.operate.nodes import Job, Node
from robotcell.operate.states import CommandWord
from robotcell.operate.words import ORDER, STATUS, checksum, count_registers, names_of
from specs.errors import LocatedError

Mode: TypeAlias = Literal["stopped", "held", "homing", "home", "running"]
COMMANDS: tuple[CommandWord, ...] = ("stop", "hold", "home", "run")
"""Their numbers on a link are their places."""
MODES: tuple[Mode, ...] = ("stopped", "held", "homing", "home", "running")
MOST_INPUTS = 64
_MOST_REGISTERS = 120
"""Of one request of Modbus it is 121 to write and 125 to read."""


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


def require_registers(to_write: int, to_read: int) -> None:
    """Refuse a cell whose order or status is too long for one request of Modbus.

    Args:
        to_write: Outputs and joints.
        to_read: Sensors.

    Raises:
        OperateError: it is.
    """
    if (words := max(count_registers(ORDER, to_write), count_registers(STATUS, to_read))) > _MOST_REGISTERS:
        raise OperateError(
            f"an order or a status of this cell has {words} words; Modbus carries {_MOST_REGISTERS}: use opcua."
        )


def check_of(run: int, sequence: int, node: Node) -> int:
    """CRC-32 of run, sequence, number, duration, routine, outputs and joints."""
    return checksum((run, sequence, node.number, node.lasts_us, node.routine), (*node.outputs, *node.joints))


def order_values(order: Order) -> dict[str, Any]:
    """Give the values of an order by their names on links; a command is its place."""
    node = order.node
    values = (
        order.heartbeat, COMMANDS.index(order.command), order.jet_permitted, order.watchdog_ms, order.run,
        order.sequence, node.number, node.lasts_us, order.check, node.routine, [*node.outputs], [*node.joints],
    )  # fmt: skip
    return dict(zip(names_of(ORDER), values, strict=True))


def read_status(values: Mapping[str, Any]) -> Status:
    """Read a status from its values by their names on links, the mode as its place.

    Raises:
        LinkError: the mode has no meaning.
    """
    epoch, mode, jet_on, heartbeat, accepted, check, reached, inputs, readings = (
        values[name] for name in names_of(STATUS)
    )
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
