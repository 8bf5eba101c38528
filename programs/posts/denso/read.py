"""Reads the PacScript that ``denso`` writes, as a controller would execute it."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from programs.errors import ProgramError
from programs.pose import Pose
from programs.posts.denso.write import ANALOG
from programs.posts.reading.rebuilt import (
    ReadBoard,
    ReadCall,
    ReadEndRepeat,
    ReadLine,
    ReadPause,
    ReadSignal,
    ReadSwitch,
    ReadTool,
    Rebuilt,
)
from programs.posts.reading.scanner import Arm, read_repeat
from programs.posts.writing.angles import from_fixed_xyz

_NUMBER = r"-?\d+(?:\.\d+)?"
_POSE = rf"P\(((?:{_NUMBER}, ){{5}}{_NUMBER})"
_LINE = re.compile(rf"Move L, @(\d+) {_POSE}, -1\), Speed = ({_NUMBER}) \* (PER_MM_S|PER_DEG_S)(, Next)?")
_REACH = re.compile(rf"Move ([PL]), @0 {_POSE}, -1\), Speed = 10")
_JOINTS = re.compile(rf"Move P, @0 J\({_NUMBER}(?:, {_NUMBER})*\), Speed = 10")
_FRAME = re.compile(rf"(Tool|Work) (\d+), {_POSE}\)")
_USE = re.compile(r"Change(Tool|Work) (\d+)")
_SWITCH = re.compile(rf"(?:(Set|Reset) IO\[(\d+)\]|(IOB|IOW)\[(\d+)\] = ({_NUMBER}))")
_ARRIVE = re.compile(r"Arrive (\d+)")
_DELAY = re.compile(r"Delay (\d+)")
_CALL = re.compile(r"Call (\w+)")
_FOR = re.compile(r"For nLoop(\d+) = 1 To (\d+)")
_EXIT = re.compile(rf"If ({_NUMBER}) \* IOW\[\d+\] \+ ({_NUMBER}) >= ({_NUMBER}) Then Exit For")
_NEXT = re.compile(r"Next nLoop\d+")
_DEFINED = re.compile(rf"#Define (?:PER_MM_S|PER_DEG_S) {_NUMBER}")
_IGNORED = re.compile(r"Dim nLoop\d+ As Integer|TakeArm Keep = 0|GiveArm|Speed 100|Accel 100, 100")


@dataclass(slots=True)
class _Controller:
    """Subprograms, tables and the arm."""

    subs: dict[str, list[str]] = field(default_factory=dict[str, list[str]])
    frames: dict[tuple[str, int], Pose] = field(default_factory=dict[tuple[str, int], Pose])
    arm: Arm = field(default_factory=Arm)
    moving: bool = False
    """Whether the last move goes on while the program does."""
    percent: int = 0
    """Of the last move that the program has waited for."""

    def run(self, sub: str) -> None:
        """Execute a subprogram, each loop once."""
        lines = self.subs[sub]
        for at, line in enumerate(lines):
            if match := _FOR.fullmatch(line):
                end = next((rest for rest in range(at, len(lines)) if lines[rest] == f"Next nLoop{match[1]}"), 0)
                if not end:
                    raise ProgramError(f"{line} has no Next.")
                looks = _EXIT.fullmatch(lines[end - 1])
                self.arm.steps.append(read_repeat(match[2], looks.groups() if looks else ()))
            else:
                self.execute(line)

    def execute(self, line: str) -> None:
        """Execute one statement."""
        if match := _LINE.fullmatch(line):
            self.move(match)
        elif match := _SWITCH.fullmatch(line):
            self.switch(match)
        elif match := _ARRIVE.fullmatch(line):
            if not self.moving:
                raise ProgramError(f"{line} does not follow a move with Next.")
            self.percent = int(match[1])
        elif line == "WaitMotion 4, 0":
            self.moving = False
        else:
            self.moving = False
            self.do(line)

    def do(self, line: str) -> None:
        """Execute what is done at rest."""
        if match := _REACH.fullmatch(line):
            self.arm.board = self.arm.board or ReadBoard(None)
            pose = _pose(match[2])
            if match[1] == "P":
                self.arm.reach(pose)
            else:
                self.arm.line(pose, True, 0.0)
        elif _JOINTS.fullmatch(line):
            self.arm.jointed = True
        elif match := _DELAY.fullmatch(line):
            self.arm.steps.append(ReadPause(float(match[1]) / 1e3))
        elif match := _CALL.fullmatch(line):
            if match[1] in self.subs:
                self.run(match[1])
            else:
                self.arm.steps.append(ReadCall(match[1]))
        elif _NEXT.fullmatch(line):
            self.arm.steps.append(ReadEndRepeat())
        else:
            self.prepare(line)

    def prepare(self, line: str) -> None:
        """Execute what sets and selects frames."""
        if match := _FRAME.fullmatch(line):
            self.frames[match[1], int(match[2])] = _pose(match[3])
        elif match := _USE.fullmatch(line):
            pose = self.frames.get((match[1], int(match[2])))
            if pose is None:
                raise ProgramError(f"{line}: it is not set.")
            if match[1] == "Tool":
                self.arm.tool = ReadTool(line, pose)
            else:
                self.arm.board = ReadBoard(pose)
        elif not _IGNORED.fullmatch(line) and not _EXIT.fullmatch(line):
            raise ProgramError(f"unknown statement {line!r}.")

    def move(self, match: re.Match[str]) -> None:
        """Move in a line."""
        passing, values, speed, unit, goes_on = match.groups()
        self.arm.line(_pose(values), passing == "0", float(speed) if unit == "PER_MM_S" else 0.0)
        self.moving, self.percent = goes_on is not None, 0

    def switch(self, match: re.Match[str]) -> None:
        """Set an output: while the last move goes on, at the percent that was waited for."""
        word, bit, group, number, value = match.groups()
        channel, said = f"digital {bit}", float(word == "Set")
        if group:
            channel, said = f"{'analog' if group == 'IOW' else 'group'} {number}", float(value)
        last = self.arm.steps[-1] if self.arm.steps else None
        if not self.moving or not isinstance(last, ReadLine):
            self.arm.steps.append(ReadSwitch(channel, said))
        elif self.percent == 0:
            self.arm.steps.insert(-1, ReadSwitch(channel, said))
        else:
            signal = ReadSignal(channel, said, self.percent / 100.0, 0.0)
            self.arm.steps[-1] = replace(last, signals=(*last.signals, signal))


def read(files: Mapping[str, str]) -> Rebuilt:
    """Rebuild what the program does.

    Raises:
        ProgramError: something is written that ``denso`` does not write.
    """
    controller = _Controller()
    for number, (name, text) in enumerate(files.items()):
        _load(controller, text, "Main" if number == 0 else name.removesuffix(".pcs"))
    if "Main" not in controller.subs:
        raise ProgramError("there is no Sub Main.")
    controller.run("Main")
    return Rebuilt(tuple(controller.arm.steps), ANALOG)


def _load(controller: _Controller, text: str, main: str) -> None:
    """Keep the subprograms of a file; its own Main goes by the name of the file."""
    lines: list[str] | None = None
    for raw in text.splitlines():
        line = raw.partition("'")[0].strip()
        if match := re.fullmatch(r"Sub (\w+)", line):
            lines = controller.subs.setdefault(main if match[1] == "Main" else match[1], [])
        elif line == "End Sub":
            lines = None
        elif lines is not None and line:
            lines.append(line)
        elif line and not _DEFINED.fullmatch(line):
            raise ProgramError(f"{line!r} stands outside a subprogram.")


def _pose(values: str) -> Pose:
    x, y, z, rx, ry, rz = (float(value) for value in values.split(", "))
    return Pose((x, y, z), from_fixed_xyz(rx, ry, rz))
