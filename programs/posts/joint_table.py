"""The joint look-up table of the Cairo arm (2009): node, time, joints, and what is switched when."""

import csv
import hashlib
import io
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from programs.errors import ProgramError
from programs.motion.installation import Installation
from programs.motion.lower import Capability, Lowered
from programs.motion.steps import (
    Await,
    Call,
    EndRepeat,
    Hold,
    Line,
    Mount,
    Note,
    Pause,
    Reach,
    Repeat,
    Step,
    Switch,
    UseBoard,
    UseTool,
)
from programs.pose import Pose
from programs.posts.dialect import Dialect, FileForm, Handover, ProgramFiles, Task
from programs.posts.reading.driver import checked
from programs.posts.rebuilt import (
    Axes,
    ReadCall,
    ReadEndRepeat,
    ReadHold,
    ReadLine,
    ReadPause,
    ReadReach,
    ReadRepeat,
    ReadStep,
    ReadSwitch,
    ReadTool,
    Rebuilt,
    TextPlace,
)
from programs.posts.writing.axes import in_degrees_and_mm
from programs.posts.writing.forms import fixed, short
from programs.posts.writing.frame import heading
from programs.posts.writing.handover import HandedOver
from programs.posts.writing.wording import cut, make_name, name_motion
from specs.source import Source

_SHARES_APART = 1e-9
_LONGEST_NAME = 60

ON_THE_WAY = "on the way"
"""Event of a row within a joint move."""


@dataclass(slots=True)
class _Row:
    """Where the robot is at a time."""

    time_s: float
    joints: tuple[float, ...]
    pose: Pose
    events: str
    made_by: Source


class _Player(HandedOver):
    """What a table leaves to the controller that plays it."""

    address_forms = ("{name} of events", "{name} of events", "{name} of events")

    def setup(self) -> Iterator[Task]:
        """State what the player has to do, as a table has no logic."""
        yield Task("your player: sets outputs at their rows, waits at those of a call or a tool, and repeats loops")
        yield Task("your player: shuts the valves where it stops", tuple(channel.name for channel in self.valves))


def write(dialect: Dialect, lowered: Lowered, installation: Installation) -> tuple[ProgramFiles, Handover]:
    """Write the table: one file.

    Raises:
        ProgramError: the joint motion is not known.
    """
    out = io.StringIO()
    for line in heading(dialect, lowered, installation):
        out.write(f"# {cut(line, dialect.longest_line - 2)}\n")
    frame = f"in the {installation.workpiece}'s CAD frame"
    out.write(f"# Joints in degrees or mm; pose of the orifice {frame}, mm, quaternion w x y z\n")
    rows = tuple(_rows(lowered.motion.steps))
    written = io.StringIO()
    table = csv.writer(written, lineterminator="\n")
    units = {"revolute": "deg", "prismatic": "mm"}
    names = [f"{make_name(joint.name, 24)}_{units[joint.kind]}" for joint in installation.joints]
    table.writerow(["node", "time_s", *names, "x", "y", "z", "qw", "qx", "qy", "qz", "events", "made_by"])
    for node, row in enumerate(rows, start=1):
        joints = [fixed(value, 5) for value in in_degrees_and_mm(row.joints, installation)]
        pose = [fixed(value, 3) for value in row.pose.position] + [fixed(value, 7) for value in row.pose.quaternion]
        table.writerow([node, fixed(row.time_s, 6), *joints, *pose, row.events, cut(str(row.made_by), 60)])
    text = written.getvalue()
    out.write(f"# Nodes  {len(rows)}\n# Rows   sha256 {_digest(text.splitlines())}\n")
    if installation.cell_sha256:
        out.write(f"# Places sha256 {installation.cell_sha256}\n")
    files = {f"{name_motion(lowered.motion, _LONGEST_NAME)}.csv": f"{out.getvalue()}{text}"}
    return files, _Player(dialect, lowered, installation).handover()


