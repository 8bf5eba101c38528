"""Reads the KRL that ``kuka`` writes, as a controller would execute it."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from programs.errors import ProgramError
from programs.pose import Pose
from programs.posts.kuka.text import ANALOG
from programs.posts.reading.rebuilt import (
    ReadBoard,
    ReadCall,
    ReadEndRepeat,
    ReadPause,
    ReadRepeat,
    ReadSignal,
    ReadSwitch,
    ReadTool,
    Rebuilt,
)
from programs.posts.reading.scanner import Arm, read_repeat
from programs.posts.writing.angles import from_fixed_xyz

_N = r"(-?\d+(?:\.\d+)?)"
_FRAME = re.compile(rf"\{{X {_N},Y {_N},Z {_N},A {_N},B {_N},C {_N}\}}")
_AXES = re.compile(rf"\{{A1 {_N}(?:,[AE]\d {_N})*\}}")
_LOAD = re.compile(rf"\{{M {_N},CM {_FRAME.pattern},J \{{X {_N},Y {_N},Z {_N}\}}\}}")
_SHAPES = {"FRAME": _FRAME, "E6AXIS": _AXES, "LOAD": _LOAD, "INT": re.compile("0")}
_DECLARATION = re.compile(r"DECL (?:GLOBAL )?(FRAME|E6AXIS|LOAD|INT) (\w+)=(.*)")
_ASSIGNMENT = r"(?:\$(OUT|ANOUT)\[(\d+)\]|([A-Za-z]\w*))=(TRUE|FALSE|-?\d+(?:\.\d+)?)"
_OUTPUT = re.compile(_ASSIGNMENT)
_TRIGGER = re.compile(rf"TRIGGER WHEN (?:PATH={_N}|DISTANCE=1) DELAY=(-?\d+) DO {_ASSIGNMENT}")
_SETTING = re.compile(rf"\$(VEL\.CP|VEL\.ORI1|VEL\.ORI2|APO\.CDIS)={_N}")
_UNTIL = re.compile(
    rf"UNTIL (?:nLoop\d+>=(\d+)|\(nLoop\d+>=(\d+)\) OR \(\(?{_N}\)?\*\$ANIN\[\d+\]\+\(?{_N}\)?>=\(?{_N}\)?\))"
)
_PREPARES = re.compile(
    r"&.*|BAS\(#INITMOV,0\)|BAS\(#VEL_PTP,\d+\)|\$ORI_TYPE=#VAR|PTP (?:HOME_POSITION|\$AXIS_ACT)"
    r"|\$LOAD=\w+|nLoop\d+=0|nLoop(\d+)=nLoop\1\+1"
)
_DIGITAL = {"TRUE": 1.0, "FALSE": 0.0}


@dataclass(slots=True)
class _Controller:
    """Declarations and routines of all modules, and the state of the robot."""

    data: dict[str, dict[str, tuple[str, str]]] = field(default_factory=dict[str, dict[str, tuple[str, str]]])
    """Type and value by name, by module."""
    routines: dict[str, tuple[str, list[str]]] = field(default_factory=dict[str, tuple[str, list[str]]])
    """Module and statements by name."""
    arm: Arm = field(default_factory=Arm)
    settings: dict[str, float] = field(default_factory=dict[str, float])
    triggers: list[tuple[float, float, str, float]] = field(default_factory=list[tuple[float, float, str, float]])
    """Place in mm from the end, seconds, channel and value: for the next motion."""

    def frame(self, name: str, module: str) -> Pose:
        """Give a declared frame: of the module, or a global one."""
        for names in (self.data.get(module, {}), *self.data.values()):
            kind, value = names.get(name, ("", ""))
            if kind == "FRAME" and (match := _FRAME.fullmatch(value)):
                x, y, z, a, b, c = map(float, match.groups())
                return Pose((x, y, z), from_fixed_xyz(c, b, a))
        raise ProgramError(f"{name} is not declared as FRAME.")

    def run(self, name: str) -> None:
        """Execute a routine."""
        module, statements = self.routines[name]
        for at, statement in enumerate(statements):
            if statement == "REPEAT":
                self.arm.steps.append(_repeat(statements[at:]))
            elif statement.startswith("UNTIL "):
                self.arm.steps.append(ReadEndRepeat())
            else:
                self.execute(statement, module)

    def execute(self, statement: str, module: str) -> None:
        """Execute one statement."""
        word, _, rest = statement.partition(" ")
        if _PREPARES.fullmatch(statement):
            return
        if word == "LIN" or (word == "PTP" and not rest.startswith("{")):
            self.move(word, rest, module)
        elif word == "PTP" and _AXES.fullmatch(rest):
            self.arm.jointed = True
        elif match := _TRIGGER.fullmatch(statement):
            place, delay, *assigned = match.groups()
            self.triggers.append((float(place or 0.0), float(delay) / 1000.0, *_assigned(assigned)))
        elif match := _SETTING.fullmatch(statement):
            self.settings[match[1]] = float(match[2])
        elif statement.startswith("WAIT SEC "):
            self.arm.steps.append(ReadPause(float(statement[9:])))
        elif match := re.fullmatch(r"\$TOOL=(\w+)", statement):
            self.arm.tool = ReadTool(match[1], self.frame(match[1], module))
        elif match := re.fullmatch(r"\$BASE=\$ROBROOT:(\w+)", statement):
            self.arm.board = ReadBoard(self.frame(match[1], module))
        elif match := _OUTPUT.fullmatch(statement):
            self.arm.steps.append(ReadSwitch(*_assigned(list(match.groups()))))
        else:
            self.call(statement)

    def call(self, statement: str) -> None:
        """Call a routine: one of the program's, or one that the integrator has."""
        match = re.fullmatch(r"([A-Za-z]\w*)\( \)", statement)
        if match is None:
            raise ProgramError(f"unknown statement {statement!r}.")
        if match[1] in self.routines:
            self.run(match[1])
        else:
            self.arm.steps.append(ReadCall(match[1]))

    def move(self, word: str, rest: str, module: str) -> None:
        """Move in a line, or by joints; the triggers before it are this motion's."""
        name, _, passing = rest.partition(" ")
        if passing not in ("", "C_DIS"):
            raise ProgramError(f"unknown statement {word} {rest!r}.")
        pose = self.frame(name, module)
        if word == "PTP":
            self.arm.reach(pose)
            return
        length_mm = self.arm.length_to(pose) if self.arm.pose is not None else 0.0
        speed_mm_s = 1000.0 * self.settings.get("VEL.CP", 0.0) if length_mm else 0.0
        signals = tuple(
            ReadSignal(channel, value, 1.0 + place / length_mm if length_mm else 1.0, seconds)
            for place, seconds, channel, value in self.triggers
        )
        self.triggers = []
        self.arm.line(pose, not passing, speed_mm_s, signals)


