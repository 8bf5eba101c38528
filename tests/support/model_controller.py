"""A robot's controller as the handshake of docs/operating.md describes it, behind real Modbus TCP and OPC UA servers.

It reads the registers and the checksum by formats of its own, not by those of the product, and keeps what it received
and when each valve opened and shut.
"""

import asyncio
import socket
import struct
import threading
import time
import zlib
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field

from asyncua import Server, ua
from pymodbus import FramerType
from pymodbus.constants import ExcCodes
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

STOP, HOLD, HOME, RUN = range(4)
STOPPED, HELD, HOMING, AT_HOME, RUNNING = range(5)
ORDERS_AT, STATUS_AT = 0, 200
NOTHING_MS = 0


@dataclass(frozen=True, slots=True)
class Received:
    """A node as it arrived."""

    sequence: int
    number: int
    lasts_us: int
    routine: int
    outputs: tuple[int, ...]
    joints: tuple[int, ...]


@dataclass(slots=True)
class ModelController:
    """The controller's program: one queue, one set of valves, one watchdog."""

    valves: tuple[int, ...]
    """Indices of the outputs that are valves."""
    outputs: int
    joints: int
    inputs: int
    """Bit n is input n."""
    readings: tuple[int, ...] = ()
    haste: float = 0.0
    """Share of each node's time that it takes; 0 for none."""
    epoch: int = 1
    acknowledge_after_s: float = 0.0
    spoil_at: int = 0
    """Sequence number of the node whose checksum is answered wrongly."""
    ignores_from: int = 1 << 40
    """Sequence number from which on nothing is acknowledged."""
    at_once: bool = True
    """Whether it knows function 23 of Modbus."""
    halted: bool = False
    """Whether its program stands still, while its server answers."""
    stuck: bool = False
    """Whether a valve that is open stays so."""
    at_node: Callable[[int], None] = lambda _: None
    """Called when the node of a sequence number is reached."""
    received: list[Received] = field(default_factory=list)
    switched: list[tuple[float, bool]] = field(default_factory=list)
    """When the jet began and ended, on the clock of ``time.monotonic``."""
    lock: threading.RLock = field(default_factory=threading.RLock)
    mode: int = STOPPED
    command: int = STOP
    permitted: bool = False
    run: int = 0
    accepted: int = 0
    check: int = 0
    reached: int = 0
    open: bool = False
    queue: list[Received] = field(default_factory=list)
    _pending: tuple[float, Received, int] | None = None
    _heartbeat: int = -1
    _beat_at: float = 0.0
    _watchdog_s: float = 10.0
    _expired: bool = False
    """Whether the watchdog has expired in this run."""
    _ticked_at: float = float("inf")
    longest_cycle_s: float = 0.0
    """Between two of its cycles: a real controller's is a few ms, whatever other computers do."""
    _due: float = 0.0

    def order(self, beat: tuple[int, int, int, int, int], node: Received | None, check: int) -> None:
        """Take an order: heartbeat, command, jet permitted, watchdog in ms, run; the node with its checksum."""
        with self.lock:
            if self.halted:
                return
            now = time.monotonic()
            heartbeat, command, permitted, watchdog_ms, run = beat
            if self._heartbeat < 0:  # what was left there before it began is no order
                command, permitted = STOP, 0
            if heartbeat != self._heartbeat:
                self._heartbeat, self._beat_at = heartbeat, now
            self._watchdog_s = watchdog_ms / 1e3
            if run != self.run:
                self.run, self.accepted, self.check, self.reached, self._pending = run, 0, 0, 0, None
                self.queue.clear()
                self._expired = False
            if self._expired:
                command, permitted = STOP, False
            if command == RUN and self.command != RUN:
                self._due = now
            self.command, self.permitted = command, bool(permitted)
            self.mode = {STOP: STOPPED, HOLD: HELD, HOME: AT_HOME, RUN: RUNNING}[command]
            if command == STOP:
                self.queue.clear()
            fresh = node is not None and node.sequence == self.accepted + 1 and command == RUN
            if fresh and node is not None and self._pending is None and node.sequence < self.ignores_from:
                self._pending = (now + self.acknowledge_after_s, node, check)
            self.tick(now)

    def tick(self, now: float) -> None:
        """One cycle of the controller."""
        with self.lock:
            if self.halted:
                return
            self.longest_cycle_s, self._ticked_at = max(self.longest_cycle_s, now - self._ticked_at), now
            if now - self._beat_at > self._watchdog_s:
                self._expired = True
                self.command, self.permitted, self.mode = STOP, False, STOPPED
                self.queue.clear()
            if self._pending is not None and now >= self._pending[0]:
                _, node, check = self._pending
                self._pending = None
                self.accepted, self.check = node.sequence, self._check(node, check)
                self.received.append(node)
                self.queue.append(node)
            while self.command == RUN and self.queue and now >= self._due + self.haste * self.queue[0].lasts_us / 1e6:
                node = self.queue.pop(0)
                self._due = now if self.haste == 0 else self._due + self.haste * node.lasts_us / 1e6
                self.reached = node.sequence
                self._set(any(node.outputs[index] for index in self.valves))
                self.at_node(node.sequence)
            if not (self.permitted and self.command == RUN):
                self._set(False)

    @property
    def taken(self) -> int:
        """Heartbeat of the last order that the program took."""
        return max(self._heartbeat, 0)

    def _check(self, node: Received, stated: int) -> int:
        words = (self.run, node.sequence, node.number, node.lasts_us, node.routine)
        data = struct.pack(">5L", *words) + b"".join(
            (value % 2**32).to_bytes(4, "big") for value in (*node.outputs, *node.joints)
        )
        found = zlib.crc32(data)
        assert found == stated, "the checksum of the order is not that of its content"
        return found ^ 1 if node.sequence == self.spoil_at else found

    def _set(self, is_open: bool) -> None:
        is_open = (is_open and self.permitted and self.command == RUN) or (self.stuck and self.open)
        if is_open != self.open:
            self.open = is_open
            self.switched.append((time.monotonic(), is_open))

    def set_input(self, number: int, *, on: bool) -> None:
        """Change a digital input; at an emergency stop the hardware opens the valves' circuit by itself."""
        with self.lock:
            self.inputs = self.inputs | 1 << number if on else self.inputs & ~(1 << number)

    def restart(self) -> None:
        """Start the program anew, as after a power cut."""
        with self.lock:
            self.epoch += 1
            self.command, self.permitted, self.mode = STOP, False, STOPPED
            self.run = self.accepted = self.check = self.reached = 0
            self.queue.clear()
            self._pending = None
            self._set(False)


