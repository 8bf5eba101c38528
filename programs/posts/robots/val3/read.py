"""Reads a VAL3 project back, as a controller would execute it, and describes the language."""

import re
from collections.abc import Iterator, Mapping
from typing import ClassVar
from xml.etree import ElementTree

from programs.errors import ProgramError
from programs.motion.lower import Capability
from programs.motion.steps import Line
from programs.pose import Pose
from programs.posts.dialect import Dialect, FileForm, ProgramFiles
from programs.posts.layout import Layout
from programs.posts.reading.driver import Reader, read_pose
from programs.posts.reading.execution import (
    Block,
    Statement,
    Values,
    differing,
    located,
    look_up,
    skip,
    statements_of,
)
from programs.posts.rebuilt import Due, ReadLine, ReadSwitch, TextPlace
from programs.posts.robots.val3.project import OUTPUTS, PATH_OUTPUTS, PERIOD_S, TRIGGER
from programs.posts.robots.val3.write import FASTEST, SAME_ARM, STOP, Val3
from programs.posts.writing.angles import from_moving_xyz
from programs.posts.writing.chapters import degrees_per_s
from programs.timing.controller import Controller

_SETTER = re.compile(r"if x_nOutput==(\d+)\s+(?:(do\d+)=x_nValue!=0|(?:dioSet|aioSet)\(([ga]o\d+),x_nValue\))\s+endIf")
_VARIABLES = {"nMove", "nHead", "nTail", "nId", "nKey", "nStart", "bOverrun"}
"""That every project has."""
_KINDS = {prefix: kind for kind, prefix in OUTPUTS.items()}


