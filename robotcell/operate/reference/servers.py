"""A controller's program behind a server of its own thread: Modbus TCP or OPC UA, with the words of the handshake."""

import asyncio
import logging
import socket
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from robotcell.cell.load import LoadedCell
from robotcell.cell.operate_spec import ModbusLink, OpcuaLink
from robotcell.operate.handshake import OperateError
from robotcell.operate.interface import elements_of, render_node_set
from robotcell.operate.reference.program import ControllerProgram, Received
from robotcell.operate.words import BEAT, ORDER, STATUS, count_registers, names_of, pack, unpack

_CYCLE_S = 0.002
_BEGIN_S = 60.0
"""Longest wait for a server: one of OPC UA has thousands of nodes to make."""
_WRITE, _READ, _BOTH = 16, 3, 23
"""Functions of Modbus."""


def free_port(host: str = "127.0.0.1") -> int:
    """Give a port that nobody listens on."""
    with socket.socket() as probe:
        probe.bind((host, 0))
        return int(probe.getsockname()[1])


class Server:
    """A server in a thread of its own, with the cycle of the controller's program."""

    def __init__(self, program: ControllerProgram, loaded: LoadedCell, host: str, port: int) -> None:
        """Begin to serve.

        Raises:
            OperateError: the address is taken, or none of this machine's.
        """
        self.program, self.loaded = program, loaded
        self.host, self.port = host, port
        self._loop = asyncio.new_event_loop()
        self._ready = threading.Event()
        self._refused = ""
        self._thread = threading.Thread(target=self._main, daemon=True)
        self._thread.start()
        if not self._ready.wait(_BEGIN_S):
            raise OperateError(f"no server began at {host} port {port} in {_BEGIN_S:g} s.")
        if self._refused:
            raise OperateError(f"no server can listen at {host} port {port} ({self._refused}); give another --port.")

    def _main(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._task = self._loop.create_task(self._serve())
        with suppress(asyncio.CancelledError):
            self._loop.run_until_complete(self._task)
        others = asyncio.all_tasks(self._loop)
        for task in others:
            task.cancel()
        self._loop.run_until_complete(asyncio.gather(*others, return_exceptions=True))
        self._loop.run_until_complete(self._loop.shutdown_default_executor())
        self._loop.close()

    async def _serve(self) -> None:
        try:
            await self.start()
        except (OSError, RuntimeError) as error:
            self._refused = getattr(error, "strerror", None) or str(error)
            return
        finally:
            self._ready.set()
        while True:
            await asyncio.sleep(_CYCLE_S)
            self.program.tick(time.monotonic())

    async def start(self) -> None:
        """Begin to listen."""
        raise NotImplementedError

    async def stop(self) -> None:
        """End to listen."""
        raise NotImplementedError

    @property
    def link(self) -> str:
        """How a cell's file names it."""
        raise NotImplementedError

    def close(self) -> None:
        """End the server and its thread."""
        with suppress(Exception):
            self.call(self.stop)
        self._loop.call_soon_threadsafe(self._task.cancel)
        self._thread.join(20)

    def call(self, work: Callable[[], object]) -> None:
        """Do something in the server's thread, and wait for it."""

        async def wrapped() -> None:
            result = work()
            if asyncio.iscoroutine(result):
                await result

        asyncio.run_coroutine_threadsafe(wrapped(), self._loop).result(30)

    def take(self, order: dict[str, Any]) -> None:
        """Give the program an order by the words' names."""
        node = None
        if order["Sequence"]:
            sequence, number, lasts_us, routine = (
                order[name] for name in ("Sequence", "Node", "DurationUs", "Routine")
            )
            node = Received(sequence, number, lasts_us, routine, tuple(order["Outputs"]), tuple(order["Joints"]))
        heartbeat, command, permitted, watchdog_ms, run = (int(order[name]) for name in BEAT)
        self.program.order((heartbeat, command, permitted, watchdog_ms, run), node, order["Check"])

    def status(self) -> dict[str, Any]:
        """Give the program's status by the words' names."""
        with self.program.lock:
            now = self.program
            values = (
                now.epoch, now.mode, now.open, now.taken, now.accepted, now.check, now.reached, now.inputs,
                [*now.readings],
            )  # fmt: skip
            return dict(zip(names_of(STATUS), values, strict=True))


class ModbusServer(Server):
    """A controller behind Modbus TCP."""

    at_once = True
    """Whether it knows function 23."""

    def __init__(self, program: ControllerProgram, loaded: LoadedCell, link: ModbusLink, host: str, port: int) -> None:
        """Begin to serve, with the registers of a link."""
        self.spec = link
        super().__init__(program, loaded, host, port)

    async def start(self) -> None:
        """Begin to listen."""
        from pymodbus import FramerType
        from pymodbus.server import ModbusTcpServer
        from pymodbus.simulator import DataType, SimData, SimDevice

        count = max(self.spec.orders_at, self.spec.status_at) + 130
        block = SimData(0, count=count, values=0, datatype=DataType.REGISTERS)
        device = SimDevice(id=self.spec.unit, simdata=[block], action=self._access)
        self._server = ModbusTcpServer(device, framer=FramerType.SOCKET, address=(self.host, self.port))
        await self._server.serve_forever(background=True)

    async def _access(
        self,
        code: int,
        begin: int,
        address: int,
        count: int,
        registers: list[int],
        values: list[int] | list[bool] | None,
    ) -> Any:
        from pymodbus.constants import ExcCodes

        at = self.spec.status_at
        if code == _BOTH and not self.at_once:
            return ExcCodes.ILLEGAL_FUNCTION
        if code in (_WRITE, _BOTH) and address == self.spec.orders_at and values:
            self.take_registers([int(value) for value in values])
        elif code in (_READ, _BOTH) and address <= at < address + count:
            words = self.status_registers()
            registers[at - begin : at - begin + len(words)] = words
        return None

    def take_registers(self, words: list[int]) -> None:
        """Give the program an order as it was written; one of another length is none."""
        elements = elements_of(self.loaded)
        counts = len(elements["Outputs"]), len(elements["Joints"])
        if len(words) == count_registers(ORDER, sum(counts)):
            self.take(unpack(ORDER, words, counts))

    def status_registers(self) -> list[int]:
        """Give the status as it is read."""
        return pack(STATUS, self.status())

    async def stop(self) -> None:
        """End to listen."""
        await self._server.shutdown()

    @property
    def link(self) -> str:
        """How a cell's file names it."""
        spec = self.spec
        return (
            f"{{kind: modbus, host: {self.host}, port: {self.port}, unit: {spec.unit}, "
            f"orders_at: {spec.orders_at}, status_at: {spec.status_at}}}"
        )


class OpcuaServer(Server):
    """A controller behind OPC UA, with the cell's set of nodes; it takes what was written when its status is read."""

    def __init__(self, program: ControllerProgram, loaded: LoadedCell, link: OpcuaLink, host: str, port: int) -> None:
        """Begin to serve, with the object of a link."""
        self.spec = link
        self.url = f"opc.tcp://{host}:{port}/washboard"
        self._taken: tuple[int, ...] = (0,) * len(BEAT)
        super().__init__(program, loaded, host, port)

    async def start(self) -> None:
        """Begin to listen."""
        from asyncua import Server as OpcServer
        from asyncua import ua

        self._ua = ua
        self._server = OpcServer()
        await self._server.init()
        self._server.set_endpoint(self.url)
        self._server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
        await self._server.import_xml(xmlstring=render_node_set(self.loaded, self.spec))
        index = await self._server.get_namespace_index(self.spec.namespace)
        folder = await self._server.nodes.objects.get_child(f"{index}:{self.spec.object}")
        words = {word.name: await folder.get_child(f"{index}:{word.name}") for word in (*ORDER, *STATUS)}
        space = self._server.iserver.aspace

        def read(name: str) -> Any:
            return space.read_attribute_value(words[name].nodeid, ua.AttributeIds.Value).Value.Value

        def report(word: Any) -> Callable[..., Any]:
            def value(*_: object) -> Any:
                if word is STATUS[0]:  # the first that is read takes the order
                    self._take(read)
                return ua.DataValue(ua.Variant(self.status()[word.name], ua.VariantType[word.kind]))

            return value

        for word in STATUS:
            self._server.set_attribute_value_callback(words[word.name].nodeid, report(word))
        await self._server.start()

    def _take(self, read: Callable[[str], Any]) -> None:
        beat = tuple(int(read(name)) for name in BEAT)
        if beat != self._taken:  # somebody only looks
            self._taken = beat
            self.take({name: read(name) for name in names_of(ORDER)})

    async def stop(self) -> None:
        """End to listen."""
        await self._server.stop()

    @property
    def link(self) -> str:
        """How a cell's file names it."""
        return f"{{kind: opcua, url: '{self.url}', namespace: '{self.spec.namespace}', object: {self.spec.object}}}"


def serve(
    program: ControllerProgram, loaded: LoadedCell, link: ModbusLink | OpcuaLink, host: str, port: int
) -> ModbusServer | OpcuaServer:
    """Serve a controller's program by a link.

    Args:
        program: The program.
        loaded: The cell whose outputs, joints and sensors it has.
        link: Kind, registers or names; its address is not that of the server.
        host: Address to listen at.
        port: Likewise; 0 for any that is free.

    Raises:
        OperateError: the address is taken, or the extra is missing.
    """
    try:
        import asyncua as _asyncua
        import pymodbus as _pymodbus
    except ImportError:
        raise OperateError("a controller is simulated with `pip install washboard[operate]`.") from None
    for library in (_asyncua, _pymodbus):
        logging.getLogger(library.__name__).setLevel(logging.CRITICAL)
    try:
        chosen = port or free_port(host)
    except OSError as error:
        raise OperateError(
            f"no server can listen at {host} ({error.strerror}); give an address of this machine."
        ) from None
    if isinstance(link, ModbusLink):
        return ModbusServer(program, loaded, link, host, chosen)
    return OpcuaServer(program, loaded, link, host, chosen)
