"""Feeds a controller: events of link and operator go to the state machine, its state goes out as an order."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from statistics import median
from time import monotonic, sleep
from typing import TypeAlias

from robotcell.cell.load import LoadedCell
from robotcell.cell.operate_spec import Condition, OperateSpec
from robotcell.cell.spec import Sensor, Wait
from robotcell.operate.handshake import MOST_INPUTS, Link, LinkError, OperateError, Order, Planned, Status, check_of
from robotcell.operate.interface import operated
from robotcell.operate.log import Log
from robotcell.operate.nodes import JOINT_DIGITS, Feed, Job, Loop, Node
from robotcell.operate.states import (
    Arm,
    Event,
    Fault,
    NotShut,
    Operation,
    Reached,
    Rules,
    Sensed,
    State,
    Unmet,
    advance,
)

_POLL_S = 0.005
"""Between two looks at a controller that has enough nodes."""
_SEEN_S = 0.1
"""In so long another operation has sent an order, also while it waits for a part with the controller stopped."""
_SHUT_S = 0.1
"""Longest wait for the confirmation that every valve is shut."""
_MEASURED = 7
"""Orders whose way to the controller's program and back is measured before the start."""
_SLOWER = 0.02
"""Share of the jet's time that a controller may take more: its clock is another one."""
_WORD, _LARGEST = 0x10000, 0xFFFFFFFF
_MICRO = 1e-6


@dataclass(frozen=True, slots=True)
class Snapshot:
    """An operation at one moment, for whoever shows it."""

    state: State
    reason: str
    """Why it is faulted, and why it is not known that every valve is shut."""
    node: Node | None
    """The last one reached; ``None`` before the first."""
    jets: tuple[str, ...]
    """Valves that may be open."""
    conditions: Mapping[str, bool]
    """Interlocks and sensors by name, as last reported."""
    quantities: Mapping[str, float]
    """Of the cell's sensors by key, as last reported."""
    joints: tuple[float, ...]
    """Degrees or mm: those of the node reached, and on the straight way to the next one by the time since; empty before
    the first."""
    age_s: float
    """Since the order whose status is shown was sent; infinite before the first."""
    seconds: float
    """Since the operation began."""


Controls: TypeAlias = Callable[[], "Event | None"]
"""The operator: the next event, or ``None`` where there is none; called before every order."""


@dataclass(frozen=True, slots=True)
class Terms:
    """What a cell states of its operation."""

    spec: OperateSpec
    conditions: Mapping[str, tuple[int, bool]]
    """Number of the input and state in which it is met, by the condition's name."""
    sensors: Mapping[str, tuple[int, Sensor]]
    """Index of the reading and the sensor, by key."""
    rules: Rules
    waits: Mapping[str, Wait] = field(default_factory=dict[str, Wait])
    """Those of ``io`` that ``operate`` does not have itself, by the condition's name."""


def terms_of(loaded: LoadedCell, job: Job) -> Terms:
    """Give the terms of a cell.

    Raises:
        OperateError: the cell has no ``operate``, an input that no link carries, or not the sensor that ends a loop.
    """
    spec = operated(loaded)

    def locate(condition: Condition) -> tuple[int, bool]:
        number = loaded.spec.io.inputs[condition.input].number
        if number >= MOST_INPUTS:
            raise OperateError(f"input {condition.input} has number {number}; a link carries inputs 0 to 63.")
        return number, condition.state == 1

    conditions = {name: locate(each) for name, each in spec.conditions.items()}
    sensed = frozenset(conditions) - frozenset(spec.interlocks)
    waits: dict[str, Wait] = {}
    for name, wait in loaded.spec.io.waits.items():
        located = None if wait.input is None else locate(Condition(input=wait.input, state=wait.state))
        if located is None or conditions.get(name) != located:
            waits[shown := name if name not in conditions else f"io.waits.{name}"] = wait
            conditions |= {} if located is None else {shown: located}
    states = {number: (name, state) for name, (number, state) in conditions.items()}
    for name, (number, state) in conditions.items():
        other, needed = states[number]
        if state != needed:
            raise OperateError(f"{name} and {other} need the same input in two states: state one of them otherwise.")
    watched = frozenset(name for name, wait in waits.items() if wait.watched)
    rules = Rules(frozenset(spec.interlocks), sensed, len(job.nodes), frozenset(waits), watched)
    sensors = {key: (index, each) for index, (key, each) in enumerate(loaded.spec.io.sensors.items())}
    for node in job.nodes:
        if isinstance(node.loop, Loop) and node.loop.key not in sensors:
            raise OperateError(
                f"node {node.number} begins a loop until {node.loop.key} is {node.loop.least:g}, and cell "
                f"{loaded.spec.cell} has no such sensor: state it under io.sensors."
            )
    return Terms(spec, conditions, sensors, rules, waits)