def _assigned(words: list[str | None]) -> tuple[str, float]:
    """Channel and value of an assignment."""
    kind, number, name, text = words
    value = _DIGITAL[text] if text in _DIGITAL else float(text or 0.0)
    return name or f"{'digital' if kind == 'OUT' else 'analog'} {number}", value


def _repeat(statements: list[str]) -> ReadRepeat:
    """Find how a loop ends, past those in it."""
    depth = 0
    for statement in statements:
        depth += (statement == "REPEAT") - statement.startswith("UNTIL ")
        if depth == 0 and (match := _UNTIL.fullmatch(statement)):
            alone, count, *condition = match.groups()
            return read_repeat(alone or count, condition)
    raise ProgramError("a REPEAT has no UNTIL.")


def read(files: Mapping[str, str]) -> Rebuilt:
    """Rebuild what the modules do; the first file's first routine is the main one.

    Raises:
        ProgramError: a data list is missing, or something is written that ``kuka`` does not write.
    """
    controller = _Controller()
    for file, text in files.items():
        module, _, kind = file.rpartition(".")
        if f"{module}.{'dat' if kind == 'src' else 'src'}" not in files:
            raise ProgramError("a .src and a .dat belong together.", file=file)
        lines = [line.partition(";")[0].strip() for line in text.splitlines()]
        _load(controller, module, [line for line in lines if line])
    controller.run(next(iter(controller.routines)))
    return Rebuilt(tuple(controller.arm.steps), ANALOG)


def _load(controller: _Controller, module: str, lines: list[str]) -> None:
    routine: list[str] | None = None
    names = controller.data.setdefault(module, {})
    for line in lines:
        if match := _DECLARATION.fullmatch(line):
            kind, name, value = match.groups()
            if not _SHAPES[kind].fullmatch(value):
                raise ProgramError(f"{value} is no {kind}.")
            names[name] = (kind, value)
        elif match := re.fullmatch(r"DEF (\w+)\( \)", line):
            routine = []
            controller.routines[match[1]] = (module, routine)
        elif line == "END":
            routine = None
        elif routine is not None:
            routine.append(line)
        elif not line.startswith("&") and line not in (f"DEFDAT {module} PUBLIC", "ENDDAT"):
            raise ProgramError(f"unknown statement {line!r}.")
