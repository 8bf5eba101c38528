"""Staubli VAL3: outputs where a move begins, set by a synchronous task that watches which move is being executed."""

import re
from collections.abc import Iterator, Mapping, Sequence
from xml.etree import ElementTree

from programs.errors import ProgramError
from programs.motion.installation import Channel, Installation
from programs.motion.lower import Capability, Lowered
from programs.motion.steps import Call, Line, Pause, Reach, Repeat, Step, Switch
from programs.pose import IDENTITY, Pose
from programs.posts.dialect import Dialect, FileForm, ProgramFiles
from programs.posts.reading.driver import Reader, read_pose
from programs.posts.reading.execution import Block, Statement, Values, look_up, skip, statements_of
from programs.posts.rebuilt import Due, ReadLine, ReadSwitch, TextPlace
from programs.posts.robots import val3_project as project
from programs.posts.robots.val3_project import OUTPUTS, PERIOD_S, TRIGGER, WATCH
from programs.posts.writing.angles import from_moving_xyz
from programs.posts.writing.chapters import Chapter, Placed, degrees_per_s
from programs.posts.writing.driver import Routine, Syntax
from programs.posts.writing.forms import fill, fixed, short
from programs.posts.writing.frame import channels_of, under_each
from programs.posts.writing.joint_moves import CAUTIOUS, Pace
from programs.timing.controller import Controller

FASTEST = 9999.0
_GROUP_BITS = 8
_SAME_ARM = {"shoulder": "ssame", "elbow": "esame", "wrist": "wsame"}
_ARM_WORDS = "".join(f' {key}="{value}"' for key, value in _SAME_ARM.items())
_STOP = ("call shutValves()", 'taskKill("guard")', 'taskKill("watch")')
"""What the application does when it stops."""
_PARAMETERS = ("x_nMove", "x_nOutput", "x_nValue")