def planned_link(job: Job, terms: Terms) -> Planned:
    """Give the controller of a run without one."""
    inputs = sum(1 << number for number, state in dict.fromkeys(terms.conditions.values()) if state)
    readings = tuple((1 if sensor.scale > 0 else -1) * 10**15 for _, sensor in terms.sensors.values())
    return Planned(job, inputs, readings)


def standing(job: Job, first: int, period_s: float, queue: int) -> tuple[float, float, int]:
    """Give how long the robot would stand with the jet on, waiting for nodes.

    Args:
        job: Its nodes in their order, each loop once.
        first: The jet is permitted from this node on.
        period_s: From an order to its acknowledgement: the next node is sent then.
        queue: Nodes that the controller holds ahead of the one it has reached.

    Returns:
        Seconds of standing, seconds of the jet, and the number of the first node that comes too late; 0 for none.
    """
    reached = [0.0]
    stood = jet = sent = 0.0
    late = 0
    for index, node in enumerate(job.nodes):
        sent = max(sent + period_s, reached[max(index - queue + 1, 0)])
        is_on = index >= first and bool(job.open_valves(job.nodes[index - 1]))
        if is_on:
            jet += _MICRO * node.lasts_us
            stood += (behind := max(sent - reached[-1], 0.0))
            late = late or (node.number if behind else 0)
        reached.append(max(reached[-1], sent) + _MICRO * node.lasts_us)
    return stood, jet, late


