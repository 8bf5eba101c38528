"""URScript: a thread compares the way done with the places of the outputs, 500 times a second."""

from collections.abc import Iterable
from dataclasses import dataclass, field

from programs.motion.installation import Installation
from programs.motion.lower import Capability, Lowered
from programs.motion.steps_of_robot import (
    UNTOLD_MM,
    Call,
    EndRepeat,
    Line,
    Note,
    Pause,
    Reach,
    Repeat,
    Step,
    Switch,
    UseBoard,
    UseTool,
)
from programs.pose import Pose
from programs.posts.ur.text import ANALOG, WATCHER, joints_text, metres, output, pose_text, rest_blend
from programs.posts.writing.chapters import Begin, Chapter, End, Part, divide, nest
from programs.posts.writing.corners import follow
from programs.posts.writing.heading import heading
from programs.posts.writing.routines import Names, tell_steps
from programs.posts.writing.wording import cut, fixed, make_name, short

TITLE = "URScript"
NOTES = (
    "For PolyScope 5; a thread watches the path. Analog outputs count from 0 to 1, inputs in volts or amperes; "
    "group outputs are integer output registers. Several files: one Script node for each, the numbered ones before the "
    "main one."
)
LONGEST_LINE = 200
CAPABILITY = Capability(
    controller_class=4,
    says="distance",
    cycle_s=0.002,  # the thread runs once in each cycle of the controller, 500 Hz; the e-Series
    references=("start",),
    step_mm=0.001,
    step_mm_s=0.1,
    most_events=8,
    analog=ANALOG,
)
MOST_STEPS = 1500
"""Of a script file. Assumed; nobody states a limit, and larger scripts take long to load."""
_LONGEST_NAME = 60
_ACCELERATION, _REACH_SPEED = "a=1.2", "a=0.5, v=0.25"
"""m/s2 and rad/s2; 1.2 is what movel takes if nothing is said."""
_RESERVED = {"arm", "fire", "settle", "set_out", "watch", "board", "main", "end", "def", "thread", "global", "local"}


def render(lowered: Lowered, installation: Installation) -> dict[str, str]:
    """Write a script: one program, or a file of functions for each part and a program that calls them."""
    parts = divide(lowered.motion, MOST_STEPS)
    chapters = [part for part in parts if isinstance(part, Chapter)]
    name = make_name(lowered.motion.origin.board, _LONGEST_NAME - 5, _RESERVED)
    names = Names(_LONGEST_NAME, {name.lower(), *_RESERVED})
    names.reserve_calls(lowered.motion)
    writer = _Writer(installation, names, follow(lowered.motion.steps))
    routines = [_routine(writer, chapter) for chapter in chapters]
    head = [f"# {cut(line, LONGEST_LINE - 4)}" for line in heading(lowered, installation, CAPABILITY, TITLE)]
    head += [f"# {line}" for line in _EXPLANATIONS]
    main = _main(writer, parts)
    if sum(len(chapter.steps) for chapter in chapters) <= MOST_STEPS:
        bodies = [line for routine in routines for line in [*routine, ""]]
        return {f"{name}.script": _program(name, [*head, "", *WATCHER, "", *bodies, *main])}
    files = {f"{name}.script": _program(name, [*head, "", *main])}
    files[f"{name}_00.script"] = _text(WATCHER)
    for number, routine in enumerate(routines, start=1):
        files[f"{name}_{number:02d}.script"] = _text(routine)
    return files


_EXPLANATIONS = (
    "Units: m, m/s, s, rad; poses are x, y, z and axis times angle, in the board's CAD frame: pose_trans(board, ...).",
    "movel rather than movep: it blends with the moves before and after, reaches the same speed on a straight line,",
    "and takes a time where the tool only turns. The speed slider has to stand at 100 %: outputs are at places.",
)


@dataclass(slots=True)
class _Writer:
    """The names given so far."""

    installation: Installation
    names: Names
    following: dict[int, Line]
    """The line that goes on from one that is passed, by its identity."""
    poses: dict[str, Pose] = field(default_factory=dict[str, Pose])

    def declare(self, kind: str, key: object, wanted: str, pose: Pose) -> str:
        """Name the pose of a tool or a board, a global variable."""
        name = self.names.give(kind, key, wanted)
        self.poses[name] = pose
        return name


def _routine(writer: _Writer, chapter: Chapter) -> list[str]:
    """Write a chapter as a function; it sets its frames, so that it runs alone."""
    body: list[str] = []
    for step in (chapter.board, chapter.tool):
        body += _instructions(writer, step) if step is not None else []
    body += tell_steps(chapter.steps, lambda maker: f"# {cut(maker, 100)}", lambda step: _instructions(writer, step))
    return [f"def {_routine_name(writer, chapter)}():", *(f"  {line}" for line in body), "end"]


