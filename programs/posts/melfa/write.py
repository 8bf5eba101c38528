"""Mitsubishi MELFA-BASIC V and VI: outputs where a move begins, by ``Wth``."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from programs.motion.analog import Counting
from programs.motion.installation import Channel, Installation
from programs.motion.lower import Capability, Lowered
from programs.motion.steps_of_robot import Call, EndRepeat, Line, Note, Pause, Reach, Repeat, Switch, UseBoard, UseTool
from programs.pose import Pose, inverse
from programs.posts.writing.angles import fixed_xyz
from programs.posts.writing.chapters import Begin, Chapter, End, Part, divide, nest
from programs.posts.writing.heading import heading
from programs.posts.writing.routines import Placed, joint_words, outputs_of, tell
from programs.posts.writing.wording import cut, fixed, make_name, short

TITLE = "Mitsubishi MELFA-BASIC"
NOTES = (
    "For CR750, CR800 and the like; outputs by Wth at the beginning of a move. Base is the robot seen from the board; "
    "the controller keeps Base and Tool, so main ends with the defaults. Groups are M_Outb, analog channels M_Outw, "
    "10000 at full scale. Where joints are not known structure flag 7 is assumed."
)
LONGEST_LINE = 127
"""Characters of a step (manual of CR1D)."""
ANALOG = Counting(full=10_000.0, step=1.0)
"""Words of 16 bits; that they count 10,000 at full scale is assumed: the module and its configuration decide."""
CAPABILITY = Capability(
    controller_class=3,
    says="boundary",
    cycle_s=0.0071,  # assumed: the motion cycle of CR750; CR800 has half of it
    step_mm_s=0.1,
    analog=ANALOG,
)
MOST_STEPS = 2000
"""Of a program: below 8,000 of the 32,767 step numbers. Assumed."""
_LONGEST_NAME = 12
"""Of a program, in capital letters and digits."""


def render(lowered: Lowered, installation: Installation) -> dict[str, str]:
    """Write a program: a file for each part, and the one that calls them."""
    parts = divide(lowered.motion, MOST_STEPS)
    names = _Names()
    name = names.give("main", 0, lowered.motion.origin.board)
    for step in lowered.motion.steps:
        if isinstance(step, Call):
            names.give("call", step.name, step.name)  # before our own programs take names
    head = [*heading(lowered, installation, CAPABILITY, TITLE), *outputs_of(lowered.motion)]
    head.append("Units: mm, mm/s, degrees; positions in the board's CAD frame, A B C about the fixed x, y, z")
    files = {f"{name}.prg": _main(head, parts, names, installation)}
    for part in parts:
        if isinstance(part, Chapter):
            files[f"{names.chapter(part)}.prg"] = _program(part, names, installation)
    return files


@dataclass(slots=True)
class _Names:
    """The names of programs given so far."""

    given: dict[tuple[str, object], str] = field(default_factory=dict[tuple[str, object], str])

    def give(self, kind: str, key: object, wanted: str) -> str:
        """Give a program the same name each time, unlike all others."""
        if (kind, key) not in self.given:
            plain = make_name(wanted, 200).replace("_", "").upper()
            chosen, number = plain[:_LONGEST_NAME], 1
            while chosen in self.given.values():
                number += 1
                chosen = plain[: _LONGEST_NAME - len(f"X{number}")] + f"X{number}"
            self.given[kind, key] = chosen
        return self.given[kind, key]

    def chapter(self, chapter: Chapter) -> str:
        """Name the program of a chapter."""
        title = make_name(chapter.title, 200).replace("_", "")[: _LONGEST_NAME - 3]
        return self.give("chapter", chapter.number, f"{title}{chapter.number:02d}")


@dataclass(slots=True)
class _Writer:
    """A program: its positions, and what holds at the end of what is written."""

    names: _Names
    installation: Installation
    positions: dict[str, str] = field(default_factory=dict[str, str])
    """By the variable; the text after the equals sign."""
    settings: dict[str, str] = field(default_factory=dict[str, str])
    points: int = 0

    def set(self, word: str, value: str) -> list[str]:
        """Set a speed or the way of passing if it is another."""
        if self.settings.get(word) == value:
            return []
        self.settings[word] = value
        return [f"{word} {value}"]

    def point(self, pose: Pose) -> str:
        """Name a position."""
        self.points += 1
        self.positions[f"P{self.points}"] = f"{_components(pose)}(7,0)"
        return f"P{self.points}"

    def joints(self, joints: tuple[float, ...]) -> str:
        """Name a joint position."""
        self.points += 1
        words = ",".join(joint_words(joints, self.installation, 4))
        self.positions[f"J{self.points}"] = f"({words})"
        return f"J{self.points}"

    def frame(self, step: UseTool | UseBoard) -> str:
        """Use another tool or board from now on; the robot's base is given as seen from the board."""
        if isinstance(step, UseTool):
            name, pose = f"PTL{step.number}", self.installation.tool(step.number).T_flange_tcp
        else:
            places = ["", *self.installation.placements]
            number = places.index(step.placement) if step.placement in places else len(places)
            name, pose = f"PBS{number}", inverse(step.T_base_board)
        self.positions[name] = f"{_components(pose)}(0,0)"
        return f"{'Tool' if isinstance(step, UseTool) else 'Base'} {name}"