class Controller:
    """A server in a thread of its own, with the cycle of the controller."""

    def __init__(self, model: ModelController) -> None:
        self.model = model
        self._loop = asyncio.new_event_loop()
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._main, daemon=True)
        self._thread.start()
        if not self._ready.wait(60):
            raise TimeoutError("the server did not start")

    def _main(self) -> None:
        asyncio.set_event_loop(self._loop)
        with suppress(asyncio.CancelledError):
            self._task = self._loop.create_task(self._begin())
            self._loop.run_until_complete(self._task)
        others = asyncio.all_tasks(self._loop)
        for task in others:
            task.cancel()
        self._loop.run_until_complete(asyncio.gather(*others, return_exceptions=True))
        self._loop.run_until_complete(self._loop.shutdown_default_executor())
        self._loop.close()

    async def _begin(self) -> None:
        await self.start()
        self._ready.set()
        while True:
            await asyncio.sleep(0.002)
            self.model.tick(time.monotonic())

    async def start(self) -> None:
        raise NotImplementedError

    async def stop(self) -> None:
        raise NotImplementedError

    @property
    def link(self) -> str:
        """How a cell names it."""
        raise NotImplementedError

    def cut(self) -> None:
        """End every connection, in the middle of whatever is on its way."""
        raise NotImplementedError

    def serve_again(self) -> None:
        """Take connections again."""
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


class ModbusController(Controller):
    """A controller behind a Modbus TCP server."""

    def __init__(self, model: ModelController, port: int = 0) -> None:
        self.port = port or free_port()
        super().__init__(model)

    async def start(self) -> None:
        block = SimData(0, count=400, values=0, datatype=DataType.REGISTERS)
        device = SimDevice(id=1, simdata=[block], action=self._access)
        self._server = ModbusTcpServer(device, framer=FramerType.SOCKET, address=("127.0.0.1", self.port))
        await self._server.serve_forever(background=True)

    async def _access(
        self, code: int, begin: int, address: int, count: int, registers: list[int], values: list[int] | None
    ) -> ExcCodes | None:
        if code == 23 and not self.model.at_once:
            return ExcCodes.ILLEGAL_FUNCTION
        if code in (16, 23) and address == ORDERS_AT and values:
            self._order([int(value) for value in values])
        elif code in (3, 23) and address <= STATUS_AT < address + count:
            words = self._status()
            registers[STATUS_AT - begin : STATUS_AT - begin + len(words)] = words
        return None

    def _order(self, words: list[int]) -> None:
        data = b"".join(word.to_bytes(2, "big") for word in words)
        beat = struct.unpack_from(">4HL", data)
        sequence, number, lasts, check, routine = struct.unpack_from(">4LH", data, 12)
        values = struct.unpack_from(f">{(len(data) - 30) // 4}l", data, 30)
        assert len(values) == self.model.outputs + self.model.joints
        outputs, joints = values[: self.model.outputs], values[self.model.outputs :]
        self.model.order(beat, Received(sequence, number, lasts, routine, outputs, joints), check)

    def _status(self) -> list[int]:
        with self.model.lock:
            now = self.model
            words = [now.epoch, now.mode, int(now.open), now.taken]
            for value in (now.accepted, now.check, now.reached):
                words += [value >> 16, value & 0xFFFF]
            words += [now.inputs >> shift & 0xFFFF for shift in (48, 32, 16, 0)]
            for value in now.readings:
                words += [value >> 16 & 0xFFFF, value & 0xFFFF]
            return words

    @property
    def link(self) -> str:
        return modbus(self.port)

    def cut(self) -> None:
        self.call(self._server.shutdown)

    def serve_again(self) -> None:
        self.call(self.start)

    async def stop(self) -> None:
        await self._server.shutdown()


