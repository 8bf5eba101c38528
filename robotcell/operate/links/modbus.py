"""Modbus TCP: an order is one block of holding registers of 16 bits that is written, the status one that is read."""

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from robotcell.cell.operate_spec import ModbusLink
from robotcell.operate.handshake import COMMANDS, MODES, LinkError, OperateError, Order, Status
from robotcell.operate.nodes import Job

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


@dataclass(frozen=True, slots=True)
class _Modbus:
    """A connection to a Modbus TCP server."""

    client: Any
    spec: ModbusLink
    sensors: int

    def exchange(self, order: Order) -> Status:
        """Write the registers of an order, read those of the status."""
        from pymodbus.exceptions import ModbusException

        try:
            written = self.client.write_registers(self.spec.orders_at, pack_order(order), device_id=self.spec.unit)
            if written.isError():
                raise LinkError(f"the order was refused ({written})")
            read = self.client.read_holding_registers(
                self.spec.status_at, count=status_size(self.sensors), device_id=self.spec.unit
            )
        except (ModbusException, OSError) as error:
            raise LinkError(str(error)) from None
        if read.isError():
            raise LinkError(f"the status cannot be read ({read})")
        return unpack_status(read.registers, self.sensors)

    def close(self) -> None:
        """End the connection."""
        self.client.close()


def open_modbus(spec: ModbusLink, job: Job, timeout_s: float) -> _Modbus:
    """Connect to a controller.

    Args:
        spec: As in the cell.
        job: Its outputs, joints and sensors give the size of the blocks.
        timeout_s: Longest wait for an answer.

    Raises:
        OperateError: pymodbus is missing, the controller cannot be reached, or an order is too long for one request.
    """
    try:
        import logging

        from pymodbus.client import ModbusTcpClient
    except ImportError:
        raise OperateError("the link modbus needs `pip install washboard[operate]`.") from None
    words = max(order_size(len(job.outputs), len(job.joints)), status_size(len(job.sensors)))
    if words > MOST_WORDS:
        raise OperateError(
            f"an order or a status of this cell has {words} words; Modbus carries {MOST_WORDS}: use opcua."
        )
    logging.getLogger("pymodbus").setLevel(logging.CRITICAL)  # what it logs is the reason of an error of ours
    client = ModbusTcpClient(spec.host, port=spec.port, timeout=timeout_s, retries=0)
    if not client.connect():
        raise OperateError(f"no controller answers at {spec.host} port {spec.port} (Modbus TCP).")
    return _Modbus(client, spec, len(job.sensors))