class Val3Reader(Reader):
    """Data and programs of a project, and the moves that the program runs ahead of."""

    syntax = Val3
    shut_name = "shutValves"
    handlers = frozenset({"main", "stop", "isPowered()==false"})
    texts: ClassVar[Mapping[str, str]] = {
        **{"verb": "movel|movej", "point": r"\w+(?:\[\d+\])?", "movement": r"\w+"},
        **{"guard": "guard", "task": "pathOutputs"},
    }

    def __init__(self) -> None:
        super().__init__()
        self.values = self.declares("value")
        """Attributes by variable and key."""
        self.types: dict[str, str] = {}
        """Type by variable."""
        self.lines: dict[str, Statement] = {}
        """Where each is declared."""
        self.counted_move = False
        """Whether the number of the last move was kept."""
        self.outputs: dict[str, str] = {}
        """Variable, by the number that the task knows it by."""
        self.stands = True
        """Whether the program has waited for the moves."""

    @classmethod
    def due(cls, line: Line, after: Line | None) -> Due:
        """Give the zone, and the rate of a turn on the spot; other turns keep up with the orifice."""
        return Due(line.blend_mm, degrees_per_s(line) if line.turns_on_the_spot else FASTEST)

    def load(self, files: ProgramFiles) -> str:
        """Read data and programs; the project file lists the others, and the task is as it is written."""
        trees: dict[str, ElementTree.Element] = {}
        for file, text in files.items():
            try:
                trees[file] = ElementTree.fromstring(text)
            except ElementTree.ParseError as error:
                raise ProgramError(f"this is no XML: {error}.", file=file, line=error.position[0]) from None
        elements = [(file, element) for file, tree in trees.items() for element in tree.iter()]
        listed = [element.attrib["file"] for _, element in elements if "file" in element.attrib]
        if sorted(listed) != sorted(list(files)[1:]):
            raise ProgramError("the project file does not list the files.")
        for file, element in ((file, each) for file, each in elements if "name" in each.attrib):
            name, tag = element.attrib["name"], element.tag.rpartition("}")[2]
            if tag == "Data":
                at = files[file].rfind(f'"{name}"')  # of two the second
                self.load_data(name, element, Statement(name, TextPlace(file, files[file].count("\n", 0, at) + 1)))
            elif tag == "Program":
                text = "".join(element.itertext()).strip().removeprefix("begin").removesuffix("end")
                self.routines[name] = list(_statements(files, name, text))
        for name, body in (("pathOutputs", PATH_OUTPUTS), ("trigger", TRIGGER)):
            found, due = self.routines.get(name, []), [line.strip() for line in body]
            if found != due:
                raise located("the task that sets outputs is not as it is written.", differing(found, due))
        for number, digital, other in _SETTER.findall(" ".join(self.routines.get("setOutput", []))):
            self.outputs[number] = digital or other
        self.called |= {"pathOutputs", "trigger", "setOutput", "stop", "guard"}
        self.check_variables()
        return "start"

    def load_data(self, name: str, element: ElementTree.Element, line: Statement) -> None:
        """Read a variable; an array states its size."""
        keys = [value.attrib["key"] for value in element]
        size = element.attrib["size"]
        if name in self.types or keys != [str(key) for key in range(len(keys))] or (keys and size != str(len(keys))):
            raise located(f"{name} is there twice, or its values are not in order, or not so many.", line)
        self.types[name], self.lines[name] = element.attrib["type"], line
        for key, value in enumerate(element):
            self.values.add((name, key), dict(value.attrib), line)
            if name == "nStart":  # of the production frame
                self.values.used.add((name, key))
            if self.types[name] == "mdesc" and not (
                value.attrib["accel"] == value.attrib["decel"] == "100"
                and value.attrib["leave"] == value.attrib["reach"]
                and value.attrib["blend"] in ("off", "cartesian")
            ):
                raise located(f"{name} has an acceleration or a speed that is not 100 %, or blends unevenly.", line)

    def check_variables(self) -> None:
        """Make sure that outputs, inputs and counters are declared, of their type, and used."""
        text = " ".join(line for lines in self.routines.values() for line in lines)
        for name in set(re.findall(r"\b(?:do|go|ao|di|ai|nLoop)\d+\b", text)) | _VARIABLES:
            kind = {"d": "dio", "g": "dio", "a": "aio", "n": "num", "b": "bool"}[name[0]]
            if self.types.get(name) != kind:
                raise located(f"variable {name} is not declared as {kind}.", self.lines.get(name, name))
        for name in (name for name in self.types if re.fullmatch(r"(?:do|go|ao|di|ai|nLoop)\d+", name)):
            if not re.search(rf"\b{name}\b", text):
                raise located(f"variable {name} is declared and never used.", self.lines[name])

    def blocks(self) -> Iterator[Block]:
        """List the statements of forms."""
        yield [Val3.move], self.move
        yield [Val3.trigger_form], self.trigger
        yield [Val3.rest_form], self.wait
        yield list(Val3.last), self.read_stop
        yield [Val3.guard_form], self.read_guard
        yield [Val3.end_form], lambda values: self.suspended.add("guard")
        yield from (([form], skip) for form in Val3.begin)
        yield from super().blocks()

    def use_first_tool(self, name: str) -> None:
        """Use the tool whose orifice is raised."""
        if self.types.get("pStart") != "pointRx" or self.types.get(name) != "tool":
            raise ProgramError("pStart is no point, or is seen for no tool.")
        self.value("pStart")

    def read_stop(self, values: Values) -> None:
        """Read what the application does when it stops."""
        if self.routines.get("stop") != list(STOP):
            raise ProgramError("stop is not as it is written.")
        self.shut_by.add("stop")

    def read_guard(self, values: Values) -> None:
        """Read the task that shuts the valves: without arm power, or without an input."""
        begin, *inside, waits, end = self.routines.get("guard") or ["", "", ""]
        if (begin, waits, end) != ("while true", "delay(0.01)", "endWhile") or len(inside) % 4:
            raise ProgramError("the task guard is not as it is written.")
        for at in range(0, len(inside), 4):
            found = re.fullmatch(r"if (isPowered\(\)==false|di(\d+)!=(true|false))", inside[at])
            if found is None or inside[at + 1 : at + 4] != ["stopMove()", "call shutValves()", "endIf"]:
                raise ProgramError("the task guard is not as it is written.")
            if found[2]:
                self.begin_watch(found[2], found[3] == "true")
            self.shut_by.add(found[1])
        self.suspended.clear()

    def stand(self, what: str) -> None:
        """Make sure that the program has waited for the moves: it runs ahead of them."""
        if not self.stands:
            raise ProgramError(f"{what!r} is done before the robot stands.")

    def wait(self, values: Values) -> None:
        """Wait for the moves."""
        self.stands = True

    def call(self, name: str) -> None:
        """Call a program; the integrator's when the robot stands."""
        if name not in self.routines:
            self.stand(name)
        super().call(name)

    def pause(self, values: Values) -> None:
        """Hold the pose when the robot stands."""
        self.stand("delay")
        super().pause(values)

    def switch(self, channel: str, value: float) -> None:
        """Set an output, by its variable, when the robot stands."""
        self.stand(channel)
        super().switch(channel, value)

    def move(self, values: Values) -> None:
        """Move in a line, or by joints."""
        word, tool, movement = values["verb"], values["tool"], values["movement"]
        name, _, key = values["point"].partition("[")
        self.stands, self.counted_move = False, "kept" in values
        target, speeds = self.value(name, int(key.rstrip("]") or 0)), self.value(movement)
        if self.types[movement] != "mdesc" or (tool != "flange" and self.types.get(tool) != "tool"):
            raise ProgramError(f"{tool} is no tool, or {movement} no movement.")
        if self.types[name] == "jointRx":
            if word == "movel" or speeds["blend"] != "off":
                raise ProgramError(f"the motion to {name} does not come to joint values as it should.")
            self.set_share(speeds["vel"])
            come = self.come_home if name == "jHome" else self.come_to
            come(float(value) for key, value in target.items() if key.startswith("j"))
            return
        if self.types[name] != "pointRx" or not target.items() >= SAME_ARM.items():
            raise ProgramError(f"{name} is no point that keeps the arm's configuration.")
        full = speeds["vel"] == "100"  # of the joints' speeds, which lines have to leave to their own speed
        if (word == "movej" or bool(self.counted)) != (movement == "mReach") or full == (movement == "mReach"):
            raise ProgramError(f"the motion to {name} has the speed of another kind of motion.")
        pose = _pose(target)
        self.use_tool(tool, _pose(self.value(tool)))
        self.use_board(_pose(self.value(target["fatherId"].removesuffix("[0]"))))
        if word == "movej":
            self.reach(pose)
            return
        turns = self.pose is not None and not self.length_to(pose)
        self.state(zone=float(speeds["leave"]), turn_deg_s=float(speeds["rmax"]))
        self.line(pose, speeds["blend"] == "off", 0.0 if turns else float(speeds["tmax"]))

    def trigger(self, values: Values) -> None:
        """Set an output with the move that was just given."""
        if not self.steps or not isinstance(self.steps[-1], ReadLine):
            raise ProgramError("a trigger does not follow a line.")
        if not self.counted_move:
            raise ProgramError("a trigger follows a line whose number is not kept.")
        output = look_up(self.outputs, values["index"], f"output {values['index']} of the task")
        channel = f"{_KINDS[output[:2]]} {output[2:]}"
        self.steps.insert(-1, ReadSwitch(channel, float(values["value"])))

    def value(self, name: str, key: int = 0) -> dict[str, str]:
        """Look up a value of the data file."""
        return self.values.use((name, key))


