"""Modbus TCP: an order is one block of holding registers of 16 bits that is written, the status one that is read."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from robotcell.cell.operate_spec import ModbusLink
from robotcell.operate.handshake import (
    Found,
    LinkError,
    OperateError,
    Order,
    Status,
    order_values,
    read_status,
    require_registers,
)
from robotcell.operate.nodes import Job
from robotcell.operate.words import BEAT, ORDER, STATUS, count_registers, pack, register_at, unpack

_ILLEGAL_FUNCTION = 1
_LOOKED = register_at(ORDER, "Sequence")
"""Registers of an order that a look reads: its beat."""


def unpack_status(registers: Sequence[int], sensors: int) -> Status:
    """Read a status from registers.

    Raises:
        LinkError: it is too short, or its mode has no meaning.
    """
    if len(registers) < (count := count_registers(STATUS, sensors)):
        raise LinkError(f"the status has {len(registers)} words, not {count}")
    return read_status(unpack(STATUS, registers, (sensors,)))


@dataclass(slots=True)
class _Modbus:
    """A connection to a Modbus TCP server."""

    client: Any
    spec: ModbusLink
    sensors: int
    at_once: bool = True
    """Whether the controller writes and reads by one request (function 23)."""

    def exchange(self, order: Order) -> Status:
        """Write the registers of an order, read those of the status."""
        words, count = pack(ORDER, order_values(order)), count_registers(STATUS, self.sensors)
        if self.at_once:
            both = self._request(
                self.client.readwrite_registers,
                write_address=self.spec.orders_at,
                values=words,
                read_address=self.spec.status_at,
                read_count=count,
            )
            if not both.isError():
                return unpack_status(both.registers, self.sensors)
            if both.exception_code != _ILLEGAL_FUNCTION:
                raise LinkError(f"the order was refused ({both})")
            self.at_once = False
        written = self._request(self.client.write_registers, self.spec.orders_at, words)
        if written.isError():
            raise LinkError(f"the order was refused ({written})")
        return self._status()

    def look(self) -> Found:
        """Read the registers of the status, and the first ones of the order."""
        read = self._request(self.client.read_holding_registers, self.spec.orders_at, count=_LOOKED)
        if read.isError() or len(read.registers) < _LOOKED:
            raise LinkError(f"the registers of the order cannot be read ({read})")
        found = unpack(ORDER[: len(BEAT)], read.registers, ())
        return Found(self._status(), found["Run"], found["Heartbeat"])

    def _status(self) -> Status:
        count = count_registers(STATUS, self.sensors)
        read = self._request(self.client.read_holding_registers, self.spec.status_at, count=count)
        if read.isError():
            raise LinkError(f"the status cannot be read ({read})")
        return unpack_status(read.registers, self.sensors)

    def _request(self, send: Callable[..., Any], *words: Any, **named: Any) -> Any:
        """Send a request.

        Raises:
            LinkError: there is no answer.
        """
        from pymodbus.exceptions import ModbusException

        try:
            return send(*words, **named, device_id=self.spec.unit)
        except (ModbusException, OSError) as error:
            raise LinkError(str(error)) from None

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
    require_registers(len(job.outputs) + len(job.joints), len(job.io.sensors))
    logging.getLogger("pymodbus").setLevel(logging.CRITICAL)  # what it logs is the reason of an error of ours
    client = ModbusTcpClient(spec.host, port=spec.port, timeout=timeout_s, retries=0)
    if not client.connect():
        raise OperateError(f"no controller answers at {spec.host} port {spec.port} (Modbus TCP).")
    return _Modbus(client, spec, len(job.io.sensors))
