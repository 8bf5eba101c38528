"""Yaskawa INFORM jobs (.JBI): outputs so many hundredths of a second before the end of a motion, by ``ENWAIT``."""

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import ClassVar

from programs.errors import ProgramError
from programs.motion.analog import Counting
from programs.motion.installation import Installation
from programs.motion.lower import Capability, Lowered
from programs.motion.steps import Line, Reach, UseBoard
from programs.pose import Pose
from programs.posts.dialect import Dialect, FileForm, ProgramFiles, Task
from programs.posts.layout import Layout
from programs.posts.reading.driver import Reader, read_pose
from programs.posts.reading.execution import (
    Block,
    Statement,
    Values,
    differing,
    located,
    look_up,
    refusal,
    skip,
    statements_of,
)
from programs.posts.rebuilt import Due, ReadSignal
from programs.posts.writing.angles import fixed_xyz, from_fixed_xyz
from programs.posts.writing.axes import as_controller_counts
from programs.posts.writing.chapters import Chapter, Part, Placed, is_straight, part_at_boards
from programs.posts.writing.driver import Routine, Syntax
from programs.posts.writing.forms import POSE, fill, fixed, pattern_of
from programs.posts.writing.vocabulary import INFORM
from programs.posts.writing.wording import TABLE_FORM, join_lines, pose_words, table_lines
from programs.timing.controller import ARM

PASSING_MM = 0.3
"""Greatest S1CxG033, which PL=1 passes by."""
_NARROWEST_CR_MM = 1.0
"""CR takes no smaller corner radius."""
_NOTES = (
    "Positions are RECTAN, as the pulses of a degree differ from robot to robot",
    f"V in mm/s, VR in degrees/s; PL=0 stops, PL=1 passes: let parameter S1CxG033 be {PASSING_MM} mm or less",
    "I090 and up count loops; ENWAIT T counts from the end of its motion, in s",
    "P010, D010 and D011 raise the tool first: select the program's first TOOL before the start",
)


