"""Staubli VAL3: outputs where a move begins, set by a synchronous task that watches which move is being executed."""

from collections.abc import Iterator, Sequence

from programs.motion.installation import Channel, Installation
from programs.motion.lower import Lowered
from programs.motion.steps import Call, Hold, Line, Mount, Pause, Reach, Repeat, Step, Switch
from programs.pose import IDENTITY, Pose
from programs.posts.dialect import Dialect, ProgramFiles, Task
from programs.posts.robots.val3 import project
from programs.posts.writing.angles import moving_xyz
from programs.posts.writing.chapters import Chapter, Placed, degrees_per_s
from programs.posts.writing.driver import Routine, Syntax
from programs.posts.writing.forms import fill, fixed, short
from programs.posts.writing.frame import under_each
from programs.posts.writing.handover import channels_of
from programs.posts.writing.joint_moves import CAUTIOUS, Pace
from programs.posts.writing.vocabulary import VAL3

FASTEST = 9999.0
_GROUP_BITS = 8
SAME_ARM = {"shoulder": "ssame", "elbow": "esame", "wrist": "wsame"}
_ARM_WORDS = "".join(f' {key}="{value}"' for key, value in SAME_ARM.items())
STOP = ("call shutValves()", 'taskKill("guard")', 'taskKill("pathOutputs")')
"""What the application does when it stops."""
_PARAMETERS = ("x_nMove", "x_nOutput", "x_nValue")


class Val3(Syntax):
    """VAL3: a project of programs, and of data in arrays."""

    mark = "// "
    longest_comment = longest_heading = 120
    call_form = "call {routine}()"
    pause_form = "delay({seconds:3})"
    mount_forms = ("userPage()", "cls()", 'putln("{mount}")', "nKey=get()")
    frame_prefixes, flange_names = ("t_", "f_"), ("flange", "world")
    move = "{kept:nId=}{verb}({point},{tool},{movement})"
    trigger_form = "call trigger(nId,{index:0},{value:-~6})"
    rest_form = "waitEndMove()"
    begin = ("nHead=0", "nTail=0", f'taskCreateSync "{{task}}",{short(project.PERIOD_S, 3)},bOverrun,pathOutputs()')
    guard_form, end_form = 'taskCreate "{guard}",50,guard()', 'taskKill("{guard}")'
    await_contact = ("wait(di{input}=={state})",)
    load_place = "payload of the arm with tool {tool}"
    digital = "do{number}={value}"
    group = "dioSet(go{number},{value})"
    analog = "aioSet(ao{number},{value})"
    address_forms = ("do{number}", "go{number}", "ao{number}")
    contact_form, sensor_form = "di{number}", "ai{number}"
    angles = ("rx ry rz", "degrees about x, y', z''", moving_xyz)
    off_on = ("false", "true")
    shut_name = "shutValves"
    states = ("false", "true")
    part_form = ("if {start}<={number}", "  {call}", "endIf")
    enter_begin = ("if {start}=={number}", "  {start}=1")
    enter_end = ("endIf",)
    guard = (
        "if getMonitorSpeed()!=100",
        "  {fault}",
        '  popUpMsg("speed is not 100 percent")',
        "  call stop()",
        "  return",
        "endIf",
    )
    wait_contact, wait_sensor = under_each(
        (
            "if watch({condition},{seconds})==false",
            "  {fault}",
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
    vocabulary = VAL3
    longest_title = 12

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        super().__init__(dialect, lowered, installation)
        used = {event.channel: None for line in self.motion.lines for event in line.events}
        self.switched = sorted(used, key=lambda channel: (channel.kind, channel.number))
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
        if isinstance(step, Pause | Switch | Mount | Hold | Call):
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
            yield fill(self.trigger_form, index=self.switched.index(event.channel), value=event.value)
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
        yield from (fill(form, task="pathOutputs") for form in self.begin)

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
        for name in ("nHead", "nTail", "nId", "nKey", *(f"nLoop{number}" for number in self.loops)):
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
        for name, kind in sorted(
            {
                (_signal(channel), channel.kind)
                for channel in (*channels_of(self.motion), *self.valves, *self.line_outputs)
            }
        ):
            yield project.variable(
                name, "aio" if kind == "analog" else "dio", (), _GROUP_BITS if kind == "group" else 1
            )
        waits = self.installation.waits
        for number in sorted({contact.number for contact in self.contacts}):
            yield project.variable(f"di{number}", "dio", (), 1)
        sensors = [step.sensor for step in self.motion.steps if isinstance(step, Repeat)]
        sensors += [wait.sensor for wait in waits]
        for number in sorted({sensor.number for sensor in sensors if sensor is not None}):
            yield project.variable(f"ai{number}", "aio", (), 1)

    def begin_production(self) -> Iterator[str]:
        """Start the task that watches when all is as it has to be."""
        yield from super().begin_production()
        yield from self.begin_watches()

    def begin_watches(self) -> list[str]:
        """Start the task that watches."""
        return [fill(self.guard_form, guard="guard")]

    def end_watches(self) -> list[str]:
        """End it."""
        return [fill(self.end_form, guard="guard")]

    def setup(self) -> Iterator[Task]:
        """State what the integrator has to set up."""
        yield Task("link the variables of the data file to your inputs and outputs, as below")
        yield Task("valves on outputs that go off with arm power, or wired so: a task that is killed shuts nothing")

    def remarks(self) -> Iterator[str]:
        """State what has to hold when the program is started."""
        yield "A stop by the task guard lasts until the application is stopped and started again"
        yield "start is main, stop shuts the valves and is called when the application stops; nStart in the data file"
        yield "Monitor speed 100 %; tools and frames are in the data file: compare them with yours"

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
        for number, channel in enumerate(self.switched):
            yield from (f"if x_nOutput=={number}", f"  {forms[channel.kind].format(_signal(channel))}", "endIf")

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write a project: its file, the data, start and stop, a program for each routine, and those of the task."""
        units = f"Units: mm, mm/s, deg/s; points in {self.cad_frame}, rx ry rz about x, y', z''"
        programs = {
            "start": project.code("start", [*self.heading(units), *main.body]),
            "stop": project.code("stop", STOP),
            self.shut_name: project.code(self.shut_name, self.shut()),
            "guard": project.code("guard", self.watched()),
            **{each.name: project.code(each.name, each.body) for each in routines},
            "pathOutputs": project.code("pathOutputs", project.PATH_OUTPUTS),
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
