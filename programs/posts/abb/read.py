"""Reads the RAPID that ``abb`` writes, as a controller would execute it."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from programs.errors import ProgramError
from programs.pose import Pose, distance
from programs.posts.reading.rebuilt import (
    ReadBoard,
    ReadCall,
    ReadEndRepeat,
    ReadLine,
    ReadPause,
    ReadReach,
    ReadSignal,
    ReadStep,
    ReadSwitch,
    ReadTool,
    Rebuilt,
)
from programs.posts.reading.scanner import read_repeat

_DATA = re.compile(r"(?:LOCAL )?(?:CONST|PERS|VAR) (\w+) (\w+)(?::=(.*))?;")
_MOVE = re.compile(r"(MoveL|MoveJ|TriggL) (\w+),(\w+)((?:,ev\d+)?(?:\\T\d:=ev\d+)*),(\w+),(\w+)\\WObj:=(\w+);")
_OUTPUT = r"\\[DGA]Op:=(\w+),([\d.-]+);"
_EQUIPMENT = re.compile(rf"TriggEquip (\w+),([\d.-]+)(\\Start)?,([\d.-]+){_OUTPUT}")
_TIMED = re.compile(rf"TriggIO (\w+),([\d.-]+)\\Time{_OUTPUT}")
_SETTER = re.compile(r"Set[DGA]O (\w+),([\d.-]+);")
_LOOP = re.compile(r"WHILE (\w+)<(\d+)(?: AND \(\1=0 OR ([\d.-]+)\*AInput\(\w+\)\+([\d.-]+)<([\d.-]+)\))? DO")
_IGNORED = re.compile(r"(ConfJ\\Off|ConfL\\Off|nLoop\d+:=.*);")
_NUMBER = re.compile(r"-?[\d.]+(?:E\d+)?")
_POSE = "[[0,0,0],[0,0,0,0]]"
_SHAPES = {
    "robtarget": "[[0,0,0],[0,0,0,0],[0,0,0,0],[0,0,0,0,0,0]]",
    "jointtarget": "[[0,0,0,0,0,0],[0,0,0,0,0,0]]",
    "tooldata": f"[TRUE,{_POSE},[0,[0,0,0],[0,0,0,0],0,0,0]]",
    "wobjdata": f'[FALSE,TRUE,"",{_POSE},{_POSE}]',
    "speeddata": "[0,0,0,0]",
    "triggdata": "",
    "num": "0",
}
"""How the values of each type are nested, every number as 0."""


@dataclass(frozen=True, slots=True)
class _Trigger:
    """A trigger as its definition says it."""

    offset_mm: float
    from_start: bool
    lead_s: float
    channel: str
    value: float


@dataclass(slots=True)
class _Machine:
    """Data and routines of all modules, and the state of the robot."""

    data: dict[str, tuple[str, str]] = field(default_factory=dict[str, tuple[str, str]])
    routines: dict[str, list[str]] = field(default_factory=dict[str, list[str]])
    triggers: dict[str, _Trigger] = field(default_factory=dict[str, _Trigger])
    steps: list[ReadStep] = field(default_factory=list[ReadStep])
    pose: Pose | None = None
    tool: str = ""
    board: str = ""
    jointed: bool = False
    """Whether the last motion was MoveAbsJ."""

    def numbers(self, name: str, kind: str) -> list[float]:
        """Give the numbers of a declared value."""
        found = self.data.get(name)
        if found is None or found[0] != kind:
            raise ProgramError(f"{name} is not declared as {kind}.")
        return [float(word) for word in _NUMBER.findall(found[1])]

    def pose_of(self, name: str, kind: str) -> Pose:
        """Give the pose that a target, tool or work object begins with."""
        x, y, z, a, b, c, d = self.numbers(name, kind)[:7]
        return Pose((x, y, z), (a, b, c, d))

    def run(self, routine: str) -> None:
        """Execute a routine."""
        for statement in self.routines[routine]:
            self.execute(statement)

    def execute(self, statement: str) -> None:
        """Execute one statement."""
        if match := _MOVE.fullmatch(statement):
            self.move(match)
        elif statement.startswith("MoveAbsJ "):
            self.jointed = True
        elif match := _EQUIPMENT.fullmatch(statement):
            name, offset, start, lead, channel, value = match.groups()
            self.triggers[name] = _Trigger(float(offset), start is not None, float(lead), channel, float(value))
        elif match := _TIMED.fullmatch(statement):
            name, lead, channel, value = match.groups()
            self.triggers[name] = _Trigger(0.0, False, float(lead), channel, float(value))
        elif match := _SETTER.fullmatch(statement):
            self.steps.append(ReadSwitch(match[1], float(match[2])))
        elif match := _LOOP.fullmatch(statement):
            self.steps.append(read_repeat(match[2], match.groups()[2:]))
        elif statement == "ENDWHILE":
            self.steps.append(ReadEndRepeat())
        elif statement.startswith("WaitTime "):
            self.steps.append(ReadPause(float(statement[9:-1])))
        elif not _IGNORED.fullmatch(statement):
            self.call(statement)

    def call(self, statement: str) -> None:
        """Call a routine: one of the program's, or one that the integrator has."""
        name = statement.removesuffix(";")
        if not re.fullmatch(r"[A-Za-z]\w*", name):
            raise ProgramError(f"unknown statement {statement!r}.")
        if name in self.routines:
            self.run(name)
        else:
            self.steps.append(ReadCall(name))

    def move(self, match: re.Match[str]) -> None:
        """Move in a line, or by joints."""
        kind, target, speed, triggers, zone, tool, board = match.groups()
        if (tool, board) != (self.tool, self.board):
            self.tool, self.board = tool, board
            mounted = self.data[tool][1].split("]],")[0]
            x, y, z, a, b, c, d = (float(word) for word in _NUMBER.findall(mounted))
            self.steps.append(ReadTool(tool, Pose((x, y, z), (a, b, c, d))))
            self.steps.append(ReadBoard(self.pose_of(board, "wobjdata")))
        pose = self.pose_of(target, "robtarget")
        if kind == "MoveJ" or self.jointed or self.pose is None:
            self.steps.append(ReadReach(pose))
        else:
            turns = distance(self.pose, pose) <= 5e-4
            speed_mm_s = 0.0 if turns else self.numbers(speed, "speeddata")[0]
            length_mm = distance(self.pose, pose)
            signals = tuple(self.signal(name, length_mm) for name in re.findall(r"ev\d+", triggers))
            self.steps.append(ReadLine(pose, zone == "fine", speed_mm_s, signals))
        self.pose, self.jointed = pose, False

    def signal(self, name: str, length_mm: float) -> ReadSignal:
        """Place a trigger on a line."""
        trigger = self.triggers[name]
        done = trigger.offset_mm / length_mm if length_mm > 5e-4 else 0.0
        share = done if trigger.from_start else 1.0 - done
        return ReadSignal(trigger.channel, trigger.value, share, -trigger.lead_s)


