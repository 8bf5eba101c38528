"""Reads the VAL3 project that ``val3`` writes, as a controller would execute it."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from xml.etree import ElementTree

from programs.errors import ProgramError
from programs.pose import Pose
from programs.posts.reading.rebuilt import (
    ReadBoard,
    ReadCall,
    ReadEndRepeat,
    ReadLine,
    ReadPause,
    ReadSwitch,
    ReadTool,
    Rebuilt,
)
from programs.posts.reading.scanner import Arm, read_repeat
from programs.posts.val3.text import OUTPUTS, TRIGGER, WATCH
from programs.posts.writing.angles import from_moving_xyz

_NUMBER = r"-?\d+(?:\.\d+)?"
_MOVE = re.compile(r"(nId=)?(movel|movej)\((\w+)(?:\[(\d+)\])?,(\w+),(\w+)\)")
_TRIGGER = re.compile(rf"call trigger\(nId,(\d+),({_NUMBER})\)")
_SWITCH = re.compile(rf"(?:(do\d+)=(true|false)|(?:dioSet|aioSet)\(([ga]o\d+),({_NUMBER})\))")
_DELAY = re.compile(rf"delay\(({_NUMBER})\)")
_CALL = re.compile(r"call (\w+)\(\)")
_UNTIL = re.compile(rf"until (nLoop\d+)>=(\d+)(?: or ({_NUMBER})\*aioGet\(ai\d+\)\+({_NUMBER})>=({_NUMBER}))?")
_SETTER = re.compile(r"if x_nOutput==(\d+)\s+(?:(do\d+)=x_nValue!=0|(?:dioSet|aioSet)\(([ga]o\d+),x_nValue\))\s+endIf")
_IGNORED = re.compile(
    r"nHead=0|nTail=0|nLoop(\d+)=(?:0|nLoop\1\+1)|do|taskCreateSync \"watch\",0\.004,bOverrun,watch\(\)|"
    r"taskKill\(\"watch\"\)"
)
_KINDS = {prefix: kind for kind, prefix in OUTPUTS.items()}


@dataclass(slots=True)
class _Controller:
    """Data and programs of a project, and the arm."""

    data: dict[str, list[dict[str, str]]] = field(default_factory=dict[str, list[dict[str, str]]])
    programs: dict[str, list[str]] = field(default_factory=dict[str, list[str]])
    outputs: dict[str, str] = field(default_factory=dict[str, str])
    """Variable, by the number that the task knows it by."""
    arm: Arm = field(default_factory=Arm)
    waits: bool = True
    """Whether the program has waited for the moves."""

    def run(self, name: str) -> None:
        """Execute a program, each loop once."""
        lines = self.programs[name]
        for at, line in enumerate(lines):
            if line == "do":
                counter = lines[at + 1].split("=")[0]
                ends = (found for rest in lines[at:] if (found := _UNTIL.fullmatch(rest)))
                end = next((found for found in ends if found[1] == counter), None)
                if end is None:
                    raise ProgramError("a do has no until.")
                self.arm.steps.append(read_repeat(end[2], end.groups()[2:]))
            self.execute(line)

    def execute(self, line: str) -> None:
        """Execute one statement."""
        if match := _MOVE.fullmatch(line):
            self.move(match)
        elif match := _TRIGGER.fullmatch(line):
            self.trigger(match[1], float(match[2]))
        elif line == "waitEndMove()":
            self.waits = True
        elif match := _CALL.fullmatch(line):
            if match[1] in self.programs:
                self.run(match[1])
            else:
                self.stand(line)
                self.arm.steps.append(ReadCall(match[1]))
        elif match := _DELAY.fullmatch(line):
            self.stand(line)
            self.arm.steps.append(ReadPause(float(match[1])))
        elif match := _SWITCH.fullmatch(line):
            self.stand(line)
            digital, bit, other, value = match.groups()
            self.arm.steps.append(_switch(digital or other, float(bit == "true") if digital else float(value)))
        elif _UNTIL.fullmatch(line):
            self.arm.steps.append(ReadEndRepeat())
        elif not _IGNORED.fullmatch(line):
            raise ProgramError(f"unknown statement {line!r}.")

    def stand(self, line: str) -> None:
        """Make sure that the program has waited for the moves: it runs ahead of them."""
        if not self.waits:
            raise ProgramError(f"{line!r} is done before the robot stands.")

    def move(self, match: re.Match[str]) -> None:
        """Move in a line, or by joints."""
        _, word, name, key, tool, movement = match.groups()
        self.waits = False
        target = self.value(name, int(key or 0))
        if "j1" in target:
            self.arm.jointed = name != "jHome"
            return
        father = target["fatherId"].removesuffix("[0]")
        self.arm.tool = ReadTool(tool, _pose(self.value(tool)))
        self.arm.board = ReadBoard(_pose(self.value(father)))
        if word == "movej":
            self.arm.reach(_pose(target))
            return
        said = self.value(movement)
        turns = not self.arm.jointed and self.arm.length_to(_pose(target)) == 0.0
        self.arm.line(_pose(target), said["blend"] == "off", 0.0 if turns else float(said["tmax"]))

    def trigger(self, number: str, value: float) -> None:
        """Set an output with the move that was just given."""
        if not self.arm.steps or not isinstance(self.arm.steps[-1], ReadLine):
            raise ProgramError("a trigger does not follow a line.")
        if number not in self.outputs:
            raise ProgramError(f"the task has no output {number}.")
        self.arm.steps.insert(-1, _switch(self.outputs[number], value))

    def value(self, name: str, key: int = 0) -> dict[str, str]:
        """Look up a value of the data file."""
        if name not in self.data or key >= len(self.data[name]):
            raise ProgramError(f"{name}[{key}] is not in the data file.")
        return self.data[name][key]


def read(files: Mapping[str, str]) -> Rebuilt:
    """Rebuild what the project does.

    Raises:
        ProgramError: a file is missing, or something is written that ``val3`` does not write.
    """
    controller = _Controller()
    try:
        trees = {name: ElementTree.fromstring(text) for name, text in files.items()}
    except ElementTree.ParseError as error:
        raise ProgramError(f"the project is no XML: {error}.") from None
    listed = [element.attrib["file"] for tree in trees.values() for element in tree.iter() if "file" in element.attrib]
    if sorted(listed) != sorted(list(files)[1:]):
        raise ProgramError("the project file does not list the files.")
    for tree in trees.values():
        _load(controller, tree)
    fixed = {"watch": WATCH, "trigger": TRIGGER}
    if any(controller.programs.get(name) != [line.strip() for line in body] for name, body in fixed.items()):
        raise ProgramError("the task that sets outputs is not as it should be.")
    for number, digital, other in _SETTER.findall(" ".join(controller.programs.get("setOutput", []))):
        controller.outputs[number] = digital or other
    if "start" not in controller.programs:
        raise ProgramError("there is no program start.")
    controller.run("start")
    return Rebuilt(tuple(controller.arm.steps))


def _load(controller: _Controller, tree: ElementTree.Element) -> None:
    for element in tree.iter():
        tag = element.tag.rpartition("}")[2]
        if tag == "Data" and "name" in element.attrib:
            values = [dict(value.attrib) for value in element]
            if any(value["key"] != str(key) for key, value in enumerate(values)):
                raise ProgramError(f"the values of {element.attrib['name']} are not in order.")
            controller.data[element.attrib["name"]] = values
        elif tag == "Program" and "name" in element.attrib:
            text = "".join(element.itertext()).strip().removeprefix("begin").removesuffix("end")
            lines = [line.strip() for line in text.splitlines()]
            kept = [line for line in lines if line and not line.startswith("//")]
            controller.programs[element.attrib["name"]] = kept


def _pose(value: dict[str, str]) -> Pose:
    x, y, z, rx, ry, rz = (float(value[name]) for name in ("x", "y", "z", "rx", "ry", "rz"))
    return Pose((x, y, z), from_moving_xyz(rx, ry, rz))


def _switch(variable: str, value: float) -> ReadSwitch:
    return ReadSwitch(f"{_KINDS[variable[:2]]} {variable[2:]}", value)