@dataclass(slots=True)
class Drive:
    """One operation, from arming to its end, a fault, or the operator's stop."""

    job: Job
    terms: Terms
    link: Link
    log: Log
    controls: Controls = lambda: None
    clock: Callable[[], float] = monotonic
    rest: Callable[[float], None] = sleep
    run: int = 1
    operation: Operation = field(init=False)
    _feed: Feed = field(init=False)
    _sent: list[Node] = field(init=False, default_factory=list[Node])
    """Nodes in the order of their sequence numbers."""
    _accepted: int = 0
    _reached: int = 0
    _heartbeat: int = 0
    _epoch: int | None = None
    _status: Status | None = None
    _status_at: float = -float("inf")
    _answered_at: float = float("inf")
    """When the last status came; the order that it answers had arrived by then."""
    _opened: bool = False
    """Whether a node from the first with the jet on was sent: in a loop smaller numbers follow."""
    _waits_since: float = 0.0
    _sent_at: float = 0.0
    _reached_at: float = 0.0
    _in_mode_at: float = 0.0
    _taken: int | None = None
    """Heartbeat that the controller's program took last."""
    _taken_at: float = 0.0
    """Since when."""
    _sprayed: tuple[float, int] | None = None
    """Since the jet is on: when its first node was reached, and the planned time since that one, µs."""
    begun: float = field(init=False, default=0.0)
    """When it began, by its clock."""

    def __post_init__(self) -> None:
        """Begin idle."""
        self.operation = Operation(self.terms.rules)
        self._feed = Feed(self.job)

    def perform(self, first: int = 1) -> Operation:
        """Carry the operation out.

        Args:
            first: The jet is permitted from this node on; the way there is that of the program, with every valve shut.

        Returns:
            The operation where it is over: at its end, faulted, or idle after a stop or where an interlock is not met.
            Nothing goes on from there.

        Raises:
            OperateError: the controller cannot be reached at all, its program does not run, its link is too slow for
                the table, or another operation has it.
        """
        self.begun = self._waits_since = self.clock()
        try:
            self._find_free()
            period_s = 0.0 if isinstance(self.link, Planned) else median(self._measure() for _ in range(_MEASURED))
            self._find_own()
        except LinkError as error:
            raise OperateError(f"the controller does not take orders: {error}.") from None
        self._check_rate(first, period_s)
        try:
            self._exchange()
            self._apply(Arm(first))
            while not self.operation.is_over:
                if (event := self.controls()) is not None:
                    self._apply(event)
                if not self._exchange() and not self.operation.is_over:
                    self.rest(_POLL_S)
        except BaseException:
            self._apply(Fault("the operation was broken off by an error"))
            raise
        finally:
            self._shut()
        return self.operation

    def _find_free(self) -> None:
        """Look at the controller before anything is sent to it.

        Raises:
            OperateError: another operation has it.
        """
        if (before := self.link.look()) is None:
            return
        self.rest(min(_SEEN_S, self.terms.spec.watchdog_s))
        found = self.link.look() or before
        status, is_alive = found.status, (found.run, found.heartbeat) != (before.run, before.heartbeat)
        if status.mode != "stopped" or status.jet_on or is_alive:
            jet = ", and a valve is open" if status.jet_on else ""
            raise OperateError(
                f"the controller is {status.mode}{jet}: run {found.run} has it. Nothing was sent to it; end that run "
                "first."
            )

    def _find_own(self) -> None:
        """Look whether the controller has this run, after it was begun.

        Raises:
            OperateError: another operation began at the same moment, and was the later one.
        """
        if (found := self.link.look()) is not None and found.run != self.run:
            raise OperateError(f"run {found.run} took the controller over as this one began; it is left to that.")

    def _measure(self) -> float:
        """Give the seconds from an order to the status of a program that has taken it.

        Raises:
            LinkError: the controller cannot be reached.
            OperateError: its program does not take orders.
        """
        begun, before = self.clock(), self._heartbeat
        while True:
            sent_at = self.clock()
            self._take(self.link.exchange(self._order()), sent_at)
            if self._is_taken(before):
                return self.clock() - begun
            if self.clock() - begun > self.terms.spec.acknowledge_s:
                raise OperateError(
                    f"the controller answers, and its program took no order in {self.terms.spec.acknowledge_s:g} s: "
                    "the heartbeat in its status stands still. Start its program."
                )
            self.rest(_POLL_S)

    def _is_taken(self, before: int) -> bool:
        """Whether the controller's program has taken an order after the one of a heartbeat."""
        assert self._taken is not None
        return 0 < (self._taken - before) % _WORD <= (self._heartbeat - before) % _WORD

    def _check_rate(self, first: int, period_s: float) -> None:
        """Refuse a table whose nodes the link cannot bring in time.

        Raises:
            OperateError: the robot would stand with the jet on.
        """
        stood_s, jet_s, node = standing(self.job, first, period_s, self.terms.spec.queue)
        if stood_s > max(self.terms.spec.watchdog_s, _SLOWER * jet_s):
            raise OperateError(
                f"the link is too slow: an order takes {1e3 * period_s:.3g} ms until it is acknowledged, which is "
                f"{1.0 / period_s:.3g} nodes a second, and from node {node} on more are needed: the robot would stand "
                f"{stood_s:.3g} s with the jet on. Nothing was moved; give the controller's program a shorter cycle, "
                "or the link a shorter way."
            )

    def _apply(self, event: Event) -> None:
        """Advance the machine, and log it."""
        before, self.operation = self.operation, advance(self.operation, event)
        if self.operation.state != before.state:
            self._waits_since = self._reached_at = self._in_mode_at = self.clock()
            self._sprayed = None
        self.log.add(event, self.operation, self._jets(), self.clock() - self.begun)

    def _jets(self) -> tuple[str, ...]:
        """Valves that are permitted to be open at the node reached."""
        node = self._last_reached()
        if node is None or not self.operation.jet_permitted or self.operation.node < self.operation.first:
            return ()
        return self.job.open_valves(node)

    def _last_reached(self) -> Node | None:
        return self.job.nodes[self.operation.node - 1] if self.operation.node else None

    def snapshot(self) -> Snapshot:
        """Give the operation as it is now; another thread may call this at any time."""
        shown, status, now = self.operation, self._status, self.clock()
        return Snapshot(
            shown.state,
            "; ".join(filter(None, (shown.reason, shown.not_shut and f"NOT CONFIRMED SHUT: {shown.not_shut}"))),
            self._last_reached(),
            self._jets(),
            conditions={} if status is None else self._conditions(status),
            quantities={} if status is None else {key: self._quantity(key, status) for key in self.terms.sensors},
            joints=self._joints(now),
            age_s=now - self._status_at,
            seconds=now - self.begun,
        )

    def _joints(self, now: float) -> tuple[float, ...]:
        """Joints as the controller interpolates between nodes; it reports which nodes it reached, and no joints."""
        reached, sent = self._reached, self._sent
        if not reached:
            return ()
        last = following = sent[reached - 1]
        share = 0.0
        if self.operation.state == "running" and reached < len(sent) and sent[reached].lasts_us:
            following = sent[reached]
            share = min((now - self._reached_at) / (_MICRO * following.lasts_us), 1.0)
        pairs = zip(last.joints, following.joints, strict=True)
        return tuple((one + share * (other - one)) / 10**JOINT_DIGITS for one, other in pairs)

    def _take(self, status: Status, sent_at: float) -> None:
        self._status, self._status_at, self._answered_at = status, sent_at, self.clock()
        if status.heartbeat != self._taken:
            self._taken, self._taken_at = status.heartbeat, self._answered_at

    def _exchange(self) -> bool:
        """Send an order, take the status in; give whether a node was sent, accepted or reached."""
        silent, watchdog_s = self.clock() - self._answered_at, self.terms.spec.watchdog_s
        if not isinstance(self.link, Planned) and self.operation.command != "stop" and silent > watchdog_s:
            # The controller's queue was emptied: the next order must not let the robot go on without these nodes.
            expired = f"the controller's watchdog of {watchdog_s:g} s expired"
            self._apply(Fault(f"no order was sent for {silent:.2f} s, so that {expired}"))
        sent, sent_at = self._offer(), self.clock()
        try:
            status = self.link.exchange(self._order())
        except LinkError as error:
            self._apply(Fault(f"the link is cut: {error}"))
            return False
        self._take(status, sent_at)
        accepted, reached = self._accepted, self._reached
        if reason := self._check(status):
            self._apply(Fault(reason))
            return False
        conditions = self._conditions(status)
        for name in sorted(self.operation.relevant):
            if conditions[name] != (name in self.operation.met):
                self._apply(Sensed(name, conditions[name]))
        self._follow(status)
        if late := self._late():
            self._apply(Fault(late))
        return sent or (self._accepted, self._reached) != (accepted, reached)

    def _offer(self) -> bool:
        """Take the next node, if the controller has room for it and has accepted the one before."""
        if self.operation.state != "running" or self._accepted < len(self._sent):
            return False
        if len(self._sent) - self._reached >= self.terms.spec.queue:
            return False
        if (loop := self._feed.question) is not None:
            if self._reached < len(self._sent):
                return False
            value = -float("inf") if self._status is None else self._quantity(loop.key, self._status)
            if not self._feed.decide(value):
                self._apply(Unmet(f"{loop.key} {value:g} of {loop.least:g} after {loop.count} turns"))
        if self._feed.is_done:
            return False
        node = self._feed.take()
        self._opened = self._opened or node.number >= self.operation.first
        self._sent.append(node if self._opened else self.job.shut(node))
        self._sent_at = self.clock()
        return True

    def _quantity(self, key: str, status: Status) -> float:
        index, sensor = self.terms.sensors[key]
        return sensor.scale * _MICRO * status.readings[index] + sensor.offset

    def _order(self) -> Order:
        self._heartbeat = (self._heartbeat + 1) % _WORD
        sequence = len(self._sent)
        node = self._sent[-1] if self._sent else self.job.shut(replace(self.job.nodes[0], routine=0))
        return Order(
            command=self.operation.command,
            jet_permitted=self.operation.jet_permitted,
            heartbeat=self._heartbeat,
            watchdog_ms=round(1e3 * self.terms.spec.watchdog_s),
            run=self.run,
            sequence=sequence,
            node=node,
            check=check_of(self.run, sequence, node),
        )

    def _check(self, status: Status) -> str:
        """Give what is wrong with a status; empty where nothing is."""
        if self._epoch is None:
            self._epoch = status.epoch
        if status.epoch != self._epoch:
            return "the controller was started anew"
        if (since := self.clock() - self._taken_at) > self.terms.spec.watchdog_s:
            return f"the controller answers, and its program has halted: it took no order for {since:.2f} s"
        if self.operation.command != "run" or not self._sent:
            return ""
        sent = len(self._sent)
        if status.accepted == sent and status.check != check_of(self.run, sent, self._sent[-1]):
            return f"the acknowledgement of node {self._sent[-1].number} is that of another content"
        if status.accepted not in (sent - 1, sent) and not (status.accepted == 0 and sent == 1):
            return f"the acknowledgement is for node {status.accepted} in the order of sending, and {sent} were sent"
        if not self._reached <= status.reached <= status.accepted:
            return f"{status.reached} nodes are reported as reached, after {self._reached} and of {status.accepted}"
        return ""

    def _conditions(self, status: Status) -> dict[str, bool]:
        met = {
            name: bool(status.inputs >> number & 1) == state for name, (number, state) in self.terms.conditions.items()
        }
        for name, wait in self.terms.waits.items():
            if wait.sensor is not None and wait.least is not None:
                met[name] = self._quantity(wait.sensor, status) >= wait.least
        return met

    def _follow(self, status: Status) -> None:
        """Pass on the progress of the controller."""
        if self.operation.state == "part present":
            self._apply("home")
        elif self.operation.state == "homing" and status.mode == "home":
            if advance(self.operation, "at home") != self.operation:
                self._apply("at home")
        elif self.operation.state in ("running", "paused"):
            self._accepted = min(status.accepted, len(self._sent)) if self._sent else 0
            for sequence in range(self._reached + 1, min(status.reached, self._accepted) + 1):
                node = self._sent[sequence - 1]
                self._apply(Reached(node.number))
                self._reached, self._reached_at = sequence, self.clock()
                if not self._jets():
                    self._sprayed = None
                elif self._sprayed is None:
                    self._sprayed = self._reached_at, 0
                else:
                    self._sprayed = self._sprayed[0], self._sprayed[1] + node.lasts_us
            if status.mode in ("running", "home"):
                self._in_mode_at = self.clock()

    def _late(self) -> str:
        """Give what did not come in its time; empty where nothing is late."""
        spec, now, sent = self.terms.spec, self.clock(), len(self._sent)
        state, waited = self.operation.state, now - self._waits_since
        if state == "armed":
            return next(self._unmet(waited), "")
        if state == "homing" and waited > spec.home_s:
            return f"the robot was not at home in {spec.home_s:g} s"
        if state != "running":
            return ""
        if self._accepted < sent and now - max(self._sent_at, self._waits_since) > spec.acknowledge_s:
            return f"node {self._sent[-1].number} was not acknowledged in {spec.acknowledge_s:g} s"
        if now - self._in_mode_at > spec.acknowledge_s and self._status is not None:
            return f"the controller is {self._status.mode} while it is to run"
        due = self._sent[self._reached] if self._reached < sent else None
        if late := self._behind(now):
            return late
        if due is not None and now - max(self._reached_at, self._sent_at) > spec.home_s + _MICRO * due.lasts_us:
            return f"node {due.number} was not reached in {spec.home_s:g} s after its time"
        if self._feed.is_done and due is None and now - self._reached_at > spec.home_s:
            return f"the end of the trajectory was not reported in {spec.home_s:g} s"
        return ""

    def _unmet(self, waited: float) -> Iterator[str]:
        """Conditions for the start that did not come in their time."""
        for name in sorted(self.terms.rules.start - self.operation.met):
            wait = self.terms.waits.get(name)
            most = self.terms.spec.part_s if wait is None else wait.timeout_s
            if waited > most:
                message = f": {wait.message}" if wait is not None and wait.message else ""
                yield f"{name} was not met in {most:g} s{message}"

    def _behind(self, now: float) -> str:
        """Give that the robot stands, or is slower than planned, with the jet on; empty where it is in time."""
        patience_s = self.terms.spec.watchdog_s
        if isinstance(self.link, Planned) or not self._jets():
            return ""
        due = self._sent[self._reached] if self._reached < self._accepted else None
        shown = f"with the jet on at node {self.operation.node}"
        is_all = self._feed.is_done and self._accepted == len(self._sent)
        if due is None and not is_all and now - max(self._reached_at, self._waits_since) > patience_s:
            return f"the controller's queue ran dry {shown}"
        if self._sprayed is None or due is None or due.routine:
            return ""
        begun, planned_us = self._sprayed
        planned_s = _MICRO * (planned_us + due.lasts_us)
        if (late := now - begun - planned_s) > patience_s + _SLOWER * planned_s:
            return f"the robot is {late:.2f} s late {shown}"
        return ""

    def _shut(self) -> None:
        """Stop the controller, and wait for its program's confirmation that every valve is shut."""
        until, before = self.clock() + _SHUT_S, self._heartbeat
        while True:
            sent_at = self.clock()
            try:
                status = self.link.exchange(self._order())
            except LinkError as error:
                self._apply(NotShut(f"the link is cut: {error}; the controller's watchdog has to shut them"))
                return
            self._take(status, sent_at)
            is_taken = self._is_taken(before)
            if is_taken and not status.jet_on:
                self._apply("shut")
                return
            if self.clock() > until:
                still = f"a valve is still open after {_SHUT_S:g} s"
                self._apply(NotShut(still if is_taken else f"the controller's program took no stop in {_SHUT_S:g} s"))
                return
            self.rest(_POLL_S)
