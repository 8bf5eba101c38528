"""Epson SPEL+: outputs by parallel processing, at whole percents of a move."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from programs.motion.installation import Channel, Installation
from programs.motion.lower import Capability, Lowered
from programs.motion.steps_of_robot import (
    Call,
    EndRepeat,
    Event,
    Line,
    Note,
    Pause,
    Reach,
    Repeat,
    Switch,
    UseBoard,
    UseTool,
)
from programs.pose import Pose
from programs.posts.writing.angles import fixed_xyz
from programs.posts.writing.chapters import Begin, Chapter, End, Part, divide, nest
from programs.posts.writing.heading import heading
from programs.posts.writing.routines import (
    Names,
    Placed,
    Slots,
    degrees_per_s,
    joint_words,
    number_slots,
    outputs_of,
    tell,
)
from programs.posts.writing.wording import cut, fixed, make_name, short

TITLE = "Epson SPEL+"
NOTES = (
    "For RC+ 7 and 8; outputs as !Dn; On n! with each move. Tool and Local are set at the start; AccelS and AccelR "
    "are assumed, put the robot's own there. Analog outputs need the option board (AIO_Out)."
)
LONGEST_LINE = 240
"""RC+ takes more; assumed."""
CAPABILITY = Capability(
    controller_class=2,
    says="percent",
    cycle_s=0.002,  # assumed
    step_percent=1.0,
    most_events=16,  # Dn may appear 16 times in one statement (SPEL+ reference for RC800)
    step_mm_s=0.1,
)
MOST_STEPS = 1500
"""Of a file. Assumed."""
_LONGEST_NAME = 32
_MOST_FRAMES = 15
"""Tools and locals are 1 to 15."""
_WORDS = {
    "main",
    "function",
    "fend",
    "tool",
    "local",
    "home",
    "move",
    "go",
    "wait",
    "call",
    "do",
    "loop",
    "start",
    "reset",
}


def render(lowered: Lowered, installation: Installation) -> dict[str, str]:
    """Write a program: one file, or a file for each function and one with main.

    Raises:
        ProgramError: there are more tools or places of the board than the controller has.
    """
    parts = divide(lowered.motion, MOST_STEPS)
    chapters = [part for part in parts if isinstance(part, Chapter)]
    names = Names(_LONGEST_NAME, set(_WORDS))
    writer = _Writer(installation, names, number_slots(lowered.motion, _MOST_FRAMES))
    names.reserve_calls(lowered.motion)
    functions = {writer.names.routine(chapter): _function(writer, chapter) for chapter in chapters}
    head = [*heading(lowered, installation, CAPABILITY, TITLE), *outputs_of(lowered.motion)]
    head.append("Units: mm, mm/s, deg/s; points in the board's CAD frame (Local), U V W about z, y', x''.")
    main = [*map(_comment, head), *_main(writer, parts)]
    name = make_name(lowered.motion.origin.board, _LONGEST_NAME, writer.names.taken)
    if sum(len(chapter.steps) for chapter in chapters) <= MOST_STEPS:
        return {f"{name}.prg": _text([*main, *(line for lines in functions.values() for line in lines)])}
    return {f"{name}.prg": _text(main)} | {f"{function}.prg": _text(lines) for function, lines in functions.items()}


@dataclass(slots=True)
class _Writer:
    """What holds at the end of what is written."""

    installation: Installation
    names: Names
    slots: Slots
    settings: dict[str, str] = field(default_factory=dict[str, str])

    def set(self, word: str, value: str) -> list[str]:
        """Set a speed if it is another."""
        if self.settings.get(word) == value:
            return []
        self.settings[word] = value
        return [f"{word} {value}"]

    def point(self, pose: Pose) -> str:
        """Write a point on the board."""
        return f"{_xy(pose)} /{self.slots.board}"


def _function(writer: _Writer, chapter: Chapter) -> list[str]:
    """Write a chapter; it sets what it needs, so that it runs alone."""
    writer.settings = {}
    writer.slots.use(chapter.tool)
    writer.slots.use(chapter.board)
    body = [f"Tool {writer.slots.tool}"] if chapter.tool is not None else []
    body += tell(chapter.steps, _comment, lambda placed: _statements(writer, placed))
    return [f"Function {writer.names.routine(chapter)}", *(f"  {line}" for line in body), "Fend", ""]


def _statements(writer: _Writer, placed: Placed) -> Iterable[str]:
    """Write one step."""
    match placed.step:
        case Line() as line:
            yield from _move(writer, line)
        case Reach() as reach:
            yield from _reach(writer, reach)
        case Pause() as pause:
            yield f"Wait {fixed(pause.duration_s, 3)}"
        case Switch() as switch:
            yield _output(switch.channel, switch.value)
        case UseTool() as tool:
            writer.slots.use(tool)
            yield f"Tool {writer.slots.tool}"
        case UseBoard() as board:
            writer.slots.use(board)
        case Call() as call:
            yield f"Call {writer.names.give('call', call.name, call.name)}"
            writer.settings = {}
        case Note() as note:
            yield _comment(note.text)
        case Repeat() | EndRepeat():
            raise AssertionError("loops are in main")


def _reach(writer: _Writer, reach: Reach) -> Iterator[str]:
    """Come to a pose: by joint values, then the rounding of the pose, or by the pose alone."""
    if reach.joints:
        yield f"Go JA({', '.join(joint_words(reach.joints, writer.installation, 4))})"
    yield f"{'Move' if reach.joints else 'Go'} {writer.point(reach.target)}"


def _move(writer: _Writer, line: Line) -> Iterator[str]:
    turns = line.turns_on_the_spot
    yield from writer.set("SpeedR", fixed(degrees_per_s(line), 1)) if turns else ()
    yield from () if turns else writer.set("SpeedS", fixed(line.speed_mm_s, 1))
    options = " ROT" * turns + " CP" * (line.blend_mm > 0.0)
    yield f"Move {writer.point(line.target)}{options}{_parallel(line.events)}"


def _parallel(events: tuple[Event, ...]) -> str:
    """Write outputs that change on the way; the controller takes them in the order of their percents."""
    said = [f"D{round(100.0 * event.share)}; {_output(event.channel, event.value)}" for event in events]
    return f" !{'; '.join(said)}!" if said else ""


def _output(channel: Channel, value: float) -> str:
    match channel.kind:
        case "digital":
            return f"{'On' if value > 0.5 else 'Off'} {channel.number}"
        case "group":
            return f"Out {channel.number}, {round(value)}"
        case "analog":
            return f"AIO_Out {channel.number}, {short(value, 6)}"


def _main(writer: _Writer, parts: tuple[Part, ...]) -> list[str]:
    """Write what sets the frames and calls the functions."""
    loops = sum(isinstance(part, Repeat) for part in parts)
    body = [f"Integer nLoop{number}" for number in range(1, loops + 1)]
    body += ["Motor On", "Power High", "Speed 10", "Accel 20, 20"]
    body += ["SpeedS 100", "AccelS 2000, 2000", "SpeedR 90", "AccelR 1000, 1000"]
    body += [
        f"TLSet {slot}, {_xy(tool.T_flange_tcp)} ' {cut(tool.name, 40)}"
        for slot, tool in ((slot, writer.installation.tool(number)) for number, slot in writer.slots.tools.items())
    ]
    body += [
        f"Local {number}, {_xy(pose)} ' {cut(placement or 'board as mounted', 40)}"
        for placement, (number, pose) in writer.slots.boards.items()
    ]
    home = []
    if writer.installation.home:
        home = [f"Go JA({', '.join(joint_words(writer.installation.home, writer.installation, 4))}) ' home"]
    calls = list(_calls(writer, parts))
    return ["Function main", *(f"  {line}" for line in [*body, *home, *calls, *home]), "Fend", ""]


def _calls(writer: _Writer, parts: tuple[Part, ...]) -> Iterator[str]:
    for indent, part in nest(parts):
        match part:
            case Chapter():
                yield f"{indent}Call {writer.names.routine(part)}"
            case Begin(number, loop):
                said = f"until {cut(loop.key, 40)} >= {short(loop.least, 6)}, {loop.count} times at most"
                yield f"{indent}{_comment(said)}"
                yield from (f"{indent}nLoop{number} = 0", f"{indent}Do", f"{indent}  nLoop{number} = nLoop{number} + 1")
            case End(number, loop):
                yield f"{indent}Loop While {_goes_on(loop, number)}"


def _goes_on(loop: Repeat, number: int) -> str:
    goes_on = f"nLoop{number} < {loop.count}"
    if loop.sensor is None:
        return goes_on
    reading = f"{short(loop.sensor.scale, 6)} * AIO_In({loop.sensor.number}) + {short(loop.sensor.offset, 6)}"
    return f"{goes_on} And {reading} < {short(loop.least, 6)}"


def _xy(pose: Pose) -> str:
    """Write a pose: U, V, W turn about z, y', x''."""
    w, v, u = fixed_xyz(pose.quaternion)
    words = [*(fixed(value, 3) for value in pose.position), *(fixed(value, 4) for value in (u, v, w))]
    return f"XY({', '.join(words)})"


def _comment(text: str) -> str:
    return f"' {cut(text, 120)}"


def _text(lines: Iterable[str]) -> str:
    return "".join(f"{line}\n" for line in lines)