ORDER_TYPES = {
    "Heartbeat": "UInt16", "Command": "UInt16", "JetPermitted": "Boolean", "WatchdogMs": "UInt16", "Run": "UInt32",
    "Node": "UInt32", "DurationUs": "UInt32", "Routine": "UInt16", "Outputs": "Int32", "Joints": "Int32",
    "Check": "UInt32", "Sequence": "UInt32",
}  # fmt: skip
STATUS_TYPES = {
    "Epoch": "UInt16", "Mode": "UInt16", "JetOn": "Boolean",
    "HeartbeatTaken": "UInt16", "Accepted": "UInt32", "AcceptedCheck": "UInt32",
    "Reached": "UInt32", "Inputs": "UInt64", "Readings": "Int32",
}  # fmt: skip


class OpcuaController(Controller):
    """A controller behind an OPC UA server; it acts on what was written when its status is read."""

    def __init__(self, model: ModelController) -> None:
        self.url = f"opc.tcp://127.0.0.1:{free_port()}/washboard"
        super().__init__(model)

    async def start(self) -> None:
        self._server = Server()
        await self._server.init()
        self._server.set_endpoint(self.url)
        self._server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
        index = await self._server.register_namespace("urn:washboard")
        folder = await self._server.nodes.objects.add_object(index, "Washboard")
        self._orders, self._statuses = {}, {}
        self._taken: tuple[int, ...] = (0, 0, 0, 0, 0)
        for types, into in ((ORDER_TYPES, self._orders), (STATUS_TYPES, self._statuses)):
            for name, kind in types.items():
                value = [0] if name in ("Outputs", "Joints", "Readings") else kind == "none" if kind == "Boolean" else 0
                into[name] = await folder.add_variable(index, name, value, ua.VariantType[kind])
                if into is self._orders:
                    await into[name].set_writable()
        self._space = self._server.iserver.aspace
        for name in self._statuses:
            self._server.set_attribute_value_callback(
                self._statuses[name].nodeid, lambda *_, name=name: self._value(name)
            )
        await self._server.start()

    @property
    def link(self) -> str:
        return opcua(self.url)

    def cut(self) -> None:
        """End the connections; the port stays open, as a server takes seconds to begin."""
        self.call(lambda: [each.transport.abort() for each in [*self._server.bserver.clients]])

    def serve_again(self) -> None:
        pass

    def _value(self, name: str) -> ua.DataValue:
        """Give a variable of the status; the first that is read takes the order first."""
        if name == "Epoch":
            self._take()
        now = self.model
        values = {
            "Epoch": now.epoch, "Mode": now.mode, "JetOn": now.open,
            "HeartbeatTaken": now.taken, "Accepted": now.accepted,
            "AcceptedCheck": now.check, "Reached": now.reached, "Inputs": now.inputs, "Readings": list(now.readings),
        }  # fmt: skip
        return ua.DataValue(ua.Variant(values[name], ua.VariantType[STATUS_TYPES[name]]))

    def _take(self) -> None:
        def read(name: str) -> object:
            return self._space.read_attribute_value(self._orders[name].nodeid, ua.AttributeIds.Value).Value.Value

        beat = tuple(int(read(name)) for name in ("Heartbeat", "Command", "JetPermitted", "WatchdogMs", "Run"))
        if beat == self._taken:  # somebody only looks
            return
        self._taken = beat
        node = None
        if read("Sequence"):
            words = (int(read(name)) for name in ("Sequence", "Node", "DurationUs", "Routine"))
            node = Received(*words, tuple(read("Outputs")), tuple(read("Joints")))
        self.model.order(beat, node, int(read("Check")))

    async def stop(self) -> None:
        await self._server.stop()


def modbus(port: int) -> str:
    """How a cell names a Modbus controller on this computer."""
    return f"{{kind: modbus, host: 127.0.0.1, port: {port}}}"


def opcua(url: str) -> str:
    """How a cell names an OPC UA controller."""
    return f"{{kind: opcua, url: '{url}'}}"


def free_port() -> int:
    """Give a port that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
