"""Yaskawa INFORM jobs (.JBI): outputs so many hundredths of a second before the end of a motion, by ``ENWAIT``."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from programs.errors import ProgramError
from programs.motion.analog import Counting
from programs.motion.installation import Channel, Installation
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
from programs.posts.reading.scanner import split_wait
from programs.posts.writing.angles import fixed_xyz
from programs.posts.writing.chapters import Begin, Chapter, End, Part, divide, nest
from programs.posts.writing.corners import follow, goes_on
from programs.posts.writing.numbering import Frames, Tables, number_frames, part_at_boards, table_lines
from programs.posts.writing.routines import tell_steps
from programs.posts.writing.sheet import sheet, short_heading
from programs.posts.writing.wording import cut, fixed, make_name, short

TITLE = "Yaskawa INFORM"
NOTES = (
    "Relative jobs for DX100 and newer; set parameter S2C714 for ENWAIT. Enter the user frames and tools that the .TXT "
    "lists. The first motion is a MOVJ from wherever the robot is."
)
LONGEST_LINE = 120
ANALOG = Counting(step=1e-3)
"""AOUT takes volts."""
CAPABILITY = Capability(
    controller_class=1,
    says="time",
    cycle_s=0.004,  # assumed: the interpolation cycle of a YRC1000
    references=("end",),
    step_s=0.01,  # T has two decimals; DIS would be exact only where the robot does not slow down
    most_events=1,  # ENWAIT lets one instruction go ahead
    step_mm_s=0.1,
    analog=ANALOG,
    reads_sensors=False,  # analog inputs come by an option, and each by its own
)
MOST_STEPS = 1000
"""Of a job. Assumed; the memory is the limit, and positions are numbered up to C09998."""
LONGEST_WAIT_S = 655.0
"""TIMER takes up to 655.35 s."""
_LONGEST_NAME = 32
_LONGEST_REMARK = 32
_REACH_PERCENT = "10.00"
_COUNTER = 90
"""I090 and up count loops. Assumed free."""
_NARROWEST_CR_MM = 1.0
"""CR takes no smaller corner radius."""


def render(lowered: Lowered, installation: Installation) -> dict[str, str]:
    """Write a job that calls one for each part, and a sheet for the integrator."""
    parts = part_at_boards(divide(lowered.motion, MOST_STEPS))  # a relative job has one user frame
    name = make_name(lowered.motion.origin.board, _LONGEST_NAME - 4).upper()
    tables = number_frames(lowered.motion, installation)
    writer = _Writer(tables, installation, follow(lowered.motion.steps), name, {name.lower()})
    for step in lowered.motion.steps:
        if isinstance(step, Call):
            writer.call(step.name)  # before our own jobs take names
    jobs = {writer.job_name(part.number): _job(writer, part) for part in parts if isinstance(part, Chapter)}
    head = map(_remark, short_heading(lowered, installation, f"{name}.TXT"))
    files = {f"{name}.JBI": _text(name, [], 0, [*head, *_main(writer, parts)])}
    files |= {f"{job}.JBI": text for job, text in jobs.items()}
    words = [*table_lines(tables, "TOOL", "USER"), *_USES]
    files[f"{name}.TXT"] = sheet(lowered, installation, CAPABILITY, TITLE, words)
    return files


_USES = (
    "Rx, Ry, Rz turn about the fixed x, then y, then z axis; points are in the board's CAD frame, as user frame",
    "Positions are RECTAN, as the pulses of a degree differ from robot to robot",
    "V in mm/s, VR in degrees/s; PL=0 stops, PL=1 passes: let parameter S1CxG033 be 0.3 mm or less",
    f"I{_COUNTER:03d} and up count loops; ENWAIT T counts from the end of its motion, in s",
)


@dataclass(slots=True)
class _Writer:
    """The names given so far, and what holds at the end of what is written."""

    tables: Tables
    installation: Installation
    following: dict[int, Line]
    """The line that goes on from one that is passed, by its identity."""
    program: str
    taken: set[str]
    calls: dict[str, str] = field(default_factory=dict[str, str])
    frames: Frames = field(init=False)
    heads: list[str] = field(default_factory=list[str])
    """Headings of positions that are in force."""
    positions: list[str] = field(default_factory=list[str])
    count: int = 0
    turns: str = "0,0,0"

    def __post_init__(self) -> None:
        self.frames = Frames(self.tables)

    def call(self, wanted: str) -> str:
        """Name a job of the integrator's."""
        if wanted not in self.calls:
            self.calls[wanted] = make_name(wanted, _LONGEST_NAME).upper()
            self.taken.add(self.calls[wanted].lower())
        return self.calls[wanted]

    def job_name(self, number: int) -> str:
        """Name a job of ours."""
        name = f"{self.program}_{number:02d}"
        return name if name.lower() not in self.taken else f"{self.program[:-1]}X_{number:02d}"

    def position(self, pose: Pose, joints: tuple[float, ...]) -> str:
        """Write a position under the headings it needs."""
        if joints:
            self.turns = _turns(joints, self.installation)
        heads = [
            f"///USER {self.frames.board}",
            f"///TOOL {self.frames.tool}",
            "///POSTYPE USER",
            "///RECTAN",
            f"///RCONF 1,0,0,{self.turns},0,0",
        ]
        if heads != self.heads:
            self.positions += heads
            self.heads = heads
        numbers = (
            *(fixed(value, 3) for value in pose.position),
            *(fixed(value, 4) for value in fixed_xyz(pose.quaternion)),
        )
        name = f"C{self.count:05d}"
        self.positions.append(f"{name}={','.join(numbers)}")
        self.count += 1
        return name