def _rows(steps: Sequence[Step]) -> Iterator[_Row]:
    """Rows of every sample, signal and step; those before the first pose stand with it."""
    now, at, waiting = 0.0, None, list[Step]()
    for step in steps:
        match step:
            case Line():
                for at in _samples(step, now):
                    yield at
                now += step.duration_s
            case Pause() if at is not None:
                now += step.duration_s
                at = _Row(now, at.joints, at.pose, "held", step.made_by)
                yield at
            case Reach():
                if not step.joints:
                    raise ProgramError("the joint motion is not known; track the program in a cell first.")
                if at is None:
                    yield from (_Row(now, step.joints, step.target, _label(each), each.made_by) for each in waiting)
                for moment in step.way[:-1]:
                    yield _Row(now + moment.seconds, moment.joints, moment.pose, ON_THE_WAY, step.made_by)
                now += step.way[-1].seconds if step.way else 0.0
                at = _Row(now, step.joints, step.target, "reach", step.made_by)
                yield at
            case _ if at is None:
                waiting.append(step)
            case _:
                yield _Row(now, at.joints, at.pose, _label(step), step.made_by)


def _samples(line: Line, begin_s: float) -> Iterator[_Row]:
    """Rows of a line: its samples, and each signal at its own time."""
    samples = line.samples
    signals = [event.signal_s for event in line.events]
    moments = np.unique(np.concatenate((samples.seconds[1:], signals)))
    shares, rows = np.interp(moments, samples.seconds, samples.shares), samples.joints_when(moments)
    last = 0.0
    for seconds, share, row in zip(moments.tolist(), shares.tolist(), rows.tolist(), strict=True):
        events = [event for event in line.events if event.signal_s == seconds]
        if share - last < _SHARES_APART and not events and seconds < line.duration_s:
            continue
        words = "; ".join(f"{event.channel.name} = {short(event.value, 6)}" for event in events)
        yield _Row(begin_s + seconds, tuple(row), line.pose_at(share), words, line.made_by)
        last = share


def _label(step: Step) -> str:
    match step:
        case Switch():
            return f"{step.channel.name} = {short(step.value, 6)}"
        case UseTool():
            return f"tool {step.number}"
        case UseBoard():
            return f"board {cut(step.placement or 'as mounted', 60)}"
        case Call():
            return f"call {cut(step.name, 60)}"
        case Repeat():
            return f"repeat {step.count} until {cut(step.key, 40)} >= {short(step.least, 6)}"
        case EndRepeat() | Hold():
            return step.words if isinstance(step, Hold) else "end repeat"
        case Note():
            return f"note {cut(step.text, 60)}"
        case Pause():
            return "held"
        case Line() | Reach() | Mount() | Await():
            raise AssertionError("these have rows of their own, or none")


_ASSIGNMENT = re.compile(r"([\w.-]+) = (-?[\d.]+)")
_LOOP = re.compile(r"repeat (\d+) until (?P<key>.*) >= (-?[\d.]+)")
_NODES = re.compile(r"# Nodes  (\d{1,9})")
SILENT = ("board ", "note ")
"""Beginnings of events that only inform."""


def rebuild(files: ProgramFiles) -> Rebuilt:
    """Rebuild the motion of the orifice from the pose columns, and what is switched from the events.

    Raises:
        ProgramError: it is not one table, or a row holds what the writer does not write.
    """
    if len(files) != 1:
        raise ProgramError("a joint table is one file.")
    ((file, text),) = files.items()
    lines = text.splitlines()
    comments = next((at for at, line in enumerate(lines) if not line.startswith("#")), len(lines))
    steps: list[ReadStep] = []
    places: list[TextPlace] = []
    before: tuple[float, Pose] | None = None
    number = 0
    try:
        if comments == len(lines):
            raise ProgramError("it has no rows")
        header = cells_of(lines[comments])
        for number, line in enumerate(lines[comments + 1 :], start=1):
            row = cells_of(line)
            if len(row) != len(header):
                raise ValueError(f"it has {len(row)} values for {len(header)} columns")
            before = _read_row(number, dict(zip(header, row, strict=True)), before, steps)
            places += [TextPlace(file, comments + 1 + number)] * (len(steps) - len(places))
    except (ValueError, KeyError, ProgramError) as error:
        line = comments + 1 + number
        raise ProgramError(f"row {number} cannot be read ({error}).", file=file, line=line) from None
    check_whole(lines[:comments], lines[comments:], number, file)
    return Rebuilt(tuple(steps), places=tuple(places))


def cells_of(line: str) -> list[str]:
    """Divide a line of a table: none of its cells goes on in the next one.

    Raises:
        ValueError: a quotation is left open, or text follows one.
    """
    try:
        return next(csv.reader([line], strict=True), [])
    except csv.Error as error:
        raise ValueError(str(error)) from None


