"""Reads a joint table back."""

import csv
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace

from programs.errors import ProgramError
from programs.pose import Pose
from programs.posts.dialect import ProgramFiles
from programs.posts.joint_table.write import ON_THE_WAY
from programs.posts.reading.driver import checked
from programs.posts.rebuilt import (
    Axes,
    ReadCall,
    ReadEndRepeat,
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

_ASSIGNMENT = re.compile(r"(\w+) = (-?[\d.]+)")
_LOOP = re.compile(r"repeat (\d+) until (?P<key>.*) >= (-?[\d.]+)")
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
    table, number = csv.reader(lines[comments:]), 0
    header = next(table, list[str]())
    try:
        for number, row in enumerate(table, start=1):
            if len(row) != len(header):
                raise ValueError(f"it has {len(row)} values for {len(header)} columns")
            before = _read_row(number, dict(zip(header, row, strict=True)), before, steps)
            places += [TextPlace(file, comments + table.line_num)] * (len(steps) - len(places))
    except (ValueError, KeyError, csv.Error) as error:
        line = comments + table.line_num
        raise ProgramError(f"row {number} cannot be read ({error}).", file=file, line=line) from None
    return Rebuilt(tuple(steps), places=tuple(places))


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
    axes = Axes(tuple(float(row[key]) for key in row if key.endswith(("_deg", "_mm"))))
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
        elif words == "end repeat":
            yield ReadEndRepeat()
        elif words.startswith("call "):
            yield ReadCall(words[5:])
        elif words.startswith("tool "):
            yield ReadTool(words, None)
        else:
            raise ValueError(f"unknown event {words!r}")
