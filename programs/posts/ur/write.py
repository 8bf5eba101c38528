"""URScript: a thread compares the way done with the places of the outputs, 500 times a second."""

import math
from collections.abc import Iterable, Iterator, Sequence

from programs.motion.steps import RESOLUTION_MM, Event, Line, UseBoard, UseTool
from programs.pose import Pose
from programs.posts.dialect import ProgramFiles
from programs.posts.ur.watcher import KINDS, WATCHER
from programs.posts.writing.angles import rotation_vector
from programs.posts.writing.axes import as_controller_counts
from programs.posts.writing.driver import Routine, Syntax
from programs.posts.writing.joint_moves import CAUTIOUS, Pace
from programs.posts.writing.lines import Placed
from programs.posts.writing.wording import fixed, indent, join_lines, short

NARROWEST_MM = 0.001
"""A blend that is written as 0 is a stop."""
ACCELERATION, REACH_SPEED = "a=1.2", "a=0.5, v=0.25"
"""m/s2 and rad/s2; 1.2 is the default of movel."""
_EXPLANATIONS = (
    "Units: m, m/s, s, rad; poses are x, y, z and axis times angle, in the board's CAD frame: pose_trans(board, ...).",
    "movel rather than movep: it blends with the moves before and after, reaches the same speed on a straight line,",
    "and takes a time where the tool only turns. The speed slider has to stand at 100 %: outputs are at places.",
)

_RESERVED = frozenset({
    "arm", "fire", "settle", "set_out", "watch", "board", "main", "shut_valves", "stop_job", "watch_inputs", "n_start",
    "n_wait", "p_start", "run_watch", "run_watch_inputs",
    "and", "break", "continue", "def", "elif", "else", "end", "enter_critical", "exit_critical", "false", "for",
    "global", "halt", "if", "in", "join", "kill", "local", "mod", "not", "or", "return", "run", "sec", "struct", "then",
    "thread", "true", "while", "xor",
    "floor", "movej", "movel", "point_dist", "popup", "pose_inv", "pose_trans", "set_payload", "set_tcp", "sleep",
    "sync",
})  # fmt: skip
"""Functions and variables that every program has, words of the language, functions of the controller in use."""


