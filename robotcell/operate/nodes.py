"""The nodes of a joint table, to the last digit, and the order in which they are fed: loops by their sensors."""

import hashlib
import math
import re
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise, takewhile
from pathlib import Path
from typing import Literal, TypeAlias

from programs.errors import ProgramError
from programs.posts.joint_table import ON_THE_WAY, SILENT, cells_of, check_whole, read_events, stated_digest
from programs.posts.rebuilt import ReadCall, ReadEndRepeat, ReadRepeat, ReadSwitch, ReadTool
from programs.posts.writing.wording import make_name
from robotcell.cell.load import LoadedCell, places_sha256
from robotcell.cell.spec import InputOutput
from robotcell.robot.robot import Robot

JOINT_DIGITS, TIME_DIGITS, OUTPUT_DIGITS = 5, 6, 6
"""Decimals of a joint (degrees or mm), a time (s) and an analog output (V or mA), which are whole numbers in here."""
_LARGEST = 2**31 - 1
_LAST_TOOL = 99
"""Routines up to it are changes to that tool."""
_FASTER = 1.001
"""Than a joint's greatest speed, where motions reach just that."""
_STAYS = 0.01
"""Millimetres of the orifice, and a part of one of its direction: a table has thousandths."""
_RETURN_STEP_S = 0.02
"""Between the nodes of a way back to the begin of a loop."""


@dataclass(frozen=True, slots=True)
class Loop:
    """The begin of a loop: what follows is done at least once, at most ``count`` times, until the sensor shows it."""

    count: int
    key: str
    least: float


LoopEnd: TypeAlias = Literal["loop end"]


@dataclass(frozen=True, slots=True)
class Node:
    """One row of a joint table."""

    number: int
    time_us: int
    """Planned, since the program's beginning."""
    lasts_us: int
    """From the row before; the joints go straight from there."""
    joints: tuple[int, ...]
    """1e-5 degrees or mm, as in the table."""
    outputs: tuple[int, ...]
    """Every output of the cell after this row: 0 or 1, a whole number, or 1e-6 V or mA."""
    routine: int = 0
    """Of the controller, carried out here: up to 99 the change to that tool, otherwise a call; 0 for none."""
    loop: Loop | LoopEnd | None = None


@dataclass(frozen=True, slots=True)
class Job:
    """A joint table as nodes, for one cell."""

    nodes: tuple[Node, ...]
    outputs: tuple[str, ...]
    """Names of the cell's outputs, in the order of each node's."""
    valves: tuple[str, ...]
    """Those that are valves."""
    io: InputOutput
    """The cell's channels."""
    joints: tuple[str, ...]
    """Columns of the table, with unit."""
    sha256: str
    """Of the table."""
    returns: "Mapping[int, tuple[Node, ...]]" = field(default_factory=dict["int", "tuple[Node, ...]"])
    """From the end of a loop back to its begin, by the number of its last node; they have the number of its first."""
    starts: tuple[int, ...] = field(default=())
    """Nodes at which a valve opens."""
    tools: tuple[tuple[int, int], ...] = field(default=())
    """Nodes at which a tool is taken, each with its number."""

    def tool_at(self, number: int) -> int:
        """Give the number of the tool after a node; of the first one before it is taken, 0 where there is none."""
        taken = bisect_right(self.tools, number, key=lambda each: each[0])
        return self.tools[max(taken - 1, 0)][1] if self.tools else 0

    def open_valves(self, node: Node) -> tuple[str, ...]:
        """Names of the valves that are open after a node."""
        return tuple(
            name for name, value in zip(self.outputs, node.outputs, strict=True) if value and name in self.valves
        )

    def shut(self, node: Node) -> Node:
        """Give a node with every valve shut."""
        values = zip(self.outputs, node.outputs, strict=True)
        return replace(node, outputs=tuple(0 if name in self.valves else value for name, value in values))