def read(files: Mapping[str, str]) -> Rebuilt:
    """Rebuild what the modules do.

    Raises:
        ProgramError: a module is missing, or something is written that ``abb`` does not write.
    """
    machine = _Machine()
    modules = {name: text for name, text in files.items() if name.endswith(".mod")}
    for name, text in files.items():
        if name.endswith(".pgf") and re.findall(r"<Module>(.*)</Module>", text) != list(modules):
            raise ProgramError("the .pgf does not list the modules.", file=name)
    for text in modules.values():
        _load(machine, text)
    machine.run("main")
    return Rebuilt(tuple(machine.steps))


def _load(machine: _Machine, text: str) -> None:
    routine: list[str] | None = None
    for line in text.splitlines():
        statement = line.strip()
        if not statement or statement.startswith(("!", "MODULE ", "ENDMODULE")):
            continue
        if statement.startswith("PROC "):
            routine = machine.routines.setdefault(statement[5:-2], [])
        elif statement == "ENDPROC":
            routine = None
        elif routine is not None:
            routine.append(statement)
        elif match := _DATA.fullmatch(statement):
            if _NUMBER.sub("0", match[3] or "") != _SHAPES.get(match[1]):
                raise ProgramError(f"{match[3]} is no {match[1]}.")
            machine.data[match[2]] = (match[1], match[3] or "")
        else:
            raise ProgramError(f"unknown statement {statement!r}.")
