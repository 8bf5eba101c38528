"""A controller's program against the rules of docs/operating.md, one after the other, over the link of its cell.

Every node stands at home: the robot goes there once, and then nothing moves; the first valve
of the cell opens for a moment.
"""

import secrets
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import count
from time import monotonic, sleep
from typing import Literal, TypeAlias

from robotcell.cell.load import LoadedCell
from robotcell.operate.drive import Terms, terms_of
from robotcell.operate.handshake import Link, LinkError, Order, Status, check_of
from robotcell.operate.nodes import Job, Node, still_job
from robotcell.operate.states import CommandWord

Verdict: TypeAlias = Literal["pass", "fail", "not testable"]
_SHUT_S = 0.1
_POLL_S = 0.005
_LEAST_LOOKS = 5
"""Of a link that is slower than the time in which something has to happen."""
_LONG_US, _SHORT_US = 20_000_000, 20_000
_TIMED_S = 0.3
_EARLY_S = 0.05
"""A node may be reported so much before its time: the order's way, and a cycle."""
_WATCHDOG_S = 1.0
"""Of all rules but its own: this computer may have other work."""


class NotTestableError(Exception):
    """A rule cannot be tested, for a reason."""


@dataclass(frozen=True, slots=True)
class Result:
    """What came of a rule."""

    rule: str
    verdict: Verdict
    seen: str
    """What was seen instead, or why the rule cannot be tested."""


@dataclass(slots=True)
class Session:
    """Orders to a controller, as an operation sends them, and otherwise than it may."""

    link: Link
    job: Job
    terms: Terms
    run: int = 0
    node: Node = field(init=False)
    sequence: int = 0
    status: Status = field(init=False)
    _beats: Iterator[int] = field(default_factory=lambda: count(1 + secrets.randbelow(30_000)))
    _home_s: float = field(init=False)

    def __post_init__(self) -> None:
        """Begin at home, with every valve shut."""
        self.node, self._home_s = self.job.nodes[0], self.terms.spec.home_s

    def order(self, command: CommandWord, *, permitted: bool = True, check: int = 0, watchdog_s: float = 0.0) -> Status:
        """Send an order with the node and its sequence number as they are."""
        own = check_of(self.run, self.sequence, self.node)
        beat = next(self._beats) % 0x10000
        watchdog_ms = round(1e3 * (watchdog_s or max(_WATCHDOG_S, self.terms.spec.watchdog_s)))
        sent = Order(command, permitted, beat, watchdog_ms, self.run, self.sequence, self.node, own ^ check)
        self.status = self.link.exchange(sent)
        return self.status

    def until(self, is_so: Callable[[Status], bool], seconds: float, command: CommandWord = "run", **how: bool) -> bool:
        """Repeat an order until the status is so; whether it is in time."""
        end, looks = monotonic() + seconds, 0
        while not is_so(self.order(command, **how)):
            looks += 1
            if monotonic() > end and looks >= _LEAST_LOOKS:
                return False
            sleep(_POLL_S)
        return True

    def stays(self, is_so: Callable[[Status], bool], seconds: float) -> bool:
        """Whether a status stays as it is while orders to run are sent."""
        return not self.until(lambda status: not is_so(status), seconds)

    def begin(self) -> None:
        """Begin a run: stop, go home."""
        self.run, self.sequence, self.node = 1 + secrets.randbelow(0xFFFFFFFE), 0, self.job.nodes[0]
        self.until(lambda status: status.mode == "stopped" and not status.jet_on, 0.5, "stop", permitted=False)
        if not self.until(lambda status: status.mode == "home", self._home_s, "home", permitted=False):
            self._home_s = 0.2  # it is the finding of its own rule: the others do not wait for it

    def send(self, lasts_us: int, *, is_open: bool = False) -> bool:
        """Send the next node; whether it is accepted in time."""
        self.offer(self.sequence + 1, lasts_us, is_open=is_open)
        return self.until(lambda status: status.accepted == self.sequence, self.terms.spec.acknowledge_s)

    def offer(self, sequence: int, lasts_us: int, *, is_open: bool = False) -> None:
        """Make a node the one of the following orders."""
        valve = self.job.outputs.index(self.job.valves[0])
        outputs = tuple(int(is_open and index == valve) for index in range(len(self.job.outputs)))
        self.sequence = sequence
        self.node = replace(self.job.nodes[0], number=sequence, lasts_us=lasts_us, outputs=outputs)

    def spray(self, *, is_dry: bool = False) -> None:
        """Begin a run and open a valve; more nodes are queued, unless the queue is to run dry.

        Raises:
            NotTestableError: none opens.
        """
        self.require_valve()
        self.begin()
        self.send(_SHORT_US)
        self.send(_SHORT_US, is_open=True)
        if not is_dry:
            self.send(_LONG_US, is_open=True)
        if not self.until(lambda status: status.jet_on, 1.0):
            raise NotTestableError("no valve is reported open after a node that opens one")

    def require_valve(self) -> None:
        """Look whether the cell has a valve that may open.

        Raises:
            NotTestableError: it has none, or an interlock is not met.
        """
        if not self.job.valves:
            raise NotTestableError("the cell has no valve")
        for name in sorted(self.terms.rules.interlocks):
            number, state = self.terms.conditions[name]
            if bool(self.status.inputs >> number & 1) != state:
                raise NotTestableError(f"{name} is not met")

    def shuts(self, command: CommandWord, *, permitted: bool = True) -> str:
        """Send an order that shuts, and give what is seen where it does not."""
        is_shut = self.until(lambda status: not status.jet_on, _SHUT_S, command, permitted=permitted)
        return "" if is_shut else f"a valve is still open after {_SHUT_S:g} s"