def _routine_name(writer: _Writer, chapter: Chapter) -> str:
    return writer.names.give("routine", chapter.number, f"{make_name(chapter.title, 20)}_{chapter.number:02d}")


def _instructions(writer: _Writer, step: Step) -> Iterable[str]:
    """Write one step."""
    match step:
        case Line():
            yield from _line(writer, step)
        case Reach():
            target = f"pose_trans(board, {pose_text(step.target)})"
            ways = [f"movej({joints_text(step.joints)}, {_REACH_SPEED})"] if step.joints else []
            yield from [*ways, f"{'movel' if step.joints else 'movej'}({target}, {_REACH_SPEED})"]
        case Pause():
            yield f"sleep({fixed(step.duration_s, 3)})"
        case Switch():
            yield f"set_out({output(step.channel, step.value)})"
        case UseTool():
            tool = writer.installation.tool(step.number)
            name = writer.declare("tool", step.number, f"tcp_{tool.name}", tool.T_flange_tcp)
            yield f"set_tcp({name})"
            yield f"set_payload({short(tool.mass_kg, 3)}, [0,0,{metres(0.5 * tool.T_flange_tcp.position[2])}])"
        case UseBoard():
            wanted = f"board_{step.placement or 'as_mounted'}"
            yield f"board = {writer.declare('board', step.placement, wanted, step.T_base_board)}"
        case Call():
            yield f"{writer.names.give('call', step.name, step.name)}()"
        case Note():
            yield f"# {cut(step.text, 100)}"
        case Repeat() | EndRepeat():
            raise AssertionError("loops are in the main program")


def _line(writer: _Writer, line: Line) -> Iterable[str]:
    """Arm the outputs, move, and see to it that none is left at a stop."""
    way_mm = _told_way(line)
    ends = f"{pose_text(line.start)}, {pose_text(line.target)}"
    late = [event for event in line.events if not way_mm and event.share > 0.5]
    for event in line.events:
        if way_mm:
            yield f"arm({ends}, {metres(event.offset_mm)}, {output(event.channel, event.value)})"
        elif event not in late:
            yield f"set_out({output(event.channel, event.value)})"
    after = writer.following.get(id(line))
    blend = f"r={metres(rest_blend(line.blend_mm, (way_mm, _told_way(after) if after is not None else 0.0)))}"
    turns = line.turns_on_the_spot
    pace = f"t={fixed(max(line.duration_s, 0.01), 3)}" if turns else f"v={metres(line.speed_mm_s)}"
    yield f"movel(pose_trans(board, {pose_text(line.target)}), {_ACCELERATION}, {pace}, {blend})"
    yield from (f"set_out({output(event.channel, event.value)})" for event in late)
    if line.events and line.blend_mm == 0.0 and way_mm:
        yield "settle()"


def _told_way(line: Line) -> float:
    """Length of a line in mm; 0 where its ends may be written as one place, which has no direction to watch."""
    return line.length_mm if line.length_mm > UNTOLD_MM else 0.0


def _main(writer: _Writer, parts: tuple[Part, ...]) -> list[str]:
    """Write what the program does."""
    home = writer.installation.home
    go_home = [f"movej({joints_text(home)}, {_REACH_SPEED})"] if home else []
    poses = [f"global {name} = {pose_text(pose)}" for name, pose in writer.poses.items()]
    body = [*poses, "run_watch = run watch()", *go_home]
    for indent, part in nest(parts):
        match part:
            case Chapter():
                body.append(f"{indent}{_routine_name(writer, part)}()")
            case Begin(number, loop):
                body += [f"{indent}{line}" for line in _loop(loop, f"n_loop_{number}")]
            case End():
                body.append(f"{indent}end")
    return [*body, *go_home, "kill run_watch"]


def _loop(step: Repeat, counter: str) -> list[str]:
    looks = ""
    if step.sensor is not None:
        scale, offset = ANALOG.reading(step.sensor)
        reading = f"{short(scale, 9)}*get_standard_analog_in({step.sensor.number})+{short(offset, 9)}"
        looks = f" and ({counter} == 0 or {reading} < {short(step.least, 6)})"
    return [
        f"# until {cut(step.key, 40)} >= {short(step.least, 6)}, {step.count} times at most",
        f"{counter} = 0",
        f"while {counter} < {step.count}{looks}:",
        f"  {counter} = {counter} + 1",
    ]


def _program(name: str, lines: Iterable[str]) -> str:
    inside = "".join(f"  {line}\n" if line else "\n" for line in lines)
    return f"def {name}():\n{inside}end\n"


def _text(lines: Iterable[str]) -> str:
    return "".join(f"{line}\n" for line in lines)