def read_job(text: str, loaded: LoadedCell, file: Path | str = "the joint table") -> Job:
    """Read a joint table as ``export`` writes it.

    Args:
        text: CSV.
        loaded: The cell it was written for, with ``operate``.
        file: Name in errors.

    Raises:
        ProgramError: a row is not what the writer writes, the table ends early, or is that of another cell or robot.
    """
    spec, robot = loaded.spec, loaded.cell.robot
    lines = text.splitlines()
    head = sum(1 for _ in takewhile(lambda line: line.startswith("#"), lines))
    joints = joint_columns(robot)
    stated = re.search(r"^# Cell   (\S+)", "\n".join(lines[:head]), re.MULTILINE)
    if stated is not None and stated[1] != spec.cell:
        raise ProgramError(f"the table is that of cell {stated[1]}, not of {spec.cell}; export it anew.", file=file)
    digest = stated_digest(lines[:head], "Places")
    if digest and digest != places_sha256(loaded):
        message = f"the table is that of cell {spec.cell} as it was: its file was changed since; export the table anew."
        raise ProgramError(message, file=file)
    expected = ["node", "time_s", *joints]
    reader = _Reader(loaded, joints)
    number = head + 1
    """Of the line."""
    try:
        columns = cells_of(lines[head]) if head < len(lines) else []
        if columns[: len(expected)] != expected:
            shown = ", ".join(expected)
            raise ProgramError(f"it is no joint table of cell {spec.cell}: the first columns are {shown}.", file=file)
        for line in lines[head + 1 :]:
            number += 1
            cells = cells_of(line)
            if len(cells) != len(columns):
                raise ValueError("it has more or fewer cells than the header")
            reader.add(dict(zip(columns, cells, strict=True)))
    except (ValueError, KeyError, TypeError) as error:
        raise ProgramError(f"the row cannot be read ({error}).", file=file, line=number) from None
    if not reader.nodes:
        raise ProgramError("the table has no rows.", file=file)
    check_whole(lines[:head], lines[head:], len(reader.nodes), file)
    digest = hashlib.sha256(text.encode()).hexdigest()
    job = replace(still_job(loaded), nodes=tuple(reader.nodes), sha256=digest)
    tools = tuple((node.number, node.routine) for node in job.nodes if 0 < node.routine <= _LAST_TOOL)
    opened = [set[str](), *(set(job.open_valves(node)) for node in job.nodes)]
    starts = tuple(
        node.number for node, (before, after) in zip(job.nodes, pairwise(opened), strict=True) if after - before
    )
    return replace(job, starts=starts, returns=_returns(job, robot, reader.stands, file), tools=tools)


def still_job(loaded: LoadedCell) -> Job:
    """Give the job of a cell whose robot stands at home: one node, every output 0."""
    spec, joints = loaded.spec, joint_columns(loaded.cell.robot)
    home = tuple(round(10**JOINT_DIGITS * value) for value in spec.home_deg_mm)
    return Job(
        nodes=(Node(1, 0, 0, home, (0,) * len(spec.io.outputs)),),
        outputs=tuple(spec.io.outputs),
        valves=tuple(dict.fromkeys(nozzle.valve for nozzle in spec.nozzles.values())),
        io=spec.io,
        joints=joints,
        sha256="",
    )


def joint_columns(robot: Robot) -> tuple[str, ...]:
    """Columns of a robot's joints in its joint table, with their units."""
    return tuple(f"{make_name(joint.name, 24)}_{joint.unit.key}" for joint in robot.joints)