def _heartbeat(session: Session) -> str:
    sent: list[int] = []

    def is_taken(status: Status) -> bool:
        sent.append(status.heartbeat)
        return len({*sent}) > 2

    session.begin()
    return "" if session.until(is_taken, 1.0, "stop") else f"HeartbeatTaken stays {sent[-1]} while orders come"


def _second_start(session: Session) -> str:
    session.begin()
    session.send(_LONG_US)
    found = session.link.look()
    if found is None or found.run != session.run:
        return f"Run is read back as {found.run if found else 'nothing'}, not as {session.run}"
    return "" if session.until(lambda status: status.mode == "running", 1.0) else f"Mode is {session.status.mode}"


def _home(session: Session) -> str:
    session.begin()
    return (
        "" if session.status.mode == "home" else f"Mode is {session.status.mode} after {session.terms.spec.home_s:g} s"
    )


def _checksum(session: Session) -> str:
    session.begin()
    if not session.send(_SHORT_US):
        return f"Accepted is {session.status.accepted} after node 1 was sent"
    own = check_of(session.run, session.sequence, session.node)
    return "" if session.status.check == own else f"AcceptedCheck is {session.status.check:#x}, not {own:#x}"


def _refuses(session: Session, sequence: int, what: str, check: int = 0) -> str:
    """Send a node that is not to be accepted, after two that are."""
    session.begin()
    session.send(_SHORT_US)
    session.send(_SHORT_US)
    session.offer(sequence, _SHORT_US)
    end = monotonic() + 0.3
    while monotonic() < end:
        if session.order("run", check=check).accepted != 2:
            return f"Accepted is {session.status.accepted} after {what}"
        sleep(_POLL_S)
    return ""


def _new_run(session: Session) -> str:
    session.begin()
    session.send(_SHORT_US)
    session.send(round(1e6 * _TIMED_S))
    session.run, session.sequence = session.run ^ 1, 0
    is_new = session.until(lambda status: status.accepted == status.reached == 0, 0.5)
    if is_new and session.stays(lambda status: status.reached == 0, 2 * _TIMED_S):
        return ""
    return f"Accepted is {session.status.accepted}, Reached {session.status.reached} in another run"


def _time(session: Session) -> str:
    session.begin()
    session.send(_SHORT_US)
    session.until(lambda status: status.reached == 1, 1.0)
    begun = monotonic()
    session.send(round(1e6 * _TIMED_S))
    if not session.until(lambda status: status.reached == 2, 2.0 + _TIMED_S):
        return f"a node of {_TIMED_S:g} s is not reached in {2 + _TIMED_S:g} s"
    took = monotonic() - begun
    return "" if took > _TIMED_S - _EARLY_S else f"a node of {_TIMED_S:g} s is reached after {took:.2f} s"


