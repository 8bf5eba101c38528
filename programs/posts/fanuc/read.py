"""Reads the TP programs that ``fanuc`` writes, as a controller would execute them."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from programs.errors import ProgramError
from programs.pose import Pose
from programs.posts.fanuc.text import ANALOG
from programs.posts.fanuc.write import LONGEST_WAIT_S
from programs.posts.reading.rebuilt import (
    ReadBoard,
    ReadCall,
    ReadEndRepeat,
    ReadRepeat,
    ReadSignal,
    ReadSwitch,
    ReadTool,
    Rebuilt,
)
from programs.posts.reading.scanner import Arm
from programs.posts.writing.angles import from_fixed_xyz

_N = r"(-?\d*\.?\d+)"
_M = r"\(?(-?\d*\.?\d+)\)?"
"""A number that stands in brackets if it is negative."""
_ASSIGNMENT = rf"(DO|GO|AO)\[(\d+)\]=(ON|OFF|{_M})"
_OUTPUT = re.compile(_ASSIGNMENT)
_LINE = re.compile(rf"L P\[(\d+)\] (\d+)(mm/sec|deg/sec) (FINE|CNT\d+)(?: TB {_N}sec,{_ASSIGNMENT})?")
_JOINT = re.compile(r"J P\[(\d+)\] \d+% FINE")
_FRAME = re.compile(r"(UFRAME|UTOOL)_NUM=(\d+)")
_ENTRY = re.compile(rf"PR\[\d+,([1-6])\]={_M}")
_ENTERED = re.compile(r"(UFRAME|UTOOL)\[(\d+)\]=PR\[\d+\]")
_READING = re.compile(rf"R\[(\d+)\]=AI\[\d+\]\*{_M}")
_SHIFTED = re.compile(rf"R\[(\d+)\]=R\[\1\]\+{_M}")
_AGAIN = re.compile(rf"IF R\[(\d+)\]<(\d+)(?: AND R\[\d+\]<{_M})?,JMP LBL\[(\d+)\]")
_IGNORED = re.compile(r"!.*|PR\[\d+\]=LPOS|R\[\d+\]=0")
_INSTRUCTION = re.compile(r" *(\d+):(?:  )?(.*) ;")
_POSITION = re.compile(
    rf"P\[(\d+)\]\{{\n   GP1:\n\tUF : (\d+), UT : (\d+),(?:\t\tCONFIG : '[NF] U T, -?\d, -?\d, -?\d',\n\t"
    rf"X = +{_N}  mm,\tY = +{_N}  mm,\tZ = +{_N}  mm,\n\tW = +{_N} deg,\tP = +{_N} deg,\tR = +{_N} deg"
    rf"|\n\tJ1 = [^}}]*)\n\}};\n"
)
_KINDS = {"DO": "digital", "GO": "group", "AO": "analog"}


@dataclass(slots=True)
class _Program:
    """Instructions, and by number the frames and the pose of each position; ``None`` where it is joint values."""

    instructions: list[str]
    positions: dict[str, tuple[str, str, Pose | None]]


@dataclass(slots=True)
class _Controller:
    """All programs, the tables, and the state of the robot."""

    programs: dict[str, _Program] = field(default_factory=dict[str, _Program])
    tables: dict[tuple[str, str], Pose] = field(default_factory=dict[tuple[str, str], Pose])
    register: list[float] = field(default_factory=lambda: [0.0] * 6)
    frames: dict[str, str] = field(default_factory=dict[str, str])
    arm: Arm = field(default_factory=Arm)

    def run(self, name: str) -> None:
        """Execute a program."""
        program = self.programs[name]
        for at, instruction in enumerate(program.instructions):
            if match := re.fullmatch(r"LBL\[(\d+)\]", instruction):
                self.arm.steps.append(_repeat(program.instructions[at:], match[1]))
            else:
                self.execute(instruction, program)

    def execute(self, instruction: str, program: _Program) -> None:
        """Execute one instruction."""
        if _IGNORED.fullmatch(instruction) or _READING.fullmatch(instruction) or _SHIFTED.fullmatch(instruction):
            return
        if match := _LINE.fullmatch(instruction):
            self.line(match, program)
        elif match := _JOINT.fullmatch(instruction):
            pose = self.position(match[1], program)
            self.arm.jointed = pose is None
            if pose is not None:
                self.arm.reach(pose)
        elif match := _FRAME.fullmatch(instruction):
            self.use(*match.groups())
        elif match := _OUTPUT.fullmatch(instruction):
            self.arm.steps.append(ReadSwitch(*_assigned(*match.groups())))
        elif match := re.fullmatch(rf"WAIT {_N}\(sec\)", instruction):
            self.arm.wait(float(match[1]), LONGEST_WAIT_S)
        elif _AGAIN.fullmatch(instruction):
            self.arm.steps.append(ReadEndRepeat())
        else:
            self.arrange(instruction)

    def arrange(self, instruction: str) -> None:
        """Enter frames, or call a program: one of ours, or one that the integrator has."""
        if match := _ENTRY.fullmatch(instruction):
            self.register[int(match[1]) - 1] = float(match[2])
        elif match := _ENTERED.fullmatch(instruction):
            x, y, z, w, p, r = self.register
            self.tables[match[1], match[2]] = Pose((x, y, z), from_fixed_xyz(w, p, r))
        elif match := re.fullmatch(r"CALL ([A-Z]\w*)", instruction):
            if match[1] in self.programs:
                self.run(match[1])
            else:
                self.arm.steps.append(ReadCall(match[1]))
        elif not re.fullmatch(r"R\[(\d+)\]=R\[\1\]\+1", instruction):
            raise ProgramError(f"unknown instruction {instruction!r}.")

    def use(self, table: str, number: str) -> None:
        """Use another tool or user frame from now on."""
        pose = self.tables.get((table, number))
        self.frames[table] = number
        if table == "UTOOL":
            self.arm.tool = ReadTool(number, pose)
        else:
            self.arm.board = ReadBoard(pose)

    def position(self, number: str, program: _Program) -> Pose | None:
        """Look up a position, taught in the frames in use."""
        if number not in program.positions:
            raise ProgramError(f"P[{number}] has no position.")
        frame, tool, pose = program.positions[number]
        if (frame, tool) != (self.frames.get("UFRAME"), self.frames.get("UTOOL")):
            raise ProgramError(f"P[{number}] is of frame {frame} and tool {tool}, which are not in use.")
        return pose

    def line(self, match: re.Match[str], program: _Program) -> None:
        """Move in a line."""
        number, speed, unit, ending, lead, *assigned = match.groups()
        pose = self.position(number, program)
        if pose is None:
            raise ProgramError(f"P[{number}] is not cartesian.")
        signals = (ReadSignal(*_assigned(*assigned), 1.0, -float(lead)),) if lead is not None else ()
        self.arm.line(pose, ending == "FINE", float(speed) if unit == "mm/sec" else 0.0, signals)


def _assigned(kind: str, number: str, word: str, value: str | None) -> tuple[str, float]:
    """Channel and value of an assignment."""
    return f"{_KINDS[kind]} {number}", float(value) if value is not None else float(word == "ON")


def _repeat(instructions: list[str], label: str) -> ReadRepeat:
    """Find how a loop ends: the jump back to its label, and the reading before it."""
    scale = offset = None
    for instruction in instructions:
        if match := _READING.fullmatch(instruction):
            scale = float(match[2])
        elif match := _SHIFTED.fullmatch(instruction):
            offset = float(match[2])
        elif (match := _AGAIN.fullmatch(instruction)) and match[4] == label:
            if match[3] is not None and (scale is None or offset is None):
                raise ProgramError(f"the loop at LBL[{label}] does not read its input.")
            if match[3] is None or scale is None or offset is None:
                return ReadRepeat(int(match[2]), None)
            return ReadRepeat(int(match[2]), float(match[3]), (scale, offset))
    raise ProgramError(f"nothing jumps to LBL[{label}].")


def read(files: Mapping[str, str]) -> Rebuilt:
    """Rebuild what the programs do; the first file is the main one, and that of the frames has been run.

    Raises:
        ProgramError: something is written that ``fanuc`` does not write.
    """
    controller = _Controller()
    for file, text in files.items():
        if file.endswith(".ls"):
            name = file.removesuffix(".ls")
            controller.programs[name] = _load(name, text)
    names = list(controller.programs)
    for name in names:
        if any(_ENTERED.fullmatch(instruction) for instruction in controller.programs[name].instructions):
            controller.run(name)
    controller.run(names[0])
    return Rebuilt(tuple(controller.arm.steps), ANALOG)


def _load(name: str, text: str) -> _Program:
    head, found, rest = text.partition("/MN\n")
    body, _, points = rest.partition("/POS\n")
    if not (found and head.startswith(f"/PROG  {name}\n/ATTR\n") and points.endswith("/END\n")):
        raise ProgramError(f"{name} is no TP program.")
    instructions: list[str] = []
    for number, line in enumerate(body.splitlines(), start=1):
        match = _INSTRUCTION.fullmatch(line)
        if match is None or int(match[1]) != number:
            raise ProgramError(f"{name}: line {line!r} is not numbered {number} or does not end in ' ;'.")
        instructions.append(match[2])
    positions: dict[str, tuple[str, str, Pose | None]] = {}
    for match in _POSITION.finditer(points):
        number, frame, tool, *numbers = match.groups()
        pose = None
        if numbers[0] is not None:
            x, y, z, w, p, r = map(float, numbers)
            pose = Pose((x, y, z), from_fixed_xyz(w, p, r))
        positions[number] = (frame, tool, pose)
    if len(_POSITION.sub("", points)) != len("/END\n"):
        raise ProgramError(f"{name}: a position is not written as expected.")
    return _Program(instructions, positions)