class Inform(Syntax):
    """INFORM: relative jobs, with their positions before the instructions."""

    mark = "'"
    longest_comment = 32
    call_form = "CALL JOB:{routine}"
    digital = "DOUT OT#({number}) {value}"
    group = "DOUT OG#({number}) {value}"
    analog = "AOUT AO#({number}) {value}"
    address_forms = ("OT#({number})", "OG#({number})", "AO#({number})")
    contact_form, sensor_form = "IN#({number})", "AI#({number})"
    off_on = ("OFF", "ON")
    move = "MOVL {point} {unit}={speed:1} {level}{ahead: ENWAIT T={lead:2}}"
    by_joints = "MOVJ {point} VJ={percent}.00 PL=0"
    pause_form = "TIMER T={seconds:2}"
    longest_wait_s = 655.0  # of 655.35 s
    mount_forms = ('MSG "{mount}"', "PAUSE")
    counter = "I{number:03d}"
    first_counter = 90  # assumed free
    start = "I089"
    start_words = "enter its number in {start}"
    watch_note = ": to be wired"
    states = ("OFF", "ON")
    part_form = ("{call} IF {start}<={number}",)
    enter_begin = ("JUMP *RUN IF {start}<>{number}", "SET {start} 1")
    enter_end = ("*RUN",)
    wait_contact = (
        "WAIT IN#({input})={state} T={seconds}",
        "JUMP *GO{index} IF IN#({input})={state}",
        "{fault}",
        'MSG "{message}"',
        "ABORT",
        "*GO{index}",
    )
    await_forms = ("WAIT IN#({input})={state}",)
    rise_forms = (
        "GETS PX010 $PX001",
        "GETE D010 P010 (3)",
        "SET D011 {height}",
        "JUMP *HIGH IF D010>=D011",
        "SETE P010 (3) D011",
        "MOVL P010 V=100.0 PL=0",
        "*HIGH",
    )
    longest_message = 32
    load_place = "tool file, TOOL {tool}"
    shared = "SHUT_VALVES, the same in each; USER and TOOL by number: enter this program's when the board changes"
    loop_text = "until {key} >= {least}"
    loop_begin = ("SET {counter} 0", "*LOOP{number}", "INC {counter}")
    loop_end = ("JUMP *LOOP{number} IF {counter}<{count}",)
    vocabulary = INFORM
    name_case, names_parts_by_program, shut_name = "upper", True, "SHUT_VALVES"
    page = ".TXT"
    indents_loops = False
    numbers_points_by_routine = True

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        super().__init__(dialect, lowered, installation)
        self.heads: list[str] = []
        """Headings of positions that are in force."""
        self.turns, self.arm = "0,0,0", "1,0,0"
        self.entries: list[Routine] = []
        """Jobs of entries that move where the board lay before."""
        for wait in installation.waits:
            if wait.timeout_s > self.longest_wait_s:
                raise ProgramError(
                    f"io.waits.{wait.name}: INFORM waits {self.longest_wait_s:g} s at most; lower timeout_s."
                )

    def setup(self) -> Iterator[Task]:
        """State what the integrator has to set up."""
        off = (
            "concurrent I/O (ladder): shut the valves while the robot is not in operation, and without what is watched"
        )
        valves = (f"{self.address(channel)} {channel.name}" for channel in self.valves)
        yield Task(off, (*valves, *self.watched_lines("IN#({input}) {name}: {words}, watched")))
        yield Task("parameter S2C714 for ENWAIT; relative jobs are allowed")
        text = "TOOL and USER of the .TXT, with the tools' loads; the first tool selected before the start"
        yield Task(text, tuple(self.load_lines()))

    def chores(self) -> Iterator[Task]:
        """List what is to be set up; loads are entered with the tools."""
        return self.setup()

    def remarks(self) -> Iterator[str]:
        """State what has to hold when the program is started."""
        yield "Play mode at 100 %, no speed limit, no dry run: a job cannot read the speed override"
        yield f"{self.start} is the part to start at"
        yield f"Rx, Ry, Rz turn about the fixed x, then y, then z axis; points are in {self.cad_frame}"
        yield from _NOTES

    def divide(self) -> tuple[Part, ...]:
        """Divide where the board is put elsewhere too: a relative job has one user frame."""
        return part_at_boards(super().divide())

    def enter(self, chapter: Chapter) -> Iterator[str]:
        """Write what a part does first: in a job of its own where the board lies elsewhere then; each has one frame."""
        board = next((step for step in chapter.steps if isinstance(step, UseBoard)), chapter.board)
        entry = self.part_entries.get(chapter.number)
        moves = entry is not None and any(isinstance(step, Line | Reach) for step in entry.steps)
        if not moves or board is None or chapter.board is None or board.placement == chapter.board.placement:
            yield from super().enter(chapter)
            return
        kept, self.data, self.heads = (self.data, self.points), [], []
        self.points = 0
        begin, started, *lines, end = super().enter(chapter)
        name = self.names.give("entry", chapter.number, f"{self.name}_{chapter.number:0{self.digits}d}E")
        self.entries.append(Routine(name, chapter.number, lines, self.data))
        (self.data, self.points), self.heads = kept, []
        yield from (begin, started, self.call(name), end)

    def chapter(self, chapter: Chapter) -> Iterator[str]:
        """Write a job; its first position has all headings."""
        self.heads = []
        return super().chapter(chapter)

    def line(self, line: Line, placed: Placed) -> Iterator[str]:
        """Write a motion; an output that belongs to its end goes ahead by ENWAIT, the instruction after it."""
        event = self.only_event(line)
        turns = line.turns_on_the_spot
        yield fill(
            self.move,
            point=self.position(line.target, line.joints),
            unit="VR" if turns else "V",
            speed=max(math.degrees(line.turn_rad_s), 0.1) if turns else line.speed_mm_s,
            level=self.level(line),
            ahead=event,
            lead=-event.offset_s if event else 0.0,
        )
        yield from (self.output(event.channel, event.value) for event in line.events)

    def level(self, line: Line) -> str:
        """PL=0 stops, PL=1 passes; a corner of 1 mm and more has a radius of its own."""
        if line.blend_mm == 0.0:
            return "PL=0"
        if line.blend_mm < _NARROWEST_CR_MM or is_straight(line, self.following.get(id(line))):
            return "PL=1"
        return f"CR={fixed(math.floor(10.0 * line.blend_mm) / 10.0, 1)}"

    def reach(self, reach: Reach) -> Iterator[str]:
        """Write ``MOVJ``."""
        yield fill(self.by_joints, point=self.position(reach.target, reach.joints), percent=self.pace(reach).percent)

    def height(self, millimetres: float) -> str:
        """Write a height in 0.001 mm, as elements of positions count."""
        return str(round(1000.0 * millimetres))

    def home(self) -> tuple[str, ...]:
        """Go nowhere: the first motion is a ``MOVJ`` from where the robot is."""
        return ()

    def position(self, pose: Pose, joints: tuple[float, ...]) -> str:
        """Declare a position under the headings it needs."""
        kinds = self.installation.joint_kinds(len(joints))
        if joints:  # of R, T and S: whether they are beyond half a turn
            counted = as_controller_counts(joints, self.installation)
            beyond = ("1" if not -180.0 < counted[at] <= 180.0 else "0" for at in (3, 5, 0))
            self.turns = ",".join(beyond) if kinds == ["revolute"] * 6 else "0,0,0"
            branch = self.installation.branch(joints)
            self.arm = f"1,{int(not branch.is_above)},{int(not branch.is_front)}"
        frames = [f"///USER {self.slots.board}", f"///TOOL {self.slots.tool}"]
        heads = [*frames, "///POSTYPE USER", "///RECTAN", f"///RCONF {self.arm},{self.turns},0,0"]
        if heads != self.heads:
            self.data += heads
            self.heads = heads
        self.points += 1
        self.data.append(f"C{self.points - 1:05d}={','.join(pose_words(pose, fixed_xyz))}")
        return f"C{self.points - 1:05d}"

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write main, a job for each routine, and a page for the integrator."""
        files = {f"{each.name}.JBI": _job(each) for each in (main, *routines, *self.entries)}
        files[f"{self.shut_name}.JBI"] = _job(Routine(self.shut_name, 0, self.shut(), []))
        return {**files, **self.sheet(next(iter(files)), table_lines(self.slots, self.installation, "TOOL", "USER"))}


def _job(routine: Routine) -> str:
    """Write a job; the date is always the same, so that the same program gives the same bytes."""
    count = sum(line.startswith("C") for line in routine.data)
    frame = next((line.split()[1] for line in routine.data if line.startswith("///USER")), "")
    relative = ["///ATTR SC,RW,RJ", f"////FRAME USER {frame}"] if routine.data else ["///ATTR SC,RW"]
    positions = [f"///NPOS {count},0,0,0,0,0", *routine.data]
    attributes = ["///DATE 2000/01/01 00:00", "///COMM Washboard", *relative, "///GROUP1 RB1"]
    head = ["/JOB", f"//NAME {routine.name}", "//POS", *positions, "//INST", *attributes]
    return join_lines([*head, "NOP", *routine.body, "END"])


_POINT = re.compile(pattern_of("{name}={pose}", {"name": r"C\d{5}", "pose": POSE}))
_HEADS = (r"USER (\d+)", r"TOOL (\d+)", r"POSTYPE USER()", r"RECTAN()", r"RCONF 1,[01],[01],([01],[01],[01]),0,0")
"""Headings of positions in their order."""
_TABLE = re.compile(pattern_of(TABLE_FORM, {"table": "TOOL|USER", "name": ".*"}))


class InformReader(Reader):
    """All jobs with their positions."""

    syntax, shut_name = Inform, Inform.shut_name
    handlers = frozenset({"main"})
    height_unit_mm = 0.001
    reads_sensors = watches_inputs = False
    goes_home = False
    texts: ClassVar[Mapping[str, str]] = {"point": r"C\d{5}", "unit": "VR?", "level": r"PL=[01]|CR=\d+\.\d"}

    def __init__(self) -> None:
        super().__init__()
        self.guards_override = None
        self.positions = self.declares("position")
        """User frame, tool and pose by job and name."""
        self.tables: dict[tuple[str, str], Pose] = {}
        """Tools and user frames that are to be entered, where the page is at hand."""

    @classmethod
    def due(cls, line: Line, after: Line | None) -> Due:
        """Give the corner radius in tenths, or what PL=1 passes by, and the rate of a turn on the spot."""
        tenths = math.floor(10.0 * line.blend_mm)
        zone = PASSING_MM if tenths < 10 or is_straight(line, after) else 0.1 * tenths
        rate = max(math.degrees(line.turn_rad_s), 0.1) if line.turns_on_the_spot else None
        return Due(zone, rate)

    def load(self, files: ProgramFiles) -> str:
        """Read the jobs; the first is the main one."""
        for file, text in files.items():
            if not file.endswith(".JBI"):
                self.load_page(file, text)
                continue
            name = file.removesuffix(".JBI")
            head, found, body = text.partition("\nNOP\n")
            points, also, attributes = head.partition("//INST\n")
            begin = f"/JOB\n//NAME {name}\n//POS\n"
            if not (found and also and points.startswith(begin) and body.endswith("END\n")):
                wrong = differing([*statements_of(file, text)], begin.splitlines())
                raise located(f"{name} is no job.", wrong)
            frames = self.load_positions(name, [*statements_of(file, points)][begin.count("\n") :])
            relative = f",RJ\n////FRAME USER {next(iter(frames), '')}" if frames else ""
            shown = re.sub(r"///DATE [\d/ :]+\n", "", attributes, count=1)
            if len(frames) > 1 or shown != f"///COMM Washboard\n///ATTR SC,RW{relative}\n///GROUP1 RB1":
                line = points.count("\n") + 2  # of the attributes
                raise ProgramError("a relative job has one user frame, and names it.", file=file, line=line)
            lines = [*statements_of(file, text)][head.count("\n") + 2 : -1]
            self.routines[name] = [line for line in lines if not line.startswith("'")]
        return next(iter(self.routines), "")

    def load_positions(self, job: str, lines: Iterable[Statement]) -> set[str]:
        """Read positions under their headings, each group of them whole, and give their user frames."""
        heads: list[str] = []
        stated, frames, count = "", set[str](), 0
        for line in lines:
            if match := _POINT.fullmatch(line):
                if len(heads) != len(_HEADS) or match[1] != f"C{count:05d}":
                    raise refusal(line, "does not follow its headings, or the position before it")
                pose = read_pose(match["pose"].split(","), from_fixed_xyz)
                self.positions.add((job, match[1]), (heads[0], heads[1], pose), line)
                frames.add(heads[0])
                count += 1
            elif match := re.fullmatch(r"///NPOS (\d+),0,0,0,0,0", line):
                stated += match[1]
            else:
                heads = [] if len(heads) == len(_HEADS) else heads
                match = re.fullmatch(f"///{_HEADS[len(heads)]}", line)
                if match is None:
                    raise refusal(line, "is no heading, or not the next one")
                heads.append(match[1])
        if stated != str(count) or (heads and len(heads) != len(_HEADS)):
            file, line = f"{job}.JBI", 4  # of the number
            message = f"job {job}: NPOS states {stated} positions, there are {count}."
            raise ProgramError(message, file=file, line=line)
        return frames

    def load_page(self, file: str, text: str) -> None:
        """Read the tools and user frames that the integrator is to enter."""
        for line in statements_of(file, text):
            if match := _TABLE.fullmatch(line):
                if (match[1], match[2]) in self.tables:
                    raise refusal(line, "is there twice")
                self.tables[match[1], match[2]] = read_pose(match.group(*"xyzabc"), from_fixed_xyz)

    def blocks(self) -> Iterator[Block]:
        """List the instructions of forms."""
        yield [Inform.move], self.move
        yield from super().blocks()
        yield ["NOP"], skip

    def place_of(self, point: str) -> Pose:
        """Look up a position, and use its frames."""
        user, tool, pose = self.positions.use((self.routine, point))
        if self.tables:
            self.use_tool(tool, look_up(self.tables, ("TOOL", tool), f"TOOL {tool}"))
            self.use_board(look_up(self.tables, ("USER", user), f"USER {user}"))
        else:
            self.use_tool(tool, None)
            self.use_board(None)
        return pose

    def move(self, values: Values) -> None:
        """Move in a line; the output that goes ahead is the instruction after it, which is not executed again."""
        pose, signals = self.pose_of(values["point"]), ()
        if "lead" in values:
            self.at += 1
            statements = self.routines[self.routine]
            if self.at == len(statements):
                raise ProgramError(f"no output follows the motion to {values['point']}.")
            signals = (ReadSignal(*self.output_of(statements[self.at]), 1.0, -float(values["lead"])),)
        turns, speed, level = values["unit"] == "VR", float(values["speed"]), values["level"]
        zone = float(level.removeprefix("CR=")) if level.startswith("CR") else PASSING_MM
        self.state(zone=zone, turn_deg_s=speed if turns else None)
        self.line(pose, level == "PL=0", 0.0 if turns else speed, signals)


DIALECT = Dialect(
    title="Yaskawa INFORM",
    notes="Relative jobs for DX100 and newer; set parameter S2C714 for ENWAIT. Enter the user frames and tools that "
    "the .TXT lists. After rising the robot goes to the first pose by MOVJ.",
    capability=Capability(
        controller_class=1,
        timing="time",
        cycle_s=0.004,  # assumed: the interpolation cycle of a YRC1000
        references=("end",),
        step_s=0.01,  # T has two decimals; DIS would be exact only where the robot does not slow down
        most_events=1,  # ENWAIT lets one instruction go ahead
        step_mm_s=0.1,
        analog=Counting(step=1e-3),  # AOUT takes volts
        reads_sensors=False,  # analog inputs come by an option, and each by its own
    ),
    layout=Layout(leading_zero=True),
    form=FileForm(".JBI", several=(".JBI", ".TXT")),
    longest_line=120,
    most_steps=1000,  # of a job; assumed, the memory is the limit, and positions are numbered up to C09998
    write=Inform.write,
    rebuild=InformReader.rebuild,
    controller=replace(
        ARM,
        rise_s=0.03,
        most_positions=9_998,
        sources={"most_positions": "positions are numbered up to C09998"},
    ),
    maker="yaskawa",
    writes_joints=False,
)