def _outputs(session: Session) -> str:
    session.begin()
    session.require_valve()
    session.send(_SHORT_US)
    session.send(round(1e6 * _TIMED_S), is_open=True)
    session.send(_LONG_US, is_open=True)
    if session.until(lambda status: status.jet_on, 2.0):
        return "" if session.status.reached == 2 else f"a valve is open when node {session.status.reached} is reached"
    return "no valve is open after the node that opens one"


def _interlock(session: Session) -> str:
    session.spray()
    return session.shuts("run", permitted=False)


def _hold(session: Session) -> str:
    session.spray()
    if seen := session.shuts("hold"):
        return seen
    if not session.until(lambda status: status.mode == "held", 1.0, "hold"):
        return f"Mode is {session.status.mode}"
    return "" if session.until(lambda status: status.jet_on, 1.0) else "no valve opens when it goes on"


def _stop(session: Session) -> str:
    session.begin()
    session.require_valve()
    session.send(_SHORT_US, is_open=True)
    session.until(lambda status: status.jet_on, 1.0)
    session.send(round(1e6 * _TIMED_S), is_open=True)
    if seen := session.shuts("stop"):
        return seen
    if not session.until(lambda status: status.mode == "stopped", 1.0, "stop"):
        return f"Mode is {session.status.mode}"
    if session.stays(lambda status: status.reached < 2, 2 * _TIMED_S):
        return ""
    return "a node that was queued before the stop is reached after it"


def _dry(session: Session) -> str:
    session.spray(is_dry=True)
    if not session.until(lambda status: status.reached == status.accepted, 1.0):
        return f"Reached is {session.status.reached} of {session.status.accepted} accepted"
    return session.shuts("stop")


def _expire(session: Session) -> str:
    """Let the watchdog expire with a valve open, and give what is seen where it stays open."""
    session.spray()
    watchdog_s = session.terms.spec.watchdog_s
    session.order("run", watchdog_s=watchdog_s)
    sleep(watchdog_s + _SHUT_S)
    found = session.link.look()
    session.status = found.status if found else session.status
    return f"a valve is open {watchdog_s + _SHUT_S:g} s after the last order" if session.status.jet_on else ""


def _latched(session: Session) -> str:
    if _expire(session):
        raise NotTestableError("its watchdog does not expire")
    is_open = session.until(lambda status: status.jet_on or status.mode == "running", 0.3)
    return "it goes on with the same Run" if is_open else ""


_BY_HAND = "by hand: {} during `washboard operate`; it ends as faulted"
RULES: dict[str, Callable[[Session], str] | str] = {
    "heartbeat": _heartbeat,
    "second start": _second_start,
    "home": _home,
    "checksum": _checksum,
    "next node": partial(_refuses, sequence=4, what="node 4 was sent in place of 3"),
    "node once": partial(_refuses, sequence=1, what="node 1 was sent again"),
    "bad node": partial(_refuses, sequence=3, what="a node with another Check than its content has", check=1),
    "new run": _new_run,
    "time": _time,
    "outputs": _outputs,
    "interlock lost": _interlock,
    "hold": _hold,
    "stop": _stop,
    "queue ran dry": _dry,
    "watchdog": _expire,
    "watchdog stays": _latched,
    "inputs": _BY_HAND.format("open the door"),
    "epoch": _BY_HAND.format("start the controller's program anew"),
}
"""By the name in docs/operating.md; a text is the reason why a rule is not tested over a link."""


def check_rules(loaded: LoadedCell, link: Link) -> Iterator[Result]:
    """Test the rules, one after the other; at the end, and at an error, the controller is stopped.

    Raises:
        LinkError: there is no answer.
    """
    job = still_job(loaded)
    session = Session(link, job, terms_of(loaded, job))
    try:
        session.order("stop", permitted=False)
        for name, check in RULES.items():
            yield _result(session, name, check)
    finally:
        with suppress(LinkError):
            session.order("stop", permitted=False)


def _result(session: Session, name: str, check: Callable[[Session], str] | str) -> Result:
    if isinstance(check, str):
        return Result(name, "not testable", check)
    try:
        seen = check(session)
    except NotTestableError as error:
        return Result(name, "not testable", str(error))
    return Result(name, "fail" if seen else "pass", seen)