def check_whole(comments: Sequence[str], rows: Sequence[str], nodes: int, file: str | Path) -> None:
    """Refuse a table that ends before its last node, as one whose copy was cut off: its jets may be on there.

    Args:
        comments: Lines of its head.
        rows: Its other lines.
        nodes: How many were read.
        file: Name in errors.

    Raises:
        ProgramError: its head states more nodes, or other rows.
    """
    stated = next((int(found[1]) for line in comments if (found := _NODES.fullmatch(line))), 0)
    if nodes < stated:
        raise ProgramError(f"the table ends at node {nodes} of {stated}: it was cut off; export it anew.", file=file)
    digest = stated_digest(comments, "Rows")
    if digest and digest != _digest(rows):
        line = next(at for at, comment in enumerate(comments, start=1) if digest in comment)
        message = "the rows are not those that its head states here: they were changed; export it anew."
        raise ProgramError(message, file=file, line=line)


def stated_digest(comments: Sequence[str], what: str) -> str:
    """SHA-256 of the ``Rows``, or of the cell's ``Places``, by the head of a table; empty where it has none."""
    found = (re.fullmatch(rf"# {what} +sha256 ([0-9a-f]{{64}})", line) for line in comments)
    return next((each[1] for each in found if each), "")


def _digest(rows: Sequence[str]) -> str:
    return hashlib.sha256("\n".join(rows).encode()).hexdigest()


def _read_row(
    number: int, row: Mapping[str, str], before: tuple[float, Pose] | None, steps: list[ReadStep]
) -> tuple[float, Pose]:
    """Add the steps of a row, and give its time and pose.

    Raises:
        ValueError: it holds what the writer does not write.
    """
    if int(row["node"]) != number:
        raise ValueError(f"it has node {row['node']}")
    x, y, z, a, b, c, d = (float(row[key]) for key in ("x", "y", "z", "qw", "qx", "qy", "qz"))
    time_s, pose, events = float(row["time_s"]), Pose((x, y, z), checked((a, b, c, d))), row["events"]
    lasts_s = time_s - (before[0] if before else 0.0)
    if lasts_s < 0.0:
        raise ValueError("it is earlier than the row before it")
    axes = Axes(tuple([float(value) for key, value in row.items() if key.endswith(("_deg", "_mm"))]))
    motion = ReadLine(pose, None, None, duration_s=lasts_s, axes=axes)
    if events == "held":
        steps.append(ReadPause(lasts_s))
    elif events in (ON_THE_WAY, "reach"):
        way = (motion,)
        if steps and isinstance(steps[-1], ReadReach) and steps[-1].way[-1].stops is None:
            way = (*steps.pop().way, motion)  # type: ignore[union-attr]
        steps.append(ReadReach(pose, way=(*way[:-1], replace(way[-1], stops=True if events == "reach" else None))))
    elif events.startswith(SILENT):
        if lasts_s or (before is not None and before[1] != pose):
            raise ValueError("nothing moves there")
    else:
        if before is not None and (lasts_s or before[1] != pose):
            steps.append(motion)
        # The text has the quantity of a loop, not the input that shows it.
        steps += (replace(each, channel="") if isinstance(each, ReadRepeat) else each for each in read_events(events))
    return time_s, pose


def read_events(events: str) -> Iterator[ReadStep]:
    """Read what a row switches: outputs, a tool, a call, a loop's begin, with its quantity as the channel, or end.

    Raises:
        ValueError: it is something else.
    """
    for words in events.split("; ") if events else ():
        if match := _ASSIGNMENT.fullmatch(words):
            yield ReadSwitch(match[1], float(match[2]))
        elif match := _LOOP.fullmatch(words):
            yield ReadRepeat(int(match[1]), float(match[3]), channel=match["key"])
        elif words.startswith("first run step "):
            yield ReadHold()
        elif words == "end repeat":
            yield ReadEndRepeat()
        elif words.startswith("call "):
            yield ReadCall(words[5:])
        elif words.startswith("tool "):
            yield ReadTool(words, None)
        else:
            raise ValueError(f"unknown event {words!r}")


DIALECT = Dialect(
    title="Joint look-up table",
    notes="CSV for a controller that plays joint values at times: degrees and mm, straight from row to row. "
    "Loops and calls are words in the column of events.",
    # Each signal has a row at its own time; times have six decimals.
    capability=Capability(
        controller_class=1, timing="distance and time", cycle_s=5e-7, most_events=10**6, changes_tools=True
    ),
    form=FileForm(".csv"),
    longest_line=250,
    write=write,
    rebuild=rebuild,
    needs_joints=True,
    writes_joints=False,
)