class UrScript(Syntax):
    """URScript: functions, and a thread beside them."""

    mark = "# "
    call_form = "{routine}()"
    pause_form = "sleep({seconds})"
    digital, group, analog = (f"set_out({code}, {{number}}, {{value}})" for code in KINDS.values())
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
    start_words = "write its number into the line {start} = 1"
    part_form = ("if {start} <= {number}:", "  {call}", "end")
    enter_begin = ("if {start} == {number}:", "  {start} = 1")
    enter_end = ("end",)
    states = ("False", "True")
    wait_contact = (
        "n_wait = 0",
        "while get_standard_digital_in({input}) != {state} and n_wait < {tenths}:",
        "  sleep(0.1)",
        "  n_wait = n_wait + 1",
        "end",
        "if get_standard_digital_in({input}) != {state}:",
        '  stop_job("{message}")',
        "end",
    )
    wait_sensor = (
        "n_wait = 0",
        "while {reading} < {least} and n_wait < {tenths}:",
        "  sleep(0.1)",
        "  n_wait = n_wait + 1",
        "end",
        "if {reading} < {least}:",
        '  stop_job("{message}")',
        "end",
    )
    counter = "n_loop_{number}"
    loop_begin = ("{counter} = 0", "while {condition}:", "  {counter} = {counter} + 1")
    loop_end = ("end",)
    counted = "{counter} < {count}"
    sensed = "{counter} < {count} and ({counter} == 0 or {reading} < {least})"
    reading = "{scale}*get_standard_analog_in({input})+{offset}"
    last = ("kill run_watch_inputs", "kill run_watch")
    reserved = _RESERVED
    longest_name = 60
    longest_program_name = 55

    def line(self, line: Line, placed: Placed) -> Iterator[str]:
        """Arm the outputs, move, and switch at a stop what the thread has left."""
        way_mm = _written_way(line)
        late = [event for event in line.events if not way_mm and event.share > 0.5]
        for event in line.events:
            if way_mm:
                yield self.armed(line, event)
            elif event not in late:
                yield self.output(event.channel, event.value)
        pace = f"t={fixed(max(line.duration_s, 0.01), 3)}" if line.turns_on_the_spot else f"v={_m(line.speed_mm_s)}"
        yield f"movel({self.point(line.target)}, {ACCELERATION}, {pace}, r={_m(self.blend(line))})"
        yield from (self.output(event.channel, event.value) for event in late)
        if line.events and line.blend_mm == 0.0 and way_mm:
            yield "settle()"

    def armed(self, line: Line, event: Event) -> str:
        """Note the place at which the thread switches an output."""
        output = self.output(event.channel, event.value).removeprefix("set_out(")
        return f"arm({_pose(line.start)}, {_pose(line.target)}, {_m(event.offset_mm)}, {output}"

    def blend(self, line: Line) -> float:
        """Narrow a blend so that it meets neither that before nor that after it; a turn on the spot takes no room."""
        ways = [_written_way(each) for each in (line, self.following.get(id(line))) if each is not None]
        room = min((way for way in ways if way > 0.0), default=math.inf)
        return min(line.blend_mm, max(0.45 * room, NARROWEST_MM))

    def point(self, pose: Pose) -> str:
        """Write a point on the board."""
        return f"pose_trans(board, {_pose(pose)})"

    def joint_move(self, joints: tuple[float, ...], pace: Pace = CAUTIOUS) -> str:
        """Write a motion to joint values in radians; its time, where it is planned, overrules speeds."""
        counted = as_controller_counts(joints, self.installation)
        speed = REACH_SPEED if pace.seconds is None else f"t={fixed(pace.seconds, 3)}"
        return f"movej([{','.join(short(math.radians(value), 6) for value in counted)}], {speed})"

    def height(self, millimetres: float) -> str:
        """Write a height in metres."""
        return _m(millimetres)

    def use(self, step: UseTool | UseBoard) -> Iterator[str]:
        """Set TCP and payload, or the pose that all others are seen from."""
        name = self.frame_name(step, "tcp_", "board_", "as_mounted")
        if isinstance(step, UseBoard):
            yield f"board = {name}"
            return
        tool = self.tools[name]
        yield f"set_tcp({name})"
        yield f"set_payload({short(tool.mass_kg, 3)}, [0,0,{_m(0.5 * tool.T_flange_tcp.position[2])}])"

    def prepare(self) -> Iterator[str]:
        """Declare the frames, and start the thread."""
        for name, pose in self.poses.items():
            yield f"global {name} = {_pose(pose)}"
        yield f"global {self.start} = 1 # the part to start at; 1 is the whole program of {len(self.chapters)}"
        yield "run_watch = run watch()"

    def begin_production(self) -> Iterator[str]:
        """Start the thread that watches inputs."""
        yield from super().begin_production()
        yield "run_watch_inputs = run watch_inputs()"

    def setup(self) -> Iterator[str]:
        """State what the integrator has to set up."""
        yield "Installation, I/O: each valve's output goes low when no program runs; after a stop no script does"
        yield "speed slider at 100 %, which a script cannot read: lock it, or have an RTDE client hold it"
        yield "TCP, payload and the board's pose are set by the program: compare them with yours"

    def faults(self) -> list[str]:
        """Write the functions that shut the valves, and the thread that watches inputs."""
        lines = [f"def {self.shut_name}():", *indent(self.shut()), "end", "def stop_job(text):"]
        lines += [
            f"  {self.shut_name}()",
            '  popup(text, title="Washboard", error=True, blocking=False)',
            "  halt",
            "end",
        ]
        watched: list[str] = []
        for wait in self.installation.waits:
            if wait.watched and wait.contact is not None:
                state = self.states[wait.state]
                watched.append(f"if get_standard_digital_in({wait.contact.number}) != {state}:")
                watched += [f'  stop_job("{self.message(wait.shown)}")', "end"]
        inside = [*(f"    {line}" for line in watched), "    sync()"]
        return [*lines, "thread watch_inputs():", "  while True:", *inside, "  end", "end"]

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write one program, or a file of functions for each part and a program that calls them."""
        head = [*self.heading(), *(f"# {line}" for line in _EXPLANATIONS), ""]
        functions = [[f"def {each.name}():", *indent(each.body), "end"] for each in routines]
        if self.fits_one_file:
            bodies = [line for function in functions for line in [*function, ""]]
            return {f"{self.name}.script": self.program([*head, *WATCHER, *self.faults(), "", *bodies, *main.body])}
        files = {f"{self.name}.script": self.program([*head, *main.body]) + f"{self.name}()\n"}
        for number, lines in enumerate([[*WATCHER, *self.faults()], *functions]):
            files[f"{self.name}_{number:02d}.script"] = join_lines(lines)
        return files

    def program(self, lines: Iterable[str]) -> str:
        """Write the function that the controller calls."""
        return join_lines([f"def {self.name}():", *indent(lines), "end"])


def _written_way(line: Line) -> float:
    """Length of a line in mm; 0 where its ends may be written as one place, which has no direction to watch."""
    return line.length_mm if line.length_mm > RESOLUTION_MM else 0.0


def _m(millimetres: float) -> str:
    """Write a length in metres, or a speed in m/s."""
    return short(millimetres / 1000.0, 6)


def _pose(pose: Pose) -> str:
    """Write a pose: metres, and axis times angle in radians."""
    numbers = [*map(_m, pose.position), *(short(value, 6) for value in rotation_vector(pose.quaternion))]
    return f"p[{','.join(numbers)}]"