class Val3(Syntax):
    """VAL3: a project of programs, and of data in arrays."""

    mark = "// "
    longest_comment = longest_heading = 120
    call_form = "call {routine}()"
    pause_form = "delay({seconds:3})"
    frame_prefixes, flange_names, keeps_program_name = ("t_", "f_"), ("flange", "world"), False
    """A program may be called like the project."""
    move = "{kept:nId=}{verb}({point},{tool},{movement})"
    trigger_form = "call trigger(nId,{index:0},{value:-~6})"
    rest_form = "waitEndMove()"
    begin = ("nHead=0", "nTail=0", f'taskCreateSync "{{watch}}",{short(project.PERIOD_S, 3)},bOverrun,watch()')
    guard_form = 'taskCreate "{guard}",50,guard()'
    digital = "do{number}={value}"
    group = "dioSet(go{number},{value})"
    analog = "aioSet(ao{number},{value})"
    off_on = ("false", "true")
    shut_name = "shutValves"
    states = ("false", "true")
    part_form = ("if {start}<={number}", "  {call}", "endIf")
    enter_begin = ("if {start}=={number}", "  {start}=1")
    enter_end = ("endIf",)
    guard = (
        "if getMonitorSpeed()!=100",
        '  popUpMsg("speed is not 100 percent")',
        "  call stop()",
        "  return",
        "endIf",
    )
    wait_contact, wait_sensor = under_each(
        (
            "if watch({condition},{seconds})==false",
            '  popUpMsg("{message}")',
            "  call stop()",
            "  return",
            "endIf",
        ),
        "di{input}=={state}",
        "{reading}>={least}",
    )
    rise_forms = (
        "pStart=here({tool},world)",
        "if pStart.trsf.z<{height}",
        "  pStart.trsf.z={height}",
        "  movel(pStart,{tool},mReach)",
        "  waitEndMove()",
        "endIf",
    )
    loop_begin = ("{counter}=0", "do", "  {counter}={counter}+1")
    loop_end = ("until {condition}",)
    counted = "{counter}>={count}"
    sensed = "{counter}>={count} or {reading}>={least}"
    reading = "{scale}*aioGet(ai{input})+{offset}"
    reading_digits = 6
    last = ("call stop()",)
    rounds_groups = True
    reserved = frozenset({
        "start", "stop", "watch", "trigger", "setoutput", "begin", "end", "call", "return", "wait", "open", "close",
        "guard", "shutvalves", "nstart",
    })  # fmt: skip
    longest_name = 15  # of programs and variables in the oldest controllers in use; assumed
    longest_title = 12

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        super().__init__(dialect, lowered, installation)
        used = {event.channel: None for line in self.motion.lines for event in line.events}
        self.channels = sorted(used, key=lambda channel: (channel.kind, channel.number))
        """Outputs that change on the path, by their number in the task."""
        self.movements: dict[str, str] = {}
        self.arrays: dict[str, list[str]] = {}
        """Points by the name of their array."""
        self.reached: list[str] = []
        """Joint values in the array ``jReach``."""
        self.chapter_number = 0
        self.in_motions: set[str] = set()
        """Names of tools and frames that motions use: others are not declared."""
        self.moving = False
        """Whether moves may be waiting: what is done at rest has to wait for them."""

    def chapter(self, chapter: Chapter) -> Iterator[str]:
        """Write a program; it waits at its end, so that what follows is done at rest."""
        self.chapter_number = chapter.number
        yield from super().chapter(chapter)
        yield from self.rest()

    def statements(self, step: Step, placed: Placed) -> Iterator[str]:
        """Write one step; what is done at rest waits for the moves."""
        if isinstance(step, Pause | Switch | Call):
            yield from self.rest()
        yield from super().statements(step, placed)

    def rest(self) -> Iterator[str]:
        """Wait until the robot stands."""
        if self.moving:
            yield self.rest_form
        self.moving = False

    def line(self, line: Line, placed: Placed) -> Iterator[str]:
        """Write a line; its outputs go to the task with the number of the move."""
        yield self.movement_to(self.point(line.target), self.movement(line), kept=placed.begins)
        for event in placed.begins:
            yield fill(self.trigger_form, index=self.channels.index(event.channel), value=event.value)
        if placed.ends:
            yield from self.rest()
        yield from (self.output(event.channel, event.value) for event in placed.ends)

    def reach(self, reach: Reach) -> Iterator[str]:
        """Write ``movej`` to joint values and the line that is left, or to the pose."""
        if reach.joints:
            self.reached.append(self.joint_value(reach.joints))
            at = f"jReach[{len(self.reached) - 1}]"
            yield self.movement_to(at, self.joint_movement(self.pace(reach)), verb="movej")
        yield self.movement_to(self.point(reach.target), "mReach", verb="movel" if reach.joints else "movej")

    def movement_to(self, point: str, movement: str, verb: str = "movel", kept: object = ()) -> str:
        """Write a motion; its number is kept where an output waits for it."""
        self.moving = True
        return fill(self.move, kept=kept, verb=verb, point=point, tool=self.tool_name, movement=movement)

    def point(self, pose: Pose) -> str:
        """Put a point into the routine's array for the board in use."""
        self.in_motions |= {self.tool_name, self.board_name}
        array = self.names.give("points", (self.chapter_number, self.board_name), f"p_{self.chapter_number:02d}")
        values = self.arrays.setdefault(array, [])
        values.append(project.place(pose, self.board_name) + _ARM_WORDS)
        return f"{array}[{len(values) - 1}]"

    def joint_value(self, joints: tuple[float, ...]) -> str:
        """Write joint values as attributes."""
        return " ".join(f'j{number}="{word}"' for number, word in enumerate(self.joints(joints), start=1))

    def movement(self, line: Line) -> str:
        """Name the speed and the zone of a line."""
        turns = line.turns_on_the_spot
        rate = degrees_per_s(line) if turns else line.speed_mm_s
        zone = f"z{fixed(line.blend_mm, 2)}" if line.blend_mm else "fine"
        proposed = f"{'r' if turns else 'm'}{short(rate, 1)}_{zone}".replace(".", "p")
        name = self.names.give("movement", proposed, proposed)
        self.movements[name] = project.movement(*((FASTEST, rate) if turns else (rate, FASTEST)), line.blend_mm)
        return name

    def joint_movement(self, pace: Pace) -> str:
        """Name the speed of a joint motion: percents of the joints' where its time is planned."""
        if pace.seconds is None:
            return "mReach"
        name = self.names.give("movement", pace.percent, f"j{pace.percent}_fine")
        self.movements[name] = project.movement(FASTEST, FASTEST, 0.0, pace.percent)
        return name

    def prepare(self) -> Iterator[str]:
        """Start the task."""
        yield from (fill(form, watch="watch") for form in self.begin)

    def home(self) -> list[str]:
        """Go home."""
        home = fill(self.move, verb="movej", point="jHome", tool="flange", movement="mReach")
        return [home, self.rest_form] if self.installation.home else []

    def variables(self) -> Iterator[str]:
        """Declare all variables."""
        named = self.in_motions | ({self.first_tool()} if self.rises else set())
        for name, pose in ((name, pose) for name, pose in self.boards.items() if name in named):
            yield project.variable(name, "frame", [project.place(pose, "world")])
        for name, tool in ((name, tool) for name, tool in self.tools.items() if name in named):
            yield project.variable(name, "tool", [project.place(tool.T_flange_tcp, "flange")])
        yield from self.signals()
        yield from (project.variable(name, "num", (), project.QUEUE) for name in ("nMove", "nOutput", "nValue"))
        yield project.variable("nStart", "num", ['value="1"'])
        for name in ("nHead", "nTail", "nId", *(f"nLoop{number}" for number in self.loops)):
            yield project.variable(name, "num", (), 1)
        yield project.variable("bOverrun", "bool", (), 1)
        yield project.variable("mReach", "mdesc", [project.movement(100.0, 30.0, 0.0, CAUTIOUS.percent)])
        yield from (project.variable(name, "mdesc", [value]) for name, value in self.movements.items())
        if self.rises:
            yield project.variable("pStart", "pointRx", [f"{project.place(IDENTITY, 'world')}{_ARM_WORDS}"])
        if self.installation.home:
            yield project.variable("jHome", "jointRx", [self.joint_value(self.installation.home)])
        if self.reached:
            yield project.variable("jReach", "jointRx", self.reached)
        yield from (project.variable(name, "pointRx", values) for name, values in self.arrays.items())

    def signals(self) -> Iterator[str]:
        """Declare outputs and inputs; what they are linked to is the integrator's."""
        for name, kind in sorted({(_signal(channel), channel.kind) for channel in channels_of(self.motion)}):
            yield project.variable(
                name, "aio" if kind == "analog" else "dio", (), _GROUP_BITS if kind == "group" else 1
            )
        waits = self.installation.waits
        for number in sorted({wait.contact.number for wait in waits if wait.contact is not None}):
            yield project.variable(f"di{number}", "dio", (), 1)
        sensors = [step.sensor for step in self.motion.steps if isinstance(step, Repeat)]
        sensors += [wait.sensor for wait in waits]
        for number in sorted({sensor.number for sensor in sensors if sensor is not None}):
            yield project.variable(f"ai{number}", "aio", (), 1)

    def begin_production(self) -> Iterator[str]:
        """Start the task that watches when all is as it has to be."""
        yield from super().begin_production()
        yield fill(self.guard_form, guard="guard")

    def setup(self) -> Iterator[str]:
        """State what the integrator has to set up."""
        yield "link do, go, ao, di and ai of the data file to your inputs and outputs"
        yield "valves on outputs that go off with arm power, or wired so: a task that is killed shuts nothing"
        yield "a stop by the task guard lasts until the application is stopped and started again"
        yield "start is main, stop shuts the valves and is called when the application stops; nStart in the data file"
        yield "monitor speed 100 %; tools and frames are in the data file: compare them with yours"

    def watched(self) -> Iterator[str]:
        """Write the task that shuts the valves without arm power, or without what is watched."""
        lost = self.watched_lines("di{input}!={state}")
        yield "while true"
        for condition in ("isPowered()==false", *lost):
            yield from (f"  if {condition}", "    stopMove()", f"    call {self.shut_name}()", "  endIf")
        yield from ("  delay(0.01)", "endWhile")

    def setters(self) -> Iterator[str]:
        """Write what sets the output of a number."""
        forms = {"digital": "{}=x_nValue!=0", "group": "dioSet({},x_nValue)", "analog": "aioSet({},x_nValue)"}
        for number, channel in enumerate(self.channels):
            yield from (f"if x_nOutput=={number}", f"  {forms[channel.kind].format(_signal(channel))}", "endIf")

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write a project: its file, the data, start and stop, a program for each routine, and those of the task."""
        units = "Units: mm, mm/s, deg/s; points in the board's CAD frame, rx ry rz about x, y', z''"
        programs = {
            "start": project.code("start", [*self.heading(units), *main.body]),
            "stop": project.code("stop", _STOP),
            self.shut_name: project.code(self.shut_name, self.shut()),
            "guard": project.code("guard", self.watched()),
            **{each.name: project.code(each.name, each.body) for each in routines},
            "watch": project.code("watch", project.WATCH),
            "trigger": project.code("trigger", project.TRIGGER, _PARAMETERS),
            "setOutput": project.code("setOutput", self.setters(), _PARAMETERS[1:]),
        }
        return {
            f"{self.name}.pjx": project.listing(list(programs), self.name),
            f"{self.name}.dtx": project.database(self.variables()),
            **{f"{name}.pgx": text for name, text in programs.items()},
        }


def _signal(channel: Channel) -> str:
    """Name the variable of an output."""
    return f"{project.OUTPUTS[channel.kind]}{channel.number}"


_SETTER = re.compile(r"if x_nOutput==(\d+)\s+(?:(do\d+)=x_nValue!=0|(?:dioSet|aioSet)\(([ga]o\d+),x_nValue\))\s+endIf")
_VARIABLES = {"nMove", "nHead", "nTail", "nId", "nStart", "bOverrun"}
"""That every project has."""
_KINDS = {prefix: kind for kind, prefix in OUTPUTS.items()}


class Val3Reader(Reader):
    """Data and programs of a project, and the moves that the program runs ahead of."""

    syntax = Val3
    shut_name = "shutValves"
    handlers = frozenset({"main", "stop", "isPowered()==false"})

    def __init__(self) -> None:
        super().__init__()
        self.values = self.declares("value")
        """Attributes by variable and key."""
        self.types: dict[str, str] = {}
        """Type by variable."""
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
        try:
            trees = [ElementTree.fromstring(text) for text in files.values()]
        except ElementTree.ParseError as error:
            raise ProgramError(f"the project is no XML: {error}.") from None
        listed = [element.attrib["file"] for tree in trees for element in tree.iter() if "file" in element.attrib]
        if sorted(listed) != sorted(list(files)[1:]):
            raise ProgramError("the project file does not list the files.")
        for element in (element for tree in trees for element in tree.iter() if "name" in element.attrib):
            name, tag = element.attrib["name"], element.tag.rpartition("}")[2]
            if tag == "Data":
                self.load_data(name, element)
            elif tag == "Program":
                text = "".join(element.itertext()).strip().removeprefix("begin").removesuffix("end")
                self.routines[name] = list(_statements(files, name, text))
        for name, body in (("watch", WATCH), ("trigger", TRIGGER)):
            if self.routines.get(name) != [line.strip() for line in body]:
                raise ProgramError("the task that sets outputs is not as it is written.")
        for number, digital, other in _SETTER.findall(" ".join(self.routines.get("setOutput", []))):
            self.outputs[number] = digital or other
        self.called |= {"watch", "trigger", "setOutput", "stop", "guard"}
        self.check_variables()
        return "start"

    def load_data(self, name: str, element: ElementTree.Element) -> None:
        """Read a variable; an array states its size."""
        keys = [value.attrib["key"] for value in element]
        size = element.attrib["size"]
        if name in self.types or keys != [str(key) for key in range(len(keys))] or (keys and size != str(len(keys))):
            raise ProgramError(f"{name} is there twice, or its values are not in order, or not so many.")
        self.types[name] = element.attrib["type"]
        for key, value in enumerate(element):
            self.values.add((name, key), dict(value.attrib))
            if name == "nStart":  # of the production frame
                self.values.used.add((name, key))
            if self.types[name] == "mdesc" and not _is_movement(value.attrib):
                raise ProgramError(f"{name} has an acceleration or a speed that is not 100 %, or blends unevenly.")

    def check_variables(self) -> None:
        """Make sure that outputs, inputs and counters are declared, of their type, and used."""
        text = " ".join(line for lines in self.routines.values() for line in lines)
        for name in set(re.findall(r"\b(?:do|go|ao|di|ai|nLoop)\d+\b", text)) | _VARIABLES:
            kind = {"d": "dio", "g": "dio", "a": "aio", "n": "num", "b": "bool"}[name[0]]
            if self.types.get(name) != kind:
                raise ProgramError(f"variable {name} is not declared as {kind}.")
        for name in (name for name in self.types if re.fullmatch(r"(?:do|go|ao|di|ai|nLoop)\d+", name)):
            if not re.search(rf"\b{name}\b", text):
                raise ProgramError(f"variable {name} is declared and never used.")

    def fields(self) -> Mapping[str, str]:
        """Give the pattern of each field of the writer's forms."""
        words = {
            "verb": "movel|movej",
            "point": r"\w+(?:\[\d+\])?",
            "movement": r"\w+",
            "guard": "guard",
            "watch": "watch",
        }
        return {**super().fields(), **words}

    def blocks(self) -> Iterator[Block]:
        """List the statements of forms."""
        yield [Val3.move], self.move
        yield [Val3.trigger_form], self.trigger
        yield [Val3.rest_form], self.wait
        yield list(Val3.last), self.read_stop
        yield [Val3.guard_form], self.read_guard
        yield from (([form], skip) for form in Val3.begin)
        yield from super().blocks()

    def use_first_tool(self, name: str) -> None:
        """Use the tool whose orifice is raised."""
        if self.types.get("pStart") != "pointRx" or self.types.get(name) != "tool":
            raise ProgramError("pStart is no point, or is seen for no tool.")
        self.value("pStart")

    def read_stop(self, values: Values) -> None:
        """Read what the application does when it stops."""
        if self.routines.get("stop") != list(_STOP):
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
                self.watched.append((found[2], found[3] == "true"))
            self.shut_by.add(found[1])

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
        if self.types[name] != "pointRx" or not target.items() >= _SAME_ARM.items():
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
        self.steps.insert(-1, ReadSwitch(_channel(output), float(values["value"])))

    def value(self, name: str, key: int = 0) -> dict[str, str]:
        """Look up a value of the data file."""
        return self.values.use((name, key))


def _is_movement(value: Mapping[str, str]) -> bool:
    """Whether a movement has full acceleration, and leaves and reaches its blend alike."""
    full = all(value[word] == "100" for word in ("accel", "decel"))
    return full and value["leave"] == value["reach"] and value["blend"] in ("off", "cartesian")


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


def _channel(variable: str) -> str:
    return f"{_KINDS[variable[:2]]} {variable[2:]}"


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
