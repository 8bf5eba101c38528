"""URScript: a thread compares the way done with the places of the outputs, 500 times a second."""

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import ClassVar

from programs.errors import ProgramError
from programs.motion.analog import Counting
from programs.motion.lower import Capability
from programs.motion.steps import RESOLUTION_MM, Event, Line
from programs.pose import Pose, angle, distance
from programs.posts.dialect import Dialect, FileForm, ProgramFiles, Task
from programs.posts.layout import Layout
from programs.posts.reading.driver import Reader, read_pose
from programs.posts.reading.execution import (
    Block,
    Statement,
    Values,
    differing,
    located,
    refusal,
    skip,
    statements_of,
)
from programs.posts.rebuilt import Due, ReadSignal
from programs.posts.robots.ur_watcher import EXPLANATIONS, KINDS, WATCHER
from programs.posts.writing.angles import from_rotation_vector, rotation_vector
from programs.posts.writing.axes import as_controller_counts
from programs.posts.writing.chapters import Placed
from programs.posts.writing.driver import Routine, Syntax
from programs.posts.writing.forms import NUMBER, POSE, fill, fixed, pattern_of, short
from programs.posts.writing.frame import under_each
from programs.posts.writing.joint_moves import CAUTIOUS, Pace
from programs.posts.writing.vocabulary import URSCRIPT
from programs.posts.writing.wording import indent, join_lines
from programs.timing.controller import Controller

NARROWEST_MM = 0.001
"""A blend that is written as 0 is a stop."""
ACCELERATION, REACH_SPEED = "a=1.2", "a=0.5, v=0.25"
"""m/s2 and rad/s2; 1.2 is the default of movel."""


