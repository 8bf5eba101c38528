"""The program of a controller as docs/operating.md describes it: one queue, one set of valves, one watchdog."""

import threading
import time
from dataclasses import dataclass, field

from robotcell.cell.load import LoadedCell
from robotcell.cell.spec import Sensor
from robotcell.operate.drive import terms_of
from robotcell.operate.handshake import COMMANDS, MODES
from robotcell.operate.nodes import still_job
from robotcell.operate.words import checksum

STOP, HOLD, HOME, RUN = range(len(COMMANDS))
STOPPED, HELD, HOMING, AT_HOME, RUNNING = range(len(MODES))
_MODES = {STOP: STOPPED, HOLD: HELD, HOME: AT_HOME, RUN: RUNNING}


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
class ControllerProgram:
    """The program of a controller whose robot is at once at home, and then keeps the times of the nodes."""

    valves: tuple[int, ...]
    """Indices of the outputs that are valves."""
    inputs: int
    """Bit n is input n."""
    readings: tuple[int, ...] = ()
    haste: float = 1.0
    """Share of each node's time that it takes; 0 for none."""
    epoch: int = 1
    mode: int = STOPPED
    command: int = STOP
    permitted: bool = False
    run: int = 0
    accepted: int = 0
    check: int = 0
    reached: int = 0
    at: Received | None = None
    """The node reached last."""
    open: bool = False
    """Whether a valve is."""
    queue: list[Received] = field(default_factory=list[Received])
    lock: threading.RLock = field(default_factory=threading.RLock)
    _heartbeat: int = -1
    _beat_at: float = 0.0
    _watchdog_s: float = 10.0
    _expired: bool = False
    """Whether the watchdog has expired in this run."""
    _due: float = 0.0
    """When the node before the first of the queue was to be reached."""

    @property
    def taken(self) -> int:
        """Heartbeat of the last order that the program took."""
        return max(self._heartbeat, 0)

    @property
    def open_valves(self) -> tuple[int, ...]:
        """Indices of the outputs that are open valves."""
        return tuple(index for index in self.valves if self.open and self.at and self.at.outputs[index])

    def order(self, beat: tuple[int, int, int, int, int], node: Received | None, check: int) -> None:
        """Take an order: heartbeat, command, jet permitted, watchdog in ms, run; the node with its checksum."""
        with self.lock:
            now = time.monotonic()
            heartbeat, command, permitted, watchdog_ms, run = beat
            if self._heartbeat < 0:  # what was left there before it began is no order
                command, permitted = STOP, 0
            if heartbeat != self._heartbeat:
                self._heartbeat, self._beat_at = heartbeat, now
            self._watchdog_s = watchdog_ms / 1e3
            if run != self.run:
                self._begin(run)
            if self._expired:
                command, permitted = STOP, 0
            if command == RUN and self.command != RUN:
                self._due = now
            self._command(command, permitted=bool(permitted))
            if node is not None and command == RUN and node.sequence == self.accepted + 1:
                self._receive(node, check)
            self.tick(now)

    def _begin(self, run: int) -> None:
        """Begin a run: nothing of the one before is left."""
        self.run, self.accepted, self.check, self.reached, self.at = run, 0, 0, 0, None
        self.queue.clear()
        self._expired = False

    def _command(self, command: int, *, permitted: bool) -> None:
        """Do as is ordered; after a stop nothing is left to be reached, and no valve is open."""
        if command == STOP:
            self.queue.clear()
            self.at = None
        self.command, self.permitted, self.mode = command, permitted, _MODES[command]

    def _receive(self, node: Received, check: int) -> None:
        """Accept the next node, if it arrived as it was sent."""
        plain = (self.run, node.sequence, node.number, node.lasts_us, node.routine)
        found = checksum(plain, (*node.outputs, *node.joints))
        if found == check:
            self.accepted, self.check = node.sequence, found
            self.queue.append(node)

    def tick(self, now: float) -> None:
        """One cycle of the controller, at a time of ``time.monotonic``."""
        with self.lock:
            if now - self._beat_at > self._watchdog_s:
                self._expire()
            while self.command == RUN and self.queue and now >= self._due + self.haste * self.queue[0].lasts_us / 1e6:
                self._due = now if self.haste == 0 else self._due + self.haste * self.queue[0].lasts_us / 1e6
                self._reach(self.queue.pop(0))
            if self.command == RUN and not self.queue:
                self._stand(now)
            self._switch()

    def _stand(self, now: float) -> None:
        """Stand with an empty queue: the time of the next node begins when it comes."""
        self._due = max(self._due, now)

    def _expire(self) -> None:
        """Stop until another run begins."""
        self._expired = True
        self._command(STOP, permitted=False)

    def _reach(self, node: Received) -> None:
        self.reached, self.at = node.sequence, node
        self._switch()

    def _switch(self) -> None:
        """Open or shut the valves: open while the outputs state so, the jet is permitted, and it runs."""
        states_so = self.at is not None and any(self.at.outputs[index] for index in self.valves)
        self.open = states_so and self.permitted and self.command == RUN

    def set_input(self, number: int, *, on: bool) -> None:
        """Change a digital input."""
        with self.lock:
            self.inputs = self.inputs | 1 << number if on else self.inputs & ~(1 << number)


def program_for(loaded: LoadedCell) -> ControllerProgram:
    """Give a controller's program for a cell, with every condition met and readings that end loops.

    Raises:
        OperateError: the cell cannot be operated.
    """
    job = still_job(loaded)
    terms = terms_of(loaded, job)
    inputs = sum(1 << number for number, state in {*terms.conditions.values()} if state)
    valves = tuple(index for index, name in enumerate(job.outputs) if name in job.valves)
    return ControllerProgram(valves, inputs, tuple(_best(sensor) for _, sensor in terms.sensors.values()))


def _best(sensor: Sensor) -> int:
    """The reading of a sensor whose quantity is the largest, 1e-6 V or mA."""
    return round(1e6 * sensor.full_scale) if sensor.scale > 0 else 0