def _turns(joints: tuple[float, ...], installation: Installation) -> str:
    """Say of R, T and S whether they are beyond half a turn, if the arm has six turning joints."""
    kinds = [joint.kind for joint in installation.joints] or ["revolute"] * len(joints)
    if kinds != ["revolute"] * 6:
        return "0,0,0"
    return ",".join("1" if not -math.pi < joints[at] <= math.pi else "0" for at in (3, 5, 0))


def _job(writer: _Writer, chapter: Chapter) -> str:
    """Write a chapter as a job."""
    writer.positions, writer.heads, writer.count = [], [], 0
    writer.frames.begin(chapter)
    body = tell_steps(chapter.steps, _remark, lambda step: _instructions(writer, step))
    return _text(writer.job_name(chapter.number), writer.positions, writer.frames.board, body)


def _instructions(writer: _Writer, step: Step) -> Iterable[str]:
    """Write one step."""
    match step:
        case Line():
            yield from _line(writer, step)
        case Reach():
            yield f"MOVJ {writer.position(step.target, step.joints)} VJ={_REACH_PERCENT} PL=0"
        case Pause():
            yield from (f"TIMER T={fixed(each, 2)}" for each in split_wait(step.duration_s, LONGEST_WAIT_S, 2))
        case Switch():
            yield _assign(step.channel, step.value)
        case UseTool() | UseBoard():
            writer.frames.use(step)
        case Call():
            yield f"CALL JOB:{writer.call(step.name)}"
        case Note():
            yield _remark(step.text)
        case Repeat() | EndRepeat():
            raise AssertionError("loops are in the main job")


def _line(writer: _Writer, line: Line) -> Iterable[str]:
    """Write a motion; an output that belongs to its end goes ahead by ENWAIT, the instruction after it."""
    if len(line.events) > 1:
        raise ProgramError(
            f"{line.made_by}: two outputs change at one moment, and INFORM times one on a motion. "
            "Give the valve a shortest pulse, or part the two."
        )
    if line.turns_on_the_spot:
        speed = f"VR={fixed(max(math.degrees(line.turn_rad_s), 0.1), 1)}"
    else:
        speed = f"V={fixed(line.speed_mm_s, 1)}"
    ending = _level(line, writer.following.get(id(line)))
    ahead = "".join(f" ENWAIT T={fixed(-event.offset_s, 2)}" for event in line.events)
    yield f"MOVL {writer.position(line.target, line.joints)} {speed} {ending}{ahead}"
    yield from (_assign(event.channel, event.value) for event in line.events)


def _level(line: Line, after: Line | None) -> str:
    """PL=0 stops, PL=1 passes; a corner of 1 mm and more has a radius of its own."""
    if line.blend_mm == 0.0:
        return "PL=0"
    if line.blend_mm < _NARROWEST_CR_MM or (after is not None and goes_on(line, after)):
        return "PL=1"
    return f"CR={fixed(math.floor(10.0 * line.blend_mm) / 10.0, 1)}"


def _assign(channel: Channel, value: float) -> str:
    match channel.kind:
        case "digital":
            return f"DOUT OT#({channel.number}) {'ON' if value else 'OFF'}"
        case "group":
            return f"DOUT OG#({channel.number}) {short(value, 6)}"
        case "analog":
            return f"AOUT AO#({channel.number}) {short(ANALOG.count(channel, value), 3)}"


def _main(writer: _Writer, parts: tuple[Part, ...]) -> list[str]:
    """Write what the main job does: labels and jumps make the loops."""
    body: list[str] = []
    for _, part in nest(parts):
        match part:
            case Chapter():
                body.append(f"CALL JOB:{writer.job_name(part.number)}")
            case Begin(number, loop):
                counter = f"I{_COUNTER - 1 + number:03d}"
                body += [_remark(f"until {loop.key} >= {short(loop.least, 6)}"), f"SET {counter} 0"]
                body += [f"*LOOP{number}", f"INC {counter}"]
            case End(number, loop):
                body.append(f"JUMP *LOOP{number} IF I{_COUNTER - 1 + number:03d}<{loop.count}")
    return body


def _remark(text: str) -> str:
    return f"'{cut(text, _LONGEST_REMARK)}"


def _text(name: str, positions: Sequence[str], frame: int, body: Sequence[str]) -> str:
    """Write a job; the date is always the same, so that the same program gives the same bytes."""
    count = sum(line.startswith("C") for line in positions)
    relative = ["///ATTR SC,RW,RJ", f"////FRAME USER {frame}"] if positions else ["///ATTR SC,RW"]
    lines = [
        "/JOB",
        f"//NAME {name}",
        "//POS",
        f"///NPOS {count},0,0,0,0,0",
        *positions,
        "//INST",
        "///DATE 2000/01/01 00:00",
        "///COMM Washboard",
        *relative,
        "///GROUP1 RB1",
        "NOP",
        *body,
        "END",
    ]
    return "".join(f"{line}\n" for line in lines)