class _Reader:
    """Rows of a table, one after the other, with the state of the outputs."""

    def __init__(self, loaded: LoadedCell, joints: Sequence[str]) -> None:
        self._io = loaded.spec.io
        self._routines = loaded.spec.operate.routines if loaded.spec.operate else {}
        self._joints, self._robot = joints, loaded.cell.robot
        self._values = dict.fromkeys(self._io.outputs, 0)
        self.nodes: list[Node] = []
        self.stands: dict[int, tuple[float, ...]] = {}
        """Place of the orifice and direction of the jet where a loop begins or ends, by the node's number."""

    def add(self, row: dict[str, str]) -> None:
        """Add a row.

        Raises:
            ValueError: it is not what the writer writes, or names something that the cell does not have.
        """
        number, time_us = len(self.nodes) + 1, _whole(row["time_s"], TIME_DIGITS)
        if int(row["node"]) != number:
            raise ValueError(f"it has node {row['node']}, not {number}")
        lasts_us = time_us - (self.nodes[-1].time_us if self.nodes else 0)
        if lasts_us < 0:
            raise ValueError("it is earlier than the row before it")
        joints = tuple(_whole(row[name], JOINT_DIGITS) for name in self._joints)
        if max(map(abs, joints)) > _LARGEST:
            raise ValueError("a joint is beyond 21,474 degrees or mm, which no link carries")
        self._check_joints(joints, lasts_us)
        routine, loop = self._switch(row["events"])
        if loop is not None:
            x, y, z, a, b, c, d = (float(row[key]) for key in ("x", "y", "z", "qw", "qx", "qy", "qz"))
            self.stands[number] = (x, y, z, 2 * (b * d + a * c), 2 * (c * d - a * b), 1 - 2 * (b * b + c * c))
        self.nodes.append(Node(number, time_us, lasts_us, joints, tuple(self._values.values()), routine, loop))

    def _check_joints(self, joints: Sequence[int], lasts_us: int) -> None:
        """Refuse what the robot cannot do.

        Raises:
            ValueError: a joint is beyond its limits, or would be faster than it can.
        """
        before = self.nodes[-1].joints if self.nodes else joints
        for name, joint, now, last in zip(self._joints, self._robot.joints, joints, before, strict=True):
            unit = 10**JOINT_DIGITS * joint.unit.per_si
            if not joint.lowest * unit - 1 <= now <= joint.highest * unit + 1:
                shown = f"{joint.lowest * joint.unit.per_si:g} to {joint.highest * joint.unit.per_si:g}"
                raise ValueError(f"{name} is {now / 10**JOINT_DIGITS:g}, and its limits are {shown}")
            # Places are rounded to a digit each, and the time to a microsecond.
            if abs(now - last) > _FASTER * joint.speed * unit * 1e-6 * (lasts_us + 1) + 1:
                shown = f"{abs(now - last) / 10**JOINT_DIGITS:g} in {1e-6 * lasts_us:g} s"
                raise ValueError(f"{name} goes {shown}, faster than its {joint.speed * joint.unit.per_si:g} a second")

    def _switch(self, events: str) -> tuple[int, Loop | LoopEnd | None]:
        """Set the outputs that a row sets, and give its routine and its loop."""
        routine, loop = 0, None
        if events in ("held", "reach", ON_THE_WAY) or events.startswith(SILENT):
            return routine, loop
        for event in read_events(events):
            match event:
                case ReadSwitch():
                    self._set(event)
                case ReadTool():
                    routine = int(event.label.removeprefix("tool "))
                case ReadCall():
                    if event.label not in self._routines:
                        message = f"call {event.label} has no number; state it under operate.routines of the cell"
                        raise ValueError(message)
                    routine = self._routines[event.label]
                case ReadRepeat():
                    loop = Loop(event.count, event.channel, event.least or 0.0)
                case ReadEndRepeat():
                    loop = "loop end"
                case _:
                    raise ValueError(f"unknown event {events!r}")
        return routine, loop

    def _set(self, switch: ReadSwitch) -> None:
        if switch.channel not in self._io.outputs:
            raise ValueError(f"{switch.channel} is not under io.outputs of the cell")
        scale = 10**OUTPUT_DIGITS if self._io.outputs[switch.channel].kind == "analog" else 1
        if not abs(switch.value * scale) <= _LARGEST:
            raise ValueError(f"{switch.channel} = {switch.value:g} is more than a link carries")
        self._values[switch.channel] = round(switch.value * scale)


def _whole(text: str, digits: int) -> int:
    """Read a number with so many decimals as a whole number of its last digit.

    Raises:
        ValueError: it has more or fewer.
    """
    whole, _, decimals = text.partition(".")
    if len(decimals) != digits:
        raise ValueError(f"{text!r} has not {digits} decimals")
    return int(whole + decimals)


