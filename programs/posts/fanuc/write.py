"""FANUC TP programs (.ls): outputs so many hundredths of a second before the end of a motion, by ``TB``."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

from programs.errors import ProgramError
from programs.motion.installation import Installation
from programs.motion.lower import Capability, Lowered
from programs.motion.steps_of_robot import (
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
from programs.posts.fanuc.text import ANALOG, assign, configure, hundredths, operand, program_text, remark
from programs.posts.reading.scanner import split_wait
from programs.posts.writing.angles import fixed_xyz
from programs.posts.writing.chapters import Begin, Chapter, End, Part, divide, nest
from programs.posts.writing.corners import follow, goes_on
from programs.posts.writing.numbering import Frames, Tables, number_frames, table_lines
from programs.posts.writing.routines import tell_steps
from programs.posts.writing.sheet import sheet, short_heading
from programs.posts.writing.wording import fixed, make_name, short

TITLE = "FANUC TP"
NOTES = (
    "ASCII programs for R-30iA and newer (option ASCII Upload). Run the program that ends in FR once, or enter your "
    "own UFRAME and UTOOL; the .txt says which. Analog channels count 2000 at full scale."
)
LONGEST_LINE = 120
CAPABILITY = Capability(
    controller_class=1,
    says="time",
    cycle_s=0.008,  # assumed: the interpolator's period of an R-30iB
    references=("end",),
    step_s=0.01,  # TB has two decimals
    step_mm_s=1.0,  # whole mm/sec
    most_events=1,  # one TB on a motion
    analog=ANALOG,
)
MOST_STEPS = 800
"""Of a program, of which each motion is an instruction and a position. Assumed; the memory is the limit."""
LONGEST_WAIT_S = 327.0
"""WAIT takes up to 327.67 s."""
_LONGEST_NAME = 8
"""Of a program on any controller; 36 on newer ones."""
_REACH_PERCENT = 10
_COUNTER, _READING, _POSITION = 91, 90, 91
"""Registers: R[91] and up count loops, R[90] holds a reading; PR[91] is used by the program of frames. Assumed free."""
_SLOW_CORNER_S = 0.05
"""At CNT100 a corner is rounded by about the way of half the time to brake; assumed 0.1 s."""


def render(lowered: Lowered, installation: Installation) -> dict[str, str]:
    """Write a program that calls one for each part, one that enters the frames, and a sheet for the integrator."""
    parts = divide(lowered.motion, MOST_STEPS)
    count = sum(isinstance(part, Chapter) for part in parts)
    digits = max(len(str(count)), 2)
    name = make_name(lowered.motion.origin.board, _LONGEST_NAME - 1 - digits).upper()
    tables = number_frames(lowered.motion, installation)
    writer = _Writer(installation, tables, follow(lowered.motion.steps), name, digits, {name.lower()})
    for step in lowered.motion.steps:
        if isinstance(step, Call):
            writer.call(step.name)  # before our own programs take names
    routines = [_routine(writer, part) for part in parts if isinstance(part, Chapter)]
    frames_name = writer.routine_name(0, "FR")
    head = short_heading(lowered, installation, f"{name}.txt")
    words = [*table_lines(tables, "UTOOL", "UFRAME"), *_USES]
    main, home = _main(writer, parts)
    files = {f"{name}.ls": program_text(name, [*map(remark, head), *main], home)}
    files |= {f"{each}.ls": program_text(each, body, positions) for each, body, positions in routines}
    files[f"{frames_name}.ls"] = program_text(frames_name, list(_enter(tables)), [])
    files[f"{name}.txt"] = sheet(lowered, installation, CAPABILITY, TITLE, words)
    return files


_USES = (
    "The program that ends in FR enters these frames in the controller's tables; run it once, or enter your own",
    f"R[{_COUNTER}] and up count loops, R[{_READING}] holds a reading, PR[{_POSITION}] is used to enter the frames",
    "W, P, R turn about the fixed x, then y, then z axis; points are in the board's CAD frame",
    "Speeds are whole mm/sec, rounded down; an output's TB counts from the end of its motion, in hundredths",
)


@dataclass(slots=True)
class _Writer:
    """The names given so far, and what holds at the end of what is written."""

    installation: Installation
    tables: Tables
    following: dict[int, Line]
    """The line that goes on from one that is passed, by its identity."""
    program: str
    digits: int
    taken: set[str]
    calls: dict[str, str] = field(default_factory=dict[str, str])
    frames: Frames = field(init=False)
    positions: list[str] = field(default_factory=list[str])
    count: int = 0
    configuration: str = "N U T, 0, 0, 0"

    def __post_init__(self) -> None:
        self.frames = Frames(self.tables)

    def call(self, wanted: str) -> str:
        """Name a program of the integrator's."""
        if wanted not in self.calls:
            self.calls[wanted] = make_name(wanted, 36).upper()
            self.taken.add(self.calls[wanted].lower())
        return self.calls[wanted]

    def routine_name(self, number: int, ending: str = "") -> str:
        """Name a program of ours."""
        end = ending or f"{number:0{self.digits}d}"
        stem = self.program[: _LONGEST_NAME - 1 - len(end)].rstrip("_")
        while f"{stem}_{end}".lower() in self.taken:
            stem = f"{stem[: _LONGEST_NAME - 2 - len(end)]}X"
        return f"{stem}_{end}"

    def position(self, pose: Pose) -> str:
        """Write a position in the frames in use."""
        w, p, r = (f"{fixed(value, 4):>10}" for value in fixed_xyz(pose.quaternion))
        x, y, z = (f"{fixed(value, 3):>9}" for value in pose.position)
        where = f"X = {x}  mm,\tY = {y}  mm,\tZ = {z}  mm,\n\tW = {w} deg,\tP = {p} deg,\tR = {r} deg"
        return self._declare(f",\t\tCONFIG : '{self.configuration}',\n\t{where}")

    def joints(self, joints: tuple[float, ...]) -> str:
        """Write a position as joint values; the third counts from level here, from the second in a cell."""
        kinds = [joint.kind for joint in self.installation.joints] or ["revolute"] * len(joints)
        values = [math.degrees(q) if kind == "revolute" else q for q, kind in zip(joints, kinds, strict=True)]
        if kinds[:3] == ["revolute"] * 3:
            values[2] -= values[1]
            self.configuration = configure(values)
        units = ["deg" if kind == "revolute" else " mm" for kind in kinds]
        words = [f"J{n} = {fixed(v, 4):>10} {unit}" for n, (v, unit) in enumerate(zip(values, units, strict=True), 1)]
        rows = [",\t".join(words[at : at + 3]) for at in range(0, len(words), 3)]
        return self._declare("".join(f",\n\t{row}" for row in rows))

    def _declare(self, what: str) -> str:
        self.count += 1
        frames = f"UF : {self.frames.board}, UT : {self.frames.tool}"
        self.positions.append(f"P[{self.count}]{{\n   GP1:\n\t{frames}{what}\n}};")
        return f"P[{self.count}]"


