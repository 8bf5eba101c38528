"""Reads the SPEL+ that ``epson`` writes, as a controller would execute it."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from programs.errors import ProgramError
from programs.pose import Pose
from programs.posts.reading.rebuilt import (
    ReadBoard,
    ReadCall,
    ReadEndRepeat,
    ReadPause,
    ReadSignal,
    ReadSwitch,
    ReadTool,
    Rebuilt,
)
from programs.posts.reading.scanner import Arm, read_repeat
from programs.posts.writing.angles import from_fixed_xyz

_NUMBER = r"-?\d+(?:\.\d+)?"
_XY = rf"XY\(((?:{_NUMBER}, ){{5}}{_NUMBER})\)"
_OUTPUT = rf"(?:(On|Off) (\d+)|(Out|AIO_Out) (\d+), ({_NUMBER}))"
_MOVE = re.compile(rf"(Move|Go) {_XY} /(\d+)( ROT)?( CP)?(?: !(.*)!)?")
_JOINTS = re.compile(rf"Go JA\({_NUMBER}(?:, {_NUMBER})*\)")
_FRAME = re.compile(rf"(TLSet|Local) (\d+), {_XY}")
_SPEED = re.compile(rf"(SpeedS|SpeedR) ({_NUMBER})")
_WAIT = re.compile(rf"Wait ({_NUMBER})")
_TOOL = re.compile(r"Tool (\d+)")
_CALL = re.compile(r"Call (\w+)")
_PARALLEL = re.compile(rf"D(\d+); {_OUTPUT}(?:; |$)")
_SWITCH = re.compile(_OUTPUT)
_WHILE = re.compile(
    rf"Loop While (nLoop\d+) < (\d+)(?: And ({_NUMBER}) \* AIO_In\(\d+\) \+ ({_NUMBER}) < ({_NUMBER}))?"
)
_COUNT = re.compile(r"nLoop(\d+) = (?:0|nLoop\1 \+ 1)")
_IGNORED = re.compile(rf"Integer nLoop\d+|Motor On|Power High|Speed \d+|(?:Accel|AccelS|AccelR) {_NUMBER}, {_NUMBER}")


@dataclass(slots=True)
class _Controller:
    """Functions, tables and the arm."""

    functions: dict[str, list[str]] = field(default_factory=dict[str, list[str]])
    frames: dict[tuple[str, int], Pose] = field(default_factory=dict[tuple[str, int], Pose])
    arm: Arm = field(default_factory=Arm)
    speed_mm_s: float = 0.0

    def run(self, function: str) -> None:
        """Execute a function, each loop once."""
        lines = self.functions[function]
        for at, line in enumerate(lines):
            if line == "Do":
                self.begin_loop(lines[at + 1 :])
            else:
                self.execute(line)

    def begin_loop(self, rest: list[str]) -> None:
        """Begin a loop whose counter is the first thing in it."""
        counter = rest[0].split()[0] if rest else ""
        end = next((found for line in rest if (found := _WHILE.fullmatch(line)) and found[1] == counter), None)
        if end is None:
            raise ProgramError("a Do has no Loop.")
        self.arm.steps.append(read_repeat(end[2], end.groups()[2:]))

    def execute(self, line: str) -> None:
        """Execute one statement."""
        if match := _MOVE.fullmatch(line):
            self.move(match)
        elif match := _SPEED.fullmatch(line):
            self.speed_mm_s = float(match[2]) if match[1] == "SpeedS" else self.speed_mm_s
        elif match := _SWITCH.fullmatch(line):
            self.arm.steps.append(ReadSwitch(*_switched(match.groups())))
        elif match := _WAIT.fullmatch(line):
            self.arm.steps.append(ReadPause(float(match[1])))
        elif match := _CALL.fullmatch(line):
            self.call(match[1])
        elif _WHILE.fullmatch(line):
            self.arm.steps.append(ReadEndRepeat())
        else:
            self.prepare(line)

    def call(self, name: str) -> None:
        """Call a function: one of the program's, or one that the integrator has."""
        if name in self.functions:
            self.run(name)
        else:
            self.arm.steps.append(ReadCall(name))

    def prepare(self, line: str) -> None:
        """Execute what sets frames and modes."""
        if match := _FRAME.fullmatch(line):
            self.frames[match[1], int(match[2])] = _pose(match[3])
        elif match := _TOOL.fullmatch(line):
            self.arm.tool = ReadTool(line, self.frame("TLSet", int(match[1])))
        elif _JOINTS.fullmatch(line):
            self.arm.jointed = True
        elif not _COUNT.fullmatch(line) and not _IGNORED.fullmatch(line):
            raise ProgramError(f"unknown statement {line!r}.")

    def frame(self, word: str, number: int) -> Pose:
        """Look up a tool or a local."""
        if (word, number) not in self.frames:
            raise ProgramError(f"{word} {number} is not set.")
        return self.frames[word, number]

    def move(self, match: re.Match[str]) -> None:
        """Move in a line, or by joints."""
        word, values, local, turns, passes, parallel = match.groups()
        self.arm.board = ReadBoard(self.frame("Local", int(local)))
        pose = _pose(values)
        if word == "Go":
            self.arm.reach(pose)
            return
        signals = tuple(_signals(parallel or ""))
        self.arm.line(pose, passes is None, 0.0 if turns else self.speed_mm_s, signals)


def read(files: Mapping[str, str]) -> Rebuilt:
    """Rebuild what the program does.

    Raises:
        ProgramError: something is written that ``epson`` does not write.
    """
    controller = _Controller()
    for text in files.values():
        _load(controller, text)
    if "main" not in controller.functions:
        raise ProgramError("there is no function main.")
    controller.run("main")
    return Rebuilt(tuple(controller.arm.steps))


def _load(controller: _Controller, text: str) -> None:
    lines: list[str] | None = None
    for raw in text.splitlines():
        line = raw.partition("'")[0].strip()
        if match := re.fullmatch(r"Function (\w+)", line):
            lines = controller.functions.setdefault(match[1], [])
        elif line == "Fend":
            lines = None
        elif line and lines is None:
            raise ProgramError(f"{line!r} stands outside a function.")
        elif line and lines is not None:
            lines.append(line)


def _signals(parallel: str) -> list[ReadSignal]:
    found, at = list[ReadSignal](), 0
    while match := _PARALLEL.match(parallel, at):
        percent, *words = match.groups()
        channel, value = _switched(tuple(words))
        found.append(ReadSignal(channel, value, float(percent) / 100.0, 0.0))
        at = match.end()
    if at < len(parallel):
        raise ProgramError(f"unknown parallel processing {parallel!r}.")
    return found


def _switched(words: tuple[str | None, ...]) -> tuple[str, float]:
    switch, bit, word, number, value = words
    if switch:
        return f"digital {bit}", float(switch == "On")
    return f"{'group' if word == 'Out' else 'analog'} {number}", float(value or 0.0)


def _pose(values: str) -> Pose:
    x, y, z, u, v, w = (float(value) for value in values.split(", "))
    return Pose((x, y, z), from_fixed_xyz(w, v, u))
