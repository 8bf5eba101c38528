"""OPC UA: an order is one Write of the variables of an object, the status one Read."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from robotcell.cell.operate_spec import OpcuaLink
from robotcell.operate.handshake import Found, LinkError, OperateError, Order, Status, order_values, read_status
from robotcell.operate.nodes import Job
from robotcell.operate.words import BEAT, ORDER, STATUS, names_of

_CONNECT_S = 10.0
"""Longest wait for a session: it takes several requests."""
NODE = (*(name for name in names_of(ORDER) if name not in (*BEAT, "Sequence")), "Sequence")
"""Written after those of ``BEAT`` where the node is another one; the sequence number last, which makes it valid."""
TYPES = {word.name: word.kind for word in (*ORDER, *STATUS)}


@dataclass(slots=True)
class _Opcua:
    """A session with an OPC UA server."""

    client: Any
    variables: dict[str, Any]
    ua: Any
    sensors: int
    _last: tuple[int, int] = (-1, -1)

    def exchange(self, order: Order) -> Status:
        """Write the variables of an order, the node's only once, and read those of the status."""
        names = BEAT if (order.run, order.sequence) == self._last else (*BEAT, *NODE)
        values = order_values(order)
        try:
            self.client.write_values(
                [self.variables[name] for name in names],
                [self.ua.DataValue(self.ua.Variant(values[name], self.ua.VariantType[TYPES[name]])) for name in names],
            )
        except (OSError, TimeoutError, RuntimeError, self.ua.UaError) as error:
            raise LinkError(str(error) or type(error).__name__) from None
        self._last = (order.run, order.sequence)
        return read_status(self._read(names_of(STATUS)))

    def look(self) -> Found:
        """Read the variables of the status, and two of the order."""
        found = self._read(("Run", "Heartbeat", *names_of(STATUS)))
        return Found(read_status(found), found["Run"], found["Heartbeat"])

    def _read(self, names: Sequence[str]) -> dict[str, Any]:
        """Read variables at once, by name.

        Raises:
            LinkError: there is no answer, or one has no value.
        """
        try:
            read = self.client.read_values([self.variables[name] for name in names])
        except (OSError, TimeoutError, RuntimeError, self.ua.UaError) as error:
            raise LinkError(str(error) or type(error).__name__) from None
        found = dict(zip(names, read, strict=True))
        found["Readings"] = found["Readings"] or []  # an empty array may come as none
        if any(value is None for value in found.values()):
            raise LinkError("a variable of the status has no value")
        if len(found["Readings"]) < self.sensors:
            raise LinkError(f"Readings has {len(found['Readings'])} values, and the cell has {self.sensors} sensors")
        return found

    def close(self) -> None:
        """End the session."""
        _end(self.client)


def _end(client: Any) -> None:
    """End a session and the thread that serves it; a server that is gone is not waited for."""
    with suppress(Exception):
        client.disconnect()
    client.tloop.stop()


def open_opcua(spec: OpcuaLink, job: Job, timeout_s: float) -> _Opcua:
    """Begin a session with a controller.

    Args:
        spec: As in the cell.
        job: Its sensors give the length of the readings; what is written has its own.
        timeout_s: Longest wait for an answer.

    Raises:
        OperateError: asyncua is missing, no server answers, or it does not have the object with its variables.
    """
    try:
        import logging

        from asyncua import ua
        from asyncua.sync import Client, ThreadLoop
    except ImportError:
        raise OperateError("the link opcua needs `pip install washboard[operate]`.") from None
    logging.getLogger("asyncua").setLevel(logging.CRITICAL)  # what it logs is the reason of an error of ours
    loop = ThreadLoop(_CONNECT_S)
    loop.daemon = True  # whatever happens to the session, the process can end
    loop.start()
    client = Client(spec.url, timeout=_CONNECT_S, tloop=loop)
    try:
        client.connect()
        index = client.get_namespace_index(spec.namespace)
        folder = client.nodes.objects.get_child(f"{index}:{spec.object}")
        variables = {name: folder.get_child(f"{index}:{name}") for name in TYPES}
    except (OSError, TimeoutError, ValueError, ua.UaError) as error:
        _end(client)
        reason = "it does not answer" if isinstance(error, TimeoutError) else str(error) or "it ends the connection"
        raise OperateError(
            f"no controller at {spec.url} has the object {spec.object} of {spec.namespace} (OPC UA): {reason}."
        ) from None
    loop.timeout = timeout_s
    return _Opcua(client, variables, ua, len(job.io.sensors))
