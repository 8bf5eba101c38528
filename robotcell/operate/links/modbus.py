"""Modbus TCP: an order is one block of holding registers that is written, the status one that is read."""

from dataclasses import dataclass
from typing import Any

from robotcell.cell.operate_spec import ModbusLink
from robotcell.operate.handshake import LinkError, OperateError, Order, Status
from robotcell.operate.links.words import MOST_WORDS, order_size, pack_order, status_size, unpack_status
from robotcell.operate.nodes import Job


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