def _returns(
    job: Job, robot: Robot, stands: Mapping[int, tuple[float, ...]], file: Path | str
) -> dict[int, tuple[Node, ...]]:
    """Give the ways from the end of each loop back to where it begins, by the number of its last node.

    The tool may have turned about its jet meanwhile: then the joint that did so alone turns back.

    Raises:
        ProgramError: a loop does not end, or elsewhere than it begins.
    """
    begun: list[Node] = []
    ways: dict[int, tuple[Node, ...]] = {}
    for node in job.nodes:
        if isinstance(node.loop, Loop):
            begun.append(node)
        elif node.loop == "loop end":
            begin = begun.pop() if begun else node
            moved = [at for at, (one, other) in enumerate(zip(begin.joints, node.joints, strict=True)) if one != other]
            stays = math.dist(stands[begin.number], stands[node.number]) < _STAYS
            if begin is node or moved[1:] or not (stays and robot.turning[moved].all()):
                raise ProgramError(f"the loop that ends at node {node.number} does not begin there.", file=file)
            ways[node.number] = tuple(_way_back(job.shut(node), begin, robot, moved[0] if moved else 0))
    if begun:
        raise ProgramError(f"the loop that begins at node {begun[0].number} does not end.", file=file)
    return ways


def _way_back(end: Node, begin: Node, robot: Robot, at: int) -> Iterator[Node]:
    """Turn a joint back by half a cosine, at half of its greatest speed and acceleration."""
    joint, way = robot.joints[at], begin.joints[at] - end.joints[at]
    unit = 10**JOINT_DIGITS * joint.unit.per_si
    speed, acceleration = 0.5 * joint.speed * unit, 0.5 * joint.acceleration * unit
    lasts_s = max(math.pi * abs(way) / (2.0 * speed), math.pi * math.sqrt(abs(way) / (2.0 * acceleration)))
    steps = math.ceil(lasts_s / _RETURN_STEP_S)
    for step in range(1, steps + 1):
        share = 0.5 - 0.5 * math.cos(math.pi * step / steps)
        joints = (*end.joints[:at], end.joints[at] + round(share * way), *end.joints[at + 1 :])
        lasts_us = round(1e6 * lasts_s / steps)
        yield replace(begin, joints=joints, lasts_us=lasts_us, outputs=end.outputs, routine=0, loop=None)


class Feed:
    """Nodes in the order in which they are done, with the loops' turns."""

    def __init__(self, job: Job) -> None:
        """Begin with the first node."""
        self._nodes = job.nodes
        self._returns = job.returns
        self._way: list[Node] = []
        self._at = 0
        self._begun: list[tuple[int, int]] = []
        """Of each open loop: index of its begin, turns begun."""

    @property
    def is_done(self) -> bool:
        """Whether every node was taken."""
        return self._at >= len(self._nodes)

    @property
    def question(self) -> Loop | None:
        """The loop whose sensor decides what comes next; ``None`` where that is known."""
        if not self._at or self._nodes[self._at - 1].loop != "loop end" or not self._begun:
            return None
        index, _ = self._begun[-1]
        loop = self._nodes[index].loop
        return loop if isinstance(loop, Loop) else None

    def decide(self, value: float) -> bool:
        """End the loop in question or begin its next turn, by the sensor's quantity; give whether that is reached."""
        loop = self.question
        if loop is None:
            return True
        index, turns = self._begun.pop()
        if value < loop.least and turns < loop.count:
            self._begun.append((index, turns + 1))
            self._way = [*self._returns[self._nodes[self._at - 1].number]]
            self._at = index + 1
            return True
        return value >= loop.least

    def take(self) -> Node:
        """Give the next node."""
        if self._way:
            return self._way.pop(0)
        node = self._nodes[self._at]
        if isinstance(node.loop, Loop):
            self._begun.append((self._at, 1))
        self._at += 1
        return node