class UrScript(Syntax):
    """URScript: functions, and a thread beside them."""

    mark = "# "
    call_form = "{routine}()"
    pause_form = "sleep({seconds:3})"
    mount_forms = ('popup("{mount}", title="Washboard", blocking=True)',)
    move = f"movel({{point}}, {ACCELERATION}, {{unit}}={{pace}}, r={{zone:~6}})"
    to_joints = f"movej([{{joints}}], {REACH_SPEED})"
    timed_joints = "movej([{joints}], t={seconds:3})"
    arm_form = "arm({begin}, {end}, {way:~6}, {switched})"
    routine_form = ("def {routine}():", "end")
    settle_form = "settle()"
    declare = "global {name} = {pose}"
    declare_start = "global n_start = 1{note: # the part to start at; 1 is the whole program of {parts:0}}"
    select_tool = ("set_tcp({name})",)
    payload_forms, needs_payload = ("set_payload({mass:~3}, [{x:-~6},{y:-~6},{z:-~6}])",), True
    select_board = ("board = {name}",)
    frame_prefixes, mounted_name = ("tcp_", "board_"), "as_mounted"
    stop_body = ("{fault}", "shut_valves()", 'popup(text, title="Washboard", error=True, blocking=False)', "halt")
    watch_form = "run_watch_inputs = run watch_inputs()"
    watch_first = f"global {watch_form}"
    watched_body = ("if get_standard_digital_in({input}) != {state}:", '  stop_job("{message}")', "end")
    digital, group, analog = (f"set_out({code}, {{number}}, {{value}})" for code in KINDS.values())
    address_forms = ("digital_out[{number}]", "output integer register {number}", "analog_out[{number}]")
    contact_form, sensor_form = "digital_in[{number}]", "analog_in[{number}]"
    angles = ("rx ry rz", "axis times angle, radians", rotation_vector)
    rise_forms = (
        "set_tcp({tool})",
        "p_start = get_actual_tcp_pose()",
        "if p_start[2] < {height}:",
        f"  movel(p[p_start[0],p_start[1],{{height}},p_start[3],p_start[4],p_start[5]], {REACH_SPEED})",
        "end",
    )
    by_joints = f"movej({{point}}, {REACH_SPEED})"
    straight = f"movel({{point}}, {REACH_SPEED})"
    start = "n_start"
    shared = "the names of its functions: one program is loaded at a time"
    start_words = "write its number into the line {start} = 1"
    part_form = ("if {start} <= {number}:", "  {call}", "end")
    enter_begin = ("if {start} == {number}:", "  {start} = 1")
    enter_end = ("end",)
    states = ("False", "True")
    wait_contact, wait_sensor = under_each(
        (
            "n_wait = 0",
            "while {condition} and n_wait < {tenths}:",
            "  sleep(0.1)",
            "  n_wait = n_wait + 1",
            "end",
            "if {condition}:",
            '  stop_job("{message}")',
            "end",
        ),
        "get_standard_digital_in({input}) != {state}",
        "{reading} < {least}",
    )
    counter = "n_loop_{number}"
    loop_begin = ("{counter} = 0", "while {condition}:", "  {counter} = {counter} + 1")
    loop_end = ("end",)
    counted = "{counter} < {count}"
    sensed = "{counter} < {count} and ({counter} == 0 or {reading} < {least})"
    reading = "{scale}*get_standard_analog_in({input})+{offset}"
    end_form, last = "kill run_watch_inputs", ("kill run_watch",)
    await_contact = ("await_input({input}, {state})",)
    await_body = ("while get_standard_digital_in(number) != state:", "  sync()", "end")
    vocabulary = URSCRIPT

    def line(self, line: Line, placed: Placed) -> Iterator[str]:
        """Arm the outputs, move, and switch at a stop what the thread has left."""
        way_mm = _written_way(line)
        late = [event for event in line.events if not way_mm and event.share > 0.5]
        for event in line.events:
            if way_mm:
                yield self.armed(line, event)
            elif event not in late:
                yield self.output(event.channel, event.value)
        turns, point = line.turns_on_the_spot, self.point(line.target)
        pace = fixed(max(line.duration_s, 0.01), 3) if turns else _m(line.speed_mm_s)
        yield fill(self.move, point=point, unit="t" if turns else "v", pace=pace, zone=self.blend(line) / 1000.0)
        yield from (self.output(event.channel, event.value) for event in late)
        if line.events and line.blend_mm == 0.0 and way_mm:
            yield self.settle_form

    def armed(self, line: Line, event: Event) -> str:
        """Note the place at which the thread switches an output."""
        begin, end = _write_pose(line.start), _write_pose(line.target)
        switched = self.output(event.channel, event.value).removeprefix("set_out(").removesuffix(")")
        return fill(self.arm_form, begin=begin, end=end, way=event.offset_mm / 1000.0, switched=switched)

    def blend(self, line: Line) -> float:
        """Narrow a blend so that it meets neither that before nor that after it; a turn on the spot takes no room."""
        ways = [_written_way(each) for each in (line, self.following.get(id(line))) if each is not None]
        room = min((way for way in ways if way > 0.0), default=math.inf)
        return min(line.blend_mm, max(0.45 * room, NARROWEST_MM))

    def point(self, pose: Pose) -> str:
        """Write a point on the board."""
        return f"pose_trans(board, {_write_pose(pose)})"

    def joint_move(self, joints: tuple[float, ...], pace: Pace = CAUTIOUS) -> str:
        """Write a motion to joint values in radians; its time, where it is planned, overrules speeds."""
        counted = as_controller_counts(joints, self.installation)
        words = ",".join(short(math.radians(value), 6) for value in counted)
        return fill(self.to_joints if pace.seconds is None else self.timed_joints, joints=words, seconds=pace.seconds)

    def height(self, millimetres: float) -> str:
        """Write a height in metres."""
        return _m(millimetres)

    def prepare(self) -> Iterator[str]:
        """Declare the frames, and start the thread."""
        for name, pose in self.poses.items():
            yield fill(self.declare, name=name, pose=_write_pose(pose))
        yield fill(self.declare_start, note=True, parts=len(self.chapters))
        yield "run_watch = run watch()"

    def begin_production(self) -> Iterator[str]:
        """Start the thread that watches inputs."""
        yield from super().begin_production()
        yield self.watch_first

    def begin_watches(self) -> list[str]:
        """Start the thread that watches inputs."""
        return [self.watch_form]

    def end_watches(self) -> list[str]:
        """End it."""
        return [self.end_form]

    def setup(self) -> Iterator[Task]:
        """State what the integrator has to set up."""
        text = "Installation, I/O: each valve's output goes low when no program runs; after a stop no script does"
        lows = (
            f"{self.address(channel)} ({channel.name}): set low when program is not running" for channel in self.valves
        )
        yield Task(text, tuple(lows))
        yield Task("speed slider at 100 %, which a script cannot read: lock it, or have an RTDE client hold it")

    def remarks(self) -> Iterator[str]:
        """State what the program sets by itself."""
        yield "TCP, payload and the board's pose are set by the program: compare them with yours"

    def faults(self) -> list[str]:
        """Write the functions that shut the valves, and the thread that watches inputs."""
        lines = [
            *self.whole(self.shut_name, self.shut())[:-1],
            "def stop_job(text):",
            *indent(self.with_fault(self.stop_body)),
            "end",
        ]
        inside = [*(f"    {line}" for line in self.watched_lines(*self.watched_body)), "    sync()"]
        lines += ["def await_input(number, state):", *indent(self.await_body), "end"]
        return [*lines, "thread watch_inputs():", "  while True:", *inside, "  end", "end"]

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write one program, or a file of functions for each part and a program that calls them."""
        units = f"Units: m, m/s, s, rad; poses are x, y, z and axis times angle, in {self.cad_frame} (pose_trans)."
        head = [*self.heading(units), *(f"# {line}" for line in EXPLANATIONS), ""]
        functions = [self.whole(each.name, each.body)[:-1] for each in routines]
        if self.fits_one_file:
            bodies = [line for function in functions for line in [*function, ""]]
            return {f"{self.name}.script": self.program([*head, *WATCHER, *self.faults(), "", *bodies, *main.body])}
        files = {f"{self.name}.script": self.program([*head, *main.body]) + f"{self.name}()\n"}
        for number, lines in enumerate([[*WATCHER, *self.faults()], *functions]):
            files[f"{self.name}_{number:02d}.script"] = join_lines(lines)
        return files

    def program(self, lines: Iterable[str]) -> str:
        """Write the function that the controller calls."""
        return join_lines(self.whole(self.name, lines)[:-1])


def _written_way(line: Line) -> float:
    """Length of a line in mm; 0 where its ends may be written as one place, which has no direction to watch."""
    return line.length_mm if line.length_mm > RESOLUTION_MM else 0.0


def _m(millimetres: float) -> str:
    """Write a length in metres, or a speed in m/s."""
    return short(millimetres / 1000.0, 6)


def _write_pose(pose: Pose) -> str:
    """Write a pose: metres, and axis times angle in radians."""
    numbers = [*map(_m, pose.position), *(short(value, 6) for value in rotation_vector(pose.quaternion))]
    return f"p[{','.join(numbers)}]"


_POSE = rf"p\[{POSE}\]"
_ACCELERATION_MM_S2 = 1000.0 * float(ACCELERATION.removeprefix("a="))
_CHANNELS = {str(code): kind for kind, code in KINDS.items()}


class UrScriptReader(Reader):
    """Functions, declared poses, and outputs that wait for their places."""

    syntax = UrScript
    handlers = frozenset({"main", "stop_job", "thread"})
    height_unit_mm = 1000.0
    texts: ClassVar[Mapping[str, str]] = {
        **{"point": rf"pose_trans\(board, {_POSE}\)", "unit": "[vt]", "pace": r"\d+(?:\.\d+)?", "name": r"\w+"},
        **{"pose": _POSE, "begin": _POSE, "end": _POSE, "switched": rf"[012], \d+, {NUMBER}"},
    }

    def __init__(self) -> None:
        super().__init__()
        self.guards_override = None
        self.armed: list[tuple[Pose, Pose, ReadSignal]] = []
        self.poses = self.declares("pose")
        self.variables = self.declares("variable")
        self.settled = True
        """Whether nothing is left that waits for its place."""

    @classmethod
    def due(cls, line: Line, after: Line | None) -> Due:
        """Give the blend, at most 0.45 of either way that is watched, and the time of a turn on the spot."""
        ways = [each.length_mm for each in (line, after) if each is not None]
        room = min((way for way in ways if way > RESOLUTION_MM), default=math.inf)
        zone = min(line.blend_mm, max(0.45 * room, NARROWEST_MM))
        return Due(zone, None, max(line.duration_s, 0.01) if line.turns_on_the_spot else None)

    def load(self, files: ProgramFiles) -> str:
        """Find the thread as it is written, and the functions; the first is the program."""
        statements = [line for file, text in files.items() for line in _statements(file, text)]
        watcher = _statements("", "\n".join(WATCHER))
        begins = [at for at, line in enumerate(statements) if line == watcher[0]] or [0]
        inside = statements[begins[0] : begins[0] + len(watcher)]
        if len(begins) != 1 or inside != watcher:
            line = statements[begins[-1]] if len(begins) > 1 else differing(inside, watcher)
            raise located("the thread that switches the outputs is not as it is written.", line)
        del statements[begins[0] : begins[0] + len(watcher)]
        self.sort_nested(statements)
        return next(iter(self.routines), "")

    def sort_nested(self, statements: Iterable[Statement]) -> None:
        """Sort statements into functions, one inside the other; an end belongs to what was opened last."""
        opened: list[list[str]] = []
        loops = 0
        for statement in statements:
            if match := re.fullmatch(r"(?:def|thread) (\w+)\((?:text|number, state)?\):", statement):
                opened.append([])
                self.routines[match[1]] = opened[-1]
            elif not opened:
                if statement != f"{next(iter(self.routines), '')}()":  # in a Script node it is called
                    raise refusal(statement, "stands outside any function")
            elif statement == "end" and loops == 0:
                opened.pop()
            else:
                loops += statement.startswith(("while ", "if ")) - (statement == "end")
                opened[-1].append(statement)
        if opened:
            raise located("a function has no end.", next(iter(opened[-1]), ""))

    def blocks(self) -> Iterator[Block]:
        """List the statements of forms."""
        yield [UrScript.move], self.move
        yield [UrScript.arm_form], self.arm
        yield [UrScript.timed_joints], self.move_joints
        yield [UrScript.declare], lambda values: self.poses.add(values["name"], _pose(values["pose"]), self.statement)
        yield [UrScript.declare_start], lambda values: self.variables.add("n_start", 1, self.statement)
        yield [UrScript.settle_form], self.settle
        yield from (([form], self.read_thread) for form in (UrScript.watch_form, UrScript.watch_first))
        yield [UrScript.end_form], lambda values: self.suspended.add("watch_inputs")
        yield from (([form], skip) for form in ("run_watch = run watch()", *UrScript.last))
        yield from super().blocks()

    def use_variable(self, name: str) -> None:
        """Use the part to start at."""
        if name == "n_start":
            self.variables.use(name)

    def use_wait(self) -> None:
        """Read the function that ends the program."""
        self.expect("stop_job", UrScript.stop_body)
        self.shut_by.add("stop_job")

    def use_first_tool(self, name: str) -> None:
        """Use the tool whose orifice is raised."""
        self.use_tool(name, self.poses.use(name))

    def place_of(self, point: str) -> Pose:
        """Read a pose on the board."""
        return _pose(point)

    def frame_of(self, kind: str, label: str) -> Pose:
        """Give a declared pose."""
        return self.poses.use(label)

    def read_thread(self, values: Values) -> None:
        """Read the thread that watches inputs: it stops the program when one leaves its state."""
        self.use_wait()
        self.expect("await_input", UrScript.await_body)
        self.called.add("watch_inputs")
        inside = list(self.routines.get("watch_inputs", []))
        if inside[:1] != ["while True:"] or inside[-2:] != ["sync()", "end"]:
            raise located("the thread that watches inputs is not as it is written.", next(iter(inside), ""))
        patterns = [re.compile(pattern_of(form, self.fields())) for form in UrScript.watched_body]
        for lines in zip(*(iter(inside[1:-2]),) * 3, strict=True):
            found = [pattern.fullmatch(line) for pattern, line in zip(patterns, lines, strict=True)]
            if found[0] is None or not all(found):
                raise located("the thread that watches inputs is not as it is written.", lines[0])
            self.begin_watch(found[0]["input"], found[0]["state"] == "True")
        self.shut_by.add("thread")
        self.suspended.clear()

    def move_joints(self, values: Values) -> None:
        """Come to joint values, in a time or at the cautious speed."""
        self.lasts_s = float(values["seconds"]) if "seconds" in values else None
        self.come_to(math.degrees(float(word)) for word in values["joints"].split(","))

    def settle(self, values: Values) -> None:
        """Switch at a stop what the thread has left."""
        if self.settled:
            raise ProgramError("settle() does not follow a move with outputs that stops.")
        self.settled = True

    def execute(self, statement: str) -> None:
        """Make sure that outputs of a move that stops are settled right after it."""
        if not self.settled and statement != UrScript.settle_form:
            raise ProgramError(f"settle() is missing before {statement!r}.")
        super().execute(statement)

    def arm(self, values: Values) -> None:
        """Arm an output for the next move."""
        begin, end = _pose(values["begin"]), _pose(values["end"])
        kind, number, value = values["switched"].split(", ")
        share = 1000.0 * float(values["way"]) / distance(begin, end)
        self.armed.append((begin, end, ReadSignal(f"{_CHANNELS[kind]} {number}", float(value), share, 0.0)))

    def move(self, values: Values) -> None:
        """Move in a line; what is armed has to be armed for it."""
        pose, pace, zone = self.pose_of(values["point"]), float(values["pace"]), 1000.0 * float(values["zone"])
        for begin, end, _ in self.armed:
            if self.pose is None or _apart(begin, self.pose) or _apart(end, pose):
                raise ProgramError("an output is armed for another move than the next.")
        signals = tuple(signal for _, _, signal in self.armed)
        self.settled = not signals or zone > 0.0
        self.armed = []
        turns = values["unit"] == "t"
        self.state(zone=zone, acceleration_mm_s2=_ACCELERATION_MM_S2, duration_s=pace if turns else None)
        self.line(pose, zone == 0.0, 0.0 if turns else 1000.0 * pace, signals)


def _apart(one: Pose, other: Pose) -> bool:
    return distance(one, other) > 1e-6 or angle(one, other) > 1e-6


def _pose(text: str) -> Pose:
    """Read a pose in metres and radians."""
    pose = read_pose(re.findall(NUMBER, text), from_rotation_vector)
    x, y, z = pose.position
    return Pose((1000.0 * x, 1000.0 * y, 1000.0 * z), pose.quaternion)


def _statements(file: str, text: str) -> list[Statement]:
    return [line for line in statements_of(file, text) if line and not line.startswith("#")]


DIALECT = Dialect(
    title="URScript",
    notes="For PolyScope 5; a thread watches the path. Analog outputs count from 0 to 1, inputs in volts or amperes; "
    "group outputs are integer output registers. Several files: one Script node for each, the numbered ones before the "
    "main one, which calls itself. One file: sent to the controller as it is; a Script node has to call it.",
    capability=Capability(
        controller_class=4,
        timing="distance",
        cycle_s=0.002,  # the thread runs once in each cycle of the controller, 500 Hz; the e-Series
        references=("start",),
        step_mm=0.001,
        step_mm_s=0.1,
        most_events=8,
        # By the script manual of the e-Series outputs take a level from 0 to 1, where 1 is 10 V or, in the domain of
        # currents, 20 mA, and inputs are read in volts or amperes. That 0 is 4 mA then is reported by users of RTDE.
        analog=Counting(full=1.0, least=0.0, zero_ma=4.0, reads_amperes=True),
    ),
    layout=Layout("#", single_blanks=True, leading_zero=True),
    form=FileForm(".script", also=(".urscript",)),
    longest_line=200,
    most_steps=1500,  # of a script file; assumed, nobody states a limit, and larger scripts take long to load
    write=UrScript.write,
    rebuild=UrScriptReader.rebuild,
    controller=Controller(
        blending="zone",
        acceleration_mm_s2=1200.0,
        joint_speed_share=0.1,
        look_ahead=100,
        least_line_s=0.008,
        times_are_whole=True,
        most_bytes=2_000_000,
        sources={"acceleration_mm_s2": "stated by each movel", "times_are_whole": "script manual: t overrules a and v"},
    ),
    maker="universal-robots",
    without_joints="Stand the arm in the configuration that it is to keep: movej takes the nearest one.",
)
