"""The reference controller with faults that tests cause, and what it received and when each valve opened and shut."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeAlias

from robotcell.cell.load import LoadedCell
from robotcell.operate.interface import link_of
from robotcell.operate.reference.program import (
    HELD,
    HOLD,
    HOME,
    RUN,
    STOP,
    ControllerProgram,
    Received,
)
from robotcell.operate.reference.servers import ModbusServer, OpcuaServer, free_port

__all__ = ["HELD", "HOLD", "HOME", "RUN", "STOP", "Received", "free_port"]


@dataclass
class ModelController(ControllerProgram):
    """A controller's program with faults."""

    haste: float = 0.0
    acknowledge_after_s: float = 0.0
    spoil_at: int = 0
    """Sequence number of the node whose checksum is answered wrongly."""
    ignores_from: int = 1 << 40
    """Sequence number from which on nothing is acknowledged."""
    at_once: bool = True
    """Whether its server knows function 23 of Modbus."""
    halted: bool = False
    """Whether its program stands still, while its server answers."""
    stuck: bool = False
    """Whether a valve that is open stays so."""
    at_node: Callable[[int], None] = lambda _: None
    """Called when the node of a sequence number is reached."""
    received: list[Received] = field(default_factory=list)
    switched: list[tuple[float, bool]] = field(default_factory=list)
    """When the jet began and ended, on the clock of ``time.monotonic``."""
    longest_cycle_s: float = 0.0
    """Between two of its cycles: a real controller's is a few ms, whatever other computers do."""
    _ticked_at: float = float("inf")
    _first_seen: dict[int, float] = field(default_factory=dict)

    def order(self, beat: tuple[int, int, int, int, int], node: Received | None, check: int) -> None:
        if not self.halted:
            super().order(beat, node, check)

    def tick(self, now: float) -> None:
        if not self.halted:
            self.longest_cycle_s, self._ticked_at = max(self.longest_cycle_s, now - self._ticked_at), now
            super().tick(now)

    def _receive(self, node: Received, check: int) -> None:
        now, before = time.monotonic(), self.accepted
        if node.sequence >= self.ignores_from:
            return
        if now - self._first_seen.setdefault(node.sequence, now) < self.acknowledge_after_s:
            return
        super()._receive(node, check)
        if self.accepted > before:
            self.received.append(node)
            self.check ^= node.sequence == self.spoil_at

    def _stand(self, now: float) -> None:
        """Make up for the time that the link took: on a busy machine nodes of 2 ms come late over OPC UA."""

    def _reach(self, node: Received) -> None:
        super()._reach(node)
        self.at_node(node.sequence)

    def _switch(self) -> None:
        before = self.open
        super()._switch()
        self.open = self.open or (self.stuck and before)
        if self.open != before:
            self.switched.append((time.monotonic(), self.open))

    def restart(self) -> None:
        """Start the program anew, as after a power cut."""
        with self.lock:
            self.epoch += 1
            self._begin(0)
            self._command(STOP, permitted=False)
            self._switch()


class ModbusController(ModbusServer):
    """The reference controller of a cell, here the small one, behind Modbus TCP."""

    def __init__(self, model: ModelController, port: int = 0, loaded: LoadedCell | None = None) -> None:
        loaded = loaded or _small()
        link = link_of(loaded, "modbus")
        super().__init__(model, loaded, link, "127.0.0.1", port or free_port())  # type: ignore[arg-type]

    @property
    def model(self) -> ModelController:
        assert isinstance(self.program, ModelController)
        return self.program

    @model.setter
    def model(self, model: ModelController) -> None:
        self.program = model

    @property
    def at_once(self) -> bool:  # type: ignore[override]
        return self.model.at_once

    def cut(self) -> None:
        """End every connection, in the middle of whatever is on its way."""
        self.call(self._server.shutdown)

    def serve_again(self) -> None:
        """Take connections again."""
        self.call(self.start)


class OpcuaController(OpcuaServer):
    """The reference controller of the small cell behind OPC UA."""

    def __init__(self, model: ModelController) -> None:
        loaded = _small()
        link = link_of(loaded, "opcua")
        super().__init__(model, loaded, link, "127.0.0.1", free_port())  # type: ignore[arg-type]

    model = ModbusController.model

    def cut(self) -> None:
        """End the connections; the port stays open, as a server takes seconds to begin."""
        self.call(lambda: [each.transport.abort() for each in [*self._server.bserver.clients]])

    def serve_again(self) -> None:
        """The port stayed open."""


Controller: TypeAlias = ModbusController | OpcuaController


def _small() -> LoadedCell:
    from operated import small_cell

    return small_cell()


def modbus(port: int) -> str:
    """How a cell names a Modbus controller on this computer."""
    return f"{{kind: modbus, host: 127.0.0.1, port: {port}}}"


def opcua(url: str) -> str:
    """How a cell names an OPC UA controller."""
    return f"{{kind: opcua, url: '{url}'}}"