def _statements(files: ProgramFiles, name: str, text: str) -> Iterator[Statement]:
    """Give the statements of a program: where it begins is looked up in the file of its name."""
    file = f"{name}.pgx"
    begins = files.get(file, "").partition("[begin")[0].count("\n")
    for line in statements_of(file, text):
        if line and not line.startswith("//"):
            number = line.place.line if line.place is not None else 1
            yield Statement(line, TextPlace(file, begins + number))


def _pose(value: dict[str, str]) -> Pose:
    return read_pose((value[name] for name in ("x", "y", "z", "rx", "ry", "rz")), from_moving_xyz)


DIALECT = Dialect(
    title="Staubli VAL3",
    notes="A project for CS8 and CS9, VAL3 s7 and newer: copy its folder to the controller and link "
    "the variables do, go, ao and ai. A task of 4 ms sets outputs on the path, as direct ones run ahead of the motion.",
    capability=Capability(
        controller_class=4,
        timing="boundary",
        cycle_s=PERIOD_S,
        step_mm_s=0.1,
        switches_at_rest=True,  # the way of the last 60 ms before a stop is of the controller's own ramp
    ),
    layout=Layout("//", comma=",", equals="=", single_blanks=True, leading_zero=True),
    form=FileForm(".pjx", several=(".pjx", ".dtx", ".pgx"), is_project=True),
    longest_line=200,  # assumed
    most_steps=1500,  # of a program; assumed, an array takes 9,999 points
    write=Val3.write,
    rebuild=Val3Reader.rebuild,
    controller=Controller(
        blending="zone",
        settle_s=0.05,
        look_ahead=20,
        least_line_s=0.004,
        most_positions=9_999,
        sources={"most_positions": "size of an array"},
    ),
    maker="staubli",
    without_joints="Stand the arm in the configuration that it is to keep: points have ssame, esame, wsame.",
)
