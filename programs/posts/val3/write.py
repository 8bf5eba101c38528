"""Staubli VAL3: outputs where a move begins, set by a synchronous task that watches which move is being executed."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from programs.motion.installation import Channel, Installation
from programs.motion.lower import Capability, Lowered
from programs.motion.steps_of_robot import (
    Call,
    EndRepeat,
    Line,
    MotionProgram,
    Note,
    Pause,
    Reach,
    Repeat,
    Switch,
    UseBoard,
    UseTool,
)
from programs.pose import Pose
from programs.posts.val3 import text as val3_text
from programs.posts.val3.data import Data, signal_name, variables
from programs.posts.writing.chapters import Begin, Chapter, End, Part, divide, nest
from programs.posts.writing.heading import heading
from programs.posts.writing.routines import (
    Names,
    Placed,
    degrees_per_s,
    outputs_of,
    tell,
)
from programs.posts.writing.wording import cut, fixed, make_name, short

TITLE = "Staubli VAL3"
NOTES = (
    "A project for CS8 and CS9, VAL3 s7 and newer: put the files into a folder of the project's name and link the "
    "variables do, go, ao and ai. A task of 4 ms sets outputs on the path, as direct ones run ahead of the motion."
)
LONGEST_LINE = 200
"""Assumed."""
CAPABILITY = Capability(controller_class=4, says="boundary", cycle_s=val3_text.PERIOD_S, step_mm_s=0.1)
MOST_STEPS = 1500
"""Of a program. Assumed; an array takes 9,999 points."""
_LONGEST_NAME = 15
"""Of programs and variables in the oldest controllers that are about. Assumed."""
_WORDS = {"start", "stop", "watch", "trigger", "setoutput", "begin", "end", "call", "return", "wait", "open", "close"}
_FASTEST = 9999.0


def render(lowered: Lowered, installation: Installation) -> dict[str, str]:
    """Write a project: its file, the data, start and stop, a program for each part, and those of the task."""
    motion = lowered.motion
    parts = divide(motion, MOST_STEPS)
    name = make_name(motion.origin.board, _LONGEST_NAME, _WORDS)
    data = Data(channels=_channels(motion))
    writer = _Writer(installation, Names(_LONGEST_NAME, set(_WORDS)), data)
    writer.names.reserve_calls(motion)
    bodies = {writer.names.routine(part): _body(writer, part) for part in parts if isinstance(part, Chapter)}
    head = [*heading(lowered, installation, CAPABILITY, TITLE), *outputs_of(motion)]
    head.append("Units: mm, mm/s, deg/s; points in the board's CAD frame, rx ry rz about x, y', z''")
    start = [*map(_comment, head), *_start(writer, parts)]
    parameters = ("x_nMove", "x_nOutput", "x_nValue")
    programs = {
        "start": val3_text.code("start", start),
        "stop": val3_text.code("stop", ['taskKill("watch")']),
        **{routine: val3_text.code(routine, body) for routine, body in bodies.items()},
        "watch": val3_text.code("watch", val3_text.WATCH),
        "trigger": val3_text.code("trigger", val3_text.TRIGGER, parameters),
        "setOutput": val3_text.code("setOutput", _setters(data.channels), parameters[1:]),
    }
    return {
        f"{name}.pjx": val3_text.project(list(programs), name),
        f"{name}.dtx": val3_text.database(variables(data, motion, installation)),
        **{f"{program}.pgx": text for program, text in programs.items()},
    }


@dataclass(slots=True)
class _Writer:
    """The names and data given so far, and what holds at the end of what is written."""

    installation: Installation
    names: Names
    data: Data
    tool: str = "flange"
    board: str = "world"
    chapter: int = 0
    moving: bool = False
    """Whether moves may be waiting: what is done at rest has to wait for them."""

    def use(self, step: UseTool | UseBoard | None) -> None:
        """Use another tool or board from now on."""
        if isinstance(step, UseTool):
            tool = self.installation.tool(step.number)
            self.tool = self.names.give("tool", step.number, f"t_{tool.name}")
            self.data.tools[self.tool] = tool.T_flange_tcp
        elif isinstance(step, UseBoard):
            self.board = self.names.give("board", step.placement, f"f_{step.placement or 'board'}")
            self.data.boards[self.board] = step.T_base_board

    def point(self, pose: Pose) -> str:
        """Put a point into the chapter's array for the board in use."""
        array = self.names.give("points", (self.chapter, self.board), f"p_{self.chapter:02d}")
        return self.data.point(array, pose, self.board)

    def movement(self, line: Line) -> str:
        """Name the speed and the zone of a line."""
        turns = line.turns_on_the_spot
        rate = degrees_per_s(line) if turns else line.speed_mm_s
        zone = f"z{fixed(line.blend_mm, 2)}" if line.blend_mm else "fine"
        said = f"{'r' if turns else 'm'}{short(rate, 1)}_{zone}".replace(".", "p")
        name = self.names.give("movement", said, said)
        speeds = (_FASTEST, rate) if turns else (rate, _FASTEST)
        self.data.movements[name] = val3_text.movement(*speeds, line.blend_mm)
        return name

    def rest(self) -> Iterator[str]:
        """Wait until the robot stands."""
        if self.moving:
            yield "waitEndMove()"
        self.moving = False