def _routine(writer: _Writer, chapter: Chapter) -> tuple[str, list[str], list[str]]:
    """Name, instructions and positions of a chapter; it sets its frames, so that it runs alone."""
    writer.positions, writer.count = [], 0
    writer.frames.begin(chapter)
    body = [remark(chapter.title)]
    body += [f"UFRAME_NUM={writer.frames.board}"] if chapter.board is not None else []
    body += [f"UTOOL_NUM={writer.frames.tool}"] if chapter.tool is not None else []
    body += tell_steps(chapter.steps, remark, lambda step: _instructions(writer, step))
    return writer.routine_name(chapter.number), body, writer.positions


def _instructions(writer: _Writer, step: Step) -> Iterable[str]:
    """Write one step."""
    match step:
        case Line():
            yield _line(writer, step)
        case Reach():
            yield from _reach(writer, step)
        case Pause():
            waits = split_wait(step.duration_s, LONGEST_WAIT_S, 2)
            yield from (f"WAIT {hundredths(seconds)}(sec)" for seconds in waits)
        case Switch():
            yield assign(step.channel, step.value)
        case UseTool():
            writer.frames.use(step)
            yield f"UTOOL_NUM={writer.frames.tool}"
        case UseBoard():
            writer.frames.use(step)
            yield f"UFRAME_NUM={writer.frames.board}"
        case Call():
            yield f"CALL {writer.call(step.name)}"
        case Note():
            yield remark(step.text)
        case Repeat() | EndRepeat():
            raise AssertionError("loops are in the main program")


