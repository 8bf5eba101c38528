"""Reads the INFORM jobs that ``yaskawa`` writes, as a controller would execute them."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from programs.errors import ProgramError
from programs.pose import Pose
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
from programs.posts.yaskawa.write import ANALOG, LONGEST_WAIT_S

_N = r"(-?\d+(?:\.\d+)?)"
_MOVE = re.compile(rf"MOVL (C\d{{5}}) (VR?)={_N} (PL=[01]|CR=[\d.]+)(?: ENWAIT T={_N})?")
_JOINT = re.compile(r"MOVJ (C\d{5}) VJ=[\d.]+ PL=0")
_OUTPUT = re.compile(rf"(?:DOUT (OT|OG)|AOUT (AO))#\((\d+)\) (ON|OFF|{_N})")
_AGAIN = re.compile(r"JUMP \*(LOOP\d+) IF I\d{3}<(\d+)")
_IGNORED = re.compile(r"'.*|NOP|SET I\d{3} 0|INC I\d{3}")
_POINT = re.compile(rf"(C\d{{5}})={_N},{_N},{_N},{_N},{_N},{_N}")
_CONFIGURATION = re.compile(r"///RCONF 1,0,0,[01],[01],[01],0,0")
_KINDS = {"OT": "digital", "OG": "group", "AO": "analog"}


@dataclass(slots=True)
class _Job:
    """Instructions, and user frame, tool and pose of each position."""

    instructions: list[str]
    positions: dict[str, tuple[str, str, Pose]]


@dataclass(slots=True)
class _Controller:
    """All jobs, and the state of the robot."""

    jobs: dict[str, _Job] = field(default_factory=dict[str, _Job])
    arm: Arm = field(default_factory=Arm)

    def run(self, name: str) -> None:
        """Execute a job."""
        job, ahead = self.jobs[name], False
        for at, instruction in enumerate(job.instructions):
            if ahead:
                ahead = False  # this output went ahead with the motion before it
            elif match := _MOVE.fullmatch(instruction):
                ahead = match[5] is not None
                self.move(match, job, next(iter(job.instructions[at + 1 :]), ""))
            elif instruction.startswith("*"):
                self.arm.steps.append(_repeat(job.instructions[at:]))
            else:
                self.execute(instruction, job)

    def execute(self, instruction: str, job: _Job) -> None:
        """Execute one instruction."""
        if _IGNORED.fullmatch(instruction):
            return
        if match := _JOINT.fullmatch(instruction):
            self.arm.reach(self.position(match[1], job))
        elif _OUTPUT.fullmatch(instruction):
            self.arm.steps.append(ReadSwitch(*_assigned(instruction)))
        elif match := re.fullmatch(rf"TIMER T={_N}", instruction):
            self.arm.wait(float(match[1]), LONGEST_WAIT_S)
        elif _AGAIN.fullmatch(instruction):
            self.arm.steps.append(ReadEndRepeat())
        elif match := re.fullmatch(r"CALL JOB:(\w+)", instruction):
            if match[1] in self.jobs:
                self.run(match[1])
            else:
                self.arm.steps.append(ReadCall(match[1]))
        else:
            raise ProgramError(f"unknown instruction {instruction!r}.")

    def position(self, name: str, job: _Job) -> Pose:
        """Look up a position, and use its frames."""
        if name not in job.positions:
            raise ProgramError(f"{name} has no position.")
        _, tool, pose = job.positions[name]  # the user frame is the job's, and in the controller's table
        self.arm.tool, self.arm.board = ReadTool(tool, None), ReadBoard(None)
        return pose

    def move(self, match: re.Match[str], job: _Job, after: str) -> None:
        """Move in a line; the output that goes ahead is the instruction after it."""
        name, unit, speed, level, ahead = match.groups()
        pose = self.position(name, job)
        signals = () if ahead is None else (ReadSignal(*_assigned(after), 1.0, -float(ahead)),)
        self.arm.line(pose, level == "PL=0", float(speed) if unit == "V" else 0.0, signals)


def _assigned(instruction: str) -> tuple[str, float]:
    """Channel and value of an output."""
    match = _OUTPUT.fullmatch(instruction)
    if match is None:
        raise ProgramError(f"{instruction!r} is no output.")
    digital, analog, number, word, value = match.groups()
    return f"{_KINDS[digital or analog]} {number}", float(value) if value is not None else float(word == "ON")


def _repeat(instructions: list[str]) -> ReadRepeat:
    """Find how a loop ends: the jump back to its label."""
    for instruction in instructions:
        if (match := _AGAIN.fullmatch(instruction)) and f"*{match[1]}" == instructions[0]:
            return ReadRepeat(int(match[2]), None)
    raise ProgramError(f"nothing jumps to {instructions[0]}.")


def read(files: Mapping[str, str]) -> Rebuilt:
    """Rebuild what the jobs do; the first file is the main one.

    Raises:
        ProgramError: something is written that ``yaskawa`` does not write.
    """
    controller = _Controller()
    for file, text in files.items():
        if file.endswith(".JBI"):
            name = file.removesuffix(".JBI")
            controller.jobs[name] = _load(name, text)
    controller.run(next(iter(controller.jobs)))
    return Rebuilt(tuple(controller.arm.steps), ANALOG)


def _load(name: str, text: str) -> _Job:
    head, found, body = text.partition("\nNOP\n")
    points, also, attributes = head.partition("//INST\n")
    begin = f"/JOB\n//NAME {name}\n//POS\n"
    if not (found and also and points.startswith(begin) and body.endswith("END\n")):
        raise ProgramError(f"{name} is no job.")
    positions = _positions(points.removeprefix(begin).splitlines())
    frames = {frame for frame, _, _ in positions.values()}
    relative = f"///ATTR SC,RW,RJ\n////FRAME USER {next(iter(frames), '')}\n"
    if len(frames) > 1 or (frames and relative not in attributes):
        raise ProgramError(f"{name}: a relative job has one user frame, and names it.")
    return _Job(body.splitlines()[:-1], positions)


def _positions(lines: list[str]) -> dict[str, tuple[str, str, Pose]]:
    """Read positions under their headings."""
    held = {"USER": "", "TOOL": ""}
    positions: dict[str, tuple[str, str, Pose]] = {}
    count = ""
    for line in lines:
        if match := _POINT.fullmatch(line):
            x, y, z, rx, ry, rz = map(float, match.groups()[1:])
            positions[match[1]] = (held["USER"], held["TOOL"], Pose((x, y, z), from_fixed_xyz(rx, ry, rz)))
        elif match := re.fullmatch(r"///(USER|TOOL) (\d+)", line):
            held[match[1]] = match[2]
        elif match := re.fullmatch(r"///NPOS (\d+),0,0,0,0,0", line):
            count = match[1]
        elif line not in ("///POSTYPE USER", "///RECTAN") and not _CONFIGURATION.fullmatch(line):
            raise ProgramError(f"unknown line {line!r}.")
    if count != str(len(positions)):
        raise ProgramError(f"NPOS says {count} positions, there are {len(positions)}.")
    return positions
