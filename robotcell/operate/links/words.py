"""Orders and status as registers of 16 bits: the layout of the handshake where a link carries words."""

import struct
from collections.abc import Sequence

from robotcell.operate.handshake import COMMANDS, MODES, LinkError, Order, Status

HEAD = struct.Struct(">4H5IH")
"""Heartbeat, command, jet permitted, watchdog in ms; run, sequence, node, duration in µs, check; routine."""
_STATUS = struct.Struct(">3H3IQ")
"""Epoch, mode, jet on; accepted, check, reached; inputs."""
MOST_WORDS = 120
"""Of one request of Modbus it is 123 to write and 125 to read."""


def order_size(outputs: int, joints: int) -> int:
    """Give the words of an order."""
    return HEAD.size // 2 + 2 * (outputs + joints)


def status_size(sensors: int) -> int:
    """Give the words of a status."""
    return _STATUS.size // 2 + 2 * sensors


def pack_order(order: Order) -> list[int]:
    """Write an order as words, the high one of 32 bits first."""
    node = order.node
    head = HEAD.pack(
        order.heartbeat,
        COMMANDS.index(order.command),
        order.jet_permitted,
        order.watchdog_ms,
        order.run,
        order.sequence,
        node.number,
        node.lasts_us,
        order.check,
        node.routine,
    )
    values = (*node.outputs, *node.joints)
    data = head + struct.pack(f">{len(values)}i", *values)
    return list(struct.unpack(f">{len(data) // 2}H", data))


def unpack_status(words: Sequence[int], sensors: int) -> Status:
    """Read a status from words.

    Raises:
        LinkError: it is too short, or its mode has no meaning.
    """
    if len(words) < status_size(sensors):
        raise LinkError(f"the status has {len(words)} words, not {status_size(sensors)}")
    data = struct.pack(f">{len(words)}H", *words)
    epoch, mode, jet_on, accepted, check, reached, inputs = _STATUS.unpack_from(data)
    if mode >= len(MODES):
        raise LinkError(f"the status has mode {mode}; there are 0 to {len(MODES) - 1}")
    readings = struct.unpack_from(f">{sensors}i", data, _STATUS.size)
    return Status(epoch, MODES[mode], bool(jet_on), accepted, check, reached, inputs, readings)
