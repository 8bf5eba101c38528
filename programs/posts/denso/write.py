"""Denso PacScript: outputs where a move has done so many percent, by ``Next`` and ``Arrive``."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from programs.motion.analog import Counting
from programs.motion.installation import Channel, Installation
from programs.motion.lower import Capability, Lowered
from programs.motion.steps_of_robot import Call, EndRepeat, Line, Note, Pause, Reach, Repeat, Switch, UseBoard, UseTool
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

TITLE = "Denso PacScript"
NOTES = (
    "For RC8 and newer; outputs by Next and Arrive. Speeds are percents: put 100 divided by the arm's greatest speeds "
    "into PER_MM_S and PER_DEG_S, and run at ExtSpeed 100. Corners are passed from 1 mm before them or more. "
    "Groups are IOB, analog channels IOW, 10000 at full scale."
)
LONGEST_LINE = 200
"""Assumed."""
ANALOG = Counting(full=10_000.0, step=1.0)
"""Words of 16 bits; that they count 10,000 at full scale is assumed: the module and its configuration decide."""
CAPABILITY = Capability(
    controller_class=2,
    says="percent",
    cycle_s=0.008,  # assumed: Arrive looks at the encoders, and a task runs every few milliseconds
    step_percent=1.0,
    most_events=8,  # assumed
    step_mm_s=0.1,
    analog=ANALOG,
)
MOST_STEPS = 1000
"""Of a program. Assumed."""
_LONGEST_NAME = 32
_MOST_FRAMES = 63
"""Tools and works are 1 to 63."""
_WORDS = {
    "main",
    "sub",
    "end",
    "move",
    "tool",
    "work",
    "call",
    "next",
    "arrive",
    "speed",
    "home",
    "loop",
    "set",
    "reset",
}
_SPEEDS = (
    "#Define PER_MM_S 0.1 ' percent of Speed for 1 mm/s, assumed: 100 / greatest CP speed of this arm",
    "#Define PER_DEG_S 0.2 ' percent of Speed for 1 deg/s, assumed: 100 / greatest turn of this arm",
)


def render(lowered: Lowered, installation: Installation) -> dict[str, str]:
    """Write a program: one file, or a file for each subprogram and one that calls them.

    Raises:
        ProgramError: there are more tools or places of the board than the controller has.
    """
    parts = divide(lowered.motion, MOST_STEPS)
    chapters = [part for part in parts if isinstance(part, Chapter)]
    name = make_name(lowered.motion.origin.board, _LONGEST_NAME, _WORDS)
    names = Names(_LONGEST_NAME, {*_WORDS, name.lower()})
    writer = _Writer(installation, names, number_slots(lowered.motion, _MOST_FRAMES))
    names.reserve_calls(lowered.motion)
    bodies = {names.routine(chapter): _body(writer, chapter) for chapter in chapters}
    head = [*heading(lowered, installation, CAPABILITY, TITLE), *outputs_of(lowered.motion)]
    head.append("Units: mm, degrees; positions in the board's CAD frame (Work), RX RY RZ about the fixed x, y, z.")
    top = [f'\'!TITLE "{name}"', *map(_comment, head), *_SPEEDS, "", *_sub("Main", _main(writer, parts))]
    if sum(len(chapter.steps) for chapter in chapters) <= MOST_STEPS:
        return {f"{name}.pcs": _text([*top, *(line for sub, body in bodies.items() for line in _sub(sub, body))])}
    files = {f"{name}.pcs": _text(top)}
    for sub, body in bodies.items():
        files[f"{sub}.pcs"] = _text([f'\'!TITLE "{sub}"', *_SPEEDS, "", *_sub("Main", body)])
    return files


@dataclass(slots=True)
class _Writer:
    """What holds at the end of what is written."""

    installation: Installation
    names: Names
    slots: Slots


def _body(writer: _Writer, chapter: Chapter) -> list[str]:
    """Write a chapter; it selects its frames, so that it runs alone."""
    writer.slots.use(chapter.tool)
    writer.slots.use(chapter.board)
    lines = [f"ChangeTool {writer.slots.tool}"] if chapter.tool is not None else []
    lines += [f"ChangeWork {writer.slots.board}"] if chapter.board is not None else []
    return [*lines, *tell(chapter.steps, _comment, lambda placed: _statements(writer, placed))]


def _statements(writer: _Writer, placed: Placed) -> Iterable[str]:
    """Write one step."""
    match placed.step:
        case Line() as line:
            yield from _move(line, placed)
        case Reach() as reach:
            yield from _reach(writer, reach)
        case Pause() as pause:
            yield f"Delay {short(1e3 * pause.duration_s, 0)}"
        case Switch() as switch:
            yield _output(switch.channel, switch.value)
        case UseTool() as tool:
            writer.slots.use(tool)
            yield f"ChangeTool {writer.slots.tool}"
        case UseBoard() as board:
            writer.slots.use(board)
            yield f"ChangeWork {writer.slots.board}"
        case Call() as call:
            yield f"Call {writer.names.give('call', call.name, call.name)}"
        case Note() as note:
            yield _comment(note.text)
        case Repeat() | EndRepeat():
            raise AssertionError("loops are in main")


def _reach(writer: _Writer, reach: Reach) -> Iterator[str]:
    """Come to a pose: by joint values, then the rounding of the pose, or by the pose alone."""
    if reach.joints:
        yield f"Move P, @0 J({', '.join(joint_words(reach.joints, writer.installation, 4))}), Speed = 10"
    yield f"Move {'L' if reach.joints else 'P'}, @0 {_position(reach.target)}, Speed = 10"


def _move(line: Line, placed: Placed) -> Iterator[str]:
    """Write a line; ``Next`` lets the program go on while the robot moves, and wait for the percents of its outputs."""
    passing = "@0" if line.blend_mm == 0.0 else f"@{max(int(line.blend_mm), 1)}"
    speed = f"{fixed(line.speed_mm_s, 1)} * PER_MM_S"
    if line.turns_on_the_spot:
        speed = f"{fixed(degrees_per_s(line), 1)} * PER_DEG_S"
    goes_on = ", Next" if placed.begins or placed.inside else ""
    yield f"Move L, {passing} {_position(line.target)}, Speed = {speed}{goes_on}"
    yield from (_output(event.channel, event.value) for event in placed.begins)
    for event in placed.inside:
        yield f"Arrive {round(100.0 * event.share)}"
        yield _output(event.channel, event.value)
    if goes_on and line.blend_mm == 0.0:
        yield "WaitMotion 4, 0"  # until 0 ms before its end: what follows is done at rest
    yield from (_output(event.channel, event.value) for event in placed.ends)


def _output(channel: Channel, value: float) -> str:
    match channel.kind:
        case "digital":
            return f"{'Set' if value > 0.5 else 'Reset'} IO[{channel.number}]"
        case "group":
            return f"IOB[{channel.number}] = {round(value)}"
        case "analog":
            return f"IOW[{channel.number}] = {round(ANALOG.count(channel, value))}"


def _main(writer: _Writer, parts: tuple[Part, ...]) -> list[str]:
    """Write what sets the frames and calls the subprograms."""
    loops = sum(isinstance(part, Repeat) for part in parts)
    lines = [f"Dim nLoop{number} As Integer" for number in range(1, loops + 1)]
    lines += ["TakeArm Keep = 0", "Speed 100", "Accel 100, 100"]
    for number, slot in writer.slots.tools.items():
        tool = writer.installation.tool(number)
        lines.append(f"Tool {slot}, {_frame(tool.T_flange_tcp)} ' {cut(tool.name, 40)}")
    for placement, (slot, pose) in writer.slots.boards.items():
        lines.append(f"Work {slot}, {_frame(pose)} ' {cut(placement or 'board as mounted', 40)}")
    home: list[str] = []
    if writer.installation.home:
        words = ", ".join(joint_words(writer.installation.home, writer.installation, 4))
        home = [f"Move P, @0 J({words}), Speed = 10 ' home"]
    return [*lines, *home, *_calls(writer, parts), *home, "GiveArm"]


def _calls(writer: _Writer, parts: tuple[Part, ...]) -> Iterator[str]:
    for indent, part in nest(parts):
        match part:
            case Chapter():
                yield f"{indent}Call {writer.names.routine(part)}"
            case Begin(number, loop):
                said = f"until {cut(loop.key, 40)} >= {short(loop.least, 6)}, {loop.count} times at most"
                yield f"{indent}{_comment(said)}"
                yield f"{indent}For nLoop{number} = 1 To {loop.count}"
            case End(number, loop):
                if loop.sensor is not None:
                    scale, offset = ANALOG.reading(loop.sensor)
                    reading = f"{short(scale, 9)} * IOW[{loop.sensor.number}] + {short(offset, 9)}"
                    yield f"{indent}  If {reading} >= {short(loop.least, 6)} Then Exit For"
                yield f"{indent}Next nLoop{number}"


def _frame(pose: Pose) -> str:
    """Write a pose without an arm's figure."""
    words = [*(fixed(value, 3) for value in pose.position), *(fixed(value, 4) for value in fixed_xyz(pose.quaternion))]
    return f"P({', '.join(words)})"


def _position(pose: Pose) -> str:
    """Write a pose of the arm; figure -1 keeps the one it has."""
    return f"{_frame(pose)[:-1]}, -1)"


def _sub(name: str, body: list[str]) -> list[str]:
    return [f"Sub {name}", *(f"  {line}" for line in body), "End Sub", ""]


def _comment(text: str) -> str:
    return f"' {cut(text, 120)}"


def _text(lines: Iterable[str]) -> str:
    return "".join(f"{line}\n" for line in lines)
