"""Reads the URScript that ``ur`` writes, as a controller would execute it."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from programs.errors import ProgramError
from programs.pose import Pose, distance
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
from programs.posts.ur.text import ANALOG, KINDS, WATCHER
from programs.posts.writing.angles import from_rotation_vector

_N = r"(-?\d+(?:\.\d+)?)"
_POSE = rf"p\[{_N},{_N},{_N},{_N},{_N},{_N}\]"
_JOINTS = rf"\[(?:{_N},)*{_N}\]"
_OUTPUT = rf"([012]), (\d+), {_N}"
_MOVE = re.compile(rf"movel\(pose_trans\(board, {_POSE}\), a=[\d.]+, ([vt])={_N}(?:, r={_N})\)")
_REACH = re.compile(rf"move([jl])\(pose_trans\(board, {_POSE}\), a=[\d.]+, v=[\d.]+\)")
_JOINT = re.compile(rf"movej\({_JOINTS}, a=[\d.]+, v=[\d.]+\)")
_ARM = re.compile(rf"arm\({_POSE}, {_POSE}, {_N}, {_OUTPUT}\)")
_SET = re.compile(rf"set_out\({_OUTPUT}\)")
_TCP = re.compile(r"set_tcp\((\w+)\)")
_BOARD = re.compile(r"board = (\w+)")
_GLOBAL = re.compile(rf"global (\w+) = {_POSE}")
_LOOP = re.compile(rf"while (\w+) < (\d+)(?: and \(\1 == 0 or {_N}\*get_standard_analog_in\(\d+\)\+{_N} < {_N}\))?:")
_IGNORED = re.compile(
    rf"set_payload\({_N}, \[0,0,{_N}\]\)|run_watch = run watch\(\)|kill run_watch|settle\(\)"
    r"|n_loop_\d+ = 0|n_loop_(\d+) = n_loop_\3 \+ 1"
)
_CHANNELS = {str(code): kind for kind, code in KINDS.items()}


@dataclass(slots=True)
class _Controller:
    """Functions, outputs that wait for their places, and the state of the robot."""

    routines: dict[str, list[str]] = field(default_factory=dict[str, list[str]])
    arm: Arm = field(default_factory=Arm)
    armed: list[tuple[Pose, Pose, ReadSignal]] = field(default_factory=list[tuple[Pose, Pose, ReadSignal]])
    poses: dict[str, Pose] = field(default_factory=dict[str, Pose])

    def run(self, name: str) -> None:
        """Execute a function."""
        for statement in self.routines[name]:
            self.execute(statement)

    def execute(self, statement: str) -> None:
        """Execute one statement."""
        if match := _MOVE.fullmatch(statement):
            self.move(match)
        elif match := _REACH.fullmatch(statement):
            self.arm.reach(_pose(match.groups()[1:]))
        elif match := _ARM.fullmatch(statement):
            self.prepare(match)
        elif match := _SET.fullmatch(statement):
            kind, number, value = match.groups()
            self.arm.steps.append(ReadSwitch(f"{_CHANNELS[kind]} {number}", float(value)))
        elif match := re.fullmatch(rf"sleep\({_N}\)", statement):
            self.arm.steps.append(ReadPause(float(match[1])))
        elif match := _LOOP.fullmatch(statement):
            self.arm.steps.append(read_repeat(match[2], match.groups()[2:]))
        elif statement == "end":
            self.arm.steps.append(ReadEndRepeat())
        else:
            self.arrange(statement)

    def arrange(self, statement: str) -> None:
        """Use frames, or call a function: one of the program's, or one that the integrator has."""
        if match := _TCP.fullmatch(statement):
            self.arm.tool = ReadTool(match[1], self.look_up(match[1]))
        elif match := _BOARD.fullmatch(statement):
            self.arm.board = ReadBoard(self.look_up(match[1]))
        elif match := _GLOBAL.fullmatch(statement):
            self.poses[match[1]] = _pose(match.groups()[1:])
        elif _IGNORED.fullmatch(statement) or _JOINT.fullmatch(statement):
            return
        elif match := re.fullmatch(r"([A-Za-z]\w*)\(\)", statement):
            if match[1] in self.routines:
                self.run(match[1])
            else:
                self.arm.steps.append(ReadCall(match[1]))
        else:
            raise ProgramError(f"unknown statement {statement!r}.")

    def look_up(self, name: str) -> Pose:
        """Give a pose that has been declared."""
        if name not in self.poses:
            raise ProgramError(f"{name} is not declared as a pose.")
        return self.poses[name]

    def prepare(self, match: re.Match[str]) -> None:
        """Arm an output for the next move."""
        numbers = match.groups()
        way, kind, number, value = numbers[12:]
        start, target = _pose(numbers[:6]), _pose(numbers[6:12])
        share = 1000.0 * float(way) / distance(start, target)
        signal = ReadSignal(f"{_CHANNELS[kind]} {number}", float(value), share, 0.0)
        self.armed.append((start, target, signal))

    def move(self, match: re.Match[str]) -> None:
        """Move in a line; what is armed has to be armed for it."""
        numbers = match.groups()
        pose, (kind, pace, blend) = _pose(numbers[:6]), numbers[6:]
        for start, target, _ in self.armed:
            if self.arm.pose is None or distance(start, self.arm.pose) > 1e-6 or distance(target, pose) > 1e-6:
                raise ProgramError("an output is armed for another move than the next.")
        signals = tuple(signal for _, _, signal in self.armed)
        self.armed = []
        self.arm.line(pose, float(blend) == 0.0, 1000.0 * float(pace) if kind == "v" else 0.0, signals)


def _pose(numbers: tuple[str, ...]) -> Pose:
    x, y, z, *turn = map(float, numbers)
    rx, ry, rz = turn
    return Pose((1000.0 * x, 1000.0 * y, 1000.0 * z), from_rotation_vector(rx, ry, rz))


def read(files: Mapping[str, str]) -> Rebuilt:
    """Rebuild what the script does; the first file holds the program.

    Raises:
        ProgramError: the thread for the outputs is missing, or something is written that ``ur`` does not write.
    """
    statements = [line for text in files.values() for line in _statements(text.splitlines())]
    watcher = list(_statements(WATCHER))
    begins = [at for at, line in enumerate(statements) if line == watcher[0]]
    if len(begins) != 1 or statements[begins[0] : begins[0] + len(watcher)] != watcher:
        raise ProgramError("the thread that switches the outputs is not as it is written.")
    del statements[begins[0] : begins[0] + len(watcher)]
    controller = _Controller()
    _load(controller, statements)
    controller.run(next(iter(controller.routines)))
    return Rebuilt(tuple(controller.arm.steps), ANALOG)


def _statements(lines: list[str]) -> Iterator[str]:
    for line in lines:
        statement = line.strip()
        if statement and not statement.startswith("#"):
            yield statement


def _load(controller: _Controller, statements: list[str]) -> None:
    """Sort statements into functions; an end belongs to what was opened last."""
    opened: list[tuple[str, list[str]]] = []
    loops = 0
    for statement in statements:
        if match := re.fullmatch(r"def (\w+)\(\):", statement):
            routine = controller.routines.setdefault(match[1], [])
            opened.append((match[1], routine))
        elif not opened:
            raise ProgramError(f"statement {statement!r} stands outside any function.")
        elif statement == "end" and loops == 0:
            opened.pop()
        else:
            loops += statement.startswith("while ") - (statement == "end")
            opened[-1][1].append(statement)
    if opened:
        raise ProgramError(f"function {opened[-1][0]} has no end.")