def _channels(motion: MotionProgram) -> list[Channel]:
    """Number the outputs that change on the path."""
    used = {event.channel: None for line in motion.lines for event in line.events}
    return sorted(used, key=lambda channel: (channel.kind, channel.number))


def _body(writer: _Writer, chapter: Chapter) -> list[str]:
    """Write a chapter; it waits at its end, so that what follows is done at rest."""
    writer.chapter = chapter.number
    writer.use(chapter.tool)
    writer.use(chapter.board)
    return [*tell(chapter.steps, _comment, lambda placed: _statements(writer, placed)), *writer.rest()]


def _statements(writer: _Writer, placed: Placed) -> Iterable[str]:
    """Write one step."""
    match placed.step:
        case Line() as line:
            yield from _move(writer, line, placed)
        case Reach() as reach:
            yield from _reach(writer, reach)
        case Pause() as pause:
            yield from (*writer.rest(), f"delay({fixed(pause.duration_s, 3)})")
        case Switch() as switch:
            yield from (*writer.rest(), _output(switch.channel, switch.value))
        case UseTool() | UseBoard() as frame:
            writer.use(frame)
        case Call() as call:
            yield from (*writer.rest(), f"call {writer.names.give('call', call.name, call.name)}()")
        case Note() as note:
            yield _comment(note.text)
        case Repeat() | EndRepeat():
            raise AssertionError("loops are in start")


def _reach(writer: _Writer, reach: Reach) -> Iterator[str]:
    """Come to a pose: by joint values, then the rounding of the pose, or by the pose alone."""
    if reach.joints:
        yield f"movej({writer.data.joint(reach.joints, writer.installation)},{writer.tool},mReach)"
    yield f"{'movel' if reach.joints else 'movej'}({writer.point(reach.target)},{writer.tool},mReach)"
    writer.moving = True


def _move(writer: _Writer, line: Line, placed: Placed) -> Iterator[str]:
    """Write a line; its outputs go to the task with the number of the move."""
    move = f"movel({writer.point(line.target)},{writer.tool},{writer.movement(line)})"
    writer.moving = True
    if not placed.begins:
        yield move
    else:
        yield f"nId={move}"
    for event in placed.begins:
        yield f"call trigger(nId,{writer.data.channels.index(event.channel)},{short(event.value, 6)})"
    if placed.ends:
        yield from writer.rest()
    yield from (_output(event.channel, event.value) for event in placed.ends)


def _output(channel: Channel, value: float) -> str:
    """Set an output while the robot stands."""
    name = signal_name(channel)
    match channel.kind:
        case "digital":
            return f"{name}={'true' if value > 0.5 else 'false'}"
        case "group":
            return f"dioSet({name},{round(value)})"
        case "analog":
            return f"aioSet({name},{short(value, 6)})"


def _setters(channels: Sequence[Channel]) -> Iterator[str]:
    """Set the output of a number."""
    for number, channel in enumerate(channels):
        name = signal_name(channel)
        yield f"if x_nOutput=={number}"
        match channel.kind:
            case "digital":
                yield f"  {name}=x_nValue!=0"
            case "group":
                yield f"  dioSet({name},x_nValue)"
            case "analog":
                yield f"  aioSet({name},x_nValue)"
        yield "endIf"


def _start(writer: _Writer, parts: tuple[Part, ...]) -> Iterator[str]:
    """Write what begins the task and calls the programs."""
    yield from ("nHead=0", "nTail=0")
    yield f'taskCreateSync "watch",{short(val3_text.PERIOD_S, 3)},bOverrun,watch()'
    home = ["movej(jHome,flange,mReach)", "waitEndMove()"] if writer.installation.home else []
    yield from home
    for indent, part in nest(parts):
        match part:
            case Chapter():
                yield f"{indent}call {writer.names.routine(part)}()"
            case Begin(number, loop):
                said = f"until {cut(loop.key, 40)} >= {short(loop.least, 6)}, {loop.count} times at most"
                yield from (f"{indent}{_comment(said)}", f"{indent}nLoop{number}=0", f"{indent}do")
                yield f"{indent}  nLoop{number}=nLoop{number}+1"
            case End(number, loop):
                yield f"{indent}until {_is_done(loop, number)}"
    yield from (*home, 'taskKill("watch")')


def _is_done(loop: Repeat, number: int) -> str:
    done = f"nLoop{number}>={loop.count}"
    if loop.sensor is None:
        return done
    reading = f"{short(loop.sensor.scale, 6)}*aioGet(ai{loop.sensor.number})+{short(loop.sensor.offset, 6)}"
    return f"{done} or {reading}>={short(loop.least, 6)}"


def _comment(text: str) -> str:
    return f"// {cut(text, 120)}"
