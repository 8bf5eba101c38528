"""The log of an operation: events, states and jets, without a clock; it replays to the same states.

The clock has a file of its own, so that a run without a controller writes the same bytes as one with a controller in
which nothing else happened.
"""

import csv
import io
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from programs.posts.joint_table import cells_of
from robotcell.operate.handshake import OperateError
from robotcell.operate.states import Arm, Event, Fault, NotShut, Operation, Reached, Rules, Sensed, Unmet, advance

_COLUMNS = ["entry", "event", "value", "state", "node", "jet"]
FIRST = "# Washboard operation, log 2"
"""First line of every log."""


@dataclass(slots=True)
class Log:
    """Entries so far, and when each was made."""

    cell: str
    job: str
    """SHA-256 of the joint table."""
    rules: Rules
    sink: Callable[[str], object] = lambda _: None
    """Receives each line as it is made."""
    lines: list[str] = field(default_factory=list[str])
    seconds: list[float] = field(default_factory=list[float])
    """Of each entry, on a clock that begins with the operation."""

    def __post_init__(self) -> None:
        """Make the head; it is written with the first entry: an operation that cannot begin leaves nothing."""
        self.lines += (
            FIRST,
            f"# Cell   {self.cell}",
            f"# Table  sha256 {self.job}",
            f"# Interlocks  {' '.join(sorted(self.rules.interlocks))}",
            f"# Sensors  {' '.join(sorted(self.rules.sensors))}",
            f"# Waits  {' '.join(sorted(self.rules.awaited))}",
            f"# Watched  {' '.join(sorted(self.rules.watched))}",
            f"# Nodes  {self.rules.last}",
            ",".join(_COLUMNS),
        )

    def add(self, event: Event, after: Operation, jets: tuple[str, ...], seconds: float) -> None:
        """Add an event, the state after it and the valves that are permitted to be open."""
        name, value = _spell(event)
        if not self.seconds:
            self.sink(self.render())
        self.seconds.append(seconds)
        out = io.StringIO()
        row = (len(self.seconds), name, value, after.state, after.node, " ".join(jets))
        csv.writer(out, lineterminator="").writerow(row)
        self.lines.append(out.getvalue())
        self.sink(f"{self.lines[-1]}\n")

    def render(self) -> str:
        """Write the log as text."""
        return "".join(f"{line}\n" for line in self.lines)

    def render_clock(self) -> str:
        """Write the clock of the log: seconds of each entry since the first."""
        lines = (f"{entry},{seconds:.6f}\n" for entry, seconds in enumerate(self.seconds, start=1))
        return "entry,seconds\n" + "".join(lines)


def _spell(event: Event) -> tuple[str, str]:
    match event:
        case Sensed(name, met):
            return ("met" if met else "not met"), name
        case Arm(first):
            return "arm", str(first)
        case Reached(node):
            return "reached", str(node)
        case Fault(reason):
            return "fault", " ".join(reason.split())
        case Unmet(what):
            return "unmet", " ".join(what.split())
        case NotShut(reason):
            return "not shut", " ".join(reason.split())
        case _:
            return event, ""


def _read_event(name: str, value: str) -> Event:
    """Read an event.

    Raises:
        ValueError: there is no such event.
    """
    match name:
        case "met" | "not met":
            return Sensed(value, name == "met")
        case "arm":
            return Arm(int(value))
        case "reached":
            return Reached(int(value))
        case "fault":
            return Fault(value)
        case "unmet":
            return Unmet(value)
        case "not shut":
            return NotShut(value)
        case "home" | "at home" | "pause" | "resume" | "stop" | "shut" | "reset":
            return name
        case _:
            raise ValueError(f"there is no event {name!r}")


def replay(text: str, file: Path | str) -> tuple[Operation, ...]:
    """Give the states of a log, from its events alone.

    Raises:
        OperateError: it is no log, an event leads to another state than it has, or a jet is on where none is permitted.
    """
    lines = text.splitlines()
    head = {line[2:].partition("  ")[0]: line[2:].partition("  ")[2] for line in lines if line.startswith("# ")}
    if not text.startswith(FIRST) or not {"Interlocks", "Sensors", "Waits", "Watched", "Nodes"} <= head.keys():
        raise OperateError("it is no log of washboard operate.", file=file)
    begin = sum(1 for line in lines if line.startswith("#")) + 1
    states: list[Operation] = []
    number = begin
    try:
        interlocks, sensors, awaited, watched = (
            frozenset(head[key].split()) for key in ("Interlocks", "Sensors", "Waits", "Watched")
        )
        rules = Rules(interlocks, sensors, int(head["Nodes"]), awaited, watched)
        now = Operation(rules)
        for number, line in enumerate(lines[begin:], start=begin + 1):
            _, name, value, state, node, jets = cells_of(line)
            now = advance(now, _read_event(name, value))
            if (now.state, str(now.node)) != (state, node):
                shown = f"{now.state} at node {now.node}, and the log has {state} at node {node}"
                raise OperateError(f"the event {name} leads to {shown}.", file=file, line=number)
            if jets and not now.jet_permitted:
                raise OperateError(f"{jets} is open, which is not permitted there.", file=file, line=number)
            states.append(now)
    except ValueError as error:
        raise OperateError(f"the log cannot be read ({error}).", file=file, line=number) from None
    return tuple(states)