def _reach(writer: _Writer, step: Reach) -> Iterable[str]:
    if not step.joints:
        yield f"J {writer.position(step.target)} {_REACH_PERCENT}% FINE"
        return
    yield f"J {writer.joints(step.joints)} {_REACH_PERCENT}% FINE"
    yield f"L {writer.position(step.target)} 100mm/sec FINE"


def _line(writer: _Writer, line: Line) -> str:
    if len(line.events) > 1:
        raise ProgramError(
            f"{line.made_by}: two outputs change at one moment, and FANUC times one on a motion. "
            "Give the valve a shortest pulse, or part the two."
        )
    if line.turns_on_the_spot:
        speed = f"{max(math.floor(math.degrees(line.turn_rad_s) + 0.3), 1)}deg/sec"
    else:
        speed = f"{round(line.speed_mm_s)}mm/sec"
    events = [f" TB {hundredths(-event.offset_s)}sec,{assign(event.channel, event.value)}" for event in line.events]
    ending = "".join([_termination(line, writer.following.get(id(line))), *events])
    return f"L {writer.position(line.target)} {speed} {ending}"


def _termination(line: Line, after: Line | None) -> str:
    """FINE stops, CNT passes: straight on, CNT100 leaves the path alone; a corner is kept as narrow as planned."""
    if line.blend_mm == 0.0:
        return "FINE"
    if after is not None and goes_on(line, after):
        return "CNT100"
    share = line.blend_mm / max(line.speed_mm_s * _SLOW_CORNER_S, 0.1)
    return f"CNT{min(max(math.floor(100.0 * share), 1), 100)}"


def _main(writer: _Writer, parts: tuple[Part, ...]) -> tuple[list[str], list[str]]:
    """Write what the main program does, labels and jumps make the loops; and its one position, if it has a home."""
    body: list[str] = []
    for _, part in nest(parts):
        match part:
            case Chapter():
                body.append(f"CALL {writer.routine_name(part.number)}")
            case Begin(number, loop):
                register = f"R[{_COUNTER - 1 + number}]"
                body.append(remark(f"until {loop.key} >= {short(loop.least, 6)}"))
                body += [f"{register}=0", f"LBL[{number}]", f"{register}={register}+1"]
            case End(number, loop):
                body += _again(number, loop)
    if not writer.installation.home:
        return body, []
    writer.positions, writer.count = [], 0
    writer.frames = Frames(writer.tables, next(iter(writer.tables.tools), 1), 1)
    go = f"J {writer.joints(writer.installation.home)} {_REACH_PERCENT}% FINE"
    home = [f"UFRAME_NUM={writer.frames.board}", f"UTOOL_NUM={writer.frames.tool}", go]
    return [*home, *body, *home], writer.positions


def _again(number: int, step: Repeat) -> list[str]:
    """Go back to the label while there is reason to."""
    condition = f"R[{_COUNTER - 1 + number}]<{step.count}"
    if step.sensor is None:
        return [f"IF {condition},JMP LBL[{number}]"]
    reading, (scale, offset) = f"R[{_READING}]", ANALOG.reading(step.sensor)
    return [
        f"{reading}=AI[{step.sensor.number}]*{operand(scale, 9)}",
        f"{reading}={reading}+{operand(offset, 9)}",
        f"IF {condition} AND {reading}<{operand(step.least)},JMP LBL[{number}]",
    ]


def _enter(tables: Tables) -> Iterable[str]:
    """Enter the cell's frames in the controller's tables; the position register is made cartesian first."""
    register = f"PR[{_POSITION}"
    yield remark("Enter the frames of the cell")
    yield f"{register}]=LPOS"
    entries = [(f"UTOOL[{number}]", tool.T_flange_tcp) for number, tool in tables.tools.items()]
    entries += [(f"UFRAME[{number}]", place) for number, place in tables.boards.values()]
    for entry, pose in entries:
        numbers = (*(round(value, 3) for value in pose.position), *(round(v, 4) for v in fixed_xyz(pose.quaternion)))
        yield from (f"{register},{axis}]={operand(value)}" for axis, value in enumerate(numbers, start=1))
        yield f"{entry}={register}]"
