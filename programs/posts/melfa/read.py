"""Reads the MELFA-BASIC that ``melfa`` writes, as a controller would execute it."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from programs.errors import ProgramError
from programs.pose import Pose, inverse
from programs.posts.melfa.write import ANALOG
from programs.posts.reading.rebuilt import (
    ReadBoard,
    ReadCall,
    ReadEndRepeat,
    ReadPause,
    ReadSwitch,
    ReadTool,
    Rebuilt,
)
from programs.posts.reading.scanner import Arm, read_repeat
from programs.posts.writing.angles import from_fixed_xyz

_NUMBER = r"-?\d+(?:\.\d+)?"
_OUTPUT = rf"(M_Out|M_Outb|M_Outw)\((\d+)\)=({_NUMBER})"
_STEP = re.compile(r"(\d+) (.*)")
_POSITION = re.compile(rf"(P\w+)=\(((?:{_NUMBER},){{5}}{_NUMBER})\)\([07],0\)")
_JOINTS = re.compile(rf"(J\d+)=\({_NUMBER}(?:,{_NUMBER})*\)")
_MOVE = re.compile(rf"Mvs (P\d+)(?: Wth {_OUTPUT})?")
_REACH = re.compile(r"Mov ([PJ]\d+)")
_SWITCH = re.compile(_OUTPUT)
_SPEED = re.compile(rf"Spd ({_NUMBER}|M_NSpd)")
_PASS = re.compile(rf"Cnt (0|1,{_NUMBER},{_NUMBER})")
_DELAY = re.compile(rf"Dly ({_NUMBER})")
_FRAME = re.compile(r"(Tool|Base) (P\w+)")
_CALL = re.compile(r'CallP "(\w+)"')
_LABEL = re.compile(r"\*LOOP(\d+)")
_BACK = re.compile(
    rf"If M(\d+)<(\d+)(?: And \(({_NUMBER})\*M_Inw\(\d+\)\+({_NUMBER})\)<({_NUMBER}))? Then GoTo \*LOOP(\d+)"
)
_IGNORED = re.compile(r"Ovrd 100|JOvrd \d+|M\d+=0|M(\d+)=M\1\+1|End")
_KINDS = {"M_Out": "digital", "M_Outb": "group", "M_Outw": "analog"}


@dataclass(slots=True)
class _Program:
    """The steps and positions of one program."""

    steps: list[str] = field(default_factory=list[str])
    positions: dict[str, Pose | None] = field(default_factory=dict[str, Pose | None])
    """``None`` for joint positions."""

    def pose(self, name: str) -> Pose | None:
        """Look up a position."""
        if name not in self.positions:
            raise ProgramError(f"position {name} is not in the program.")
        return self.positions[name]

    def point(self, name: str) -> Pose:
        """Look up a position that is a pose."""
        pose = self.pose(name)
        if pose is None:
            raise ProgramError(f"{name} is a joint position.")
        return pose


@dataclass(slots=True)
class _Controller:
    """All programs, and the arm."""

    programs: dict[str, _Program] = field(default_factory=dict[str, _Program])
    arm: Arm = field(default_factory=Arm)
    speed_mm_s: float = 0.0
    stops: bool = True

    def run(self, name: str) -> None:
        """Execute a program, each loop once."""
        program = self.programs[name]
        for at, step in enumerate(program.steps):
            if match := _LABEL.fullmatch(step):
                rest = (found for line in program.steps[at:] if (found := _BACK.fullmatch(line)))
                end = next((found for found in rest if found[6] == match[1]), None)
                if end is None or end[1] != match[1]:
                    raise ProgramError(f"nothing goes back to {step}.")
                self.arm.steps.append(read_repeat(end[2], end.groups()[2:5]))
            else:
                self.execute(program, step)

    def execute(self, program: _Program, step: str) -> None:
        """Execute one step."""
        if match := _MOVE.fullmatch(step):
            if match[2]:
                self.arm.steps.append(_switched(*match.groups()[1:]))
            self.arm.line(program.point(match[1]), self.stops, self.speed_mm_s)
        elif match := _REACH.fullmatch(step):
            pose = program.pose(match[1])
            self.arm.jointed = pose is None
            if pose is not None:
                self.arm.reach(pose)
        elif match := _SWITCH.fullmatch(step):
            self.arm.steps.append(_switched(*match.groups()))
        elif match := _DELAY.fullmatch(step):
            self.arm.steps.append(ReadPause(float(match[1])))
        elif match := _CALL.fullmatch(step):
            self.call(match[1])
        elif _BACK.fullmatch(step):
            self.arm.steps.append(ReadEndRepeat())
        else:
            self.set(program, step)

    def call(self, name: str) -> None:
        """Call a program: one of ours, or one that the integrator has."""
        if name in self.programs:
            self.run(name)
        else:
            self.arm.steps.append(ReadCall(name))

    def set(self, program: _Program, step: str) -> None:
        """Execute what sets frames and modes."""
        if match := _SPEED.fullmatch(step):
            self.speed_mm_s = 0.0 if match[1] == "M_NSpd" else float(match[1])
        elif match := _PASS.fullmatch(step):
            self.stops = match[1] == "0"
        elif match := _FRAME.fullmatch(step):
            if match[2] in ("P_NBase", "P_NTool"):
                return
            pose = program.point(match[2])
            if match[1] == "Tool":
                self.arm.tool = ReadTool(match[2], pose)
            else:
                self.arm.board = ReadBoard(inverse(pose))
        elif not _IGNORED.fullmatch(step):
            raise ProgramError(f"unknown step {step!r}.")


def read(files: Mapping[str, str]) -> Rebuilt:
    """Rebuild what the programs do, from the first on.

    Raises:
        ProgramError: something is written that ``melfa`` does not write.
    """
    controller = _Controller()
    for name, text in files.items():
        controller.programs[name.removesuffix(".prg")] = _load(text)
    controller.run(next(iter(controller.programs)))
    return Rebuilt(tuple(controller.arm.steps), ANALOG)


def _load(text: str) -> _Program:
    program = _Program()
    for number, line in enumerate(text.splitlines(), start=1):
        if match := _POSITION.fullmatch(line):
            x, y, z, a, b, c = (float(value) for value in match[2].split(","))
            program.positions[match[1]] = Pose((x, y, z), from_fixed_xyz(a, b, c))
        elif match := _JOINTS.fullmatch(line):
            program.positions[match[1]] = None
        elif (match := _STEP.fullmatch(line)) and int(match[1]) == number:
            if not match[2].startswith("'"):
                program.steps.append(match[2])
        else:
            raise ProgramError(f"line {number} is neither a step nor a position: {line!r}.")
    return program


def _switched(word: str, number: str, value: str) -> ReadSwitch:
    return ReadSwitch(f"{_KINDS[word]} {number}", float(value))