def _program(chapter: Chapter, names: _Names, installation: Installation) -> str:
    """Write a chapter; it sets what it needs, so that it runs alone."""
    writer = _Writer(names, installation)
    frames = [writer.frame(step) for step in (chapter.tool, chapter.board) if step is not None]
    body = tell(chapter.steps, _comment, lambda placed: _statements(writer, placed))
    return _text([*frames, *body, "End"], writer)


def _statements(writer: _Writer, placed: Placed) -> Iterable[str]:
    """Write one step."""
    match placed.step:
        case Line() as line:
            yield from _move(writer, line, placed)
        case Reach() as reach:
            yield from _reach(writer, reach)
        case Pause() as pause:
            yield f"Dly {fixed(pause.duration_s, 3)}"
        case Switch() as switch:
            yield _output(switch.channel, switch.value)
        case UseTool() | UseBoard() as frame:
            yield writer.frame(frame)
        case Call() as call:
            yield f'CallP "{writer.names.give("call", call.name, call.name)}"'
            writer.settings = {}
        case Note() as note:
            yield _comment(note.text)
        case Repeat() | EndRepeat():
            raise AssertionError("loops are in main")


def _reach(writer: _Writer, reach: Reach) -> Iterator[str]:
    """Come to a pose: by joint values, then the rounding of the pose, or by the pose alone."""
    yield from writer.set("Cnt", "0")
    if reach.joints:
        yield f"Mov {writer.joints(reach.joints)}"
    yield f"{'Mvs' if reach.joints else 'Mov'} {writer.point(reach.target)}"


def _move(writer: _Writer, line: Line, placed: Placed) -> Iterator[str]:
    """Write a line; a move takes one output with it, others that begin there are set right before."""
    near = short(line.blend_mm, 2)
    yield from writer.set("Cnt", "0" if line.blend_mm == 0.0 else f"1,{near},{near}")
    yield from writer.set("Spd", "M_NSpd" if line.turns_on_the_spot else short(line.speed_mm_s, 1))
    *others, last = ["", *(_output(event.channel, event.value) for event in placed.begins)]
    yield from others[1:] if last else ()
    yield f"Mvs {writer.point(line.target)}{f' Wth {last}' if last else ''}"
    yield from (_output(event.channel, event.value) for event in placed.ends)


def _output(channel: Channel, value: float) -> str:
    match channel.kind:
        case "digital":
            return f"M_Out({channel.number})={int(value > 0.5)}"
        case "group":
            return f"M_Outb({channel.number})={round(value)}"
        case "analog":
            return f"M_Outw({channel.number})={round(ANALOG.count(channel, value))}"


def _main(head: list[str], parts: tuple[Part, ...], names: _Names, installation: Installation) -> str:
    """Write what calls the other programs."""
    writer = _Writer(names, installation)
    home = [f"Mov {writer.joints(installation.home)}"] if installation.home else []
    start = ["Ovrd 100", "JOvrd 10", "Cnt 0", *home]
    end = [*home, "Base P_NBase", "Tool P_NTool", "End"]
    return _text([*map(_comment, head), *start, *_calls(parts, names), *end], writer)


def _calls(parts: tuple[Part, ...], names: _Names) -> Iterator[str]:
    for _, part in nest(parts):
        match part:
            case Chapter():
                yield f'CallP "{names.chapter(part)}"'
            case Begin(number, loop):
                yield _comment(f"until {cut(loop.key, 40)} >= {short(loop.least, 6)}, {loop.count} times at most")
                yield from (f"M{number}=0", f"*LOOP{number}", f"M{number}=M{number}+1")
            case End(number, loop):
                goes_on = f"M{number}<{loop.count}"
                if loop.sensor is not None:
                    scale, offset = ANALOG.reading(loop.sensor)
                    reading = f"{short(scale, 9)}*M_Inw({loop.sensor.number})+{short(offset, 9)}"
                    goes_on += f" And ({reading})<{short(loop.least, 6)}"
                yield f"If {goes_on} Then GoTo *LOOP{number}"


def _components(pose: Pose) -> str:
    words = [*(fixed(value, 3) for value in pose.position), *(fixed(value, 4) for value in fixed_xyz(pose.quaternion))]
    return f"({','.join(words)})"


def _comment(text: str) -> str:
    return f"' {cut(text, LONGEST_LINE - 10)}"


def _text(lines: list[str], writer: _Writer) -> str:
    """Number the steps, and put the positions behind them."""
    steps = [f"{number} {line}" for number, line in enumerate(lines, start=1)]
    positions = [f"{name}={value}" for name, value in writer.positions.items()]
    return "".join(f"{line}\n" for line in [*steps, *positions])
