"""The joint look-up table of the Cairo arm (2009): node, time, joints, and what is switched when."""

import csv
import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from programs.errors import ProgramError
from programs.motion.installation import Installation
from programs.motion.lower import Lowered
from programs.motion.steps import (
    Call,
    EndRepeat,
    Line,
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
from programs.posts.dialect import Dialect, ProgramFiles
from programs.posts.writing.axes import in_degrees_and_mm
from programs.posts.writing.heading import heading
from programs.posts.writing.wording import cut, fixed, make_name, short
from specs.source import Source

_SHARES_APART = 1e-9

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


def write(dialect: Dialect, lowered: Lowered, installation: Installation) -> ProgramFiles:
    """Write the table: one file.

    Raises:
        ProgramError: the joint motion is not known.
    """
    out = io.StringIO()
    for line in heading(dialect, lowered, installation):
        out.write(f"# {cut(line, dialect.longest_line - 2)}\n")
    out.write("# Joints in degrees or mm; pose of the orifice in the board's CAD frame, mm, quaternion w x y z\n")
    table = csv.writer(out, lineterminator="\n")
    units = {"revolute": "deg", "prismatic": "mm"}
    names = [f"{make_name(joint.name, 24)}_{units[joint.kind]}" for joint in installation.joints]
    table.writerow(["node", "time_s", *names, "x", "y", "z", "qw", "qx", "qy", "qz", "events", "made_by"])
    for node, row in enumerate(_rows(lowered.motion.steps), start=1):
        joints = [fixed(value, 5) for value in in_degrees_and_mm(row.joints, installation)]
        pose = [fixed(value, 3) for value in row.pose.position] + [fixed(value, 7) for value in row.pose.quaternion]
        table.writerow([node, fixed(row.time_s, 6), *joints, *pose, row.events, cut(str(row.made_by), 60)])
    return {f"{make_name(lowered.motion.origin.board, 60)}.csv": out.getvalue()}


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
    last = 0.0
    for seconds in moments.tolist():
        events = [event for event in line.events if event.signal_s == seconds]
        share = samples.share_at(seconds)
        if share - last < _SHARES_APART and not events and seconds < line.duration_s:
            continue
        joints = tuple(float(np.interp(seconds, samples.seconds, column)) for column in samples.joints.T)
        words = "; ".join(f"{event.channel.name} = {short(event.value, 6)}" for event in events)
        yield _Row(begin_s + seconds, joints, line.pose_at(share), words, line.made_by)
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
        case EndRepeat():
            return "end repeat"
        case Note():
            return f"note {cut(step.text, 60)}"
        case Pause():
            return "held"
        case Line() | Reach():
            raise AssertionError("these have rows of their own")
